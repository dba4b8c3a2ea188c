//! One pulse at a pin, at an instant of TIM5, to compare the clocks of boards on an oscilloscope.
//!
//! ```text
//! TIM5, a channel that captures nothing, match ── TRGO ── ITR2 ── TIM3 counts once ── channel 4 ── PB1
//! ```
//!
//! TIM5, which also captures frames, compares over its 32 bits and starts TIM3; TIM3 in one-pulse mode makes the pulse and
//! its width. So both edges are made by hardware, and no second time base runs beside that of the stamps. From the match to
//! the edge pass five clocks (RM0090 18.4.7, OC1FE), which the match is early by. The outputs of TIM5 itself are not
//! used: a board has them for other things, such as PA2 and PA3, the serial port of the ST-LINK on the Nucleo.

use thiserror::Error;

use ecss_can::node::TimeKeeper;
use ecss_can::runner::Clock;
use ecss_can::runner::{Platform, SpacecraftClock};
use ecss_can::types::{Duration, FineInstant};
use embassy_stm32::gpio::{AfType, Flex, OutputType, Speed};
use embassy_stm32::pac::timer::vals::{Mms, Ocm, Sms, Ts};
use embassy_stm32::pac::{TIM3, TIM5};
use embassy_stm32::{peripherals, rcc};

use crate::Uptime;
use crate::alternate::AlternatePin;
use crate::capture::PER_MICRO;
use crate::spec::PulseOutput;

/// Clocks of both timers from the match to the edge.
const LATENCY: u32 = 5;
/// Length of a pulse.
const WIDTH: Duration = Duration::from_micros(20);
/// The match is armed between these two before the edge. TIM5 is up to a microsecond behind the uptime, so that the latest is
/// not too late.
const EARLIEST: Duration = Duration::from_millis(5);
const LATEST: Duration = Duration::from_micros(10);

/// The clock is asked when a pulse is to be, so long before it.
const AHEAD: Duration = Duration::from_micros(500);

/// The pulse output of a board, low.
pub struct Pulse {
    /// Of TIM5, from 0.
    channel: usize,
}

/// The instant is past, or less than 10 µs away. There was no pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the instant of the pulse is past, or less than 10 µs away")]
pub struct TooLate;

impl Pulse {
    /// Takes the pin and a channel of TIM5, from 0. TIM5 counts already.
    pub(crate) fn new(output: PulseOutput, channel: usize) -> Pulse {
        rcc::enable_and_reset::<peripherals::TIM3>();
        TIM3.arr().write(|w| w.set_arr((WIDTH.as_micros() as u32 * PER_MICRO) as u16));
        TIM3.ccr(3).write(|w| w.set_ccr(1));
        TIM3.ccmr_output(1).write(|w| w.set_ocm(1, Ocm::PWM_MODE2));
        TIM3.ccer().write(|w| w.set_cce(3, true));
        TIM3.smcr().write(|w| {
            w.set_ts(Ts::ITR2);
            w.set_sms(Sms::TRIGGER_MODE);
        });
        TIM3.cr1().write(|w| w.set_opm(true));
        TIM5.cr2().write(|w| w.set_mms(Mms::from_bits(Mms::COMPARE_OC1.to_bits() + channel as u8)));
        let AlternatePin(function, pin) = output.pin;
        let mut pin = Flex::new(pin);
        pin.set_as_af_unchecked(function, AfType::output(OutputType::PushPull, Speed::VeryHigh));
        // Dropping it would cut the timer off.
        core::mem::forget(pin);
        Pulse { channel }
    }

    /// Raises the pin at `at`, rounded to the nearest tick of TIM5 (11.9 ns), for 20 µs. Returns after the pulse. Dropped before
    /// the edge, there is no pulse.
    ///
    /// # Errors
    /// [`TooLate`]: there was no pulse, rather than one at another time.
    pub async fn at(&mut self, at: FineInstant) -> Result<(), TooLate> {
        let instant = at.instant();
        Uptime.at(instant - EARLIEST).await;
        let ticks = at.ticks(PER_MICRO);
        let _armed = cortex_m::interrupt::free(|_| {
            if instant.since(Uptime.now()) < LATEST {
                return Err(TooLate);
            }
            TIM5.ccr(self.channel).write_value((ticks as u32).wrapping_sub(LATENCY));
            set_mode(self.channel, Ocm::ACTIVE_ON_MATCH);
            Ok(Armed(self.channel))
        })?;
        Uptime.at(instant + WIDTH + LATEST).await;
        Ok(())
    }

    /// A pulse whenever a second of the spacecraft time begins, or one of so many equal parts of it: `per_second` is asked before
    /// each. A time that the clock steps over has none.
    pub async fn run<P: Platform<Clock = Uptime>, N: TimeKeeper>(
        mut self,
        clock: SpacecraftClock<P, N>,
        per_second: impl Fn() -> u16,
    ) -> ! {
        loop {
            let next = clock.now().plus(AHEAD).next_part(per_second());
            // The clock is asked late: it may be steered until then.
            clock.at(next.minus(AHEAD)).await;
            if self.at(clock.when(next)).await.is_err() {
                warn!("no pulse at second {=u32}: the clock stepped", next.coarse());
            }
        }
    }
}

/// This channel of TIM5 is to start a pulse.
struct Armed(usize);

impl Drop for Armed {
    fn drop(&mut self) {
        set_mode(self.0, Ocm::FORCE_INACTIVE);
    }
}

/// Sets how a channel of TIM5 matches.
fn set_mode(channel: usize, mode: Ocm) {
    TIM5.ccmr_output(channel / 2).modify(|w| w.set_ocm(channel % 2, mode));
}
