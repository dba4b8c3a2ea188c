//! SDO transfers of the master itself. The boot-up process goes first, then the identification of new nodes.
//!
//! *Identification* asks each new node for its device type (1000h), and again after its next boot-up message. A node that
//! answers counts as a slave. The master asks up to three times while the node is heard, and takes a late answer as well.
//! After a question without an answer the SDO client is free for others for the same time.
//!
//! *Active errors* of the slaves (2048h) follow their emergencies. The master reads them after a change of the bus, a
//! takeover, and the boot-up of a slave. It does so as well after its own controller was bus-off on the active bus or lost
//! frames, a second after an emergency whose register is not explained, and every ten seconds.

use async_canopen::node::extend::Part;

use super::transfers::Owner;
use super::{Master, MasterEvent, MasterServices, Turn};
use crate::boot::machine::{Boot, BootAction, BootRequest, Identified};
use crate::emcy::{ActiveError, EmcyObjects, Emergency, ReadOutcome};
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::index::{RPDO, TPDO};
use crate::node::services::TimeServices;
use crate::node::{Communication, SpacecraftDevice};
use crate::profile::Profile;
use crate::redundancy::MasterBoards;
use crate::sdo::{Error, Mode};
use crate::types::{Address, Duration, Instant, NodeId, earliest};

/// Interval between two reads of the error register of each slave.
pub(super) const PERIOD: Duration = Duration::from_millis(10_000);
const DEVICE_TYPE: Address = Communication::DEVICE_TYPE.address();
/// Most bytes of a device type, or of an error.
const BYTES: usize = 4;
/// Bytes taken from the client at once.
const CHUNK: usize = 32;

/// Objects of a slave, which has them where every node has.
const IDENTIFIED: Identified = Identified {
    device_type: Communication::DEVICE_TYPE.index(),
    identity: Communication::IDENTITY.index(),
    configuration: Communication::CONFIGURATION.index(),
    rpdo: RPDO,
    emergency: EmcyObjects::COB_ID.index(),
    tpdo: TPDO,
};

/// Before the slaves of the profile are heard.
pub(super) fn boot_at_power_on(profile: &Profile) -> Boot {
    let mut boot = Boot::new(profile.boot, IDENTIFIED, profile.settings);
    for slave in profile.slaves {
        boot.assign(slave.node, slave.assignment());
    }
    boot
}

/// Instants that limit the questions to new nodes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Identification {
    /// A node waits for its question.
    is_wanted: bool,
    not_before: Instant,
}

impl Identification {
    /// Notes whether a node waits for its question.
    pub const fn set_wanted(&mut self, is_wanted: bool) {
        self.is_wanted = is_wanted;
    }
}

