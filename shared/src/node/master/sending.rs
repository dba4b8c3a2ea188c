//! What the application of the master sends.

use super::Master;
use crate::link::queue::Outgoing;
use crate::node::{Device, Refusal};
use crate::types::{Frame, Instant, NmtState, NodeId};

impl<D: Device> Master<D> {
    /// An event of the application: sends a transmit PDO (0 is the first) as its transmission type has it.
    ///
    /// # Errors
    /// [`Refusal::NotValid`], counted on the active bus.
    pub fn send_pdo(&mut self, number: usize, now: Instant) -> Result<(), Refusal> {
        self.send_pdo_if(true, number, now)
    }

    /// The same for one that a slave consumes, which has to be Operational.
    ///
    /// # Errors
    /// [`Refusal`], counted on the active bus.
    pub fn send_pdo_to(&mut self, node: NodeId, number: usize, now: Instant) -> Result<(), Refusal> {
        let is_operational = self.manager.peers().state(node) == Some(NmtState::Operational);
        self.send_pdo_if(is_operational, number, now)
    }

    fn send_pdo_if(&mut self, is_operational: bool, number: usize, now: Instant) -> Result<(), Refusal> {
        let tpdos = &mut self.services.dictionary.tpdos;
        let refusal = if !is_operational {
            Refusal::NotOperational
        } else if !(tpdos.is_valid(number) && self.nmt.state().allows_pdo()) {
            Refusal::NotValid
        } else if !self.manager.is_announced() && self.held.is_full() {
            Refusal::Busy
        } else {
            tpdos.trigger(number, now);
            self.services.next = now;
            return Ok(());
        };
        self.services.buses.refused(self.manager.active());
        Err(refusal)
    }

    /// Sends a frame that no PDO covers, within the lifetime of PDOs of events.
    ///
    /// # Errors
    /// [`Refusal::NotValid`] for a restricted COB-ID (CiA 301 7.3.5) and outside Operational, [`Refusal::Busy`]; both are counted
    /// on the active bus.
    pub fn send_frame(&mut self, frame: Frame, now: Instant) -> Result<(), Refusal> {
        let expires = now + self.services.lifetimes.event;
        let refusal = if frame.id().is_restricted() || !self.nmt.state().allows_pdo() {
            Refusal::NotValid
        } else if self.held.push_back(Outgoing { frame, expires }).is_err() {
            Refusal::Busy
        } else {
            self.services.next = now;
            return Ok(());
        };
        self.services.buses.refused(self.manager.active());
        Err(refusal)
    }
}
