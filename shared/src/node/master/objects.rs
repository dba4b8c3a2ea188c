//! The dictionary of the master, and what a written object means to it.

use super::{Master, MasterEvent, Out};
use crate::boot::{Assignment, BootProgress, Expected};
use crate::emcy::ErrorCode;
use crate::heartbeat::ConsumerSlots;
use crate::nmt::{Command, NmtMessage, NmtStartup, Target};
use crate::node::index::{
    ASSIGNMENT, CONSUMER_HEARTBEAT, CYCLE_PERIOD, PRODUCER_HEARTBEAT, REDUNDANCY, REQUEST_NMT, SCET_SET,
    SELF_TEST_START, SYNC_COB_ID, SYNC_OVERFLOW,
};
use crate::node::services::{FIRST_TOLD, SdoStep};
use crate::node::{Communication, Device, NodeObjects, SelfTest};
use crate::od::{INVALID, Objects, Record};
use crate::pdo::PdoSet;
use crate::profile::Profile;
use crate::sync;
use crate::types::{Address, Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, earliest};

/// Slaves that an array has entries for: sub-index is Node-ID.
const NODES: usize = 127;
/// 1005h: it produces SYNC.
const PRODUCES: u32 = 1 << 30;
/// 1F82h: never heard, or forgotten.
pub(super) const UNKNOWN: u8 = 0;
/// 1F82h: lost.
pub(super) const MISSING: u8 = 1;
/// 1F82h: sub-index of all nodes.
const ALL: u8 = 128;

/// What a master has beside the objects of every node: those of its device, and those for the management of its network.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct MasterObjects<D: Device> {
    /// Of the device
    #[objects]
    pub device: D,
    /// Of the network
    #[objects]
    pub network: NetworkObjects,
}

impl<D: Device> Device for MasterObjects<D> {
    type Pdos = D::Pdos;
    type Consumers = D::Consumers;

    const PDOS: PdoSet = D::PDOS;

    /// It produces SYNC (ECSS 6.9d). Nobody consumes its emergencies: 1003h has them.
    fn communication(id: NodeId) -> Communication {
        let mut communication = D::communication(id);
        communication.sync_cob_id |= PRODUCES;
        communication.nmt_startup = NmtStartup::MASTER.raw();
        communication.emcy_cob_id |= INVALID;
        communication
    }

    fn consumers(id: NodeId) -> D::Consumers {
        D::consumers(id)
    }

    fn pdos(id: NodeId) -> D::Pdos {
        D::pdos(id)
    }
}

/// Management of the network: the boot-up process and its SDO client (CiA 302-2). Entries of arrays have the Node-ID of the
/// slave as sub-index.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct NetworkObjects {
    /// SDO client parameter
    ///
    /// Of the transfer that runs, or of the last one. Not valid (bit 31) before the first.
    #[object(0x1280, record)]
    pub sdo_client: SdoClientParameters,
    /// Expected configuration date
    ///
    /// 1020h of a slave that needs no configuration. Days since 1984-01-01; zero: it is configured at each boot.
    #[object(0x1F26, array, rw)]
    pub configuration_date: [u32; NODES],
    /// Expected configuration time
    ///
    /// Milliseconds since midnight.
    #[object(0x1F27, array, rw)]
    pub configuration_time: [u32; NODES],
    /// NMT slave assignment
    ///
    /// Bit 0: is a slave of this master. Bit 2: is checked, configured and started. Bit 3: SYNC waits for it.
    #[object(0x1F81, array, rw)]
    pub assignment: [u32; NODES],
    /// Request NMT
    ///
    /// Read: 0 unknown, 1 missing, 4 stopped, 5 operational, 127 pre-operational. Written: 4 stop, 5 start, 6 reset node,
    /// 7 reset communication, 127 enter pre-operational. Sub-index 128: all slaves.
    #[object(0x1F82, array, rw)]
    pub request_nmt: [u8; NODES + 1],
    /// Device type identification
    ///
    /// Zero: not checked.
    #[object(0x1F84, array, rw)]
    pub device_type: [u32; NODES],
    /// Vendor identification
    ///
    /// Zero: not checked.
    #[object(0x1F85, array, rw)]
    pub vendor: [u32; NODES],
    /// Product code
    ///
    /// Zero: not checked.
    #[object(0x1F86, array, rw)]
    pub product: [u32; NODES],
    /// Revision number
    ///
    /// Zero: not checked.
    #[object(0x1F87, array, rw)]
    pub revision: [u32; NODES],
    /// Serial number
    ///
    /// Zero: not checked.
    #[object(0x1F88, array, rw)]
    pub serial: [u32; NODES],
    /// Boot time
    ///
    /// Milliseconds from power-on; zero for no limit.
    #[object(0x1F89, ro)]
    pub boot_time: u32,
    /// Boot progress
    ///
    /// 0 unassigned, 1 awaited, 2 queued, 3 checking, 4 comparing, 5 configuring, 6 started, 7 booted, 8 failed.
    #[object(0x2040, array, ro)]
    pub boot_progress: [u8; NODES],
    /// Boot error
    ///
    /// The letter of CiA 302-2; zero for none.
    #[object(0x2041, array, ro)]
    pub boot_error: [u8; NODES],
    /// Boot abort code
    ///
    /// Of the SDO transfer that failed; zero for none.
    #[object(0x2042, array, ro)]
    pub boot_abort: [u32; NODES],
}

