//! The FPU: access, context and instructions (A2.5, B1.4.7, B1.5.7, B3.2.20 to B3.2.24).

use crate::cpu::bus::Bus;
use crate::cpu::core::{Core, Raised, Result};
use crate::cpu::cycles;
use crate::cpu::float::{Float, Rounding, SIGN};
use crate::cpu::fpu::{ASPEN, BFRDY, FPSCR_BITS, HFRDY, LSPACT, MMRDY, MODES, MONRDY, USER};
use crate::cpu::instruction::{FpBinary, FpConvert, FpUnary, Instruction as I};
use crate::cpu::registers::Flags;
use crate::cpu::system::scb::HFSR_FORCED;
use crate::cpu::trap::{BUS_FAULT, DEBUG_MONITOR, HARD_FAULT, LSPERR, MEM_MANAGE, MLSPERR, Trap};

impl Core {
    /// Refuses the FPU to code with these rights if CPACR does not permit it.
    pub(in crate::cpu) fn check_fpu(&mut self, privileged: bool) -> Result {
        self.fpu.is_used = true;
        if self.scb.permits_fpu(privileged) { Ok(()) } else { Err(self.raise(Trap::NO_COPROCESSOR)) }
    }

    /// FPCCR bits of the fault handlers that could run at the current priority.
    pub(in crate::cpu) fn handlers_ready(&self) -> u32 {
        let ready = |exception, bit| if self.can_preempt(exception) { bit } else { 0 };
        let hard_fault = if self.execution_priority() > -1 { HFRDY } else { 0 };
        ready(DEBUG_MONITOR, MONRDY) | ready(BUS_FAULT, BFRDY) | ready(MEM_MANAGE, MMRDY) | hard_fault
    }

    /// Begins an FPU instruction that has access: completes a deferred stacking, starts a new context (ExecuteFPCheck).
    fn begin_fp<B: Bus>(&mut self, bus: &mut B) -> Result {
        if self.fpu.fpccr & LSPACT != 0 {
            // With the rights at the time of the entry: FPCCR.USER, and HFRDY for a priority that was not negative.
            let rights = (self.fpu.fpccr & USER == 0, self.fpu.fpccr & HFRDY == 0);
            if let Err(Raised) = self.stack_registers(bus, self.fpu.fpcar, rights) {
                self.fail_deferred()?;
            }
            self.fpu.fpccr &= !LSPACT;
        }
        if self.fpu.fpccr & ASPEN != 0 && !self.control.fp_active {
            self.fpu.fpscr = self.fpu.fpscr & !MODES | self.fpu.fpdscr;
            self.control.fp_active = true;
        }
        Ok(())
    }

    /// Handles a fault of a deferred store. FPCCR says which handlers could run at exception entry; the others escalate to HardFault.
    ///
    /// A fault whose priority does not suffice now waits, and the instruction runs. `Err`: the fault ends the instruction.
    fn fail_deferred(&mut self) -> Result {
        let (fault, bits, ready) = match self.raised.take() {
            Some(Trap::DataBus(_)) => (BUS_FAULT, LSPERR, BFRDY),
            _ => (MEM_MANAGE, MLSPERR, MMRDY),
        };
        self.scb.cfsr |= bits;
        let exception = if self.fpu.fpccr & ready != 0 {
            fault
        } else {
            self.scb.hfsr |= HFSR_FORCED;
            HARD_FAULT
        };
        if self.can_preempt(exception) {
            return Err(self.raise(Trap::Deferred(Some(exception))));
        }
        if self.fpu.fpccr & HFRDY == 0 {
            return Err(self.raise(Trap::Deferred(None)));
        }
        self.pend(exception);
        Ok(())
    }

