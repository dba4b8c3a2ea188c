//! Dictionary of a slave at run time: SDO, SYNC and PDOs, and the effect of a written object.

use super::Slave;
use crate::emcy::DeviceError;
use crate::link::Stamp;
use crate::node::index::{CONSUMER_HEARTBEAT, PRODUCER_HEARTBEAT, REDUNDANCY, SELF_TEST_START, STORE};
use crate::node::services::SpacecraftServices;
use crate::node::slave::Turn;
use crate::node::{DeviceNode, NodeObjects, SelfTest, SpacecraftDevice};
use crate::store::Group;
use crate::types::{AbortCode, Address, Frame, Instant};

/// The last object that a node follows.
const LAST_OWN: u16 = SELF_TEST_START;

impl<D: SpacecraftDevice> Slave<D> {
    /// Returns the object dictionary.
    pub fn objects(&self) -> &NodeObjects<D> {
        self.canopen.services().objects()
    }

    /// Returns the object dictionary alone, for a data sheet.
    pub fn into_objects(self) -> NodeObjects<D> {
        self.canopen.into_objects()
    }

    /// Takes an event of the application: sends a transmit PDO (0 is the first) by its transmission type. Refuses
    /// it, and counts that on the active bus, unless the node is Operational and the PDO is valid.
    pub fn send_pdo(&mut self, number: usize, now: Instant) {
        self.canopen.send_pdo(self.redundancy.selected(), number, now);
    }

    /// Takes an SDO request on the active bus.
    #[inline(never)] // row `rx.interrupt_to_dictionary_median`: 60 more without the eight that name it
    pub(super) fn on_sdo(&mut self, frame: &Frame, turn: &mut Turn) {
        if self.canopen.services_mut().on_plain_segment(frame, turn.now) {
            // Its deadline has only moved away.
            self.run(turn);
        } else {
            self.on_request(frame, turn);
        }
    }

    #[inline(never)] // row `instructions.block_download_segment`: 2 more without it
    fn on_request(&mut self, frame: &Frame, turn: &mut Turn) {
        if let Some(at) = self.canopen.on_request(self.redundancy.selected(), frame, turn) {
            self.on_written(at, turn);
        }
        self.run(turn);
    }

    /// Takes a SYNC on the active bus.
    #[inline(never)] // row `instructions.rpdo_static`: 15 more without it
    pub(super) fn on_sync(&mut self, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        self.canopen.on_sync(self.redundancy.selected(), frame, stamp, turn);
        self.run(turn);
    }

    /// Takes a frame on the active bus, in Operational, that may be of RPDOs.
    #[inline(never)] // row `instructions.heartbeat_consumed`: 14 more without it
    pub(super) fn on_pdo(&mut self, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        let bus = self.redundancy.selected();
        if self.canopen.services_mut().on_pdo(bus, frame, stamp, turn) {
            self.run(turn);
        } else {
            self.on_network(bus, frame, stamp, turn);
        }
    }

    /// Lets the node follow an object that was written over the bus.
    fn on_written(&mut self, at: Address, turn: &mut Turn) {
        if at.index <= LAST_OWN {
            self.on_own_written(at, turn);
        }
        self.canopen.services_mut().report_written(at, turn);
    }

    /// Goes on with a save that runs, and answers its client at its end.
    #[inline(never)] // row `size.pyboard-v11.slave.flash`: five of these save 40 bytes
    pub(super) fn advance_save(&mut self, turn: &mut Turn) {
        let Some((answer, saved)) = self.canopen.services_mut().advance_save(turn.now) else { return };
        if let Some(frame) = answer {
            let lifetime = self.canopen.services().sdo_lifetime();
            turn.out.send_for(self.redundancy.selected(), frame, turn.now, lifetime);
        }
        if let Some(at) = saved
            && Group::from_sub(at.sub).is_some_and(|group| group.contains(REDUNDANCY))
        {
            self.on_stored(at.index == STORE, turn);
        }
    }

    /// Lets the services follow an object of their own that was written.
    fn on_own_written(&mut self, at: Address, turn: &mut Turn) {
        self.canopen.on_own_written(at, turn);
        if matches!(at.index, CONSUMER_HEARTBEAT | PRODUCER_HEARTBEAT | REDUNDANCY) {
            let written = self.canopen.services().written_redundancy();
            self.redundancy.change(self.canopen.wakes_mut()).configure(written);
        }
    }

    /// Puts the result of a self-test into object 2031h (ECSS 6.7b).
    pub fn report_self_test(&mut self, result: SelfTest, now: Instant) {
        self.canopen.services_mut().change(now, |objects| objects.extension.self_test = result);
    }
}

impl<D: SpacecraftDevice> DeviceNode for Slave<D> {
    type Device = D;

    fn device(&self) -> &D {
        &self.objects().application
    }

    fn change<R>(&mut self, now: Instant, change: impl FnOnce(&mut D) -> R) -> R {
        self.canopen.services_mut().change(now, |objects| change(&mut objects.application))
    }

    fn write(&mut self, at: Address, value: &[u8], turn: &mut Turn) -> Result<(), AbortCode> {
        if let Some(at) = self.canopen.services_mut().write(at, value, turn.now)? {
            self.on_written(at, turn);
        }
        self.run(turn);
        Ok(())
    }

    fn raise(&mut self, error: DeviceError, info: [u8; 4]) {
        self.canopen.services_mut().raise(error.code, error.field(info));
    }

    fn clear(&mut self, error: DeviceError) {
        self.canopen.services_mut().clear(error.code, error.source);
    }
}
