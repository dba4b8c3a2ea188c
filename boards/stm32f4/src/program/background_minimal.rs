//! The check in the background, in the interrupt of the supervisor.

use core::sync::atomic::{AtomicUsize, Ordering};

use embassy_stm32::pac::RCC;

use super::mend::{add, begin, mend_program, sealed};

/// Lines that are added in a tick.
const SLICE: usize = 32;

/// Lines that were added in this pass.
static ADDED: AtomicUsize = AtomicUsize::new(0);

/// Adds the next lines of the program. At the end of a pass with a wrong remainder the program is mended.
pub fn on_tick() {
    let program = sealed();
    if program.is_empty() {
        return;
    }
    let added = ADDED.load(Ordering::Relaxed);
    if added == 0 {
        // No table of registers shows that this clock was lost.
        RCC.ahb1enr().modify(|w| w.set_crcen(true));
        begin();
    }
    let rest = program.get(added..).unwrap_or_default();
    let slice = rest.get(..SLICE).unwrap_or(rest);
    let is_wrong = add(slice) != 0;
    let is_last = slice.len() < SLICE;
    // A bit of this check may have flipped, too. `mend_program` begins again.
    if is_last && is_wrong {
        mend_program();
    }
    ADDED.store(if is_last { 0 } else { added + SLICE }, Ordering::Relaxed);
}
