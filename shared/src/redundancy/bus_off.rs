//! Recovery from bus-off: after a pause, a bounded number of times in a window; then the bus is failed.

use crate::link::port::ErrorState;
use crate::time::{Duration, Instant};

/// How often a controller may come back from bus-off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BusOffPolicy {
    /// Between bus-off and the start of the recovery sequence.
    pub pause: Duration,
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
    recover_at: Option<Instant>,
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
        BusOffRecovery {
            policy,
            off: false,
            failed: false,
            recover_at: None,
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
        if was_off {
            return None;
        }
        if now >= self.window_end {
            (self.window_end, self.used) = (now + self.policy.window, 0);
        }
        if self.used < self.policy.attempts {
            self.used = self.used.saturating_add(1);
            self.recover_at = Some(now + self.policy.pause);
            return None;
        }
        self.recover_at = Some(self.window_end);
        self.failed = true;
        Some(RecoveryStep::Failed)
    }

    /// The bus was left: nothing to recover any more.
    pub fn leave(&mut self) {
        (self.off, self.failed, self.recover_at) = (false, false, None);
    }

    /// The recovery, when it is due.
    pub fn poll(&mut self, now: Instant) -> Option<RecoveryStep> {
        self.recover_at.filter(|at| *at <= now)?;
        self.recover_at = None;
        Some(RecoveryStep::Recover)
    }

    /// When the recovery is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.recover_at
    }

    /// Whether the bus is failed: until the controller is back on it.
    pub const fn is_failed(&self) -> bool {
        self.failed
    }
}
