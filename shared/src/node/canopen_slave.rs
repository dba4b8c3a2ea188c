//! CANopen slave on one bus, without ECSS-E-ST-50-15C: for a board of the test bench, or for a bus inside a unit.

use super::canopen::{Canopen, Out};
use super::extension::CanopenOnly;
use super::{Counters, Device, DeviceNode, Filters, FullDepth, LinkEvent, Node, NodeObjects, SlaveEvent};
use crate::emcy::ErrorCode;
use crate::heartbeat::is_heartbeat;
use crate::link::Stamp;
use crate::link::port::Filter;
use crate::nmt::{NmtMessage, Reaction};
use crate::profile::Profile;
use crate::redundancy::Parameters;
use crate::types::{AbortCode, Address, Bus, CobId, Frame, Instant, NmtState, NodeId};

/// Its only bus.
const BUS: Bus = Bus::Nominal;

/// CANopen slave on one bus: NMT slave, heartbeat, EMCY, SYNC, PDOs and SDO server, as CiA 301 defines them.
///
/// It has no redundancy, no spacecraft time and no parameter store, and obeys every reset. It runs on the port of
/// [`Single`](crate::runner::Single).
#[doc(alias("CANopen slave", "NMT slave"))]
#[derive(Debug)]
pub struct CanopenSlave<D: Device> {
    canopen: Canopen<D, CanopenOnly>,
    initial: Parameters,
}

impl<D: Device> CanopenSlave<D> {
    /// Makes a slave before power-on. `id` is 2 to 127. The profile gives heartbeat, lifetimes, time-out of SDO,
    /// recovery from bus-off and autostart.
    #[inline(never)]
    pub fn new(id: NodeId, profile: &Profile, device: D) -> Self {
        let initial = profile.redundancy();
        let objects = NodeObjects::at_power_on(id, &initial, device);
        CanopenSlave { canopen: Canopen::new(id, profile, objects), initial }
    }

    /// Returns the object dictionary.
    pub fn objects(&self) -> &NodeObjects<D, CanopenOnly> {
        &self.canopen.services.dictionary.objects
    }

    /// Returns the NMT state of the slave.
    pub fn state(&self) -> NmtState {
        self.canopen.control.state()
    }

    /// Returns the counters of the frames of the bus.
    pub fn counters(&self) -> &Counters {
        &self.canopen.services.buses.counters[BUS]
    }

    /// Takes an event of the application: sends a transmit PDO (0 is the first) by its transmission type. Refuses
    /// it, and counts that, unless the node is Operational and the PDO is valid.
    pub fn send_pdo(&mut self, number: usize, now: Instant) {
        self.canopen.send_pdo(BUS, number, now);
    }

