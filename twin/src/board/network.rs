//! A board and its buses: bus activity for its controllers, and warnings about mismatches of image and board.

use super::EmulatedBoard;
use crate::bxcan::{Activity, Side, bit_pclks};
use crate::rtt::{Level, LogLine};
use crate::wire::time::Time;

/// Bit rates of CiA 301 (table 1), bit/s.
const BIT_RATES: [u64; 8] = [10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

/// Time after which the bit rate of a controller counts as final: a driver may begin with that of the reset and set its
/// own some microseconds later.
const SETTLED: Time = Time::from_ms(1);

/// Whether a controller takes part in its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Participation {
    None,
    /// Takes part since this instant.
    Since(Time),
    /// Takes part, and its bit rate was checked.
    Judged,
}

impl EmulatedBoard {
    /// Updates modes, aborts and interrupts of the CAN controllers after the wires have reached `now`. `idle`: whether
    /// the bus of CAN1 and CAN2 is idle; `None`: no bus.
    pub(crate) fn settle(&mut self, now: Time, idle: [Option<bool>; 2]) {
        if !self.is_powered() {
            return;
        }
        for (side, idle) in [Side::Can1, Side::Can2].into_iter().zip(idle) {
            let heard = match self.chip.peripherals.can_registers(side).and(idle) {
                None => Activity::Nothing,
                Some(true) => Activity::Idle,
                Some(false) => Activity::Busy,
            };
            self.chip.peripherals.can.hear(side, heard);
            let reason = match heard {
                Activity::Nothing => self.chip.peripherals.unconnected_can(side, idle.is_some()),
                _ => None,
            };
            self.warn_of_pins(side, now, reason);
            self.judge_participation(side, now);
        }
        self.chip.peripherals.can.poll(now);
        if self.chip.peripherals.can.irqs() != self.can_lines {
            self.refresh();
        }
    }

    /// Logs why a controller reaches no bus, once for each reason.
    fn warn_of_pins(&mut self, side: Side, at: Time, reason: Option<String>) {
        let known = &mut self.unconnected[side as usize];
        if *known == reason {
            return;
        }
        *known = reason.clone();
        if let Some(reason) = reason {
            self.warn(at, format!("{side} takes part in no bus: {reason}"));
        }
    }

    /// Logs mismatches after a controller has taken part for a while: wires to pins that the program does not use, and
    /// a bit rate that is not in CiA 301, which usually means that the image was built for another oscillator.
    fn judge_participation(&mut self, side: Side, at: Time) {
        let known = &mut self.participation[side as usize];
        if !self.chip.peripherals.can.takes_part(side) {
            *known = Participation::None;
            return;
        }
        match *known {
            Participation::None => {
                *known = Participation::Since(at);
                return;
            }
            Participation::Since(begin) if at >= begin + SETTLED => *known = Participation::Judged,
            _ => return,
        }
        for contradiction in self.chip.peripherals.unused_wires(self.config.fittings.capture_wires) {
            self.warn_once(at, contradiction);
        }
        let clocks = self.chip.peripherals.rcc.clocks();
        let rate = clocks.hclk / clocks.apb1_divider / bit_pclks(self.can_btr(side));
        if BIT_RATES.iter().any(|known| rate.abs_diff(*known) * 200 <= *known) {
            return;
        }
        let [hclk, hse] = [clocks.hclk, self.config.model.oscillator.hz].map(|hz| hz as f64 / 1e6);
        let text = format!(
            "{side} runs at {:.1} kbit/s, which is no bit rate of CiA 301: HCLK is {hclk} MHz, and the oscillator of the board has \
             {hse} MHz; build the image for this oscillator, or correct the oscillator of the board",
            rate as f64 / 1e3
        );
        self.warn_once(at, text);
    }

    fn warn_once(&mut self, at: Time, text: String) {
        if !self.warnings.contains(&text) {
            self.warn(at, text);
        }
    }

    fn warn(&mut self, at: Time, text: String) {
        self.log.push(LogLine { at, level: Some(Level::Warn), text: format!("twin: {text}") });
        if !self.warnings.contains(&text) {
            self.warnings.push(text);
        }
    }
}
