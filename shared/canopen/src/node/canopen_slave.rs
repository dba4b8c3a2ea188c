//! CANopen slave on one bus.

use super::slave_core::SlaveCore;
use super::turn;
use super::{
    Counters, Device, DeviceNode, Event, Filters, FullDepth, LinkEvent, MAX_FILTERS, Node, Settings,
};
use crate::emcy::DeviceError;
use crate::heartbeat::{HeartbeatTimes, is_heartbeat};
use crate::link::Stamp;
use crate::link::port::Filter;
use crate::nmt::NmtMessage;
use crate::node::services::{CanopenOnly, NodeObjects};
use crate::types::{AbortCode, Address, Bus, CobId, Frame, Instant, NmtState, NodeId};

type Turn<'a> = turn::Turn<'a, Event>;

/// Its only bus.
const BUS: Bus = Bus::Nominal;

/// CANopen slave on one bus: NMT slave, heartbeat, EMCY, SYNC, PDOs and SDO server, as CiA 301 defines them.
///
/// It has no parameter store, and obeys every reset. It runs on the port of
/// [`Single`](crate::runner::Single).
#[doc(alias("CANopen slave", "NMT slave"))]
#[derive(Debug)]
pub struct CanopenSlave<D: Device> {
    canopen: SlaveCore<D, CanopenOnly>,
    initial: HeartbeatTimes,
}

impl<D: Device> CanopenSlave<D> {
    /// Makes a slave before power-on. `id` is 2 to 127.
    pub fn new(id: NodeId, settings: &Settings, device: D) -> Self {
        let initial = settings.heartbeats;
        let objects = NodeObjects::at_power_on(id, initial, device);
        CanopenSlave { canopen: SlaveCore::new(id, settings, objects, || ()), initial }
    }

    /// Returns the object dictionary.
    pub fn objects(&self) -> &NodeObjects<D, CanopenOnly> {
        self.canopen.services().objects()
    }

    /// Returns the object dictionary alone, for a data sheet.
    pub fn into_objects(self) -> NodeObjects<D, CanopenOnly> {
        self.canopen.into_objects()
    }

    /// Returns the NMT state of the slave.
    pub fn state(&self) -> NmtState {
        self.canopen.state()
    }

    /// Returns the counters of the frames of the bus.
    pub fn counters(&self) -> &Counters {
        &self.canopen.services().buses().counters()[BUS]
    }

    /// Takes an event of the application: sends a transmit PDO (0 is the first) by its transmission type. Refuses
    /// it, and counts that, unless the node is Operational and the PDO is valid.
    pub fn send_pdo(&mut self, number: usize, now: Instant) {
        self.canopen.send_pdo(BUS, number, now);
    }

    /// Lends the instant before which nothing is due.
    #[cfg(test)]
    pub(crate) fn wakes_mut(&mut self) -> &mut super::turn::Wakes {
        self.canopen.wakes_mut()
    }

    fn boot(&mut self, turn: &mut Turn) {
        self.canopen.restore_communication(self.initial, turn.now);
        self.canopen.boot(BUS, turn);
    }

    /// Dispatches a frame that may be for this node.
    fn on_frame(&mut self, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        let (id, state) = (frame.id(), self.state());
        if self.canopen.takes_sync(id) {
            self.canopen.on_sync(BUS, frame, stamp, turn);
        } else if self.canopen.takes_sdo(id) {
            if !self.canopen.services_mut().on_plain_segment(frame, turn.now) {
                self.on_request(frame, turn);
            }
        } else if state.allows_pdo() && self.canopen.services_mut().on_pdo(BUS, frame, stamp, turn) {
        } else if id == CobId::NMT {
            self.on_nmt(frame, turn);
        } else if is_heartbeat(id) && state != NmtState::Initialising {
            self.canopen.on_peer_heartbeat(BUS, frame, stamp, turn);
        } else if D::RAW_FRAMES.contains(&id) && state != NmtState::Initialising {
            turn.out.event(Event::Frame(*frame));
        } else {
            self.canopen.buses_mut().count_ignored(BUS);
        }
        self.run(turn);
    }

