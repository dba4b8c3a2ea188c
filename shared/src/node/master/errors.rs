//! Active errors of the slaves (object 2048h): follows their emergencies, and reads what it may not have heard.
//!
//! The master reads after a change of the bus, a takeover, and the boot-up of a slave. It does so as well after its own
//! controller was bus-off on the active bus or lost frames, a second after an emergency whose register is not explained,
//! and every ten seconds.
//! The boot-up process and the identification of new nodes go first.

use super::MasterServices;
use super::transfers::{Owner, Transfers};
use super::{Master, MasterEvent, Turn};
use crate::emcy::{ActiveError, Emergency, ReadOutcome};
use crate::node::SpacecraftDevice;
use crate::redundancy::MasterBoards;
use crate::sdo::Error;
use crate::sdo::Mode;
use crate::types::{Duration, Instant, NodeId};

/// Between two looks at the register of each slave.
pub(super) const PERIOD: Duration = Duration::from_millis(10_000);
/// Most bytes of an answer.
const BYTES: usize = 4;

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Returns the active errors of the slaves, as far as they reported them (objects 2048h and 2049h).
    pub fn active_errors(&self) -> impl Iterator<Item = ActiveError> {
        self.services.errors().iter()
    }

    /// Takes an emergency of a slave.
    pub(super) fn follow_errors(&mut self, node: NodeId, emergency: &Emergency, turn: &mut Turn) {
        let errors = self.services.errors_mut();
        if !errors.on_emergency(node, emergency) {
            turn.out.event(MasterEvent::ErrorNotKept { node });
        }
        if !errors.explain(node, emergency.register) {
            self.errors_mut().ask_again(node, turn.now);
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
        let errors = services.errors();
        // One that does not count has no SDO server as far as the master knows.
        let is_minimal = |node| minimal.iter().any(|minimal| minimal.node == node);
        let has_server = |node| redundancy.peers().counts(node) && !is_minimal(node);
        let question = reader.no_sooner().question(errors, has_server, until);
        let Some((node, object)) = question else { return false };
        self.transfers.no_sooner().take(Owner::Errors, node).start_upload(object, BYTES, Mode::Segmented);
        self.services.network_mut().show_client(node);
        true
    }

    /// Collects an answer.
    pub(super) fn collect_errors(&mut self, turn: &mut Turn) {
        if self.transfers.owner != Owner::Errors {
            return;
        }
        let Transfers { client, owner, .. } = self.transfers.no_sooner();
        let mut value = [0; BYTES];
        // One piece: the values have 1 and 4 bytes.
        client.pull(&mut value);
        let Some(outcome) = client.outcome() else { return };
        *owner = Owner::Nobody;
        let answer = match outcome {
            Ok(_) => ReadOutcome::Value(u32::from_le_bytes(value)),
            Err(Error::Timeout) => ReadOutcome::Missing,
            Err(Error::BusChanged) => ReadOutcome::BusChanged,
            Err(_) => ReadOutcome::Refused,
        };
        let (timeout, errors) = (self.services.sdo_lifetime(), self.services.errors_mut());
        if let Some(node) = self.errors.no_sooner().on_answer(answer, errors, timeout, turn.until) {
            turn.out.event(MasterEvent::ErrorsRead { node });
        }
    }
}
