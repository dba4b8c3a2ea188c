//! Recovery from bus-off: after a pause, a bounded number of times in a window; then the bus is failed.

use crate::link::port::ErrorState;
use crate::types::{Duration, Instant};

/// How often a controller may come back from bus-off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BusOffPolicy {
    /// Between bus-off and the start of the recovery sequence.
    pub pause: Duration,
    /// What a recovery sequence may take; then it counts as another bus-off. Above 128 of the longest frames, each of
    /// which ends in 11 recessive bits: 17 ms at 1 Mbit/s.
    pub patience: Duration,
    /// Recoveries allowed in a window.
    pub attempts: u8,
    /// Counts from the first bus-off. A failed bus is tried again when it ends.
    pub window: Duration,
}

/// The recovery of one controller.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BusOffRecovery {
    policy: BusOffPolicy,
    off: bool,
    failed: bool,
    due: Option<Due>,
    window_end: Instant,
    used: u8,
}

/// What comes next while a controller is bus-off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Due {
    /// The recovery sequence begins.
    Recovery(Instant),
    /// It should have ended.
    End(Instant),
}

/// What is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RecoveryStep {
    /// Begin the recovery sequence.
    Recover,
    /// Too many bus-offs in the window: the bus is failed.
    Failed,
}

impl BusOffRecovery {
    /// On the bus.
    pub const fn new(policy: BusOffPolicy) -> Self {
        BusOffRecovery { policy, off: false, failed: false, due: None, window_end: Instant::ZERO, used: 0 }
    }

    /// The controller is in this state now.
    pub fn on_state(&mut self, state: ErrorState, now: Instant) -> Option<RecoveryStep> {
        let was_off = core::mem::replace(&mut self.off, state == ErrorState::BusOff);
        if !self.off {
            self.leave();
            return None;
        }
        if was_off { None } else { self.went_off(now) }
    }

    fn went_off(&mut self, now: Instant) -> Option<RecoveryStep> {
        if now >= self.window_end {
            (self.window_end, self.used) = (now + self.policy.window, 0);
        }
        if self.used < self.policy.attempts {
            self.used = self.used.saturating_add(1);
            self.due = Some(Due::Recovery(now + self.policy.pause));
            return None;
        }
        self.due = Some(Due::Recovery(self.window_end));
        (!core::mem::replace(&mut self.failed, true)).then_some(RecoveryStep::Failed)
    }

    /// The bus was left: nothing to recover any more.
    pub fn leave(&mut self) {
        (self.off, self.failed, self.due) = (false, false, None);
    }

    /// What is due at `now`.
    pub fn poll(&mut self, now: Instant) -> Option<RecoveryStep> {
        match self.due? {
            Due::Recovery(at) if at <= now => {
                self.due = Some(Due::End(now + self.policy.patience));
                Some(RecoveryStep::Recover)
            }
            Due::End(at) if at <= now => self.went_off(now),
            _ => None,
        }
    }

    /// When something is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.due.map(|(Due::Recovery(at) | Due::End(at))| at)
    }

    /// Whether the bus is failed: until the controller is back on it.
    pub const fn is_failed(&self) -> bool {
        self.failed
    }
}