/// SDO parameters of a client (0022h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x22)]
pub struct SdoClientParameters {
    /// COB-ID client to server
    #[sub(1, ro, default = INVALID)]
    pub request: u32,
    /// COB-ID server to client
    #[sub(2, ro, default = INVALID)]
    pub response: u32,
    /// Node-ID of the server
    #[sub(3, ro)]
    pub node: u8,
}

/// Entry of a slave.
fn entry<T>(array: &mut [T], node: NodeId) -> Option<&mut T> {
    array.get_mut(usize::from(node.get()).wrapping_sub(1))
}

impl NetworkObjects {
    /// What a slave should be: 1F26h, 1F27h, 1F84h to 1F88h.
    pub(super) fn expected(&self, node: NodeId) -> Expected {
        let nth = usize::from(node.get()).wrapping_sub(1);
        let of = |array: &[u32; NODES]| array.get(nth).copied().unwrap_or(0);
        Expected {
            device_type: of(&self.device_type),
            identity: [of(&self.vendor), of(&self.product), of(&self.revision), of(&self.serial)],
            stamp: [of(&self.configuration_date), of(&self.configuration_time)],
        }
    }

    fn expect(&mut self, node: NodeId, expected: &Expected) {
        let [vendor, product, revision, serial] = expected.identity;
        let [date, time] = expected.stamp;
        let all = [
            (&mut self.device_type, expected.device_type),
            (&mut self.vendor, vendor),
            (&mut self.product, product),
            (&mut self.revision, revision),
            (&mut self.serial, serial),
            (&mut self.configuration_date, date),
            (&mut self.configuration_time, time),
        ];
        for (array, value) in all {
            if let Some(entry) = entry(array, node) {
                *entry = value;
            }
        }
    }

    pub(super) fn show_client(&mut self, node: NodeId) {
        self.sdo_client = SdoClientParameters {
            request: u32::from(CobId::sdo_request(node).raw()),
            response: u32::from(CobId::sdo_response(node).raw()),
            node: node.get(),
        };
    }

    /// A slave that is past its error has none.
    pub(super) fn show_progress(&mut self, node: NodeId, progress: BootProgress) {
        if let Some(shown) = entry(&mut self.boot_progress, node) {
            *shown = progress as u8;
        }
        if progress == BootProgress::Started {
            self.show_error(node, 0, 0);
        }
    }

    pub(super) fn show_error(&mut self, node: NodeId, letter: u8, abort: u32) {
        if let (Some(error), Some(code)) =
            (entry(&mut self.boot_error, node), entry(&mut self.boot_abort, node))
        {
            (*error, *code) = (letter, abort);
        }
    }
}

