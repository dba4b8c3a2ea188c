//! SDO client of the master: one transfer at a time, for the boot-up process, the application, the identification of a
//! new node, or the errors of a slave.

use core::task::Waker;

use async_canopen::node::extend::{Part, SdoStep};
use async_canopen::store::machine::Storage;
use embassy_sync::waitqueue::MultiWakerRegistration;

use super::{Master, Turn};
use crate::link::bit_timing::BitRate;
use crate::node::{ClientNode, SpacecraftDevice};
use crate::redundancy::MasterBoards;
use crate::sdo;
use crate::sdo::machine::Client;
use crate::types::{Bus, CobId, Duration, Frame, Instant, NodeId};

/// Tasks that may wait for the client without waking each other.
const TASKS: usize = 4;

/// Bit times that the bus is left to others between two sub-blocks: four heartbeats, which have a lower priority than
/// SDOs, fit in. A sub-block takes fifty times as long.
const GAP_BITS: u32 = 300;

/// A server that follows to another bus aborts its transfer there: what is sent until then would be taken for aborted.
const AFTER_SWITCH: Duration = Duration::from_millis(10);

/// Owner of the transfer that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    Nobody,
    Boot,
    Application,
    /// The master asks a node for its device type.
    Identification,
    /// The master reads the errors of a slave.
    Errors,
    /// The application released it: the transfer is to be cancelled.
    Abandoned,
}

#[derive(Debug)]
pub(super) struct Transfers {
    client: Client,
    owner: Owner,
    /// Node-ID of the server.
    node: NodeId,
    /// Something was done to the client: it may have something to send.
    is_due: bool,
    gap: Duration,
    /// Nothing is sent before.
    pause: Option<Instant>,
    /// Between two sub-blocks.
    is_at_gap: bool,
    tasks: MultiWakerRegistration<TASKS>,
}

impl Transfers {
    pub fn new(timeout: Duration, bit_rate: BitRate) -> Transfers {
        Transfers {
            client: Client::new(timeout),
            gap: Duration::from_micros(u64::from(1_000_000 * GAP_BITS / bit_rate.get().max(1))),
            pause: None,
            is_at_gap: false,
            owner: Owner::Nobody,
            node: NodeId::MASTER,
            is_due: false,
            tasks: MultiWakerRegistration::new(),
        }
    }

    pub fn deadline(&self) -> Option<Instant> {
        self.pause.or_else(|| self.client.deadline())
    }

    fn is_overdue(&self, until: Instant) -> bool {
        self.is_due || self.deadline().is_some_and(|deadline| deadline <= until)
    }

    /// Notes that a frame of the client was sent, or failed.
    fn on_sent(&mut self) {
        self.client.on_sent();
        self.is_due = true;
    }

    /// Takes the client for a transfer that is about to start.
    pub fn take(&mut self, owner: Owner, node: NodeId) -> &mut Client {
        (self.owner, self.node, self.is_due) = (owner, node, true);
        &mut self.client
    }

    /// Returns whether the running transfer is one of `owner`.
    pub fn is_of(&self, owner: Owner) -> bool {
        self.owner == owner
    }

    /// Returns the Node-ID of the server.
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// Takes received bytes of the transfer. Returns their number.
    pub fn pull(&mut self, into: &mut [u8]) -> usize {
        self.client.pull(into)
    }

    /// Returns the end of the transfer, once. Then the client is free.
    pub fn finish(&mut self) -> Option<Result<usize, sdo::Error>> {
        let outcome = self.client.outcome()?;
        self.owner = Owner::Nobody;
        Some(outcome)
    }

    /// Wakes the tasks that can continue.
    pub fn wake(&mut self, now: Instant) {
        let is_at_gap = self.client.fills_bus() && self.client.needs_application();
        if is_at_gap && !self.is_at_gap {
            self.pause = Some(now + self.gap);
        }
        self.is_at_gap = is_at_gap;
        let goes_on = match self.owner {
            Owner::Nobody => true,
            Owner::Application => self.client.needs_application(),
            Owner::Boot | Owner::Identification | Owner::Errors | Owner::Abandoned => false,
        };
        if goes_on {
            self.tasks.wake();
        }
    }
}

