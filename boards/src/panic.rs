//! A panic: its place goes to the log, then the core stops.
//!
//! The message is not read, so that the compiler drops all messages and the code that formats them, 2.5 kB of flash. The
//! place shows which check failed.

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering};

#[panic_handler]
// The lint says that this does nothing. But only when the handler is inlined does the compiler see that it reads no message.
#[allow(unused_attributes)]
#[inline(always)]
fn panic(info: &PanicInfo) -> ! {
    /// The log itself may panic.
    static PANICKED: AtomicBool = AtomicBool::new(false);
    cortex_m::interrupt::disable();
    if !PANICKED.swap(true, Ordering::Relaxed)
        && let Some(place) = info.location()
    {
        defmt::error!("panicked at {=str}:{=u32}:{=u32}", place.file(), place.line(), place.column());
    }
    // An undefined instruction is a fault, at which a debugger stops.
    cortex_m::asm::udf()
}

/// A panic of `defmt`, whose message is in the log already. Its own handler would log a place in `defmt` behind it.
#[defmt::panic_handler]
fn logged() -> ! {
    cortex_m::interrupt::disable();
    cortex_m::asm::udf()
}
