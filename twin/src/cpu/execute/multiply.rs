//! Multiplies and divides (A4.4.3).

use crate::cpu::core::{Core, Result};
use crate::cpu::cycles;
use crate::cpu::instruction::{Instruction as I, LongMultiply};
use crate::cpu::system::scb::CCR_DIV_0_TRP;
use crate::cpu::trap::Trap;

impl Core {
    /// Runs an instruction of this group. `false`: it belongs to another one.
    pub(super) fn execute_multiply(&mut self, instruction: I) -> Result<bool> {
        match instruction {
            I::Multiply { s, rd, rn, rm } => {
                let result = self.reg(rn).wrapping_mul(self.reg(rm));
                self.set_reg(rd, result);
                if s {
                    self.flags.set_nz(result);
                }
            }
            I::MultiplyAccumulate { subtract, rd, rn, rm, ra } => {
                let product = self.reg(rn).wrapping_mul(self.reg(rm));
                let base = self.reg(ra);
                let result = if subtract { base.wrapping_sub(product) } else { base.wrapping_add(product) };
                self.set_reg(rd, result);
            }
            I::MultiplyLong { op, low, high, rn, rm } => self.multiply_long(op, low, high, rn, rm),
            I::Divide { signed, rd, rn, rm } => self.divide(signed, rd, rn, rm)?,
            I::MultiplyHalves { rd, rn, rm, ra, n_top, m_top } => {
                self.accumulate(rd, ra, self.half(rn, n_top) * self.half(rm, m_top));
            }
            I::MultiplyWordHalf { rd, rn, rm, ra, m_top } => {
                let product = i64::from(self.reg(rn) as i32) * self.half(rm, m_top);
                self.accumulate(rd, ra, product >> 16);
            }
            I::MultiplyDual { subtract, exchange, rd, rn, rm, ra } => {
                self.accumulate(rd, ra, self.dual_product(subtract, exchange, rn, rm));
            }
            I::MultiplyHigh { subtract, round, rd, rn, rm, ra } => {
                let product = i64::from(self.reg(rn) as i32) * i64::from(self.reg(rm) as i32);
                let base = if ra == 15 { 0 } else { i64::from(self.reg(ra)) << 32 };
                let sum = if subtract { base.wrapping_sub(product) } else { base.wrapping_add(product) };
                let rounded = if round { sum.wrapping_add(1 << 31) } else { sum };
                self.set_reg(rd, (rounded >> 32) as u32);
            }
            I::MultiplyHalvesLong { low, high, rn, rm, n_top, m_top } => {
                let product = self.half(rn, n_top) * self.half(rm, m_top);
                self.set_long(low, high, self.long(low, high).wrapping_add_signed(product));
            }
            I::MultiplyDualLong { subtract, exchange, low, high, rn, rm } => {
                let product = self.dual_product(subtract, exchange, rn, rm);
                self.set_long(low, high, self.long(low, high).wrapping_add_signed(product));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn long(&self, low: u8, high: u8) -> u64 {
        u64::from(self.reg(high)) << 32 | u64::from(self.reg(low))
    }

    fn set_long(&mut self, low: u8, high: u8, value: u64) {
        self.set_reg(low, value as u32);
        self.set_reg(high, (value >> 32) as u32);
    }

    fn multiply_long(&mut self, op: LongMultiply, low: u8, high: u8, rn: u8, rm: u8) {
        let (n, m) = (self.reg(rn), self.reg(rm));
        let unsigned = u64::from(n) * u64::from(m);
        let signed = (i64::from(n as i32) * i64::from(m as i32)) as u64;
        let base = self.long(low, high);
        let result = match op {
            LongMultiply::Unsigned => unsigned,
            LongMultiply::Signed => signed,
            LongMultiply::UnsignedAccumulate => base.wrapping_add(unsigned),
            LongMultiply::SignedAccumulate => base.wrapping_add(signed),
            LongMultiply::UnsignedAccumulateBoth => unsigned + (base & 0xFFFF_FFFF) + (base >> 32),
        };
        self.set_long(low, high, result);
    }

    fn divide(&mut self, signed: bool, rd: u8, rn: u8, rm: u8) -> Result {
        let (n, m) = (self.reg(rn), self.reg(rm));
        if m == 0 && self.scb.ccr & CCR_DIV_0_TRP != 0 {
            return Err(self.raise(Trap::DIVIDE_BY_ZERO));
        }
        let (n_signed, m_signed) = (n as i32, m as i32);
        let (result, cost) = if signed {
            let result = if m == 0 { 0 } else { n_signed.wrapping_div(m_signed) as u32 };
            (result, cycles::divide(n_signed.unsigned_abs(), m_signed.unsigned_abs()))
        } else {
            (n.checked_div(m).unwrap_or(0), cycles::divide(n, m))
        };
        self.spent += cost;
        self.set_reg(rd, result);
        Ok(())
    }

    /// The upper or lower half of a register.
    fn half(&self, reg: u8, top: bool) -> i64 {
        let value = self.reg(reg);
        i64::from((if top { value >> 16 } else { value }) as i16)
    }

    /// Adds `ra`, unless it is 15, and sets Q if the sum does not fit.
    fn accumulate(&mut self, rd: u8, ra: u8, value: i64) {
        let base = if ra == 15 { 0 } else { i64::from(self.reg(ra) as i32) };
        let sum = base + value;
        self.flags.q |= i64::from(sum as i32) != sum;
        self.set_reg(rd, sum as u32);
    }

    /// Sum or difference of the products of the halves.
    fn dual_product(&self, subtract: bool, exchange: bool, rn: u8, rm: u8) -> i64 {
        let low = self.half(rn, false) * self.half(rm, exchange);
        let high = self.half(rn, true) * self.half(rm, !exchange);
        if subtract { low - high } else { low + high }
    }
}
