//! The error register, and the error-state changes that are not yet reported.
//!
//! ESR shows the present state. Interrupts record it whenever it may have changed; the task takes the changes since its
//! last poll. If the task polls late, neither a bus-off nor a worse state that has ended by then is lost.
//!
//! Verifies: ECSS 5.6.2a

use ecss_can::link::port::{ErrorState, Health, LastError};

const EWGF: u32 = 1 << 0;
const EPVF: u32 = 1 << 1;
const BOFF: u32 = 1 << 2;

/// ESR as read (RM0090 32.9.2). Reading it changes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Status(pub u32);

impl Status {
    /// After a recovery from bus-off, as after reset: error active, both counters zero.
    const FRESH: Status = Status(0);

    /// EWGF, EPVF and BOFF.
    pub fn flags(self) -> u32 {
        self.0 & (EWGF | EPVF | BOFF)
    }

    pub fn is_warning(self) -> bool {
        self.0 & EWGF != 0
    }

    pub fn is_passive(self) -> bool {
        self.0 & EPVF != 0
    }

    pub fn is_bus_off(self) -> bool {
        self.0 & BOFF != 0
    }

    /// Returns whether the status is that of a transmitter without another node on the bus.
    fn is_unacknowledged(self) -> bool {
        self.is_passive() && self.last_error() == LastError::Ack
    }

    fn last_error(self) -> LastError {
        match self.0 >> 4 & 0b111 {
            1 => LastError::Stuff,
            2 => LastError::Form,
            3 => LastError::Ack,
            4 => LastError::BitRecessive,
            5 => LastError::BitDominant,
            6 => LastError::Crc,
            // LEC is 7 only if software wrote it, which this driver does not.
            _ => LastError::None,
        }
    }

    /// Returns error state and counters.
    pub fn health(self) -> Health {
        let [_, _, tec, rec] = self.0.to_le_bytes();
        let state = if self.is_bus_off() {
            ErrorState::BusOff
        } else if self.is_passive() {
            ErrorState::Passive
        } else {
            ErrorState::Active
        };
        Health { state, tec, rec, last_error: self.last_error() }
    }

    /// Returns the flags that may raise the error interrupt now. In bus-off only another bus-off may: the receive error
    /// counter may count recessive sequences then. If flags that are set `repeat` the interrupt, only those that are
    /// clear may raise it.
    fn enables(self, repeat: bool) -> Enables {
        let stands = |flag: bool| flag && repeat;
        let on_bus = !self.is_bus_off();
        Enables {
            warning: on_bus && !stands(self.is_warning()),
            passive: on_bus && !stands(self.is_passive()),
            bus_off: !stands(self.is_bus_off()),
        }
    }

    /// Rank of the state; a change between equal ranks is not reported.
    fn severity(self) -> u8 {
        if self.is_bus_off() {
            4
        } else if self.is_unacknowledged() {
            3
        } else {
            u8::from(self.is_warning()) + u8::from(self.is_passive())
        }
    }
}

/// Flags that may raise the error interrupt: EWGIE, EPVIE and BOFIE of IER.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Enables {
    pub warning: bool,
    pub passive: bool,
    pub bus_off: bool,
}

impl Enables {
    pub const ALL: Enables = Enables { warning: true, passive: true, bus_off: true };
}

/// Error-state changes that the task has to report.
#[derive(Debug)]
pub(super) struct ErrorLog {
    told: Status,
    latest: Status,
    /// Worst status recorded since the task's last poll.
    worst: Status,
    /// Number of bus-offs not yet reported, and the status of the latest one.
    bus_offs: u8,
    off: Status,
    /// The manual says that ERRI is set when a flag rises. After it was once set by a flag that was set already, flags
    /// that are set are masked.
    repeats: bool,
    /// Flags that are set are masked until the register is recorded next.
    masked: bool,
    /// A change was recorded since [`ErrorLog::take`] last returned `None`.
    changed: bool,
}

impl ErrorLog {
    pub const fn new() -> Self {
        let fresh = Status::FRESH;
        ErrorLog {
            told: fresh,
            latest: fresh,
            worst: fresh,
            bus_offs: 0,
            off: fresh,
            repeats: false,
            masked: false,
            changed: false,
        }
    }

    /// Returns whether the present value of the register has to be recorded.
    #[inline]
    pub fn is_news(&self, now: Status) -> bool {
        now != self.latest || self.masked
    }

    /// Returns the flags that may raise the error interrupt, as [`ErrorLog::note`] and [`ErrorLog::on_interrupt`] returned
    /// them last.
    pub fn enables(&self) -> Enables {
        self.latest.enables(self.repeats || self.masked)
    }

