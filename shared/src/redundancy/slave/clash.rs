//! Two nodes with one Node-ID: the clash is reported, and the node that booted last is silent.

use super::{SlaveAction as Action, SlaveRedundancy, SlaveStep, SlaveVerdict};
use crate::emcy::ErrorCode;
use crate::heartbeat;
use crate::nmt::machine::{Clash, ClashTimes};
use crate::redundancy::Parameters;
use crate::types::{Bus, Duration, Frame, Instant};

/// Heartbeat periods after boot-up for which a node yields to one that it hears.
pub(super) const PERIODS: u32 = 2;
/// The same while its own heartbeat is late: two rounds of the pattern of late heartbeats.
const ROUNDS: u32 = 2 * 32;

impl SlaveRedundancy {
    /// A heartbeat with the Node-ID of this node, which does not receive its own.
    #[inline(never)] // heartbeats of others need not pay for it
    pub(super) fn on_own_heartbeat(
        &mut self,
        bus: Bus,
        frame: &Frame,
        at: Instant,
        step: &mut SlaveStep,
    ) -> SlaveVerdict {
        let Some(state) = heartbeat::decode(frame) else { return SlaveVerdict::Malformed };
        let control = step.control;
        let periods = if control.is_held_back(at) { ROUNDS } else { PERIODS };
        let (is_due, source) = (control.is_just_due(at), control.id().get());
        let clash = self.clashes.on_heartbeat(state, at, self.probation(periods), is_due);
        if clash == Clash::Known {
            return SlaveVerdict::Taken;
        }
        step.act(Action::Clash { bus, yields: clash == Clash::Newcomer });
        step.act(Action::Raise { code: ErrorCode::CAN_ID_COLLISION, source });
        SlaveVerdict::Taken
    }

    /// Does what the clash demands at `until`. Returns whether there was something.
    pub(super) fn follow_clash(&mut self, until: Instant, step: &mut SlaveStep) -> bool {
        if self.clashes.must_fall_silent() {
            self.clashes.fall_silent();
            // Stopped forbids the message, so it goes out before.
            step.act(Action::FallSilent { bus: self.selected() });
        } else if self.clashes.poll(until, self.parameters().hold_off_time()) {
            self.on_clash_over(step);
        } else {
            return false;
        }
        true
    }

    /// Returns the time after boot-up in which the node yields: the consumer time, or `periods` heartbeat periods if
    /// these are longer.
    pub(super) fn probation(&self, periods: u32) -> Duration {
        let Parameters { consumer, producer, .. } = *self.parameters();
        consumer.max(producer.times(periods))
    }

    /// Times for the canonical form. No heartbeat of a model is late, which would make the probation longer.
    pub(super) fn clash_times(&self) -> ClashTimes {
        ClashTimes { probation: self.probation(PERIODS), quiet: self.parameters().hold_off_time() }
    }

    /// The other node was silent long enough.
    fn on_clash_over(&mut self, step: &mut SlaveStep) {
        let source = step.control.id().get();
        step.act(Action::Clear { code: ErrorCode::CAN_ID_COLLISION, source });
        step.act(Action::ClashOver);
        if self.clashes.restore() {
            self.enter_pre_operational(step);
            step.act(Action::Announce);
        }
    }
}
