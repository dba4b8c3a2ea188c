//! Recovery from bus-off: after a pause, a bounded number of times in a window; then the bus is failed.

use crate::link::port::ErrorState;
use crate::types::{Duration, Instant};

/// Policy for the recovery from bus-off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BusOffPolicy {
    /// Time from bus-off to the start of the recovery sequence.
    pub pause: Duration,
    /// Longest time of a recovery sequence. Beyond it counts as another bus-off. It is above 128 of the longest
    /// frames, each of which ends in 11 recessive bits: 17 ms at 1 Mbit/s.
    pub patience: Duration,
    /// Number of recoveries allowed in a window.
    pub attempts: u8,
    /// Length of the window from the first bus-off on. A failed bus is tried again when the window ends.
    pub window: Duration,
}

/// State of the recovery of one controller.
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
    /// Instant at which the recovery sequence begins, or should have ended.
    due: Instant,
    window_end: Instant,
    used: u8,
}

/// Step of a recovery that is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RecoveryStep {
    /// Begin the recovery sequence of the controller.
    Recover,
    /// Declare the bus failed: there were too many bus-offs in the window.
    Failed,
}

impl BusOffRecovery {
    /// Makes the state of a controller on its bus.
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

    /// Takes the present state of the controller. Returns the step that is due.
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

    /// Notes that the bus was left: there is nothing to recover.
    pub fn leave(&mut self) {
        (self.off, self.failed, self.recovering, self.due) = (false, false, false, Instant::NEVER);
    }

    /// Returns the step that is due at `now`.
    pub fn poll(&mut self, now: Instant) -> Option<RecoveryStep> {
        // Later than every step is due: a bit flipped.
        let is_lost =
            self.due < Instant::NEVER && self.due.since(now) > self.window.max(self.pause).max(self.patience);
        if now < self.due && !is_lost {
            return None;
        }
        if self.recovering {
            return self.went_off(now);
        }
        (self.recovering, self.due) = (true, now + self.patience);
        Some(RecoveryStep::Recover)
    }

    /// Returns when a step is due, [`Instant::NEVER`] if none is.
    pub(crate) const fn due(&self) -> Instant {
        self.due
    }

    /// Returns when a step is due.
    pub fn deadline(&self) -> Option<Instant> {
        (self.due < Instant::NEVER).then_some(self.due)
    }

    /// Returns whether the bus is failed. It is until the controller is on it again.
    pub const fn is_failed(&self) -> bool {
        self.failed
    }
}