    /// Records the present value of the register. Returns the flags that may raise the error interrupt from now on.
    pub fn note(&mut self, now: Status) -> Enables {
        (self.masked, self.changed) = (false, true);
        if now.is_bus_off() && !self.latest.is_bus_off() {
            self.went_off(now);
        }
        self.latest = now;
        if now.severity() >= self.worst.severity() {
            self.worst = now;
        }
        now.enables(self.repeats)
    }

    /// Handles the error interrupt with the present value of the register. Returns the flags that may raise the next
    /// one. `repeated`: the interrupt would be raised again at once. If the last recorded state is bus-off, the
    /// interrupt means another bus-off: the first one ended between two polls.
    pub fn on_interrupt(&mut self, now: Status, repeated: bool) -> Enables {
        let off_again = now.is_bus_off() && self.latest.is_bus_off() && !self.repeats;
        if off_again {
            self.went_off(now);
        }
        let is_news = off_again || now.flags() & !self.latest.flags() != 0;
        self.repeats |= repeated;
        let enables = self.note(now);
        // Some controllers may interrupt for every error while a flag is set. Masking the flag until the register is
        // read for another reason avoids an interrupt storm on a cut bus.
        self.masked = !is_news;
        if is_news { enables } else { now.enables(true) }
    }

    fn went_off(&mut self, now: Status) {
        self.bus_offs = self.bus_offs.saturating_add(1);
        self.off = now;
    }

    /// Takes the next change, the oldest first.
    #[inline]
    pub fn take(&mut self) -> Option<Health> {
        if self.changed { self.news() } else { None }
    }

