//! Division of 64-bit numbers, in place of the compiler's function, which takes ten times the memory.
//!
//! A bit of the quotient takes some ten cycles. Divided are times in microseconds, a few for each SYNC. A strong symbol takes
//! the place of a weak one of `compiler_builtins` (run-time ABI of ARM, IHI 0043, 4.3.1).

// SAFETY: as the run-time ABI has it, the numerator is in r0 and r1, the denominator in r2 and r3, the lower words first. The
// quotient is returned in r0 and r1, the remainder in r2 and r3. The stack is used for saved registers only, r4 to r6 are
// restored. By zero, which Rust checks before, it ends with a quotient of ones.
core::arch::global_asm!(
    ".syntax unified",
    ".section .text.__aeabi_uldivmod, \"ax\", %progbits",
    ".global __aeabi_uldivmod",
    ".type __aeabi_uldivmod, %function",
    ".thumb_func",
    "__aeabi_uldivmod:",
    "push {{r4, r5, r6, lr}}",
    "movs r4, #0",
    "movs r5, #0",
    "movs r6, #64",
    "cbnz r1, 1f",
    // The upper word is zero: 32 rounds are enough.
    "mov r1, r0",
    "movs r0, #0",
    "movs r6, #32",
    // The numerator moves up into the remainder, r4 and r5; the quotient follows it. No bit is lost: before the last round
    // the remainder has 63.
    "1: adds r0, r0, r0",
    "adcs r1, r1",
    "adcs r4, r4",
    "adcs r5, r5",
    "cmp r4, r2",
    "sbcs r12, r5, r3",
    "blo 3f",
    "subs r4, r4, r2",
    "sbc r5, r5, r3",
    "adds r0, #1",
    "3: subs r6, #1",
    "bne 1b",
    "mov r2, r4",
    "mov r3, r5",
    "pop {{r4, r5, r6, pc}}",
    ".size __aeabi_uldivmod, . - __aeabi_uldivmod",
);
