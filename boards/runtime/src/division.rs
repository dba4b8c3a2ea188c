//! Division of 64-bit numbers, in place of the compiler's functions, which take ten times the memory.
//!
//! Each bit of the quotient takes about ten cycles. A node divides times in microseconds, a few for each SYNC. Strong
//! symbols take the place of weak ones of `compiler_builtins` (run-time ABI of ARM, IHI 0043, 4.3.1).

// SAFETY: as the run-time ABI defines, the numerator is in r0 and r1, the denominator in r2 and r3, the lower words
// first. The quotient is returned in r0 and r1, the remainder in r2 and r3. The stack is used for saved registers only,
// r4 to r6 are restored. A division by zero, which Rust excludes before the call, ends with a quotient of all ones.
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

// SAFETY: operands and results as above, signed: the quotient is rounded towards zero, the remainder has the sign of
// the numerator. `__aeabi_uldivmod` divides the absolute values. The absolute value of the least number is correct when
// read as unsigned. The stack is used for saved registers only, r4 to r6 are restored.
core::arch::global_asm!(
    ".syntax unified",
    ".section .text.__aeabi_ldivmod, \"ax\", %progbits",
    ".global __aeabi_ldivmod",
    ".type __aeabi_ldivmod, %function",
    ".thumb_func",
    "__aeabi_ldivmod:",
    "push {{r4, r5, r6, lr}}",
    // Signs of the remainder and of the quotient.
    "mov r4, r1",
    "eor r5, r1, r3",
    "cmp r1, #0",
    "bpl 1f",
    "rsbs r0, r0, #0",
    "sbc r1, r1, r1, lsl #1",
    "1: cmp r3, #0",
    "bpl 2f",
    "rsbs r2, r2, #0",
    "sbc r3, r3, r3, lsl #1",
    "2: bl __aeabi_uldivmod",
    "cmp r5, #0",
    "bpl 3f",
    "rsbs r0, r0, #0",
    "sbc r1, r1, r1, lsl #1",
    "3: cmp r4, #0",
    "bpl 4f",
    "rsbs r2, r2, #0",
    "sbc r3, r3, r3, lsl #1",
    "4: pop {{r4, r5, r6, pc}}",
    ".size __aeabi_ldivmod, . - __aeabi_ldivmod",
);