impl Part for Identification {
    fn earliest(&self) -> Option<Instant> {
        self.is_wanted.then_some(self.not_before)
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Aborts the running transfer. The boot-up process waits to hear its slaves on the new bus.
    pub(super) fn on_bus_changed(&mut self, turn: &mut Turn) {
        self.boot_mut().on_bus_changed();
        self.errors_mut().restart();
        self.abort_transfers(turn);
    }

    /// Runs the boot-up process and the SDO client.
    pub(super) fn run_boot(&mut self, turn: &mut Turn) {
        let due = earliest(&[
            self.boot.earliest(),
            self.transfers.earliest(),
            self.identification_deadline(),
            self.errors_deadline(),
        ]);
        if due.is_none_or(|due| due > turn.until) {
            return;
        }
        self.run_client(turn);
        self.collect(turn);
        self.collect_answer(turn);
        self.collect_errors(turn);
        self.carry_out_boot(turn);
        // Once: only a frame or the time ends what has begun.
        if self.begin_transfer() || self.begin_identification(turn.until) || self.begin_errors(turn.until) {
            self.run_client(turn);
            self.carry_out_boot(turn);
        }
        self.transfers.no_sooner().wake(turn.now);
    }

    /// Collects the result of a transfer of the boot-up process.
    fn collect(&mut self, turn: &mut Turn) {
        if !self.transfers.is_of(Owner::Boot) {
            return;
        }
        if !self.boot.is_asking() {
            // Its slave booted up again, is lost, or is awaited on another bus.
            self.cancel_transfer(turn);
            return;
        }
        let (transfers, mut chunk) = (self.transfers.no_sooner(), [0; CHUNK]);
        loop {
            let count = transfers.pull(&mut chunk);
            if count == 0 {
                break;
            }
            self.boot.no_sooner().on_data(chunk.get(..count).unwrap_or(&chunk));
        }
        if let Some(outcome) = transfers.finish() {
            self.boot.no_sooner().on_done(outcome.map(drop), |id| self.services.sends(id));
        }
    }

    /// Starts the next transfer of the boot-up process, if the client is free. Returns whether it did.
    fn begin_transfer(&mut self) -> bool {
        if !self.transfers.is_of(Owner::Nobody) || !self.redundancy.is_announced() {
            return false;
        }
        let time = self.services.time_pdo();
        let objects = self.services.network();
        match self.boot.no_sooner().request(|node| objects.expected(node), time) {
            Some(BootRequest::Read { node, at, most }) => {
                self.transfers.no_sooner().take(Owner::Boot, node).start_upload(at, most, Mode::Segmented);
            }
            Some(BootRequest::Write { node, at, value }) => {
                let client = self.transfers.no_sooner().take(Owner::Boot, node);
                client.start_download(at, value.len(), Mode::Auto);
                client.push(value);
            }
            None => return false,
        }
        self.services.network_mut().show_client(self.transfers.node());
        true
    }

    /// Carries out what the boot-up process decided.
    fn carry_out_boot(&mut self, turn: &mut Turn) {
        while let Some(action) = self.boot.no_sooner().poll(turn.until) {
            let objects = self.services.network_mut();
            let event = match action {
                BootAction::Hold { node, difference } => {
                    let wait =
                        NmtMessage { command: Command::EnterPreOperational, target: Target::Node(node) };
                    self.send_nmt(wait, turn);
                    MasterEvent::ConfigurationLost { node, difference }
                }
                BootAction::Start(node) => {
                    if !self.redundancy.peers().is_held(node) {
                        let start = NmtMessage { command: Command::Start, target: Target::Node(node) };
                        self.send_nmt(start, turn);
                    }
                    continue;
                }
                BootAction::ReportFailure { node, failure } => {
                    objects.show_error(node, failure.error as u8, failure.cause.abort_code());
                    MasterEvent::BootFailed { node, failure }
                }
                BootAction::ReportProgress { node, progress } => {
                    objects.show_progress(node, progress);
                    MasterEvent::Boot { node, progress }
                }
                BootAction::ReportCompleted => MasterEvent::BootCompleted,
            };
            turn.out.event(event);
        }
    }

    /// Returns when a waiting question can be asked. `None` while the client is not free for it.
    pub(super) fn identification_deadline(&self) -> Option<Instant> {
        let is_free = self.transfers.is_of(Owner::Nobody) && self.redundancy.is_announced();
        let is_wanted = self.redundancy.peers().is_any_unasked();
        (is_free && is_wanted && !self.boot.is_busy()).then_some(self.identification.not_before)
    }

    /// Starts the next question. Returns whether there is a transfer to run.
    pub(super) fn begin_identification(&mut self, until: Instant) -> bool {
        if self.identification_deadline().is_none_or(|deadline| deadline > until) {
            return false;
        }
        let node = loop {
            let Some(node) = self.redundancy.no_sooner().peers_mut().take_unasked() else { return false };
            // A minimal slave has no SDO server.
            if self.minimal(node).is_none() {
                break node;
            }
        };
        self.transfers.no_sooner().take(Owner::Identification, node).start_upload(
            DEVICE_TYPE,
            BYTES,
            Mode::Segmented,
        );
        self.services.network_mut().show_client(node);
        true
    }

    /// Collects the answer to a question.
    pub(super) fn collect_answer(&mut self, turn: &mut Turn) {
        if !self.transfers.is_of(Owner::Identification) {
            return;
        }
        let (node, transfers) = (self.transfers.node(), self.transfers.no_sooner());
        while transfers.pull(&mut [0; BYTES]) > 0 {}
        let Some(outcome) = transfers.finish() else { return };
        let peers = self.redundancy.no_sooner().peers_mut();
        match outcome {
            Err(Error::BusChanged) => peers.ask_again(node),
            Err(Error::Timeout) => {
                self.identification.no_sooner().not_before = turn.until + self.services.sdo_lifetime();
                if peers.on_no_answer(node, turn.until) {
                    turn.out.event(MasterEvent::UnknownNode { node });
                }
            }
            // Any answer is one of a server; what a slave should be is checked by the boot-up process.
            Ok(_) | Err(_) => self.redundancy.no_sooner().on_answer(node, turn.until),
        }
    }

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
        let is_free = self.transfers.is_of(Owner::Nobody) && self.redundancy.is_announced();
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
        if !self.transfers.is_of(Owner::Errors) {
            return;
        }
        let (transfers, mut value) = (self.transfers.no_sooner(), [0; BYTES]);
        // One piece: the values have 1 and 4 bytes.
        transfers.pull(&mut value);
        let Some(outcome) = transfers.finish() else { return };
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
