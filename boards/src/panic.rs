//! A panic: its place goes to the log, which goes into the post-mortem record, then the chip is reset.
//!
//! The message is not read, so that the compiler drops all messages and the code that formats them, 2.5 kB of flash. The
//! place shows which check failed.

use core::panic::PanicInfo;
#[cfg(feature = "full")]
use core::sync::atomic::{AtomicBool, Ordering};

use crate::post_mortem;

#[cfg(feature = "full")]
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
    post_mortem::panicked()
}

/// The place is not read either: a minimal slave has no room for the names of all files.
#[cfg(not(feature = "full"))]
#[panic_handler]
#[allow(unused_attributes)] // see above
#[inline(always)]
fn panic(_: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    post_mortem::panicked()
}

/// A panic of `defmt`, whose message is in the log already. Its own handler would log a place in `defmt` behind it.
#[defmt::panic_handler]
fn logged() -> ! {
    cortex_m::interrupt::disable();
    post_mortem::panicked()
}