    /// Reports an error of the device that appeared. The first of the five bytes is its source.
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) {
        self.canopen.services.raise(code, info);
        self.canopen.services.next = Instant::ZERO;
    }

    /// Reports that an error of the device is gone.
    pub fn clear(&mut self, code: ErrorCode, source: u8) {
        self.canopen.services.clear(code, source);
        self.canopen.services.next = Instant::ZERO;
    }

    fn boot(&mut self, now: Instant, out: &mut Out) {
        self.canopen.restore_communication(&self.initial, now);
        self.canopen.boot(BUS, now, out);
    }

    /// A frame that may be for this node.
    #[inline(never)] // what is for others need not pay for it
    fn on_frame(&mut self, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let (id, state) = (frame.id(), self.canopen.control.state());
        let services = &mut self.canopen.services;
        if services.is_sync(id) && state.allows_sync() {
            self.canopen.on_sync(BUS, frame, stamp, now, out);
        } else if services.is_sdo(id) && self.canopen.control.reporting_state().allows_sdo() {
            if !services.on_plain_segment(frame, now)
                && let Some(at) = self.canopen.on_request(BUS, frame, now, out)
            {
                self.on_written(at, now, out);
            }
        } else if state.allows_pdo() && services.on_pdo(BUS, frame, stamp, now, out) {
        } else if id == CobId::NMT {
            self.on_nmt(frame, now, out);
        } else if is_heartbeat(id) && state != NmtState::Initialising {
            self.canopen.on_peer_heartbeat(BUS, frame, stamp, out);
        } else {
            services.buses.ignored(BUS);
        }
        self.run(now, now, out);
    }

    fn on_nmt(&mut self, frame: &Frame, now: Instant, out: &mut Out) {
        let Some(message) = NmtMessage::decode(frame) else {
            return self.canopen.services.buses.malformed(BUS);
        };
        if !message.target.includes(self.canopen.control.id()) || self.state() == NmtState::Initialising {
            return;
        }
        match self.canopen.control.on_command(message.command, now) {
            Reaction::Unchanged => {}
            Reaction::Entered(state) => self.canopen.entered(state, now, out),
            Reaction::ResetNode => self.canopen.wait_for_reset(out),
            Reaction::ResetCommunication => self.boot(now, out),
        }
    }

    fn on_written(&mut self, at: Address, now: Instant, out: &mut Out) {
        self.canopen.on_own_written(at, now, out);
        self.canopen.services.report_written(at, now, out);
    }

    /// Does what was due at `until`, which may be before `now`: a frame is judged by its end.
    fn run(&mut self, until: Instant, now: Instant, out: &mut Out) {
        if until >= self.canopen.services.next {
            self.run_due(until, now, out);
        }
    }

    #[inline(never)] // most frames find nothing due
    fn run_due(&mut self, until: Instant, now: Instant, out: &mut Out) {
        if self.state() == NmtState::Initialising {
            return;
        }
        self.canopen.poll(BUS, until, now, out);
        self.canopen.set_filters(&[BUS], out);
        self.canopen.set_deadline(self.canopen.due(), now);
    }
}

impl<D: Device> Node for CanopenSlave<D> {
    type Event = SlaveEvent;
    type Request = core::convert::Infallible;
    type Depth = FullDepth;

    fn filters(&self) -> Filters {
        self.canopen.filters()
    }

    fn filter(&self, number: usize) -> Option<Filter> {
        self.canopen.wanted_filter(number)
    }

    fn start(&mut self, now: Instant, out: &mut Out) {
        self.canopen.services.buses.join_one(BUS, out);
        self.boot(now, out);
        self.run(now, now, out);
    }

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Out) {
        if let LinkEvent::Received { frame, stamp } = event {
            return self.on_received(bus, frame, stamp, now, out);
        }
        self.canopen.on_bus_event(bus, true, event, now, out);
        // On one bus an acknowledgement is all that there is to know.
        self.canopen.services.dictionary.emcy.confirm();
        self.run(now, now, out);
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        self.canopen.services.buses.received(bus);
        self.run(stamp.at.min(now), now, out);
        if self.canopen.may_take(frame.id()) {
            self.on_frame(frame, stamp, now, out);
        } else {
            self.canopen.services.buses.ignored(bus);
        }
    }

    fn on_request(&mut self, request: Self::Request, _now: Instant, _out: &mut Out) {
        match request {}
    }

    fn poll(&mut self, now: Instant, out: &mut Out) {
        self.run_due(now, now, out);
    }

    fn deadline(&self) -> Option<Instant> {
        self.canopen.deadline()
    }

    /// Without a clock no frame is worth a stamp.
    fn is_stamped(&self, _bus: Bus, _frame: &Frame) -> bool {
        false
    }
}

impl<D: Device> DeviceNode for CanopenSlave<D> {
    type Device = D;

    fn change<R>(&mut self, now: Instant, change: impl FnOnce(&mut D) -> R) -> R {
        self.canopen.services.change(now, |objects| change(&mut objects.application))
    }

    fn write(&mut self, at: Address, value: &[u8], now: Instant, out: &mut Out) -> Result<(), AbortCode> {
        if let Some(at) = self.canopen.services.write(at, value, now)? {
            self.on_written(at, now, out);
        }
        self.run(now, now, out);
        Ok(())
    }
}
