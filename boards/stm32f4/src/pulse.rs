//! One pulse at a pin, at an instant of TIM5, to compare the clocks of boards on an oscilloscope.
//!
//! ```text
//! TIM5, a channel that captures nothing, match ── TRGO ── ITR2 ── TIM3 counts once ── channel 4 ── PB1
//! ```
//!
//! TIM5, which also captures frames, compares all its 32 bits and starts TIM3, which generates the pulse in one-pulse
//! mode. So hardware generates both edges, on the time base of the stamps. The match is set five clocks early, which is
//! the delay from match to edge (RM0090 18.4.7, OC1FE). The outputs of TIM5 are not used because boards need these
//! pins, as PA2 and PA3 for the serial port of the ST-LINK on the Nucleo.

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
/// Earliest and latest time before the edge at which the match is armed. The latest has a margin because TIM5 may be a
/// microsecond behind the uptime.
const EARLIEST: Duration = Duration::from_millis(5);
const LATEST: Duration = Duration::from_micros(10);

/// Lead time with which the instant of a pulse is computed.
const AHEAD: Duration = Duration::from_micros(500);

/// The pulse output of a board, low.
pub struct Pulse {
    /// Channel of TIM5 that starts the pulse, from 0.
    channel: usize,
}

/// The instant is past, or less than 10 µs away. There was no pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the instant of the pulse is past, or less than 10 µs away")]
pub struct TooLate;

impl Pulse {
    /// Takes the pin and a channel of TIM5, from 0. TIM5 must count already.
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
        // Dropping the pin would disconnect the timer.
        core::mem::forget(pin);
        Pulse { channel }
    }

    /// Raises the pin at `at`, rounded to the nearest tick of TIM5 (11.9 ns), for 20 µs. Returns after the pulse.
    ///
    /// # Cancel safety
    /// If the future is dropped before the edge, there is no pulse.
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

    /// Raises a pulse at the beginning of each second of the spacecraft time, or of each of `per_second` equal parts of
    /// it. `per_second` is called before each pulse. There is no pulse at a time that a clock step skips.
    pub async fn run<P: Platform<Clock = Uptime>, N: TimeKeeper>(
        mut self,
        clock: SpacecraftClock<P, N>,
        per_second: impl Fn() -> u16,
    ) -> ! {
        loop {
            let next = clock.now().plus(AHEAD).next_part(per_second());
            // Computed late, because the clock may be corrected until then.
            clock.at(next.minus(AHEAD)).await;
            if self.at(clock.when(next)).await.is_err() {
                warn!("no pulse at second {=u32}: the clock stepped", next.coarse());
            }
        }
    }
}

/// An armed channel of TIM5, which starts the pulse.
struct Armed(usize);

impl Drop for Armed {
    fn drop(&mut self) {
        set_mode(self.0, Ocm::FORCE_INACTIVE);
    }
}

/// Sets the output compare mode of a channel of TIM5.
fn set_mode(channel: usize, mode: Ocm) {
    TIM5.ccmr_output(channel / 2).modify(|w| w.set_ocm(channel % 2, mode));
}
