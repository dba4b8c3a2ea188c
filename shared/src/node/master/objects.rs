//! Dictionary of the master, and effects of written objects.

use async_canopen::node::extend::SdoStep;

use super::MasterServices;
use super::declared::MasterObjects;
use super::{Master, Turn};
use crate::boot::machine::Assignment;
use crate::emcy::{ActiveErrors, DeviceError, EmcyConsumers, ErrorCode, PostMortem};
use crate::heartbeat::{ConsumerSlots, HeartbeatTimes};
use crate::link::machine::Outgoing;
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::NetworkObjects;
use crate::node::index::{
    ASSIGNMENT, CONSUMER_HEARTBEAT, LAST_TPDO_MAPPING, PRODUCER_HEARTBEAT, RANGING, REDUNDANCY, REQUEST_NMT,
    RPDO, SYNC_COB_ID, SYNC_DITHER,
};
use crate::node::network_objects::entry;
use crate::node::services::LiveServices;
use crate::node::services::carries_time;
use crate::node::{
    Communication, Device, DeviceNode, NodeObjects, SelfTest, Spacecraft, SpacecraftDevice, assert_device,
};
use crate::pdo::PdoSlots;
use crate::pdo::machine::rules::{LAST_CYCLIC, is_synchronous};
use crate::profile::Profile;
use crate::redundancy::{MasterBoards, MasterSetup, Parameters, Sending};
use crate::sdo::SdoServerObjects;
use crate::types::{AbortCode, Address, Bus, Duration, Frame, Instant, NmtState, NodeId};

/// Transmission type of a PDO that goes with each SYNC.
const EVERY_SYNC: u8 = 1;
/// 1F82h: never heard, or forgotten.
pub(super) const UNKNOWN: u8 = 0;
/// 1F82h: lost.
pub(super) const MISSING: u8 = 1;
/// 1F82h: sub-index of all nodes.
const ALL: u8 = 128;

/// Numbers of the profile that power-on and reset communication begin with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Initial {
    redundancy: Parameters,
    sync: Duration,
    time: Duration,
}

/// Returns the numbers of the redundancy at power-on.
pub(super) fn setup(profile: &Profile) -> MasterSetup {
    MasterSetup {
        parameters: profile.master_redundancy(),
        silent_share: profile.silent_share,
        dwell: profile.dwell,
        grace: profile.grace,
        access: profile.access(NodeId::MASTER),
        lifetime: profile.heartbeat,
    }
}

impl Initial {
    pub fn new(profile: &Profile) -> Initial {
        Initial { redundancy: profile.master_redundancy(), sync: profile.sync, time: profile.time }
    }

    /// Makes the objects at power-on.
    #[inline(never)] // made in their place
    pub fn objects<D: SpacecraftDevice>(
        &self,
        profile: &Profile,
        device: D,
        post_mortem: PostMortem,
    ) -> NodeObjects<MasterObjects<D>> {
        const { assert_device::<MasterObjects<D>>() };
        NodeObjects {
            application: application(profile, device),
            extension: self.spacecraft(post_mortem),
            communication: self.communication::<D>(),
            consumers: self.consumers::<D>(),
            pdos: self.pdos::<D>(),
            sdo: SdoServerObjects::of(NodeId::MASTER),
        }
    }

    /// Restores the communication profile of power-on.
    pub fn restore<D: SpacecraftDevice>(&self, objects: &mut NodeObjects<MasterObjects<D>>) {
        objects.communication = self.communication::<D>();
        objects.consumers = self.consumers::<D>();
        objects.pdos = self.pdos::<D>();
    }

    fn spacecraft(&self, post_mortem: PostMortem) -> Spacecraft {
        let mut spacecraft = Spacecraft::default();
        spacecraft.set_redundancy(&self.redundancy);
        spacecraft.set_post_mortem(post_mortem);
        spacecraft
    }

    /// Returns the communication profile with the periods of the mission.
    pub fn communication<D: SpacecraftDevice>(&self) -> Communication {
        let mut communication = MasterObjects::<D>::communication(NodeId::MASTER);
        communication.heartbeat.time = self.redundancy.producer.as_millis() as u16;
        communication.sync.cycle_period = self.sync.as_micros() as u32;
        communication
    }

    /// 1016h: entries take the time of the profile where the device declares none.
    fn consumers<D: SpacecraftDevice>(&self) -> D::Consumers {
        let mut consumers = D::consumers(NodeId::MASTER);
        let time = self.redundancy.consumer.as_millis() as u32 & 0xFFFF;
        for entry in consumers.entries_mut() {
            if *entry >> 16 != 0 && *entry & 0xFFFF == 0 {
                *entry |= time;
            }
        }
        consumers
    }

