//! The check in the background, in the interrupt of the supervisor.

use core::sync::atomic::{AtomicUsize, Ordering};

use super::mend::{add, begin, mend_program, sealed};

/// Lines that are added in a tick.
const SLICE: usize = 32;

/// Lines that were added in this pass.
static ADDED: AtomicUsize = AtomicUsize::new(0);

/// Adds the next lines of the program. At the end of a pass with a wrong remainder the program is mended.
pub fn on_tick() {
    let added = ADDED.load(Ordering::Relaxed);
    let rest = sealed().get(added..).unwrap_or_default();
    let slice = rest.get(..SLICE).unwrap_or(rest);
    let is_wrong = add(slice) != 0;
    ADDED.store(added + slice.len(), Ordering::Relaxed);
    if slice.len() < SLICE {
        // A bit of this check may have flipped, too. `mend_program` begins again.
        if is_wrong {
            mend_program();
        }
        begin();
        ADDED.store(0, Ordering::Relaxed);
    }
}
