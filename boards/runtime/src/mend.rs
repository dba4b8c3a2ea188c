//! The first function of a program: it mends the program.

/// Runs before RAM has its initial values, because any other function may have the flipped bit.
// SAFETY: the start-up code of `cortex-m-rt` knows the function by this name, and no other symbol has it. It uses registers,
// flash, and RAM without initial values.
#[unsafe(no_mangle)]
unsafe extern "C" fn __pre_init() {
    ecss_can_stm32f4::mend_program();
}
