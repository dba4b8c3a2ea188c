//! Values that a slave keeps over a reset or beyond power-off: Bdefault as the bus where it found its master, and
//! resets in a row.
//!
//! | kept | since | until |
//! | --- | --- | --- |
//! | Bdefault in RAM | each find | "save", "load", power-off |
//! | Bdefault as a note in the parameter store | a consumer time after a find that changed it | a newer set, "load" |
//! | resets in a row, notes written, in RAM | | power-off; resets also until a heartbeat or a pause |

use super::{Retained, SlaveAction as Action, SlaveRedundancy, SlaveStep};
use crate::emcy::ErrorCode;
use crate::nmt::Command;
use crate::nmt::machine::ResetVerdict;
use crate::types::{Bus, Duration, Instant};

impl SlaveRedundancy {
    /// The master was found, so that Bdefault is a new one: a reset starts there.
    pub(super) fn retain_bdefault(&mut self, step: &mut SlaveStep) {
        let bdefault = Some(self.parameters().bdefault);
        self.retain(Retained { bdefault, ..self.retained }, step);
    }

    /// Nothing contradicted the new Bdefault: it is noted in the store.
    pub(super) fn keep_bdefault(&mut self, bus: Bus, step: &mut SlaveStep) {
        step.act(Action::NoteBdefault { bus, may_write: self.retained.notes < Retained::MOST_NOTES });
    }

    /// Takes the result of [`SlaveAction::NoteBdefault`](Action::NoteBdefault). `is_kept`: whether the parameter store
    /// has the new value. Returns the values that outlive a reset from now on.
    pub fn on_noted(&mut self, bus: Bus, is_kept: bool) -> Retained {
        if !is_kept {
            self.selector.set_kept(bus.other());
        }
        self.retained.notes = self.retained.notes.saturating_add(1);
        self.retained
    }

    /// Takes "save" or "load": the next reset starts on the Bdefault that is `stored` now.
    pub fn on_stored(&mut self, stored: Bus, step: &mut SlaveStep) {
        self.selector.set_kept(stored);
        self.retain(Retained { bdefault: None, ..self.retained }, step);
    }

    /// Takes a reset of this node. Returns whether the guard refuses it.
    pub(super) fn refuses(&mut self, bus: Bus, command: Command, step: &mut SlaveStep) -> bool {
        self.open_guard(step.now, step);
        let ResetVerdict::Ignore { is_first } = self.guard.on_reset(step.now) else { return false };
        if is_first {
            step.act(Action::Raise { code: ErrorCode::COMMUNICATION, source: command as u8 });
            step.act(Action::ResetIgnored { bus, command });
        }
        true
    }

    /// A reset is obeyed: it counts from now on, whatever becomes of the chip.
    pub(super) fn count_reset(&mut self, step: &mut SlaveStep) {
        self.guard.obeyed();
        self.retain_resets(step);
    }

    /// A heartbeat of the master.
    #[inline(never)] // seldom
    pub(super) fn trust_resets(&mut self, step: &mut SlaveStep) {
        let were_ignored = self.guard.on_heartbeat();
        self.trusted(were_ignored, step);
    }

    /// Two consumer times without a reset.
    pub(super) fn open_guard(&mut self, until: Instant, step: &mut SlaveStep) {
        let were_ignored = self.guard.poll(until, self.pause());
        self.trusted(were_ignored, step);
    }

    fn trusted(&mut self, were_ignored: bool, step: &mut SlaveStep) {
        if were_ignored {
            for command in [Command::ResetNode, Command::ResetCommunication] {
                step.act(Action::Clear { code: ErrorCode::COMMUNICATION, source: command as u8 });
            }
        }
        self.retain_resets(step);
    }

    fn retain_resets(&mut self, step: &mut SlaveStep) {
        self.retain(Retained { resets: self.guard.row(), ..self.retained }, step);
    }

    fn retain(&mut self, retained: Retained, step: &mut SlaveStep) {
        if retained != self.retained {
            self.retained = retained;
            step.act(Action::Retain(retained));
        }
    }

    /// Time without a reset after which resets are obeyed again.
    pub(super) fn pause(&self) -> Duration {
        let consumer = self.parameters().consumer;
        consumer + consumer
    }
}