    /// PDOs of the time take the period of the profile where the device declares none: with SYNCs every n-th one.
    #[inline(never)] // made in their place
    fn pdos<D: SpacecraftDevice>(&self) -> D::Pdos {
        let mut pdos = D::pdos(NodeId::MASTER);
        let period = self.time.as_millis().min(u64::from(u16::MAX)) as u16;
        let syncs = self.time.as_micros() / self.sync.as_micros().max(1);
        let (tpdos, mappings) = pdos.tpdos_mut();
        for (tpdo, mapping) in tpdos.iter_mut().zip(mappings) {
            if !carries_time(mapping) {
                continue;
            }
            match tpdo.transmission {
                EVERY_SYNC => tpdo.transmission = syncs.clamp(1, u64::from(LAST_CYCLIC)) as u8,
                by_event if !is_synchronous(by_event) && tpdo.event_timer == 0 => tpdo.event_timer = period,
                _ => {}
            }
        }
        pdos
    }
}

#[inline(never)] // made in their place
fn application<D: SpacecraftDevice>(profile: &Profile, device: D) -> MasterObjects<D> {
    MasterObjects {
        device,
        emergencies: EmcyConsumers::of_others(NodeId::MASTER),
        errors: ActiveErrors::default(),
        network: network(profile),
    }
}

/// The slaves of the profile.
#[inline(never)] // made in its place
fn network(profile: &Profile) -> NetworkObjects {
    let boot_time = profile.boot.time.as_millis() as u32;
    let mut network = NetworkObjects { boot_time, ..NetworkObjects::default() };
    for slave in profile.slaves {
        if let Some(assignment) = entry(&mut network.assignment, slave.node) {
            *assignment = slave.assignment().raw();
        }
        network.expect(slave.node, &slave.expected);
    }
    network
}

