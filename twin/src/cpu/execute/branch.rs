//! Branches to the content of a register, and table branches (A7.7.19, A7.7.20, A7.7.185).

use crate::cpu::bus::{Bus, Width};
use crate::cpu::core::{Core, Result};
use crate::cpu::registers::EPSR_T;
use crate::cpu::trap::Trap;

/// Bits of EXC_RETURN that are ones, below its upper four.
const EXC_RETURN_ONES: u32 = 0x0FFF_FFE0;

impl Core {
    /// Branches to a target whose bit 0 is set for Thumb code. Without the bit the next instruction raises INVSTATE.
    pub(super) fn branch_to_address(&mut self, target: u32) {
        if target & 1 == 0 {
            self.epsr &= !EPSR_T;
        }
        self.branch(target);
    }

    /// Returns whether a branch to `target` returns from the exception (B1.5.8).
    fn is_exception_return(&self, target: u32) -> bool {
        target >> 28 == 0xF && self.ipsr != 0
    }

    /// Refuses a target that is an EXC_RETURN with a reserved bit clear: that is UNPREDICTABLE.
    pub(super) fn check_target(&mut self, target: u32) -> Result {
        if self.is_exception_return(target) && target & EXC_RETURN_ONES != EXC_RETURN_ONES {
            return Err(self.raise(Trap::Unpredictable));
        }
        Ok(())
    }

    /// As [`Core::branch_to_address`]; in Handler mode a target from F000_0000h on returns from the exception.
    pub(in crate::cpu) fn branch_exchange<B: Bus>(&mut self, bus: &mut B, target: u32) -> Result {
        if self.is_exception_return(target) {
            self.check_target(target)?;
            self.exception_return(bus, target);
        } else {
            self.branch_to_address(target);
        }
        Ok(())
    }

    pub(super) fn table_branch<B: Bus>(&mut self, bus: &mut B, half: bool, rn: u8, rm: u8) -> Result {
        let width = if half { Width::Half } else { Width::Byte };
        let address = self.reg(rn).wrapping_add(self.reg(rm) << u32::from(half));
        let offset = self.read(bus, address, width, self.is_privileged())?;
        self.branch(self.r[15].wrapping_add(offset * 2));
        Ok(())
    }
}