/// The objects at power-on.
pub(super) fn at_power_on<D: Device>(profile: &Profile, device: D) -> NodeObjects<MasterObjects<D>> {
    let redundancy = profile.redundancy();
    let application = MasterObjects { device, network: NetworkObjects::default() };
    let mut objects = NodeObjects::new(NodeId::MASTER, &redundancy, application);
    objects.communication.cycle_period = profile.sync.as_micros() as u32;
    let consumer = redundancy.consumer.as_millis() as u32 & 0xFFFF;
    let entries = objects.consumers.entries_mut();
    entries.fill(0);
    for (slot, slave) in entries.iter_mut().zip(profile.slaves) {
        *slot = u32::from(slave.node.get()) << 16 | consumer;
    }
    let network = &mut objects.application.network;
    network.boot_time = profile.boot.time.as_millis() as u32;
    for slave in profile.slaves {
        if let Some(assignment) = entry(&mut network.assignment, slave.node) {
            *assignment = slave.assignment().raw();
        }
        network.expect(slave.node, &slave.expected);
    }
    objects
}

/// SYNC as 1005h, 1006h and 1019h have it.
pub(super) fn sync_config(objects: &Communication) -> sync::Config {
    sync::Config::new(objects.sync_cob_id, objects.cycle_period, objects.sync_overflow)
}

impl<D: Device> Master<D> {
    /// The object dictionary.
    pub fn objects(&self) -> &NodeObjects<MasterObjects<D>> {
        &self.services.dictionary.objects
    }

    /// The object dictionary, to be changed.
    pub fn objects_mut(&mut self) -> &mut NodeObjects<MasterObjects<D>> {
        &mut self.services.dictionary.objects
    }

    /// A request to the SDO server.
    pub(super) fn on_sdo(&mut self, bus: Bus, frame: &Frame, now: Instant, out: &mut Out) {
        // Values of the moment that may be asked for.
        match frame.data() {
            [_, 0x11, 0x20, ..] => {
                self.services.dictionary.objects.spacecraft.scet_get = self.clock.at(now).into()
            }
            [_, 0x20 | 0x21, 0x20, ..] => self.refresh_health(),
            _ => {}
        }
        if !self.manager.is_announced() {
            return self.buses.ignored(bus);
        }
        let lifetime = self.lifetimes.sdo;
        let send = &mut |frame| out.send_for(bus, frame, now, lifetime);
        if !self.serve(SdoStep::Request(frame), now, send) {
            self.buses.malformed(bus);
        }
        if let Some(at) = self.services.take_written() {
            self.on_written(at, now, out);
        }
        self.is_device_due = true;
    }

    pub(super) fn refresh_health(&mut self) {
        self.services.show_health(&self.buses.health, &self.buses.counters);
    }

    /// Frames were lost on their way in or out.
    pub(super) fn lost(&mut self, bus: Bus) {
        self.services.occurred(ErrorCode::CAN_OVERRUN, bus);
        self.is_device_due = true;
    }