    fn on_request(&mut self, frame: &Frame, turn: &mut Turn) {
        if let Some(at) = self.canopen.on_request(BUS, frame, turn) {
            self.on_written(at, turn);
        }
    }

    fn on_nmt(&mut self, frame: &Frame, turn: &mut Turn) {
        let Some(message) = NmtMessage::decode(frame) else {
            return self.canopen.buses_mut().count_malformed(BUS);
        };
        if !message.target.includes(self.canopen.control().id()) || self.state() == NmtState::Initialising {
            return;
        }
        let now = turn.now;
        if self.canopen.change_state(turn, |control| control.on_command(message.command, now)) {
            self.boot(turn);
        }
    }

    fn on_written(&mut self, at: Address, turn: &mut Turn) {
        self.canopen.on_own_written(at, turn);
        self.canopen.services_mut().report_written(at, turn);
    }

    /// Does what is due.
    fn run(&mut self, turn: &mut Turn) {
        if self.canopen.is_due(turn.until) {
            self.run_due(turn);
        }
    }

    fn run_due(&mut self, turn: &mut Turn) {
        if self.state() == NmtState::Initialising {
            return;
        }
        self.canopen.poll(BUS, turn);
        self.canopen.set_filters(&[BUS], turn);
        self.canopen.settle();
        turn.out.note_done(turn.until);
    }
}

impl<D: Device> Node for CanopenSlave<D> {
    type Event = Event;
    type Request = core::convert::Infallible;
    type Depth = FullDepth;

    fn filters(&self) -> Filters {
        (0..MAX_FILTERS).map_while(|number| self.filter(number)).collect()
    }

    /// Those of [`Device::RAW_FRAMES`] are the last ones.
    fn filter(&self, number: usize) -> Option<Filter> {
        self.canopen.wanted_filter(number).or_else(|| {
            let nth = number.checked_sub(self.canopen.wanted_filters())?;
            let id = D::RAW_FRAMES.get(nth).filter(|_| number < MAX_FILTERS)?;
            Some(Filter::exact(*id))
        })
    }

    fn start(&mut self, turn: &mut Turn) {
        self.canopen.buses_mut().join_one(BUS, turn.out);
        self.boot(turn);
        self.run(turn);
    }

    fn on_link(&mut self, _bus: Bus, event: &LinkEvent, turn: &mut Turn) {
        if let LinkEvent::Received { frame, stamp } = event {
            return self.on_received(BUS, frame, stamp, turn);
        }
        self.canopen.on_bus_event(BUS, true, event, turn);
        // On one bus an acknowledgement is all that there is to know.
        self.canopen.services_mut().confirm_emergencies();
        self.run(turn);
    }

    fn on_received(&mut self, _bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        self.canopen.buses_mut().count_received(BUS);
        // A frame is judged by its end.
        turn.until = stamp.at.min(turn.now);
        self.run(turn);
        turn.until = turn.now;
        if self.canopen.may_take(frame.id()) || D::RAW_FRAMES.contains(&frame.id()) {
            self.on_frame(frame, stamp, turn);
        } else {
            self.canopen.buses_mut().count_ignored(BUS);
        }
    }

    fn on_request(&mut self, request: Self::Request, _turn: &mut Turn) {
        match request {}
    }

    fn poll(&mut self, turn: &mut Turn) {
        self.run_due(turn);
    }

    fn deadline(&self) -> Option<Instant> {
        self.canopen.deadline()
    }

    fn is_on_schedule(&self, now: Instant) -> bool {
        self.canopen.control().is_on_schedule(now)
    }

    /// Without a clock no frame is worth a stamp.
    fn is_stamped(&self, _bus: Bus, _frame: &Frame) -> bool {
        false
    }
}

impl<D: Device> DeviceNode for CanopenSlave<D> {
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
