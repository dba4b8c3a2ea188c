//! Asks each new node for its device type. A node that answers counts as a slave.
//!
//! The master reads 1000h of each new Node-ID, and again after its next boot-up message. It asks up to three times while
//! the node is heard, and takes a late answer as well. The boot-up process goes first. After a question without an answer
//! the SDO client is free for others for the same time.

use async_canopen::node::extend::Part;

use super::MasterServices;
use super::transfers::{Owner, Transfers};
use super::{Master, MasterEvent, Turn};
use crate::node::{Communication, SpacecraftDevice};
use crate::redundancy::MasterBoards;
use crate::sdo::Error;
use crate::sdo::Mode;
use crate::types::{Address, Instant};

const DEVICE_TYPE: Address = Communication::DEVICE_TYPE.address();
/// Bytes of a device type.
const BYTES: usize = 4;

/// Instants that limit the questions to new nodes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Identification {
    /// A node waits for its question.
    pub is_wanted: bool,
    not_before: Instant,
}

impl Part for Identification {
    fn earliest(&self) -> Option<Instant> {
        self.is_wanted.then_some(self.not_before)
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Returns when a waiting question can be asked. `None` while the client is not free for it.
    pub(super) fn identification_deadline(&self) -> Option<Instant> {
        let is_free = self.transfers.owner == Owner::Nobody && self.redundancy.is_announced();
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
        if self.transfers.owner != Owner::Identification {
            return;
        }
        let Transfers { client, owner, node, .. } = self.transfers.no_sooner();
        let node = *node;
        while client.pull(&mut [0; BYTES]) > 0 {}
        let Some(outcome) = client.outcome() else { return };
        *owner = Owner::Nobody;
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
}
