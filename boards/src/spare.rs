//! RAM that neither statics nor the stack need.

use core::ptr::addr_of_mut;
use core::slice;
use core::sync::atomic::{AtomicBool, Ordering};

/// Left to the stack, at the upper end of RAM: the start of a master takes 49 KiB (`cargo xtask sizes`).
const STACK: usize = 56 * 1024;
/// Most that is handed out.
const MOST: usize = 64 * 1024;

unsafe extern "C" {
    /// End of all statics.
    static mut __sheap: u8;
    /// End of RAM: here the stack begins and grows down.
    static mut _stack_start: u8;
}

static TAKEN: AtomicBool = AtomicBool::new(false);

/// The memory between statics and stack, zeroed. Empty the second time.
pub(crate) fn take() -> &'static mut [u8] {
    let (start, end) = (addr_of_mut!(__sheap), addr_of_mut!(_stack_start));
    let len = (end as usize - start as usize).saturating_sub(STACK).min(MOST);
    if len == 0 || TAKEN.swap(true, Ordering::Relaxed) {
        return &mut [];
    }
    // SAFETY: the linker places nothing behind __sheap, there is no heap, and the stack ends above; nobody else gets
    // this memory, since it is handed out once. Zeroing first makes all bytes initialised.
    unsafe {
        start.write_bytes(0, len);
        slice::from_raw_parts_mut(start, len)
    }
}
