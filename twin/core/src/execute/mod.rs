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

use crate::bus::Bus;
use crate::core::{Core, Raised};
use crate::cycles;
use crate::instruction::Instruction as I;
use crate::trap::Trap;

impl Core {
    /// Runs one instruction whose condition holds. `next` already holds its successor.
    #[inline(always)]
    pub(crate) fn execute<B: Bus>(&mut self, bus: &mut B, instruction: I) -> Result<(), Raised> {
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

            I::Load { size, index, rt, rn, offset } => return self.load(bus, size, index, rt, rn, offset),
            I::LoadRegister { size, rt, rn, rm, shift } => {
                let address = self.reg(rn).wrapping_add(self.reg(rm) << shift);
                return self.load_to(bus, size, rt, address);
            }
            I::LoadLiteral { size, rt, offset } => {
                let address = (self.r[15] & !3).wrapping_add_signed(i32::from(offset));
                return self.load_to(bus, size, rt, address);
            }
            I::Store { size, index, rt, rn, offset } => return self.store(bus, size, index, rt, rn, offset),
            I::StoreRegister { size, rt, rn, rm, shift } => {
                let address = self.reg(rn).wrapping_add(self.reg(rm) << shift);
                return self.store_sized(bus, size, address, self.reg(rt), self.is_privileged());
            }
            I::LoadMultiple { rn, list, decrement, writeback } => {
                return self.load_multiple(bus, rn, list, decrement, writeback);
            }
            I::StoreMultiple { rn, list, decrement, writeback } => {
                return self.store_multiple(bus, rn, list, decrement, writeback);
            }

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
    fn execute_rarer<B: Bus>(&mut self, bus: &mut B, instruction: I) -> Result<(), Raised> {
        match instruction {
            I::Undefined => return Err(self.raise(Trap::UNDEFINED)),
            I::Unpredictable => return Err(self.raise(Trap::Unpredictable)),
            I::NoCoprocessor => return Err(self.raise(Trap::NO_COPROCESSOR)),

            I::BitFieldInsert { rd, rn, lsb, width } => self.bit_field_insert(rd, self.reg(rn), lsb, width),
            I::BitFieldClear { rd, lsb, width } => self.bit_field_insert(rd, 0, lsb, width),
            I::BitFieldExtract { signed, rd, rn, lsb, width } => {
                self.bit_field_extract(signed, rd, rn, lsb, width);
            }
            I::Saturate { signed, bits, rd, rn, shift } => self.saturate(signed, bits, rd, rn, shift),
            I::Saturate16 { signed, bits, rd, rn } => self.saturate16(signed, bits, rd, rn),
            I::Extend { kind, rd, rn, rm, rotation } => self.extend(kind, rd, rn, rm, rotation),
            I::Reverse { kind, rd, rm } => self.reverse(kind, rd, rm),

            I::Parallel { lanes, treatment, signed, rd, rn, rm } => {
                self.parallel(lanes, treatment, signed, rd, rn, rm);
            }
            I::SaturatingAdd { op, rd, rn, rm } => self.saturating_add(op, rd, rn, rm),
            I::Select { rd, rn, rm } => self.select(rd, rn, rm),
            I::Pack { top, rd, rn, rm, shift } => self.pack(top, rd, rn, rm, shift),
            I::AbsoluteDifferences { rd, rn, rm, ra } => self.absolute_differences(rd, rn, rm, ra),

            I::Multiply { s, rd, rn, rm } => self.multiply(s, rd, rn, rm),
            I::MultiplyAccumulate { subtract, rd, rn, rm, ra } => {
                self.multiply_accumulate(subtract, rd, rn, rm, ra);
            }
            I::MultiplyLong { op, low, high, rn, rm } => self.multiply_long(op, low, high, rn, rm),
            I::Divide { signed, rd, rn, rm } => return self.divide(signed, rd, rn, rm),
            I::MultiplyHalves { rd, rn, rm, ra, n_top, m_top } => {
                self.multiply_halves(rd, (rn, n_top), (rm, m_top), ra);
            }
            I::MultiplyWordHalf { rd, rn, rm, ra, m_top } => self.multiply_word_half(rd, rn, (rm, m_top), ra),
            I::MultiplyDual { subtract, exchange, rd, rn, rm, ra } => {
                self.multiply_dual(subtract, exchange, rd, rn, rm, ra);
            }
            I::MultiplyHigh { subtract, round, rd, rn, rm, ra } => {
                self.multiply_high(subtract, round, rd, rn, rm, ra);
            }
            I::MultiplyHalvesLong { low, high, rn, rm, n_top, m_top } => {
                self.multiply_halves_long(low, high, (rn, n_top), (rm, m_top));
            }
            I::MultiplyDualLong { subtract, exchange, low, high, rn, rm } => {
                self.multiply_dual_long(subtract, exchange, low, high, rn, rm);
            }

            I::LoadDual { index, rt, rt2, rn, offset } => {
                return self.load_dual(bus, index, rt, rt2, rn, offset);
            }
            I::StoreDual { index, rt, rt2, rn, offset } => {
                return self.store_dual(bus, index, rt, rt2, rn, offset);
            }
            I::LoadExclusive { size, rt, rn, offset } => {
                return self.load_exclusive(bus, size, rt, rn, offset);
            }
            I::StoreExclusive { size, rd, rt, rn, offset } => {
                return self.store_exclusive(bus, size, rd, rt, rn, offset);
            }
            I::ClearExclusive => self.exclusive = false,

            I::Hint { hint } => self.hint(hint),
            I::Barrier => {}
            I::ChangeState { disable, primask, faultmask } => self.change_state(disable, primask, faultmask),
            I::MoveFromSpecial { rd, register } => self.move_from_special(rd, register),
            I::MoveToSpecial { rn, register, mask } => self.move_to_special(rn, register, mask),
            I::SupervisorCall => return Err(self.call_supervisor()),
            I::Breakpoint { immediate } => return Err(self.raise(Trap::Breakpoint(immediate))),

            _ => return self.execute_fp(bus, instruction),
        }
        Ok(())
    }

    /// A taken branch within Thumb code (BranchWritePC in the manual).
    pub(crate) fn branch(&mut self, target: u32) {
        self.next = target & !1;
        self.spent += cycles::REFILL;
    }
}
