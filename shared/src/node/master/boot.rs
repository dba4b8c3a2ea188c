//! Boot-up process in the master: SDO transfers, starts of slaves, and reports.

use async_canopen::node::extend::Part;

use super::MasterServices;
use super::transfers::{Owner, Transfers};
use super::{Master, MasterEvent, Turn};
use crate::boot::machine::{Boot, BootAction, BootRequest, Identified};
use crate::emcy::EmcyObjects;
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::index::{RPDO, TPDO};
use crate::node::services::TimeServices;
use crate::node::{Communication, SpacecraftDevice};
use crate::profile::Profile;
use crate::redundancy::MasterBoards;
use crate::sdo::Mode;
use crate::types::earliest;

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
#[inline(never)] // made in its place
pub(super) fn at_power_on(profile: &Profile) -> Boot {
    let mut boot = Boot::new(profile.boot, IDENTIFIED, profile.settings);
    for slave in profile.slaves {
        boot.assign(slave.node, slave.assignment());
    }
    boot
}

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// The transfer that was running fails. The boot-up process waits to hear its slaves on the new bus.
    pub(super) fn on_bus_changed(&mut self, turn: &mut Turn) {
        self.boot_mut().on_bus_changed();
        self.errors_mut().restart();
        self.abort_transfers(turn);
    }

    /// Everything that the boot-up process and the SDO client can do now.
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
        if self.transfers.owner != Owner::Boot {
            return;
        }
        if !self.boot.is_asking() {
            // Its slave booted up again, is lost, or is awaited on another bus.
            self.cancel_transfer(turn);
            return;
        }
        let Transfers { client, owner, .. } = self.transfers.no_sooner();
        let mut chunk = [0; CHUNK];
        loop {
            let count = client.pull(&mut chunk);
            if count == 0 {
                break;
            }
            self.boot.no_sooner().on_data(chunk.get(..count).unwrap_or(&chunk));
        }
        if let Some(outcome) = client.outcome() {
            *owner = Owner::Nobody;
            self.boot.no_sooner().on_done(outcome.map(drop), |id| self.services.sends(id));
        }
    }

    /// Starts the next transfer of the boot-up process, if the client is free. Returns whether it did.
    fn begin_transfer(&mut self) -> bool {
        if self.transfers.owner != Owner::Nobody || !self.redundancy.is_announced() {
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
        self.services.network_mut().show_client(self.transfers.node);
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
}