    /// An object was written over the bus: what depends on it follows.
    fn on_written(&mut self, at: Address, now: Instant, out: &mut Out) {
        let objects = &mut self.services.dictionary.objects;
        match (at.index, NodeId::new(at.sub)) {
            (SYNC_COB_ID | CYCLE_PERIOD | SYNC_OVERFLOW, _) => {
                self.sync.configure(sync_config(&objects.communication), now)
            }
            (CONSUMER_HEARTBEAT | PRODUCER_HEARTBEAT | REDUNDANCY, _) => {
                // The longest: no slave is lost before its own time.
                let times = objects.consumers.entries().iter().map(|entry| entry & 0xFFFF);
                let longest = times.max().filter(|time| *time > 0);
                if let Some(time) = longest {
                    self.redundancy.consumer = Duration::from_millis(u64::from(time));
                }
                let written = &objects.spacecraft.redundancy;
                self.redundancy.producer =
                    Duration::from_millis(u64::from(objects.communication.producer_heartbeat));
                self.redundancy.bdefault = Bus::from_bdefault(written.bdefault).unwrap_or(Bus::Nominal);
                (self.redundancy.ttoggle, self.redundancy.ntoggle) = (written.ttoggle, written.ntoggle);
                self.redundancy.ctoggle = written.ctoggle;
                self.manager.configure(self.redundancy, now);
            }
            (ASSIGNMENT, Some(node)) => {
                let raw = entry(&mut objects.application.network.assignment, node).map_or(0, |raw| *raw);
                let assignment = Assignment::from_raw(raw);
                self.boot.assign(node, assignment);
                self.manager.peers_mut().assign(node, assignment.is_slave());
            }
            (REQUEST_NMT, node) => self.on_requested_nmt(at.sub, node, now, out),
            (SCET_SET, _) => self.clock.set(objects.spacecraft.scet_set.into(), now),
            (SELF_TEST_START, _) => {
                objects.spacecraft.self_test = SelfTest { progress: SelfTest::RUNNING, failures: 0 };
                out.event(MasterEvent::SelfTest);
            }
            _ => {}
        }
        self.services.on_written(at);
        if at.index >= FIRST_TOLD {
            out.event(MasterEvent::Written(at));
        }
    }

    /// 1F82h was written: what is read there is the state of the slave, not the command.
    fn on_requested_nmt(&mut self, sub: u8, node: Option<NodeId>, now: Instant, out: &mut Out) {
        let nth = usize::from(sub).wrapping_sub(1);
        let Some(entry) = self.services.dictionary.objects.application.network.request_nmt.get_mut(nth)
        else {
            return;
        };
        let command = match *entry {
            4 => Command::Stop,
            5 => Command::Start,
            6 => Command::ResetNode,
            7 => Command::ResetCommunication,
            _ => Command::EnterPreOperational,
        };
        let state = node.and_then(|node| self.manager.peers().state(node));
        *entry = state.map_or(0, NmtState::byte);
        let target = node.filter(|_| sub != ALL).map_or(Target::All, Target::Node);
        self.on_nmt_request(NmtMessage { command, target }, now, out);
    }

    /// Object 1F82h.
    pub(super) fn show_state(&mut self, node: NodeId, state: u8) {
        if let Some(shown) =
            entry(&mut self.services.dictionary.objects.application.network.request_nmt, node)
        {
            *shown = state;
        }
    }

    /// A heartbeat on the active bus, for the consumers of 1016h.
    pub(super) fn on_monitored(&mut self, node: NodeId, state: NmtState, at: Instant) {
        if self.services.monitor.on_heartbeat(node, state, at).is_some_and(|heard| heard.resolved) {
            self.services.clear(ErrorCode::HEARTBEAT, node.get());
            self.is_device_due = true;
        }
    }

    pub(super) fn device_deadline(&self) -> Option<Instant> {
        let device = self.services.deadline(NmtState::Operational);
        earliest(&[device, self.services.monitor.deadline()])
    }

    pub(super) fn run_device(&mut self, until: Instant, now: Instant, out: &mut Out) {
        let is_overdue = self.device_deadline().is_some_and(|deadline| deadline <= until);
        if !(self.is_device_due || is_overdue) {
            return;
        }
        self.is_device_due = false;
        while let Some(missed) = self.services.monitor.poll(until) {
            self.services.raise(ErrorCode::HEARTBEAT, [missed.node.get(), 0, 0, 0, 0]);
        }
        let (bus, lifetime) = (self.manager.active(), self.lifetimes.sdo);
        let send = &mut |frame| out.send_for(bus, frame, now, lifetime);
        self.services.poll(until, NmtState::Operational, send);
        if self.services.is_sdo_busy() {
            self.serve(SdoStep::Poll, until, send);
        }
    }

    /// The SDO server runs.
    #[inline(never)] // of three callers
    pub(super) fn serve(&mut self, step: SdoStep, now: Instant, send: &mut dyn FnMut(Frame)) -> bool {
        self.services.serve(step, now, &mut |frame| send(frame))
    }
}
