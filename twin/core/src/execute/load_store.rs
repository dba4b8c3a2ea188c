//! Loads and stores of one or two registers, and exclusive ones (A4.6).

use crate::bus::{Bus, Width};
use crate::core::{Core, Raised};
use crate::instruction::{Index, Size};
use crate::trap::Trap;

const PC: u8 = 15;

impl Core {
    /// Address of the access, and what the base holds afterwards.
    fn indexed(&self, index: Index, rn: u8, offset: i16) -> (u32, u32) {
        let base = self.reg(rn);
        let moved = base.wrapping_add_signed(i32::from(offset));
        match index {
            Index::Offset | Index::Unprivileged => (moved, base),
            Index::Pre => (moved, moved),
            Index::Post => (base, moved),
        }
    }

    #[inline]
    pub(super) fn load<B: Bus>(
        &mut self,
        bus: &mut B,
        size: Size,
        index: Index,
        rt: u8,
        rn: u8,
        offset: i16,
    ) -> Result<(), Raised> {
        let (address, base) = self.indexed(index, rn, offset);
        let privileged = index != Index::Unprivileged && self.is_privileged();
        let value = self.load_sized(bus, size, address, privileged)?;
        if matches!(index, Index::Pre | Index::Post) {
            if rt == PC {
                self.check_loaded_target(address, value)?;
            }
            self.set_reg(rn, base);
        }
        self.set_loaded(bus, rt, address, value)
    }

    pub(super) fn load_to<B: Bus>(
        &mut self,
        bus: &mut B,
        size: Size,
        rt: u8,
        address: u32,
    ) -> Result<(), Raised> {
        let value = self.load_sized(bus, size, address, self.is_privileged())?;
        self.set_loaded(bus, rt, address, value)
    }

    /// Refuses a load to PC that is UNPREDICTABLE, before a register changes.
    fn check_loaded_target(&mut self, address: u32, value: u32) -> Result<(), Raised> {
        if address & 3 != 0 {
            return Err(self.raise(Trap::Unpredictable));
        }
        self.check_target(value)
    }

    /// A load to PC branches; from an unaligned address it is UNPREDICTABLE.
    fn set_loaded<B: Bus>(&mut self, bus: &mut B, rt: u8, address: u32, value: u32) -> Result<(), Raised> {
        if rt != PC {
            self.set_reg(rt, value);
            Ok(())
        } else {
            self.check_loaded_target(address, value)?;
            self.branch_exchange(bus, value)
        }
    }

    fn load_sized<B: Bus>(
        &mut self,
        bus: &mut B,
        size: Size,
        address: u32,
        privileged: bool,
    ) -> Result<u32, Raised> {
        match size {
            Size::Word => self.read(bus, address, Width::Word, privileged),
            Size::Byte => self.read(bus, address, Width::Byte, privileged),
            Size::Half => self.read(bus, address, Width::Half, privileged),
            Size::SignedByte => Ok(self.read(bus, address, Width::Byte, privileged)? as i8 as u32),
            Size::SignedHalf => Ok(self.read(bus, address, Width::Half, privileged)? as i16 as u32),
        }
    }

    pub(super) fn store<B: Bus>(
        &mut self,
        bus: &mut B,
        size: Size,
        index: Index,
        rt: u8,
        rn: u8,
        offset: i16,
    ) -> Result<(), Raised> {
        let (address, base) = self.indexed(index, rn, offset);
        let privileged = index != Index::Unprivileged && self.is_privileged();
        self.store_sized(bus, size, address, self.reg(rt), privileged)?;
        if matches!(index, Index::Pre | Index::Post) {
            self.set_reg(rn, base);
        }
        Ok(())
    }

    pub(super) fn store_sized<B: Bus>(
        &mut self,
        bus: &mut B,
        size: Size,
        address: u32,
        value: u32,
        privileged: bool,
    ) -> Result<(), Raised> {
        match size {
            Size::Word => self.write(bus, address, Width::Word, value, privileged),
            Size::Byte | Size::SignedByte => self.write(bus, address, Width::Byte, value & 0xFF, privileged),
            Size::Half | Size::SignedHalf => {
                self.write(bus, address, Width::Half, value & 0xFFFF, privileged)
            }
        }
    }

    /// LDRD; of the literal form the base is the aligned PC (A7.7.50, A7.7.51).
    pub(super) fn load_dual<B: Bus>(
        &mut self,
        bus: &mut B,
        index: Index,
        rt: u8,
        rt2: u8,
        rn: u8,
        offset: i16,
    ) -> Result<(), Raised> {
        let (address, base) = self.indexed(index, rn, offset);
        let address = if rn == PC { address & !3 } else { address };
        let privileged = self.is_privileged();
        self.check_alignment(address, Width::Word, true)?;
        let first = self.read(bus, address, Width::Word, privileged)?;
        let second = self.read(bus, address.wrapping_add(4), Width::Word, privileged)?;
        if rn != PC {
            self.set_reg(rn, base);
        }
        self.set_reg(rt, first);
        self.set_reg(rt2, second);
        Ok(())
    }

    pub(super) fn store_dual<B: Bus>(
        &mut self,
        bus: &mut B,
        index: Index,
        rt: u8,
        rt2: u8,
        rn: u8,
        offset: i16,
    ) -> Result<(), Raised> {
        let (address, base) = self.indexed(index, rn, offset);
        let privileged = self.is_privileged();
        self.check_alignment(address, Width::Word, true)?;
        self.write(bus, address, Width::Word, self.reg(rt), privileged)?;
        self.write(bus, address.wrapping_add(4), Width::Word, self.reg(rt2), privileged)?;
        self.set_reg(rn, base);
        Ok(())
    }

    /// LDREX, LDREXB, LDREXH (A3.4). The monitor marks all memory, as that of a Cortex-M4 does.
    pub(super) fn load_exclusive<B: Bus>(
        &mut self,
        bus: &mut B,
        size: Size,
        rt: u8,
        rn: u8,
        offset: u16,
    ) -> Result<(), Raised> {
        let address = self.reg(rn).wrapping_add(u32::from(offset));
        self.check_alignment(address, width(size), true)?;
        let value = self.load_sized(bus, size, address, self.is_privileged())?;
        self.exclusive = true;
        self.set_reg(rt, value);
        Ok(())
    }

    /// STREX, STREXB, STREXH: stores and gives 0, or stores nothing and gives 1.
    pub(super) fn store_exclusive<B: Bus>(
        &mut self,
        bus: &mut B,
        size: Size,
        rd: u8,
        rt: u8,
        rn: u8,
        offset: u16,
    ) -> Result<(), Raised> {
        let address = self.reg(rn).wrapping_add(u32::from(offset));
        self.check_alignment(address, width(size), true)?;
        if self.exclusive {
            self.store_sized(bus, size, address, self.reg(rt), self.is_privileged())?;
        } else {
            self.spent += crate::cycles::ACCESS;
        }
        self.set_reg(rd, u32::from(!self.exclusive));
        self.exclusive = false;
        Ok(())
    }
}

fn width(size: Size) -> Width {
    match size {
        Size::Byte | Size::SignedByte => Width::Byte,
        Size::Half | Size::SignedHalf => Width::Half,
        Size::Word => Width::Word,
    }
}
