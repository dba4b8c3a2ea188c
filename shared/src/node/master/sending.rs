//! Frames that the application of the master sends.

use super::Master;
use crate::link::machine::Outgoing;
use crate::node::minimal::MinimalPdos;
use crate::node::{Refusal, SpacecraftDevice};
use crate::pdo::{Pdo, PdoValues};
use crate::profile::MinimalNode;
use crate::redundancy::MasterBoards;
use crate::types::{Frame, Instant, NmtState, NodeId};

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Returns the last state of a slave. `None` if the slave was never heard, is lost or forgotten.
    pub fn slave_state(&self, node: NodeId) -> Option<NmtState> {
        self.redundancy.peers().state(node)
    }

    /// Returns whether a slave takes commands. It is Operational by its heartbeat, or it is a [minimal
    /// slave](MinimalNode) without a heartbeat.
    pub fn may_command(&self, node: NodeId) -> bool {
        let is_silent = self.minimal(node).is_some_and(|minimal| !minimal.has_heartbeat);
        is_silent || self.slave_state(node) == Some(NmtState::Operational)
    }

    /// A slave of the minimal set.
    pub(super) fn minimal(&self, node: NodeId) -> Option<&'static MinimalNode> {
        self.minimal.iter().find(|minimal| minimal.node == node)
    }

    /// Sends a command or a telemetry request to a minimal slave by one of its four receive PDOs (0 is the first;
    /// ECSS 9.4.2c).
    ///
    /// # Errors
    /// As [`Master::send_frame`]. [`Refusal::NotValid`] for a fifth PDO or more than 8 bytes.
    /// [`Refusal::NotOperational`] if the slave does not take commands.
    pub fn send_to_minimal(
        &mut self,
        node: NodeId,
        number: usize,
        data: &[u8],
        now: Instant,
    ) -> Result<(), Refusal> {
        let id = MinimalPdos::DEFAULT.receive.get(number).copied().flatten();
        let frame = id.and_then(|pdo| Frame::new(pdo.cob_id.of(node), data).ok());
        let refusal = match frame {
            Some(frame) if self.may_command(node) => return self.send_frame(frame, now),
            Some(_) => Refusal::NotOperational,
            None => Refusal::NotValid,
        };
        self.services.buses_mut().count_refused(self.redundancy.active());
        Err(refusal)
    }

    /// Sends a transmit PDO (0 is the first) by its transmission type, even if its content has not changed.
    ///
    /// # Errors
    /// [`Refusal::NotValid`], [`Refusal::Busy`]; both are counted on the active bus.
    pub fn send_pdo(&mut self, number: usize, now: Instant) -> Result<(), Refusal> {
        let is_valid = self.services.tpdos().is_valid(number) && self.redundancy.state().allows_pdo();
        let refusal = if !is_valid {
            Refusal::NotValid
        } else if !self.redundancy.has_room() {
            Refusal::Busy
        } else {
            self.services.trigger(number, now);
            return Ok(());
        };
        self.services.buses_mut().count_refused(self.redundancy.active());
        Err(refusal)
    }

    /// Sends values to a slave by one of its receive PDOs. The master needs no object for them.
    ///
    /// # Errors
    /// As [`Master::send_frame`]. [`Refusal::NotOperational`], counted on the active bus, if the slave does not take commands.
    pub fn send_to<E, T: PdoValues>(
        &mut self,
        node: NodeId,
        pdo: Pdo<E, T>,
        values: T,
        now: Instant,
    ) -> Result<(), Refusal> {
        if !self.may_command(node) {
            self.services.buses_mut().count_refused(self.redundancy.active());
            return Err(Refusal::NotOperational);
        }
        self.send_frame(pdo.of(node).frame(values), now)
    }

    /// Returns whether a frame that was not sent is a command or another event of the application, which no later frame
    /// replaces.
    pub(super) fn is_lost(&self, frame: &Frame) -> bool {
        let id = frame.id();
        // PDOs have the function codes between those of emergencies and of SDO responses.
        let is_process_data = (0x180..0x580).contains(&id.raw());
        let is_raw = is_process_data && !self.services.tpdos().has(id);
        is_raw || self.services.tpdos().is_event(frame.id())
    }

    /// Sends a frame that no PDO covers, with the lifetime of event-driven PDOs.
    ///
    /// # Errors
    /// [`Refusal::NotValid`] for a restricted COB-ID (CiA 301 7.3.5) and if the master is not Operational,
    /// [`Refusal::Busy`]. Both are counted on the active bus.
    pub fn send_frame(&mut self, frame: Frame, now: Instant) -> Result<(), Refusal> {
        let expires = now + self.services.event_lifetime();
        let refusal = if frame.id().is_restricted() || !self.redundancy.state().allows_pdo() {
            Refusal::NotValid
        } else if !self.redundancy_mut().queue(Outgoing { frame, expires }) {
            Refusal::Busy
        } else {
            return Ok(());
        };
        self.services.buses_mut().count_refused(self.redundancy.active());
        Err(refusal)
    }
}
