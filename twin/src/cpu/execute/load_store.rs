//! Loads and stores of one or two registers, and exclusive ones (A4.6).

use crate::cpu::bus::{Bus, Width};
use crate::cpu::core::{Core, Result};
use crate::cpu::cycles;
use crate::cpu::instruction::{Index, Indexed, Size};
use crate::cpu::trap::Trap;

const PC: u8 = 15;

impl Core {
    /// Address of the access, and what the base holds afterwards.
    #[inline]
    fn indexed(&self, Indexed { index, rn, offset }: Indexed) -> (u32, u32) {
        let base = self.reg(rn);
        let moved = base.wrapping_add_signed(i32::from(offset));
        match index {
            Index::Offset | Index::Unprivileged => (moved, base),
            Index::Pre => (moved, moved),
            Index::Post => (base, moved),
        }
    }

    #[inline(always)]
    pub(super) fn load<B: Bus>(&mut self, bus: &mut B, size: Size, rt: u8, at: Indexed) -> Result {
        let (address, base) = self.indexed(at);
        let privileged = at.index != Index::Unprivileged && self.is_privileged();
        let value = self.load_sized(bus, size, address, privileged)?;
        if at.index.writes_base() {
            if rt == PC {
                self.check_loaded_target(address, value)?;
            }
            self.set_reg(at.rn, base);
        }
        self.set_loaded(bus, rt, address, value)
    }

    pub(super) fn load_to<B: Bus>(&mut self, bus: &mut B, size: Size, rt: u8, address: u32) -> Result {
        let value = self.load_sized(bus, size, address, self.is_privileged())?;
        self.set_loaded(bus, rt, address, value)
    }

    /// Refuses a load to PC that is UNPREDICTABLE, before a register changes.
    fn check_loaded_target(&mut self, address: u32, value: u32) -> Result {
        if address & 3 != 0 {
            return Err(self.raise(Trap::Unpredictable));
        }
        self.check_target(value)
    }

    /// A load to PC branches; from an unaligned address it is UNPREDICTABLE.
    fn set_loaded<B: Bus>(&mut self, bus: &mut B, rt: u8, address: u32, value: u32) -> Result {
        if rt != PC {
            self.set_reg(rt, value);
            Ok(())
        } else {
            self.check_loaded_target(address, value)?;
            self.branch_exchange(bus, value)
        }
    }

    fn load_sized<B: Bus>(&mut self, bus: &mut B, size: Size, address: u32, privileged: bool) -> Result<u32> {
        // Each width is a constant: the row twin.host_instructions.
        match size {
            Size::Word => self.read(bus, address, Width::Word, privileged),
            Size::Byte => self.read(bus, address, Width::Byte, privileged),
            Size::Half => self.read(bus, address, Width::Half, privileged),
            Size::SignedByte => Ok(self.read(bus, address, Width::Byte, privileged)? as i8 as u32),
            Size::SignedHalf => Ok(self.read(bus, address, Width::Half, privileged)? as i16 as u32),
        }
    }

    #[inline(always)]
    pub(super) fn store<B: Bus>(&mut self, bus: &mut B, size: Size, rt: u8, at: Indexed) -> Result {
        let (address, base) = self.indexed(at);
        let privileged = at.index != Index::Unprivileged && self.is_privileged();
        self.store_sized(bus, size, address, self.reg(rt), privileged)?;
        if at.index.writes_base() {
            self.set_reg(at.rn, base);
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
    ) -> Result {
        match size {
            Size::Word => self.write(bus, address, Width::Word, value, privileged),
            Size::Byte | Size::SignedByte => self.write(bus, address, Width::Byte, value & 0xFF, privileged),
            Size::Half | Size::SignedHalf => {
                self.write(bus, address, Width::Half, value & 0xFFFF, privileged)
            }
        }
    }

    /// LDRD and STRD; of the literal form the base is the aligned PC (A7.7.50, A7.7.51).
    pub(super) fn dual<B: Bus>(
        &mut self,
        bus: &mut B,
        load: bool,
        [rt, rt2]: [u8; 2],
        at: Indexed,
    ) -> Result {
        let (address, base) = self.indexed(at);
        let address = if at.rn == PC { address & !3 } else { address };
        let mut words = [self.reg(rt), self.reg(rt2)];
        if load {
            self.read_words(bus, address, &mut words)?;
        } else {
            self.write_words(bus, address, &words)?;
        }
        if at.rn != PC {
            self.set_reg(at.rn, base);
        }
        if load {
            self.set_reg(rt, words[0]);
            self.set_reg(rt2, words[1]);
        }
        Ok(())
    }

    /// LDREX, LDREXB, LDREXH (A3.4). The monitor marks all memory, as that of a Cortex-M4 does.
    pub(super) fn load_exclusive<B: Bus>(&mut self, bus: &mut B, size: Size, rt: u8, address: u32) -> Result {
        self.check_alignment(address, size.width(), true)?;
        let value = self.load_sized(bus, size, address, self.is_privileged())?;
        self.exclusive = true;
        self.set_reg(rt, value);
        Ok(())
    }

    /// STREX, STREXB, STREXH: stores and gives 0, or stores nothing and gives 1.
    ///
    /// Without a mark it does not ask the MPU: the manual leaves open which of the two comes first (A3.4.4, A7.7).
    pub(super) fn store_exclusive<B: Bus>(
        &mut self,
        bus: &mut B,
        size: Size,
        rd: u8,
        rt: u8,
        address: u32,
    ) -> Result {
        self.check_alignment(address, size.width(), true)?;
        if self.exclusive {
            self.store_sized(bus, size, address, self.reg(rt), self.is_privileged())?;
        } else {
            self.spent += cycles::ACCESS;
        }
        self.set_reg(rd, u32::from(!self.exclusive));
        self.exclusive = false;
        Ok(())
    }
}
