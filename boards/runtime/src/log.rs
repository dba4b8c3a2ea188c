//! The log: a ring in RAM, by `defmt-rtt`, that a debug probe reads. When a program ends, its record contains the
//! newest bytes of the log.

use core::sync::atomic::{AtomicU32, Ordering};

use defmt_rtt as _;

/// Control block of the log, with the layout of RTT as version 1.3.1 of `defmt-rtt` declares it. The manifest requires
/// exactly that version.
#[repr(C)]
struct ControlBlock {
    id: [u8; 16],
    up_channels: u32,
    down_channels: u32,
    name: u32,
    buffer: u32,
    size: u32,
    /// Offset in the buffer at which the next byte is written.
    next: AtomicU32,
}

const ID: [u8; 16] = *b"SEGGER RTT\0\0\0\0\0\0";

unsafe extern "C" {
    #[link_name = "_SEGGER_RTT"]
    static LOG: ControlBlock;
}

/// Copies the newest bytes of the log, the newest one last. Copies nothing if the control block has another layout.
pub(crate) fn newest(bytes: &mut [u8]) {
    // SAFETY: `defmt-rtt` defines the symbol, and it is larger than what is read here. Any bits are numbers.
    let log = unsafe { &LOG };
    let mut at = log.next.load(Ordering::Relaxed);
    if log.id != ID || log.up_channels != 1 || at >= log.size {
        return;
    }
    for byte in bytes.iter_mut().rev() {
        at = if at == 0 { log.size } else { at } - 1;
        // SAFETY: the buffer is a static of bytes with this size, as the checks above say of the control block.
        *byte = unsafe { ((log.buffer + at) as *const u8).read_volatile() };
    }
}

/// Ends a panic of `defmt`, whose message is in the log already.
#[cfg(feature = "panics")]
#[defmt::panic_handler]
fn logged() -> ! {
    cortex_m::interrupt::disable();
    panic_probe::hard_fault()
}
