//! RAM that neither statics nor the stack use.

use core::ptr::addr_of_mut;
use core::slice;
use core::sync::atomic::{AtomicBool, Ordering};

/// Largest size that is returned, in bytes.
const MOST: usize = 64 * 1024;

unsafe extern "C" {
    /// End of all statics.
    static mut __sheap: u8;
    /// End of RAM.
    static mut _ram_end: u8;
}

static TAKEN: AtomicBool = AtomicBool::new(false);

/// Returns the memory behind the statics, zeroed. The second call returns an empty slice.
pub(crate) fn take() -> &'static mut [u8] {
    let (start, end) = (addr_of_mut!(__sheap), addr_of_mut!(_ram_end));
    let len = (end as usize - start as usize).min(MOST);
    if len == 0 || TAKEN.swap(true, Ordering::Relaxed) {
        return &mut [];
    }
    // SAFETY: the linker places nothing behind __sheap, there is no heap, and the stack is elsewhere; the memory is
    // returned once, so this is the only reference. Zeroing first initialises all bytes.
    unsafe {
        start.write_bytes(0, len);
        slice::from_raw_parts_mut(start, len)
    }
}
