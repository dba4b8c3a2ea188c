//! Load and store multiple, PUSH and POP (A7.7.41, A7.7.42, A7.7.99, A7.7.101, A7.7.159, A7.7.160).
//!
//! The core takes interrupts between instructions, so it never leaves one of these in the middle. It does go on with one that an
//! ICI field in a restored xPSR describes: registers below the one in the field count as transferred (B1.5.10).

use crate::bus::{Bus, Width};
use crate::core::{Core, Raised};
use crate::trap::Trap;

impl Core {
    /// Lowest address, and what the base holds afterwards.
    fn block(&self, rn: u8, list: u16, decrement: bool) -> (u32, u32) {
        let base = self.reg(rn);
        let size = 4 * list.count_ones();
        if decrement {
            (base.wrapping_sub(size), base.wrapping_sub(size))
        } else {
            (base, base.wrapping_add(size))
        }
    }

    /// The registers that are left to transfer, and the address of the first.
    fn remaining(&mut self, list: u16, start: u32) -> Result<(u16, u32), Raised> {
        if self.resume == 0 {
            return Ok((list, start));
        }
        let below = (1 << self.resume) - 1;
        if list & !below == list || list >> self.resume & 1 == 0 {
            return Err(self.raise(Trap::Unpredictable));
        }
        Ok((list & !below, start.wrapping_add(4 * (list & below).count_ones())))
    }

    pub(super) fn load_multiple<B: Bus>(
        &mut self,
        bus: &mut B,
        rn: u8,
        list: u16,
        decrement: bool,
        writeback: bool,
    ) -> Result<(), Raised> {
        let (start, end) = self.block(rn, list, decrement);
        let (left, mut address) = self.remaining(list, start)?;
        self.check_alignment(address, Width::Word, true)?;
        let privileged = self.is_privileged();
        // Registers change after the last load: a fault leaves them as they were.
        let mut loaded = [0; 16];
        for value in loaded.iter_mut().take(left.count_ones() as usize) {
            *value = self.read(bus, address, Width::Word, privileged)?;
            address = address.wrapping_add(4);
        }
        if self.ipsr != 0 && list >> 15 == 1 {
            self.check_target(loaded[left.count_ones() as usize - 1])?;
        }
        if writeback {
            self.set_reg(rn, end);
        }
        let mut values = loaded.into_iter();
        let mut registers = left & 0x7FFF;
        while registers != 0 {
            let reg = registers.trailing_zeros() as u8;
            registers &= registers - 1;
            self.set_reg(reg, values.next().unwrap_or_default());
        }
        if list >> 15 == 1 {
            return self.branch_exchange(bus, values.next().unwrap_or_default());
        }
        Ok(())
    }

    pub(super) fn store_multiple<B: Bus>(
        &mut self,
        bus: &mut B,
        rn: u8,
        list: u16,
        decrement: bool,
        writeback: bool,
    ) -> Result<(), Raised> {
        let (start, end) = self.block(rn, list, decrement);
        let (mut registers, mut address) = self.remaining(list, start)?;
        self.check_alignment(address, Width::Word, true)?;
        let privileged = self.is_privileged();
        while registers != 0 {
            let reg = registers.trailing_zeros() as u8;
            registers &= registers - 1;
            self.write(bus, address, Width::Word, self.reg(reg), privileged)?;
            address = address.wrapping_add(4);
        }
        if writeback {
            self.set_reg(rn, end);
        }
        Ok(())
    }
}
