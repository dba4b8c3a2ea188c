//! Values that a slave keeps over a reset or beyond power-off: Bdefault as the bus where it found its master, and
//! resets in a row.
//!
//! | kept | since | until |
//! | --- | --- | --- |
//! | Bdefault in RAM | each find | "save", "load", power-off |
//! | Bdefault as a note in the parameter store | a consumer time after a find that changed it | a newer set, "load" |
//! | resets in a row, notes written, in RAM | | power-off; resets also until a heartbeat or a pause |

use super::{Retained, SlaveAction as Action, SlaveNode, SlaveRedundancy};
use crate::emcy::ErrorCode;
use crate::nmt::{Command, ResetVerdict};
use crate::types::{Bus, Duration, Instant};

impl SlaveRedundancy {
    /// The master was found, so that Bdefault is a new one: a reset starts there.
    pub(super) fn retain_bdefault(&mut self, node: &mut impl SlaveNode) {
        let bdefault = Some(self.parameters().bdefault);
        self.retain(Retained { bdefault, ..self.retained }, node);
    }

    /// Nothing contradicted the new Bdefault: it is noted in the store.
    pub(super) fn keep_bdefault(&mut self, bus: Bus, node: &mut impl SlaveNode) {
        let notes = self.retained.notes;
        let is_kept = notes < Retained::MOST_NOTES
            && match node.note_bdefault(bus) {
                Some(is_kept) => is_kept,
                None => return,
            };
        if !is_kept {
            self.selector.set_kept(bus.other());
        }
        self.retain(Retained { notes: notes.saturating_add(1), ..self.retained }, node);
        node.act(Action::BdefaultNoted { bus, is_kept });
    }

    /// Takes "save" or "load": the next reset starts on the Bdefault that is `stored` now.
    pub fn on_stored(&mut self, stored: Bus, node: &mut impl SlaveNode) {
        self.selector.set_kept(stored);
        self.retain(Retained { bdefault: None, ..self.retained }, node);
    }

    /// A reset of this node. Returns whether the guard does not let it pass.
    pub(super) fn is_refused(
        &mut self,
        bus: Bus,
        command: Command,
        now: Instant,
        node: &mut impl SlaveNode,
    ) -> bool {
        self.open_guard(now, node);
        let ResetVerdict::Ignore { is_first } = self.guard.on_reset(now) else { return false };
        if is_first {
            node.act(Action::Raise { code: ErrorCode::COMMUNICATION, source: command as u8 });
            node.act(Action::ResetIgnored { bus, command });
        }
        true
    }

    /// A reset is obeyed: it counts from now on, whatever becomes of the chip.
    pub(super) fn count_reset(&mut self, node: &mut impl SlaveNode) {
        self.guard.obeyed();
        self.retain_resets(node);
    }

    /// A heartbeat of the master.
    #[inline(never)] // seldom
    pub(super) fn trust_resets(&mut self, node: &mut impl SlaveNode) {
        let were_ignored = self.guard.on_heartbeat();
        self.trusted(were_ignored, node);
    }

    /// Two consumer times without a reset.
    pub(super) fn open_guard(&mut self, until: Instant, node: &mut impl SlaveNode) {
        let were_ignored = self.guard.poll(until, self.pause());
        self.trusted(were_ignored, node);
    }

    fn trusted(&mut self, were_ignored: bool, node: &mut impl SlaveNode) {
        if were_ignored {
            for command in [Command::ResetNode, Command::ResetCommunication] {
                node.act(Action::Clear { code: ErrorCode::COMMUNICATION, source: command as u8 });
            }
        }
        self.retain_resets(node);
    }

    fn retain_resets(&mut self, node: &mut impl SlaveNode) {
        self.retain(Retained { resets: self.guard.row(), ..self.retained }, node);
    }

    fn retain(&mut self, retained: Retained, node: &mut impl SlaveNode) {
        if retained != self.retained {
            self.retained = retained;
            node.act(Action::Retain(retained));
        }
    }

    /// Time without a reset after which resets are obeyed again.
    pub(super) fn pause(&self) -> Duration {
        let consumer = self.parameters().consumer;
        consumer + consumer
    }
}
