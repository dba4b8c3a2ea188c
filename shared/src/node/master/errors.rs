//! Active errors of the slaves (object 2048h): follows their emergencies, and reads what it may not have heard.
//!
//! The master reads after a change of the bus, a takeover, and the boot-up of a slave. It does so as well after its own
//! controller was bus-off on the active bus or lost frames, a second after an emergency whose register is not explained,
//! and every ten seconds.
//! The boot-up process and the identification of new nodes go first.

use super::transfers::Owner;
use super::{Master, MasterEvent, Out};
use crate::emcy::{ActiveError, Emergency, ReadOutcome};
use crate::node::Device;
use crate::redundancy::MasterBoards;
use crate::sdo::{Error, Mode};
use crate::types::{Duration, Instant, NodeId};

/// Between two looks at the register of each slave.
pub(super) const PERIOD: Duration = Duration::from_millis(10_000);
/// Most bytes of an answer.
const BYTES: usize = 4;

impl<D: Device, B: MasterBoards> Master<D, B> {
    /// Returns the active errors of the slaves, as far as they reported them (objects 2048h and 2049h).
    pub fn active_errors(&self) -> impl Iterator<Item = ActiveError> {
        self.services.dictionary.objects.application.errors.iter()
    }

    /// Takes an emergency of a slave.
    pub(super) fn follow_errors(&mut self, node: NodeId, emergency: &Emergency, now: Instant, out: &mut Out) {
        let errors = &mut self.services.dictionary.objects.application.errors;
        if !errors.on_emergency(node, emergency) {
            out.event(MasterEvent::ErrorNotKept { node });
        }
        if !errors.explain(node, emergency.register) {
            self.errors.ask_again(node, now);
        }
    }

    /// Returns when the errors of a slave can be read. `None` while the client is not free for it.
    pub(super) fn errors_deadline(&self) -> Option<Instant> {
        let due = self.errors.deadline()?;
        let is_free = self.transfers.owner == Owner::Nobody && self.redundancy.is_announced();
        (is_free && !self.boot.is_busy() && !self.redundancy.peers().is_any_unasked()).then_some(due)
    }

    /// Starts to read an object. Returns whether there is a transfer to run.
    pub(super) fn begin_errors(&mut self, until: Instant) -> bool {
        if self.errors_deadline().is_none_or(|deadline| deadline > until) {
            return false;
        }
        let Self { redundancy, services, errors: reader, minimal, .. } = self;
        let errors = &services.dictionary.objects.application.errors;
        // One that does not count has no SDO server as far as the master knows.
        let is_minimal = |node| minimal.iter().any(|minimal| minimal.node == node);
        let has_server = |node| redundancy.peers().counts(node) && !is_minimal(node);
        let Some((node, object)) = reader.question(errors, has_server, until) else { return false };
        self.transfers.take(Owner::Errors, node).start_upload(object, BYTES, Mode::Segmented);
        self.services.dictionary.objects.application.network.show_client(node);
        true
    }

    /// Collects an answer.
    pub(super) fn collect_errors(&mut self, until: Instant, out: &mut Out) {
        if self.transfers.owner != Owner::Errors {
            return;
        }
        let client = &mut self.transfers.client;
        let mut value = [0; BYTES];
        // One piece: the values have 1 and 4 bytes.
        client.pull(&mut value);
        let Some(outcome) = client.outcome() else { return };
        self.transfers.owner = Owner::Nobody;
        let errors = &mut self.services.dictionary.objects.application.errors;
        let answer = match outcome {
            Ok(_) => ReadOutcome::Value(u32::from_le_bytes(value)),
            Err(Error::Timeout) => ReadOutcome::Missing,
            Err(Error::BusChanged) => ReadOutcome::BusChanged,
            Err(_) => ReadOutcome::Refused,
        };
        let timeout = self.services.lifetimes.sdo;
        if let Some(node) = self.errors.on_answer(answer, errors, timeout, until) {
            out.event(MasterEvent::ErrorsRead { node });
        }
    }
}