/// The redundancy parameters as the dictionary has them (1016h, 1017h, 2000h). Without an entry of 1016h in use the
/// consumer time is that of power-on.
pub(super) fn written_redundancy<D: SpacecraftDevice>(
    objects: &NodeObjects<MasterObjects<D>>,
    initial: &Initial,
) -> Parameters {
    // The longest: no decision goes before a slave's own time.
    let consumer = objects.consumers.longest_time().unwrap_or(initial.redundancy.consumer);
    let producer = objects.communication.heartbeat.period();
    objects.extension.redundancy(HeartbeatTimes { consumer, producer })
}

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Returns the object dictionary.
    pub fn objects(&self) -> &NodeObjects<MasterObjects<D>> {
        self.services.objects()
    }

    /// Returns the object dictionary alone, for a data sheet.
    pub fn into_objects(self) -> NodeObjects<MasterObjects<D>> {
        self.services.into_objects()
    }

    /// Takes a request to the SDO server.
    pub(super) fn on_sdo(&mut self, bus: Bus, frame: &Frame, turn: &mut Turn) {
        self.services.refresh_for(frame, turn.now);
        if !self.redundancy.is_announced() || !self.redundancy.state().allows_sdo() {
            return self.services.buses_mut().count_ignored(bus);
        }
        let Turn { now, out, .. } = turn;
        let expires = *now + self.services.sdo_lifetime();
        let send = &mut |frame| out.send_until(bus, frame, expires);
        if !self.serve(SdoStep::Request(frame), *now, send) {
            self.services.buses_mut().count_malformed(bus);
        }
        if let Some(at) = self.services.take_written() {
            self.on_written(at, turn);
        }
    }

    /// Goes on with a save that runs, and answers its client at its end.
    pub(super) fn advance_save(&mut self, turn: &mut Turn) {
        if let Some((Some(answer), _)) = self.services.advance_save(turn.now) {
            turn.out.send_for(self.redundancy.active(), answer, turn.now, self.services.sdo_lifetime());
        }
    }

    /// Reports frames that were lost in the receiver or before they were sent.
    pub(super) fn lost(&mut self, bus: Bus) {
        self.services.occurred(ErrorCode::CAN_OVERRUN, bus);
        if bus == self.redundancy.active() {
            self.errors_mut().restart();
        }
    }

    /// Applies an object that was written over the bus.
    fn on_written(&mut self, at: Address, turn: &mut Turn) {
        self.services.on_own_written(at, turn);
        if at.index == REQUEST_NMT {
            self.on_requested_nmt(at.sub, turn);
        }
        self.follow(at, turn.now);
        self.services.report_written(at, turn);
    }

    /// Applies a new value of an object.
    pub(super) fn follow(&mut self, at: Address, now: Instant) {
        let sync = self.sync.change(self.services.wakes_mut());
        sync.follow(at, &self.services.objects().communication.sync, now);
        match at.index {
            CONSUMER_HEARTBEAT | PRODUCER_HEARTBEAT | REDUNDANCY => {
                let written = written_redundancy(self.services.objects(), &self.initial);
                self.follow_consumers();
                self.redundancy_mut().configure(written, now);
            }
            SYNC_COB_ID | RPDO..=LAST_TPDO_MAPPING => self.filters_mut().note_change(),
            SYNC_DITHER => sync.set_dither(self.services.network().sync_dither),
            RANGING => self.services.network_mut().ranging.heard = 0,
            ASSIGNMENT => {
                if let Some(node) = NodeId::new(at.sub) {
                    self.take_assignment(node);
                }
            }
            _ => {}
        }
    }

    /// Before power-on, and when communication is reset: objects 1016h and 1F81h.
    pub(super) fn take_assignments(&mut self) {
        self.follow_consumers();
        (1..=127).filter_map(NodeId::new).for_each(|node| self.take_assignment(node));
    }

    /// Takes the consumer times of 1016h.
    fn follow_consumers(&mut self) {
        let redundancy = self.redundancy.change(self.services.wakes_mut());
        redundancy.peers_mut().set_times(self.services.objects().consumers.entries());
    }

    fn take_assignment(&mut self, node: NodeId) {
        let network = self.services.network_mut();
        let raw = entry(&mut network.assignment, node).map_or(0, |raw| *raw);
        let assignment = Assignment::from_raw(raw);
        self.boot_mut().assign(node, assignment);
        self.redundancy_mut().peers_mut().assign(node, assignment.is_slave());
    }

    /// Executes a command written to 1F82h. The entry then shows the state of the node again.
    fn on_requested_nmt(&mut self, sub: u8, turn: &mut Turn) {
        let (nth, node) = (usize::from(sub).wrapping_sub(1), NodeId::new(sub));
        let network = self.services.network_mut();
        let Some(entry) = network.request_nmt.get_mut(nth) else { return };
        let command = match *entry {
            4 => Command::Stop,
            5 => Command::Start,
            6 => Command::ResetNode,
            7 => Command::ResetCommunication,
            _ => Command::EnterPreOperational,
        };
        let state = match node {
            Some(NodeId::MASTER) => Some(self.redundancy.state()),
            node => node.and_then(|node| self.redundancy.peers().state(node)),
        };
        *entry = state.map_or(UNKNOWN, NmtState::byte);
        let target = node.filter(|_| sub != ALL).map_or(Target::All, Target::Node);
        self.on_nmt_request(NmtMessage { command, target }, turn);
    }

    /// Object 1F82h.
    pub(super) fn show_state(&mut self, node: NodeId, state: u8) {
        if let Some(shown) = entry(&mut self.services.network_mut().request_nmt, node) {
            *shown = state;
        }
    }

    pub(super) fn run_device(&mut self, turn: &mut Turn) {
        while self.services.poll_monitor(turn.until).is_some() {}
        self.send_due(turn);
        let (bus, lifetime) = (self.redundancy.active(), self.services.sdo_lifetime());
        if self.services.is_sdo_busy() {
            let Turn { until, now, out } = turn;
            let send = &mut |frame| out.send_for(bus, frame, *now, lifetime);
            self.serve(SdoStep::Poll(*until), *now, send);
        }
    }

    /// Returns the state that decides whether emergencies may be sent.
    pub(super) fn reporting_state(&self) -> NmtState {
        if self.is_booting { NmtState::Initialising } else { self.redundancy.state() }
    }

    /// Sends emergencies and transmit PDOs. Before the bus is announced they are held. The spacecraft time is not
    /// held: it is sampled again at the announcement.
    fn send_due(&mut self, turn: &mut Turn) {
        let (withheld, state) = (self.withheld_time(), self.reporting_state());
        let Self { services, redundancy, .. } = self;
        let (redundancy, Turn { until, now, out }) = (redundancy.no_sooner(), turn);
        services.poll(*until, *now, state, &mut |frame, expires, carries_time| {
            if withheld == Some(frame.id()) {
                // The time of the slaves is better.
                return true;
            }
            let outgoing = Outgoing { frame, expires };
            match if carries_time { redundancy.send_time() } else { redundancy.send(outgoing) } {
                Sending::Now(bus) => out.offer(bus, frame, expires),
                Sending::Held => true,
                Sending::Refused(_) => false,
            }
        });
    }

    /// The SDO server runs.
    #[inline(never)] // three callers
    pub(super) fn serve(&mut self, step: SdoStep, now: Instant, send: &mut dyn FnMut(Frame)) -> bool {
        self.services.serve(step, now, &mut |frame| send(frame))
    }

    /// Puts the result of a self-test into object 2031h (ECSS 6.7b).
    pub fn report_self_test(&mut self, result: SelfTest, now: Instant) {
        self.services.change(now, |objects| objects.extension.self_test = result);
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> DeviceNode for Master<D, B> {
    type Device = D;

    fn device(&self) -> &D {
        &self.objects().application.device
    }

    fn change<R>(&mut self, now: Instant, change: impl FnOnce(&mut D) -> R) -> R {
        self.services.change(now, |objects| change(&mut objects.application.device))
    }

    fn write(&mut self, at: Address, value: &[u8], turn: &mut Turn) -> Result<(), AbortCode> {
        if let Some(at) = self.services.write(at, value, turn.now)? {
            self.on_written(at, turn);
        }
        self.run_all(turn);
        Ok(())
    }

    fn raise(&mut self, error: DeviceError, info: [u8; 4]) {
        self.services.raise(error.code, error.field(info));
    }

    fn clear(&mut self, error: DeviceError) {
        self.services.clear(error.code, error.source);
    }
}
