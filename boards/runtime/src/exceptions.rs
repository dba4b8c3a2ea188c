//! Exceptions of the core: faults, the NMI of the clock security system, SysTick.

use boards_stm32f4::exceptions::{FAULT_STACK, FAULT_STACK_SIZE, ReadLog, on_fault, on_oscillator, on_tick};

/// What a record gets of the log.
const LOG: ReadLog = {
    #[cfg(feature = "log")]
    let log = crate::log::newest;
    #[cfg(not(feature = "log"))]
    let log = |_: &mut [u8]| ();
    log
};

/// `frame`: where the exception stacked the registers of what it interrupted. Of all three.
extern "C" fn fault(frame: u32) -> ! {
    on_fault(Some(frame), LOG)
}

extern "C" fn oscillator(frame: u32) -> ! {
    on_oscillator(Some(frame), LOG)
}

extern "C" fn tick(frame: u32) {
    on_tick(Some(frame), LOG);
}

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

on_its_own_stack!(HardFault, fault);
// The clock security system raises it alone (RM0090 7.2.7).
on_its_own_stack!(NonMaskableInt, oscillator);

/// Above all other handlers.
// SAFETY: the vector table knows the handler by this name and no other symbol has it. `tick` returns from the exception.
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn SysTick() {
    core::arch::naked_asm!("mov r0, sp", "b {handler}", handler = sym tick)
}
