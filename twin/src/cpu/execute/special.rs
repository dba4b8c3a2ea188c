//! Special registers, CPS and hints (B5.2, A7.7).

use crate::cpu::core::Core;
use crate::cpu::instruction::{Hint, Instruction as I};
use crate::cpu::registers::Flags;
use crate::cpu::system::nvic::PRIORITY_BITS;
use crate::cpu::trap::Sleep;

impl Core {
    /// Runs an instruction of this group. `false`: it belongs to another one.
    pub(super) fn execute_special(&mut self, instruction: I) -> bool {
        match instruction {
            I::Barrier | I::Hint { hint: Hint::Nop } => {}
            I::Hint { hint: Hint::SendEvent } => self.event = true,
            I::Hint { hint: Hint::WaitForEvent } if self.event => self.event = false,
            I::Hint { hint: Hint::WaitForEvent } => self.fall_asleep(Sleep::ForEvent),
            I::Hint { hint: Hint::WaitForInterrupt } => self.fall_asleep(Sleep::ForInterrupt),
            I::ChangeState { disable, primask, faultmask } => self.change_state(disable, primask, faultmask),
            I::MoveFromSpecial { rd, register } => self.move_from_special(rd, register),
            I::MoveToSpecial { rn, register, mask } => self.move_to_special(rn, register, mask),
            _ => return false,
        }
        true
    }

    /// MRS. Unprivileged code reads flags and CONTROL; everything else reads as zero (B5.2.2).
    fn move_from_special(&mut self, rd: u8, register: u8) {
        let privileged = self.is_privileged();
        let (main, process) = self.stack_pointers();
        let value = match register {
            0..=7 => {
                let apsr = if register & 4 == 0 { self.flags.bits() } else { 0 };
                let ipsr = if register & 1 != 0 && privileged { u32::from(self.ipsr) } else { 0 };
                apsr | ipsr
            }
            20 => self.control.bits(),
            _ if !privileged => 0,
            8 => main,
            9 => process,
            16 => u32::from(self.masks.primask),
            17 | 18 => u32::from(self.masks.basepri),
            _ => u32::from(self.masks.faultmask),
        };
        self.set_reg(rd, value);
    }

    /// MSR. Unprivileged code writes flags alone (B5.2.3).
    fn move_to_special(&mut self, rn: u8, register: u8, mask: u8) {
        let value = self.reg(rn);
        match register {
            0..=3 => {
                let new = Flags::from_bits(value);
                if mask & 1 != 0 {
                    self.flags.ge = new.ge;
                }
                if mask & 2 != 0 {
                    self.flags = Flags { ge: self.flags.ge, ..new };
                }
            }
            _ if !self.is_privileged() => {}
            8 => self.set_stack_pointers(value, self.stack_pointers().1),
            9 => self.set_stack_pointers(self.stack_pointers().0, value),
            16 => self.masks.primask = value & 1 == 1,
            17 => self.masks.basepri = value as u8 & PRIORITY_BITS,
            18 => {
                let new = value as u8 & PRIORITY_BITS;
                if new != 0 && (new < self.masks.basepri || self.masks.basepri == 0) {
                    self.masks.basepri = new;
                }
            }
            19 if value & 1 == 0 || self.execution_priority() > -1 => self.masks.faultmask = value & 1 == 1,
            20 => self.write_control(value),
            _ => {}
        }
        self.attention = 0;
    }

    /// The stack in use changes in Thread mode alone.
    fn write_control(&mut self, value: u32) {
        let (main, process) = self.stack_pointers();
        self.control.unprivileged = value & 1 != 0;
        self.control.fp_active = value & 4 != 0;
        if self.ipsr == 0 {
            self.control.process_stack = value & 2 != 0;
            self.set_stack_pointers(main, process);
        }
    }

    /// CPS (B5.2.1).
    fn change_state(&mut self, disable: bool, primask: bool, faultmask: bool) {
        if !self.is_privileged() {
            return;
        }
        if primask {
            self.masks.primask = disable;
        }
        if faultmask && (!disable || self.execution_priority() > -1) {
            self.masks.faultmask = disable;
        }
        self.attention = 0;
    }
}