    /// Runs an FPU instruction.
    pub(super) fn execute_fp<B: Bus>(&mut self, bus: &mut B, instruction: I) -> Result {
        self.check_fpu(self.is_privileged())?;
        if matches!(instruction, I::FpUndefined) {
            return Err(self.raise(Trap::UNDEFINED));
        }
        self.begin_fp(bus)?;
        match instruction {
            I::FpBinary { op, d, n, m } => self.fp_binary(op, d, n, m),
            I::FpAccumulate { fused, negate_addend, negate_product, d, n, m } => {
                self.spent += cycles::FP_ACCUMULATE;
                let sign = |negate| if negate { SIGN } else { 0 };
                let addend = self.fpu.get(d) ^ sign(negate_addend);
                let (n, m) = (self.fpu.get(n), self.fpu.get(m));
                let sum = self.float(|float| {
                    if fused {
                        return float.mul_add(addend, n ^ sign(negate_product), m);
                    }
                    let product = float.mul(n, m) ^ sign(negate_product);
                    float.add(addend, product)
                });
                self.fpu.set(d, sum);
            }
            I::FpUnary { op, d, m } => self.fp_unary(op, d, m),
            I::FpImmediate { d, value } => self.fpu.set(d, value),
            I::FpCompare { quiet_raises, zero, d, m } => {
                let operand = if zero { 0 } else { self.fpu.get(m) };
                let a = self.fpu.get(d);
                let nzcv = self.float(|float| float.compare(a, operand, quiet_raises));
                self.fpu.fpscr = self.fpu.fpscr & !(0xF << 28) | nzcv << 28;
            }
            I::FpConvert { op, d, m } => self.fp_convert(op, d, m),
            I::FpMoveCore { to_core, rt, n } => match to_core {
                true => self.set_reg(rt, self.fpu.get(n)),
                false => self.fpu.set(n, self.reg(rt)),
            },
            I::FpMovePair { to_core, rt, rt2, m } => {
                self.spent += cycles::FP_MOVE_PAIR;
                if to_core {
                    self.set_reg(rt, self.fpu.get(m));
                    self.set_reg(rt2, self.fpu.get(m + 1));
                } else {
                    self.fpu.set(m, self.reg(rt));
                    self.fpu.set(m + 1, self.reg(rt2));
                }
            }
            I::FpStatusRead { rt: 15 } => {
                let Flags { q, ge, .. } = self.flags;
                self.flags = Flags { q, ge, ..Flags::from_bits(self.fpu.fpscr) };
            }
            I::FpStatusRead { rt } => self.set_reg(rt, self.fpu.fpscr),
            I::FpStatusWrite { rt } => self.fpu.fpscr = self.reg(rt) & FPSCR_BITS,
            I::FpTransfer { load, d, count, rn, offset } => {
                let base = if rn == 15 { self.r[15] & !3 } else { self.reg(rn) };
                let address = base.wrapping_add_signed(i32::from(offset));
                return self.fp_transfer(bus, load, d, count, address);
            }
            I::FpMultiple { load, d, count, rn, decrement, writeback } => {
                let (address, base) = self.block(rn, u32::from(count), decrement);
                self.fp_transfer(bus, load, d, count, address)?;
                if writeback {
                    self.set_reg(rn, base);
                }
            }
            // Integer instructions, which do not come here.
            _ => return Err(self.raise(Trap::UNDEFINED)),
        }
        Ok(())
    }

    /// Runs an operation in the modes of FPSCR and keeps its flags.
    fn float<T>(&mut self, operation: impl FnOnce(&mut Float) -> T) -> T {
        let mut float = Float::new(self.fpu.fpscr);
        let result = operation(&mut float);
        self.fpu.fpscr |= float.flags;
        result
    }

    fn fp_binary(&mut self, op: FpBinary, d: u8, n: u8, m: u8) {
        let (n, m) = (self.fpu.get(n), self.fpu.get(m));
        if op == FpBinary::Div {
            self.spent += cycles::FP_DIVIDE;
        }
        let result = self.float(|float| match op {
            FpBinary::Add => float.add(n, m),
            FpBinary::Sub => float.sub(n, m),
            FpBinary::Mul => float.mul(n, m),
            FpBinary::NegMul => float.mul(n, m) ^ SIGN,
            FpBinary::Div => float.div(n, m),
        });
        self.fpu.set(d, result);
    }

    fn fp_unary(&mut self, op: FpUnary, d: u8, m: u8) {
        let m = self.fpu.get(m);
        let result = match op {
            FpUnary::Mov => m,
            FpUnary::Abs => m & !SIGN,
            FpUnary::Neg => m ^ SIGN,
            FpUnary::Sqrt => {
                self.spent += cycles::FP_DIVIDE;
                self.float(|float| float.sqrt(m))
            }
        };
        self.fpu.set(d, result);
    }

    fn fp_convert(&mut self, op: FpConvert, d: u8, m: u8) {
        let (m, old) = (self.fpu.get(m), self.fpu.get(d));
        let integer = |value: u32, signed, word| match (signed, word) {
            (true, true) => i64::from(value as i32),
            (false, true) => i64::from(value),
            (true, false) => i64::from(value as i16),
            (false, false) => i64::from(value & 0xFFFF),
        };
        let result = self.float(|float| match op {
            FpConvert::FromInteger { signed } => float.fixed_to_single(integer(m, signed, true), 0),
            FpConvert::ToInteger { signed, to_zero } => {
                let rounding = if to_zero { Rounding::ToZero } else { float.rounding };
                float.single_to_fixed(m, signed, 32, 0, rounding) as u32
            }
            FpConvert::FromFixed { signed, word, fraction } => {
                float.rounding = Rounding::Nearest;
                float.fixed_to_single(integer(m, signed, word), fraction)
            }
            FpConvert::ToFixed { signed, word, fraction } => {
                float.single_to_fixed(m, signed, if word { 32 } else { 16 }, fraction, Rounding::ToZero)
                    as u32
            }
            FpConvert::FromHalf { top } => float.half_to_single(if top { m >> 16 } else { m & 0xFFFF }),
            FpConvert::ToHalf { top: false } => old & 0xFFFF_0000 | float.single_to_half(m),
            FpConvert::ToHalf { top: true } => old & 0xFFFF | float.single_to_half(m) << 16,
        });
        self.fpu.set(d, result);
    }

    fn fp_transfer<B: Bus>(&mut self, bus: &mut B, load: bool, d: u8, count: u8, address: u32) -> Result {
        let (first, count) = (usize::from(d), usize::from(count));
        let mut registers = self.fpu.s;
        let words = &mut registers[first..first + count];
        if load {
            self.read_words(bus, address, words)?;
            self.fpu.s = registers;
            Ok(())
        } else {
            self.write_words(bus, address, words)
        }
    }
}