    #[inline(never)] // most looks find nothing noted
    fn news(&mut self) -> Option<Health> {
        let news = if self.bus_offs > 0 {
            if self.told.is_bus_off() {
                // Between two bus-offs there is always a recovery.
                Status::FRESH
            } else {
                self.bus_offs -= 1;
                self.worst = Status::FRESH;
                self.off
            }
        } else {
            let worst = core::mem::replace(&mut self.worst, Status::FRESH);
            if worst.severity() > self.told.severity().max(self.latest.severity()) {
                worst
            } else if self.latest.severity() != self.told.severity() {
                self.latest
            } else {
                self.changed = false;
                return None;
            }
        };
        self.told = news;
        Some(news.health())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // RM0090 32.9.2: REC 31:24, TEC 23:16, LEC 6:4, BOFF 2, EPVF 1, EWGF 0.
    const ACTIVE: Status = Status(0x0000_0000);
    const WARNING: Status = Status(0x0060_0031);
    const PASSIVE: Status = Status(0x0580_0053);
    const ALONE: Status = Status(0x0080_0033);
    const OFF: Status = Status(0x00F8_0057);

    fn news(log: &mut ErrorLog) -> Vec<Health> {
        std::iter::from_fn(|| log.take()).collect()
    }

    fn states(log: &mut ErrorLog) -> Vec<ErrorState> {
        news(log).into_iter().map(|health| health.state).collect()
    }

    /// Given a controller that interrupts for every error while a flag is set, then a cut bus causes no interrupt
    /// storm.
    #[test]
    fn interrupt_without_new_flag_masks_set_flags_until_next_poll() {
        let mut log = ErrorLog::new();
        assert_eq!(log.on_interrupt(PASSIVE, false), Enables::ALL);
        let masked = Enables { warning: false, passive: false, bus_off: true };
        assert_eq!(log.on_interrupt(PASSIVE, false), masked);
        assert_eq!(log.note(PASSIVE), Enables::ALL);
    }

    #[test]
    fn unchanged_register_is_noted_again_only_if_flags_are_masked() {
        let mut log = ErrorLog::new();
        assert!(log.is_news(PASSIVE));
        log.on_interrupt(PASSIVE, false);
        assert!(!log.is_news(PASSIVE));
        log.on_interrupt(PASSIVE, false);
        assert!(log.is_news(PASSIVE), "masked");
        log.note(PASSIVE);
        assert!(!log.is_news(PASSIVE) && log.is_news(WARNING));
    }

    /// Verifies: ECSS 5.6.2b, 5.6.2c
    /// Notices: ECSS 5.6.2a: bus-off is taken for error passive, and nothing recovers from it.
    #[test]
    fn the_register_tells_state_counters_and_last_error() {
        let passive =
            Health { state: ErrorState::Passive, tec: 0x80, rec: 5, last_error: LastError::BitDominant };
        assert_eq!(PASSIVE.health(), passive);
        assert_eq!(ACTIVE.health(), Health::default());
        assert_eq!(OFF.health().state, ErrorState::BusOff);
        let causes = [1, 2, 3, 4, 5, 6].map(|lec| Status(lec << 4).health().last_error);
        use LastError::{Ack, BitDominant, BitRecessive, Crc, Form, Stuff};
        assert_eq!(causes, [Stuff, Form, Ack, BitRecessive, BitDominant, Crc]);
    }

    /// Verifies: ECSS 5.6.2b
    /// Notices: ECSS 5.6.2b: the return to error active is not reported.
    #[test]
    fn a_change_of_state_is_told_once_and_moving_counters_are_none() {
        let mut log = ErrorLog::new();
        assert_eq!(log.take(), None);
        log.note(Status(0x0008_0030));
        assert_eq!(log.take(), None);
        for status in [WARNING, ALONE, PASSIVE, ACTIVE] {
            log.note(status);
            assert_eq!(news(&mut log), [status.health()]);
        }
    }

    /// Verifies: ECSS 5.6.2b
    /// Notices: ECSS 5.6.2b: error passive that was over before the application looked is not reported.
    #[test]
    fn worse_state_that_ended_is_reported_before_the_present_one() {
        let mut log = ErrorLog::new();
        [WARNING, PASSIVE, WARNING].into_iter().for_each(|status| _ = log.note(status));
        assert_eq!(news(&mut log), [PASSIVE.health(), WARNING.health()]);
        [PASSIVE, ACTIVE].into_iter().for_each(|status| _ = log.note(status));
        assert_eq!(news(&mut log), [PASSIVE.health(), ACTIVE.health()]);
    }

    #[test]
    fn a_bus_off_that_is_over_when_the_task_looks_is_told() {
        let mut log = ErrorLog::new();
        log.on_interrupt(OFF, false);
        log.note(ACTIVE);
        assert_eq!(news(&mut log), [OFF.health(), ACTIVE.health()]);
    }

    #[test]
    fn second_bus_off_before_end_of_first_is_reported_separately() {
        use ErrorState::{Active, BusOff};
        let mut log = ErrorLog::new();
        log.on_interrupt(OFF, false);
        assert_eq!(states(&mut log), [BusOff]);
        log.on_interrupt(OFF, false);
        assert_eq!(states(&mut log), [Active, BusOff]);
        // Neither bus-off was polled, nor the recovery after the second one.
        log.note(ACTIVE);
        log.on_interrupt(OFF, false);
        log.on_interrupt(OFF, false);
        log.note(ACTIVE);
        assert_eq!(states(&mut log), [Active, BusOff, Active, BusOff, Active]);
    }

    #[test]
    fn looking_at_a_controller_in_bus_off_is_no_news() {
        let mut log = ErrorLog::new();
        log.on_interrupt(OFF, false);
        assert_eq!(states(&mut log), [ErrorState::BusOff]);
        log.note(OFF);
        assert_eq!(log.take(), None);
    }

    #[test]
    fn in_bus_off_only_another_bus_off_may_interrupt() {
        let mut log = ErrorLog::new();
        assert_eq!(log.on_interrupt(ALONE, false), Enables::ALL);
        assert_eq!(log.on_interrupt(OFF, false), Enables { warning: false, passive: false, bus_off: true });
        assert_eq!(log.note(ACTIVE), Enables::ALL);
    }

    #[test]
    fn enabled_flags_are_those_that_were_returned_last() {
        let mut log = ErrorLog::new();
        assert_eq!(log.enables(), Enables::ALL);
        for (status, repeated) in
            [(PASSIVE, false), (PASSIVE, false), (OFF, false), (PASSIVE, true), (WARNING, false)]
        {
            let enables = log.on_interrupt(status, repeated);
            assert_eq!(log.enables(), enables, "{status:?}");
            let enables = log.note(ACTIVE);
            assert_eq!(log.enables(), enables, "{status:?}, then active");
        }
    }

    #[test]
    fn flags_that_repeat_their_interrupt_are_masked_while_set() {
        let mut log = ErrorLog::new();
        let enables = log.on_interrupt(PASSIVE, true);
        assert_eq!(enables, Enables { warning: false, passive: false, bus_off: true });
        assert_eq!(log.on_interrupt(OFF, true), Enables { warning: false, passive: false, bus_off: false });
        // A repeated interrupt does not count as another bus-off.
        log.on_interrupt(OFF, true);
        assert_eq!(states(&mut log), [ErrorState::BusOff]);
        assert_eq!(log.note(WARNING), Enables { warning: false, passive: true, bus_off: true });
        assert_eq!(log.note(ACTIVE), Enables::ALL);
    }
}
