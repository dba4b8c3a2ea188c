//! The interrupt of SysTick, ten times a second.

use crate::post_mortem::ReadLog;
#[cfg(not(feature = "full"))]
use crate::program;
#[cfg(feature = "full")]
use crate::register_table;
use crate::supervisor;

/// Compares registers, on a minimal board a part of the program, and feeds the watchdog or ends the program. Call it from the handler of SysTick, which has the highest
/// priority. `frame`: address at which the exception stacked the registers of the interrupted code. With `None` the record of a
/// late task has no program counter. `log` reads the log, see [`ReadLog`].
pub fn on_tick(frame: Option<u32>, log: ReadLog) {
    #[cfg(feature = "full")]
    register_table::on_tick(frame, log);
    #[cfg(not(feature = "full"))]
    program::on_tick();
    supervisor::on_tick(frame, log);
}
