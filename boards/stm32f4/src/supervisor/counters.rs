//! Comparison of counters that share no register: the uptime (TIM2 and its interrupt), SysTick and the capture timer TIM5.
//!
//! All of them count one clock, so their ratio is exact and their differences are constant. A counter that stops, counts
//! at another rate or jumps differs from both others within one tick of SysTick. All depend on the PLL: an error of HSE or
//! of the PLL changes all of them equally and is not seen here.
//!
//! ```text
//! uptime    84 * microseconds
//! SysTick   2^23 * ticks + cycles since the last tick      + a constant
//! TIM5      count; started as 84 * uptime
//! ```
//! The unit is a cycle of the timers, 1/84 µs, modulo 2^32. On a board without capture only the first two are compared.

#[cfg(feature = "full")]
use core::sync::atomic::AtomicBool;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::{DCB, SYST};
#[cfg(feature = "full")]
use embassy_stm32::pac::TIM5;
use embassy_time::Instant;

use crate::clocks::TIMERS;

/// Logarithm of the timer cycles in a tick of SysTick: 99.9 ms.
pub const TICK: u32 = 23;
const PER_MICRO: u32 = TIMERS / 1_000_000;
/// Largest difference. Between two of the reads the core may wait for the flash, which programs a word within 100 µs
/// (DS8626, flash memory characteristics). The uptime is rounded to 1 µs. The smallest error of a rate, that of a flipped
/// bit 0 of a prescaler of 84, is 1.2 ms in a tick.
const TOLERANCE: u32 = 128 * PER_MICRO;
/// Set in a known offset, which is therefore not zero. After one flipped bit it is not zero either.
const KNOWN: u32 = 0b11;

/// Count of SysTick minus the uptime; zero while it is not known.
static OFFSET: AtomicU32 = AtomicU32::new(0);
/// Whether TIM5 counts the uptime.
#[cfg(feature = "full")]
static IS_CAPTURING: AtomicBool = AtomicBool::new(false);

/// Returns the reload value of SysTick for a core clock of `hclk` Hz, 84 MHz or 168 MHz.
pub fn reload(hclk: u32) -> u32 {
    ((hclk / TIMERS) << TICK) - 1
}

/// Adds TIM5 to the comparison: from now on its count is the uptime in cycles of the timers.
#[cfg(feature = "full")]
pub fn add_capture() {
    IS_CAPTURING.store(true, Ordering::Relaxed);
}

/// Compares the counters in tick number `ticks` of SysTick. Returns the name of the one that differs.
pub fn odd_one(ticks: u32) -> Option<&'static [u8; 4]> {
    let reload = SYST::get_reload();
    // At 168 MHz a cycle of the timers has two cycles of the core, and the reload value has one bit more.
    let since = (reload - SYST::get_current()) >> (reload >> TICK);
    let uptime = (Instant::now().as_micros() as u32).wrapping_mul(PER_MICRO);
    let counted = (ticks << TICK).wrapping_add(since);
    let offset = OFFSET.load(Ordering::Relaxed);
    // A debugger halts the core and SysTick, and the timers count on.
    if offset == 0 || DCB::is_debugger_attached() {
        OFFSET.store(counted.wrapping_sub(uptime) | KNOWN, Ordering::Relaxed);
        return None;
    }
    let differs = |count: u32| count.wrapping_sub(uptime).wrapping_add(TOLERANCE) > 2 * TOLERANCE;
    #[cfg(feature = "full")]
    let is_capture_odd = IS_CAPTURING.load(Ordering::Relaxed) && differs(TIM5.cnt().read());
    #[cfg(not(feature = "full"))]
    let is_capture_odd = false;
    match (differs(counted.wrapping_sub(offset)), is_capture_odd) {
        (false, false) => None,
        (true, false) => Some(b"SYST"),
        (false, true) => Some(b"TIM5"),
        (true, true) => Some(b"TIM2"),
    }
}
