//! Load and store multiple, PUSH and POP (A7.7.41, A7.7.42, A7.7.99, A7.7.101, A7.7.159, A7.7.160).
//!
//! The core takes interrupts between instructions, so it never leaves one of these in the middle. It does go on with one that an
//! ICI field in a restored xPSR describes: registers below the one in the field count as transferred (B1.5.10).

use crate::cpu::bus::{Bus, Width};
use crate::cpu::core::{Core, Result};
use crate::cpu::instruction::Block;
use crate::cpu::trap::Trap;

impl Core {
    /// Lowest address, and what the base holds afterwards.
    pub(super) fn block(&self, rn: u8, words: u32, decrement: bool) -> (u32, u32) {
        let base = self.reg(rn);
        if decrement {
            (base.wrapping_sub(4 * words), base.wrapping_sub(4 * words))
        } else {
            (base, base.wrapping_add(4 * words))
        }
    }

    /// The registers that are left to transfer, and the address of the first.
    fn remaining(&mut self, list: u16, start: u32) -> Result<(u16, u32)> {
        if self.resume == 0 {
            return Ok((list, start));
        }
        let below = (1 << self.resume) - 1;
        if list & !below == list || list >> self.resume & 1 == 0 {
            return Err(self.raise(Trap::Unpredictable));
        }
        Ok((list & !below, start.wrapping_add(4 * (list & below).count_ones())))
    }

    pub(super) fn load_multiple<B: Bus>(&mut self, bus: &mut B, block: Block) -> Result {
        let Block { rn, list, decrement, writeback } = block;
        let (start, end) = self.block(rn, list.count_ones(), decrement);
        let (left, address) = self.remaining(list, start)?;
        // Registers change after the last load: a fault leaves them as they were.
        let mut words = [0; 16];
        let words = &mut words[..left.count_ones() as usize];
        self.read_words(bus, address, words)?;
        let target = words.last().copied().filter(|_| list >> 15 == 1);
        if let Some(target) = target.filter(|_| self.ipsr != 0) {
            self.check_target(target)?;
        }
        if writeback {
            self.set_reg(rn, end);
        }
        let mut registers = left & 0x7FFF;
        for &mut word in words {
            if registers != 0 {
                self.set_reg(take_lowest(&mut registers), word);
            }
        }
        target.map_or(Ok(()), |target| self.branch_exchange(bus, target))
    }

    pub(super) fn store_multiple<B: Bus>(&mut self, bus: &mut B, block: Block) -> Result {
        let Block { rn, list, decrement, writeback } = block;
        let (start, end) = self.block(rn, list.count_ones(), decrement);
        let (mut registers, mut address) = self.remaining(list, start)?;
        self.check_alignment(address, Width::Word, true)?;
        let privileged = self.is_privileged();
        while registers != 0 {
            let reg = take_lowest(&mut registers);
            self.write(bus, address, Width::Word, self.reg(reg), privileged)?;
            address = address.wrapping_add(4);
        }
        if writeback {
            self.set_reg(rn, end);
        }
        Ok(())
    }
}

/// Takes the register with the lowest number out of a list that is not empty.
#[inline]
fn take_lowest(list: &mut u16) -> u8 {
    let reg = list.trailing_zeros() as u8;
    *list &= *list - 1;
    reg
}
