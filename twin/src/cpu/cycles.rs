//! Cycles of each class of instructions.
//!
//! The figures are those of the Cortex-M4 technical reference manual (ARM 100166), table 3-1 for the core and table 7-1 for the FPU,
//! with memory without wait states. The bus adds its waits. Where the manual gives a range, this model takes one value:
//!
//! - P, the refill of the pipeline after a branch, is 2 (manual: 1 to 3).
//! - Neighbouring loads and stores do not overlap (manual: pairs may take less).
//! - A divide takes 2 to 12 cycles, linear in the length of the quotient. The manual gives the range without a formula, so this is an
//!   approximation.
//! - Barriers wait for nothing, and IT takes its cycle (manual: it may take none).
//!
//! Every instruction takes [`BASE`]. The other lines are added to it. FPU registers that are stacked or unstacked with a frame add
//! [`ACCESS`] for each of their 17 words, when that happens.

/// Any instruction; complete for data processing, shifts, extends, bit fields, saturation, parallel arithmetic, multiplies, MRS, MSR,
/// CPS, hints, barriers, CLREX, a branch that is not taken, and an instruction whose condition fails (table 3-1). VABS, VNEG, VMOV,
/// VADD, VSUB, VMUL, VNMUL, VCMP, VCVT, VMRS, VMSR (table 7-1).
pub const BASE: u32 = 1;
/// A taken branch, or another write to PC: P (table 3-1).
pub const REFILL: u32 = 2;
/// Each word, half-word or byte loaded or stored: LDR and STR 2, LDM and STM 1 + N, LDRD 3, TBB 2 + P (table 3-1); VLDR, VLDM (table 7-1).
pub const ACCESS: u32 = 1;
/// The read before the write of a store to a bit-band alias ("Bit-banding").
pub const BIT_BAND_READ: u32 = 1;
/// VMOV between two core registers and two single registers: 2 (table 7-1).
pub const FP_MOVE_PAIR: u32 = 1;
/// VMLA, VMLS, VNMLA, VNMLS, VFMA, VFMS, VFNMA, VFNMS: 3 (table 7-1).
pub const FP_ACCUMULATE: u32 = 2;
/// VDIV, VSQRT: 14 (table 7-1).
pub const FP_DIVIDE: u32 = 13;
/// Exception entry, stacking of 8 words included ("Exceptions": an interrupt latency of 12).
pub const ENTRY: u32 = 12;
/// Exception return, added to the instruction that returns; unstacking of 8 words included ("Exceptions": 12 in all).
pub const RETURN: u32 = 11;
/// Tail-chaining, added to the instruction that returns ("Exceptions": 6).
pub const TAIL_CHAIN: u32 = 6;
/// Reset sequence: the two words of the vector table.
pub const RESET: u32 = 2;
/// A step of a core that sleeps, is halted at a breakpoint or is locked up.
pub const IDLE: u32 = 1;

/// SDIV, UDIV: 2 to 12 in all, fewer the closer the leading bits of the operands are (table 3-1). Takes magnitudes.
pub const fn divide(dividend: u32, divisor: u32) -> u32 {
    let quotient_bits = (divisor.leading_zeros() + 1).saturating_sub(dividend.leading_zeros());
    if divisor == 0 || dividend < divisor { 1 } else { 1 + (quotient_bits * 10).div_ceil(32) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divide_takes_two_to_twelve_cycles() {
        assert_eq!(BASE + divide(1, 2), 2);
        assert_eq!(BASE + divide(7, 0), 2);
        assert_eq!(BASE + divide(5, 5), 3);
        assert_eq!(BASE + divide(u32::MAX, 1), 12);
    }
}
