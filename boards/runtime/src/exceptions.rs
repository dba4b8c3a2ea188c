//! Exceptions of the core: faults, the NMI of the clock security system, SysTick.

use boards::exceptions::{FAULT_STACK, FAULT_STACK_SIZE, on_fault, on_oscillator, on_tick};

/// Defines the handler of an exception after which nothing returns. The stack may be lost: it loads another one before it touches
/// memory.
macro_rules! on_its_own_stack {
    ($exception:ident, $handler:ident) => {
        // SAFETY: the vector table knows the handler by this name and no other symbol has it. It never returns.
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        unsafe extern "C" fn $exception() -> ! {
            core::arch::naked_asm!(
                "mov r0, sp",
                "ldr r1, ={stack} + {size}",
                "mov sp, r1",
                "b {handler}",
                stack = sym FAULT_STACK,
                size = const FAULT_STACK_SIZE,
                handler = sym $handler,
            )
        }
    };
}

on_its_own_stack!(HardFault, on_fault);
// The clock security system raises it alone (RM0090 7.2.7).
on_its_own_stack!(NonMaskableInt, on_oscillator);

/// Above all other handlers.
// SAFETY: the vector table knows the handler by this name and no other symbol has it. `on_tick` returns from the exception.
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn SysTick() {
    core::arch::naked_asm!("mov r0, sp", "b {handler}", handler = sym on_tick)
}
