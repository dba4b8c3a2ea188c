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
    // The policy, field by field: copied as a whole, it would keep the profile that it comes from in an image.
    pause: Duration,
    patience: Duration,
    attempts: u8,
    window: Duration,
    off: bool,
    failed: bool,
    /// The recovery sequence runs.
    recovering: bool,
    /// When the recovery sequence begins, or should have ended.
    due: Instant,
    window_end: Instant,
    used: u8,
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
        let BusOffPolicy { pause, patience, attempts, window } = policy;
        BusOffRecovery {
            pause,
            patience,
            attempts,
            window,
            off: false,
            failed: false,
            recovering: false,
            due: Instant::NEVER,
            window_end: Instant::ZERO,
            used: 0,
        }
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
        self.recovering = false;
        if now >= self.window_end {
            (self.window_end, self.used) = (now + self.window, 0);
        }
        if self.used < self.attempts {
            self.used = self.used.saturating_add(1);
            self.due = now + self.pause;
            return None;
        }
        self.due = self.window_end;
        (!core::mem::replace(&mut self.failed, true)).then_some(RecoveryStep::Failed)
    }

    /// The bus was left: nothing to recover any more.
    pub fn leave(&mut self) {
        (self.off, self.failed, self.recovering, self.due) = (false, false, false, Instant::NEVER);
    }

    /// What is due at `now`.
    pub fn poll(&mut self, now: Instant) -> Option<RecoveryStep> {
        if now < self.due {
            return None;
        }
        if self.recovering {
            return self.went_off(now);
        }
        (self.recovering, self.due) = (true, now + self.patience);
        Some(RecoveryStep::Recover)
    }

    /// When something is due.
    pub fn deadline(&self) -> Option<Instant> {
        (self.due < Instant::NEVER).then_some(self.due)
    }

    /// Whether the bus is failed: until the controller is back on it.
    pub const fn is_failed(&self) -> bool {
        self.failed
    }
}
