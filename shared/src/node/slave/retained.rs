//! Values that a slave keeps over a reset or beyond power-off: Bdefault as the bus where it found its master, and
//! resets in a row.
//!
//! | kept | since | until |
//! | --- | --- | --- |
//! | Bdefault in RAM | each find | "save", "load", power-off |
//! | Bdefault as a note in the parameter store | a consumer time after a find that changed it | a newer set, "load" |
//! | resets in a row, notes written, in RAM | | power-off; resets also until a heartbeat or a pause |

use super::{Out, Slave};
use crate::emcy::ErrorCode;
use crate::nmt::{Command, NmtMessage, ResetGuard, ResetVerdict};
use crate::node::{Device, SlaveEvent};
use crate::redundancy::Selector;
use crate::store::{Group, MOST_NOTES, Retained, RetainedMemory};
use crate::types::{Bus, Duration, Instant};

/// Memory that outlives a reset, if the board has some, and what is in it.
#[derive(Default)]
pub(super) struct Memory {
    words: Option<&'static mut (dyn RetainedMemory + Send)>,
    held: Retained,
}

impl core::fmt::Debug for Memory {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.held.fmt(f)
    }
}

impl Memory {
    #[inline(never)] // of several callers, none in a hurry
    fn hold(&mut self, held: Retained) {
        if let Some(words) = &mut self.words
            && held != self.held
        {
            words.write(held.encode());
        }
        self.held = held;
    }
}

impl<D: Device> Slave<D> {
    /// Adds memory that outlives a reset. The slave starts on the bus where it last found its master, and counts
    /// resets in a row across resets of its chip.
    #[must_use]
    pub fn with_retained(mut self, words: &'static mut (dyn RetainedMemory + Send)) -> Self {
        let held = Retained::decode(words.read()).unwrap_or_default();
        self.retained = Memory { words: Some(words), held };
        self.guard = ResetGuard::new(held.resets);
        self.select_bdefault(self.selector.kept());
        self
    }

    /// Before power-on: takes what is stored.
    pub(super) fn load_all(&mut self) {
        self.canopen.services.dictionary.objects.spacecraft.redundancy.parameters.bdefault =
            self.initial.bdefault.bdefault();
        self.canopen.services.load(Group::All);
        self.select_bdefault(self.written_redundancy().bdefault);
    }

    /// Before power-on: selects the retained Bdefault, else the stored one (ECSS 8.3.2a).
    fn select_bdefault(&mut self, stored: Bus) {
        if let Some(bus) = self.retained.held.bdefault {
            self.canopen.services.dictionary.objects.spacecraft.redundancy.parameters.bdefault =
                bus.bdefault();
        }
        self.selector = Selector::new(self.written_redundancy());
        self.selector.set_kept(stored);
    }

    /// The master was found, so that Bdefault is a new one: a reset starts there.
    pub(super) fn retain_bdefault(&mut self) {
        let bdefault = Some(self.selector.parameters().bdefault);
        self.retained.hold(Retained { bdefault, ..self.retained.held });
    }

    /// Nothing contradicted the new Bdefault: it is noted in the store.
    pub(super) fn keep_bdefault(&mut self, bus: Bus, out: &mut Out) {
        let held = self.retained.held;
        let is_kept = held.notes < MOST_NOTES
            && match self.canopen.services.dictionary.stored.note_bdefault(self.canopen.id, bus) {
                Some(outcome) => outcome.is_ok(),
                None => return,
            };
        if !is_kept {
            self.selector.set_kept(bus.other());
        }
        self.retained.hold(Retained { notes: held.notes.saturating_add(1), ..held });
        out.event(SlaveEvent::BdefaultNoted { bus, is_kept });
    }

    /// "save" or "load" was written: the next reset starts on the Bdefault that is stored now.
    pub(super) fn on_stored(&mut self, is_saved: bool) {
        let stored = if is_saved { self.written_redundancy().bdefault } else { self.initial.bdefault };
        self.selector.set_kept(stored);
        self.retained.hold(Retained { bdefault: None, ..self.retained.held });
    }

    /// Returns whether a command is a reset of this node that the guard does not let pass.
    pub(super) fn is_refused(&mut self, bus: Bus, message: &NmtMessage, now: Instant, out: &mut Out) -> bool {
        let NmtMessage { command, target } = *message;
        if !matches!(command, Command::ResetNode | Command::ResetCommunication)
            || !target.includes(self.canopen.id)
        {
            return false;
        }
        self.open_guard(now);
        let ResetVerdict::Ignore { is_first } = self.guard.on_reset(now) else { return false };
        self.canopen.services.wake(self.guard.deadline(self.pause()));
        self.canopen.services.buses.ignored(bus);
        if is_first {
            self.canopen.services.raise(ErrorCode::COMMUNICATION, [command as u8, 0, 0, 0, 0]);
            self.canopen.services.next = now;
            out.event(SlaveEvent::ResetIgnored { bus, command });
        }
        true
    }

    /// A reset is obeyed: it counts from now on, whatever becomes of the chip.
    pub(super) fn count_reset(&mut self) {
        self.guard.obeyed();
        self.retain_resets();
    }

    /// A heartbeat of the master.
    pub(super) fn trust_resets(&mut self) {
        let were_ignored = self.guard.on_heartbeat();
        self.trusted(were_ignored);
    }

    /// Two consumer times without a reset.
    pub(super) fn open_guard(&mut self, until: Instant) {
        let were_ignored = self.guard.poll(until, self.pause());
        self.trusted(were_ignored);
    }

    fn trusted(&mut self, were_ignored: bool) {
        if were_ignored {
            for command in [Command::ResetNode, Command::ResetCommunication] {
                self.canopen.services.clear(ErrorCode::COMMUNICATION, command as u8);
            }
            self.canopen.services.next = Instant::ZERO;
        }
        self.retain_resets();
    }

    fn retain_resets(&mut self) {
        self.retained.hold(Retained { resets: self.guard.row(), ..self.retained.held });
    }

    /// The pause of the guard.
    pub(super) fn pause(&self) -> Duration {
        let consumer = self.selector.parameters().consumer;
        consumer + consumer
    }
}
