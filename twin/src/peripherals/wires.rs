//! Wires of the board to timers, and the program's use of their pins.

use super::gpio::TIMER_AF;
use super::timers::{TIM3, TIM5, TIMERS};
use super::{CAPTURE_PINS, Peripherals, TIM3_PINS};
use crate::bxcan::Side;
use crate::pin::Pin;

impl Peripherals {
    /// Returns mismatches of the program and the board's wires: it captures CAN_RX, or outputs a pulse, at another pin.
    /// A program that does neither has none.
    pub(crate) fn unused_wires(&self, has_capture_wires: bool) -> Vec<String> {
        let capture = self.pins.capture.filter(|_| has_capture_wires).into_iter().flatten();
        let captured = self.captured_pins();
        let capture = [Side::Can1, Side::Can2].into_iter().zip(capture).filter_map(|(side, wired)| {
            let other = captured.first().filter(|_| !captured.contains(&wired))?;
            Some(format!("TIM5 captures at {other}, and the board has the wire from {side}_RX at {wired}"))
        });
        let pulsed = self.pulsed_pins();
        let pulse = self.pins.pulse.and_then(|wired| {
            let other = pulsed.first().filter(|_| !pulsed.contains(&wired))?;
            Some(format!("TIM3 drives {other}, and the board has the pulse at {wired}"))
        });
        capture.chain(pulse).collect()
    }

    /// Pins at which TIM5 captures.
    fn captured_pins(&self) -> Vec<Pin> {
        let is_on = self.rcc.is_clocked(TIMERS[TIM5].gate);
        let pins = (0..4)
            .zip(CAPTURE_PINS)
            .filter(|(input, pin)| self.timers.all[TIM5].captures(*input) && self.is_of_timer(*pin));
        pins.map(|(_, pin)| pin).filter(|_| is_on).collect()
    }

    /// Pins that TIM3 drives.
    fn pulsed_pins(&self) -> Vec<Pin> {
        let is_on = self.rcc.is_clocked(TIMERS[TIM3].gate);
        let channels =
            (0..4).zip(TIM3_PINS).filter(|(channel, _)| self.timers.all[TIM3].output(*channel).is_some());
        let pins = channels.flat_map(|(_, pins)| pins).copied();
        pins.filter(|pin| is_on && self.is_of_timer(*pin)).collect()
    }

    fn is_of_timer(&self, pin: Pin) -> bool {
        self.gpio[pin.port_index()].alternate_function(u32::from(pin.number)) == Some(TIMER_AF)
    }
}
