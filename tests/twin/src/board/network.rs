//! A board and its buses: what its controllers hear, and a warning when one reaches no bus.

use can_wire::time::Time;

use super::EmulatedBoard;
use crate::bxcan::{Activity, Side};
use crate::rtt::{Level, Line};

impl EmulatedBoard {
    /// The wires have reached `now`: modes, aborts and interrupts of the CAN controllers follow. `idle` says of CAN1 and CAN2
    /// whether their bus is idle; `None`: no bus.
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
            self.chip.peripherals.can_mut().hear(side, heard);
            let reason = match heard {
                Activity::Nothing => self.chip.peripherals.unconnected_can(side, idle.is_some()),
                _ => None,
            };
            self.warn_of(side, now, reason);
        }
        self.chip.peripherals.can_mut().poll(now);
        if self.chip.peripherals.can().irqs() != self.can_lines {
            self.refresh();
        }
    }

    /// Logs why a controller reaches no bus, once for each reason.
    fn warn_of(&mut self, side: Side, at: Time, reason: Option<String>) {
        let known = &mut self.unconnected[side as usize];
        if *known == reason {
            return;
        }
        if let Some(reason) = &reason {
            let text = format!("twin: {side} takes part in no bus: {reason}");
            self.log.push(Line { at, level: Some(Level::Warn), text });
        }
        *known = reason;
    }
}
