//! Execution: one function for each group of instructions.

mod bits;
mod branch;
mod data;
mod dsp;
mod fpu;
mod load_store;
mod multiple;
mod multiply;
mod special;

use crate::cpu::bus::Bus;
use crate::cpu::core::{Core, Result};
use crate::cpu::cycles;
use crate::cpu::instruction::Instruction as I;
use crate::cpu::trap::Trap;

impl Core {
    /// Runs one instruction whose condition holds. `next` already holds its successor.
    #[inline(always)]
    pub(in crate::cpu) fn execute<B: Bus>(&mut self, bus: &mut B, instruction: I) -> Result {
        match instruction {
            I::AluImmediate { op, s, rotated, rd, rn, imm } => {
                self.alu_immediate(op, s, rotated, rd, rn, imm)
            }
            I::AluRegister { op, s, rd, rn, rm, shift } => self.alu_register(op, s, rd, rn, rm, shift),
            I::ShiftRegister { kind, s, rd, rn, rm } => self.shift_register(kind, s, rd, rn, rm),
            I::MovTop { rd, imm } => self.set_reg(rd, self.reg(rd) & 0xFFFF | u32::from(imm) << 16),
            I::Adr { rd, offset } => {
                self.set_reg(rd, (self.r[15] & !3).wrapping_add_signed(i32::from(offset)))
            }

            I::Load { size, rt, at } => return self.load(bus, size, rt, at),
            I::LoadRegister { size, rt, rn, rm, shift } => {
                let address = self.reg(rn).wrapping_add(self.reg(rm) << shift);
                return self.load_to(bus, size, rt, address);
            }
            I::LoadLiteral { size, rt, offset } => {
                let address = (self.r[15] & !3).wrapping_add_signed(i32::from(offset));
                return self.load_to(bus, size, rt, address);
            }
            I::Store { size, rt, at } => return self.store(bus, size, rt, at),
            I::StoreRegister { size, rt, rn, rm, shift } => {
                let address = self.reg(rn).wrapping_add(self.reg(rm) << shift);
                return self.store_sized(bus, size, address, self.reg(rt), self.is_privileged());
            }
            I::Multiple { load: true, block } => return self.load_multiple(bus, block),
            I::Multiple { load: false, block } => return self.store_multiple(bus, block),

            I::Branch { offset } => self.branch(self.r[15].wrapping_add_signed(offset)),
            I::BranchIf { condition, offset } => {
                if self.flags.pass(condition.0) {
                    self.branch(self.r[15].wrapping_add_signed(offset));
                }
            }
            I::BranchLink { offset } => {
                self.r[14] = self.next | 1;
                self.branch(self.r[15].wrapping_add_signed(offset));
            }
            I::BranchExchange { rm } => return self.branch_exchange(bus, self.reg(rm)),
            I::BranchLinkExchange { rm } => {
                let target = self.reg(rm);
                self.r[14] = self.next | 1;
                self.branch_to_address(target);
            }
            I::CompareBranch { rn, non_zero, offset } => {
                if (self.reg(rn) != 0) == non_zero {
                    self.branch(self.r[15].wrapping_add(u32::from(offset)));
                }
            }
            I::TableBranch { half, rn, rm } => return self.table_branch(bus, half, rn, rm),
            I::MovPc { rm } => self.branch(self.reg(rm)),
            I::AddPc { rm } => self.branch(self.r[15].wrapping_add(self.reg(rm))),

            I::IfThen { state } => self.set_itstate(state),
            _ => return self.execute_rarer(bus, instruction),
        }
        Ok(())
    }

    /// The instructions that programs contain less often.
    fn execute_rarer<B: Bus>(&mut self, bus: &mut B, instruction: I) -> Result {
        match instruction {
            I::Undefined => return Err(self.raise(Trap::UNDEFINED)),
            I::Unpredictable => return Err(self.raise(Trap::Unpredictable)),
            I::NoCoprocessor => return Err(self.raise(Trap::NO_COPROCESSOR)),

            I::Dual { load, rt, rt2, at } => return self.dual(bus, load, [rt, rt2], at),
            I::LoadExclusive { size, rt, rn, offset } => {
                let address = self.reg(rn).wrapping_add(u32::from(offset));
                return self.load_exclusive(bus, size, rt, address);
            }
            I::StoreExclusive { size, rd, rt, rn, offset } => {
                let address = self.reg(rn).wrapping_add(u32::from(offset));
                return self.store_exclusive(bus, size, rd, rt, address);
            }
            I::ClearExclusive => self.exclusive = false,

            I::SupervisorCall => return Err(self.call_supervisor()),
            I::Breakpoint { immediate } => return Err(self.raise(Trap::Breakpoint(immediate))),

            _ => {
                // Each group takes what is its own.
                let is_done = self.execute_bits(instruction)
                    || self.execute_multiply(instruction)?
                    || self.execute_special(instruction)
                    || self.execute_dsp(instruction);
                return if is_done { Ok(()) } else { self.execute_fp(bus, instruction) };
            }
        }
        Ok(())
    }

    /// A taken branch within Thumb code (BranchWritePC in the manual).
    pub(in crate::cpu) fn branch(&mut self, target: u32) {
        self.next = target & !1;
        self.spent += cycles::REFILL;
    }
}