impl Part for Transfers {
    fn earliest(&self) -> Option<Instant> {
        if self.is_due { Some(Instant::ZERO) } else { self.deadline() }
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> ClientNode for Master<D, B> {
    /// The boot-up process goes first.
    fn claim_sdo(&mut self, node: NodeId, task: &Waker) -> Option<&mut Client> {
        if self.transfers.owner != Owner::Nobody || self.boot.is_busy() || !self.is_active() {
            self.transfers.no_sooner().tasks.register(task);
            return None;
        }
        self.transfers_mut().take(Owner::Application, node);
        Some(&mut self.transfers.no_sooner().client)
    }

    fn claimed_sdo(&mut self, task: &Waker) -> &mut Client {
        self.transfers_mut().is_due = true;
        let transfers = self.transfers.no_sooner();
        transfers.tasks.register(task);
        &mut transfers.client
    }

    fn release_sdo(&mut self) {
        let transfers = self.transfers_mut();
        (transfers.owner, transfers.is_due) = (Owner::Abandoned, true);
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Lets the client do something; its frames go out on the active bus.
    fn with_client<R>(
        &mut self,
        turn: &mut Turn,
        step: impl FnOnce(&mut Client, &mut dyn FnMut(sdo::machine::Payload)) -> R,
    ) -> R {
        let (bus, lifetime) = (self.redundancy.active(), self.services.sdo_lifetime());
        let Turn { now, out, .. } = turn;
        let transfers = self.transfers_mut();
        let id = CobId::sdo_request(transfers.node);
        step(&mut transfers.client, &mut |payload| out.send_for(bus, Frame::of(id, payload), *now, lifetime))
    }

    /// Takes an SDO response on the active bus.
    pub(super) fn on_response(&mut self, bus: Bus, node: NodeId, frame: &Frame, turn: &mut Turn) {
        let Ok(payload) = <&sdo::machine::Payload>::try_from(frame.data()) else {
            return self.services.buses_mut().count_malformed(bus);
        };
        // Not announced: what comes belongs to nothing that was asked here.
        let is_ours = node == self.transfers.node && self.redundancy.is_announced();
        let now = turn.now;
        let was_used =
            is_ours && self.with_client(turn, |client, mut send| client.on_response(payload, now, &mut send));
        self.transfers_mut().is_due = true;
        if !was_used {
            self.services.buses_mut().count_ignored(bus);
            if self.redundancy.peers().is_answer_late(node) {
                self.redundancy_mut().on_answer(node, turn.now);
            }
        }
    }

    /// Notes that a frame was sent, or failed: there is room for another one.
    pub(super) fn on_sdo_sent(&mut self, bus: Bus, frame: &Frame) {
        if frame.id() == CobId::sdo_response(NodeId::MASTER) {
            self.services.on_sdo_sent();
        } else if frame.id() == CobId::sdo_request(self.transfers.node) && bus == self.redundancy.active() {
            self.transfers_mut().on_sent();
        }
    }

    /// Frames were dropped before they came to the bus; some may have been segments that server or client wait for.
    pub(super) fn on_unsent(&mut self, bus: Bus, frames: u16) {
        for _ in 0..frames {
            self.services.on_sdo_sent();
            self.transfers_mut().on_sent();
        }
        self.lost(bus);
    }

    /// Aborts running transfers. Servers and clients get the abort on the new bus, once that bus is announced.
    pub(super) fn abort_transfers(&mut self, turn: &mut Turn) {
        let mut aborts = [None; 2];
        let [of_client, of_server] = &mut aborts;
        let transfers = self.transfers_mut();
        let id = CobId::sdo_request(transfers.node);
        let mut note: &mut dyn FnMut(sdo::machine::Payload) =
            &mut |payload| *of_client = Some(Frame::of(id, payload));
        transfers.client.bus_changed(&mut note);
        (transfers.is_due, transfers.pause) = (true, Some(turn.now + AFTER_SWITCH));
        self.serve(SdoStep::BusChanged, turn.now, &mut |frame| *of_server = Some(frame));
        for frame in aborts.into_iter().flatten() {
            self.send(frame, self.services.sdo_lifetime(), turn);
        }
    }

    /// Drops all transfers without an abort: another master is active.
    pub(super) fn drop_transfers(&mut self, now: Instant) {
        if self.transfers.owner == Owner::Identification {
            let node = self.transfers.node;
            self.redundancy_mut().peers_mut().ask_again(node);
        }
        let mut silent: &mut dyn FnMut(sdo::machine::Payload) = &mut |_| {};
        let transfers = self.transfers_mut();
        if transfers.owner == Owner::Application {
            // Its task collects the error.
            transfers.client.bus_changed(&mut silent);
        } else {
            transfers.client.cancel(&mut silent);
            transfers.owner = Owner::Nobody;
        }
        let transfers = self.transfers.no_sooner();
        transfers.pause = None;
        transfers.wake(now);
        self.serve(SdoStep::BusChanged, now, &mut |_| {});
        self.services.storage_mut().give_up();
    }

    /// Lets the client do what is due.
    pub(super) fn run_client(&mut self, turn: &mut Turn) {
        if self.transfers.owner == Owner::Abandoned {
            self.cancel_transfer(turn);
        }
        let (until, transfers) = (turn.until, self.transfers.no_sooner());
        if !transfers.is_overdue(until) {
            return;
        }
        transfers.pause.take_if(|pause| *pause <= until);
        if self.redundancy.is_announced() && transfers.pause.is_none() {
            transfers.is_due = false;
            self.with_client(turn, |client, mut send| client.poll(until, &mut send));
        }
    }

    /// Aborts the running transfer, if there is one. The client is free.
    pub(super) fn cancel_transfer(&mut self, turn: &mut Turn) {
        self.transfers.no_sooner().owner = Owner::Nobody;
        self.with_client(turn, |client, mut send| client.cancel(&mut send));
    }
}
