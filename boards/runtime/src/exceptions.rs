//! Exceptions of the core: faults, the NMI of the clock security system, SysTick.

use ecss_can_stm32f4::exceptions::{
    FAULT_STACK, FAULT_STACK_SIZE, ReadLog, on_fault, on_oscillator, on_tick,
};

/// Function that copies the end of the log into a record.
const LOG: ReadLog = {
    #[cfg(feature = "log")]
    let log = crate::log::newest;
    #[cfg(not(feature = "log"))]
    let log = |_: &mut [u8]| ();
    log
};

/// Ends the program; used by all three fault exceptions. `frame`: address at which the exception stacked the registers
/// of the interrupted code.
extern "C" fn fault(frame: u32) -> ! {
    on_fault(Some(frame), LOG)
}

extern "C" fn oscillator(frame: u32) -> ! {
    on_oscillator(Some(frame), LOG)
}

extern "C" fn tick(frame: u32) {
    on_tick(Some(frame), LOG);
}

/// Defines the handler of an exception that never returns. The stack may be unusable, so the handler loads another
/// stack pointer before it accesses memory.
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
// Only the clock security system raises the NMI (RM0090 7.2.7).
on_its_own_stack!(NonMaskableInt, oscillator);

/// Has a higher priority than all other handlers.
// SAFETY: the vector table knows the handler by this name and no other symbol has it. `tick` returns from the exception.
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn SysTick() {
    core::arch::naked_asm!("mov r0, sp", "b {handler}", handler = sym tick)
}
