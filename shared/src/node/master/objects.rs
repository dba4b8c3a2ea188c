//! Dictionary of the master at run time: SDO server, PDOs, effects of written objects, and acceptance filters.

use async_canopen::node::extend::{Part, SdoStep};

use super::declared::MasterObjects;
use super::initial::written_redundancy;
use super::{Master, MasterServices, Turn};
use crate::emcy::ErrorCode;
use crate::heartbeat::ConsumerSlots;
use crate::link::machine::Outgoing;
use crate::link::port::Filter;
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::index::{
    ASSIGNMENT, CONSUMER_HEARTBEAT, LAST_TPDO_MAPPING, PRODUCER_HEARTBEAT, RANGING, REDUNDANCY, REQUEST_NMT,
    RPDO, SYNC_COB_ID, SYNC_DITHER,
};
use crate::node::network_objects::entry;
use crate::node::services::{LiveServices, TimeServices, UpsetServices};
use crate::node::{Filters, NodeObjects, Ranging, SelfTest, SpacecraftDevice};
use crate::redundancy::{MasterBoards, Sending};
use crate::types::{Address, Bus, CobId, Frame, Instant, NmtState, NodeId};

/// 1F82h: never heard, or forgotten.
pub(super) const UNKNOWN: u8 = 0;
/// 1F82h: lost.
pub(super) const MISSING: u8 = 1;
/// 1F82h: sub-index of all nodes.
const ALL: u8 = 128;
/// Function codes of COB-IDs. Each has a filter; that of the requests to the SDO server of the master follows.
pub(super) const FUNCTIONS: usize = 16;

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
    pub(super) fn on_written(&mut self, at: Address, turn: &mut Turn) {
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
                let written = written_redundancy(&self.services, &self.initial);
                self.follow_consumers();
                self.redundancy_mut().configure(written, now);
            }
            SYNC_COB_ID | RPDO..=LAST_TPDO_MAPPING => self.note_filters(),
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

    /// Takes the consumer times of 1016h.
    pub(super) fn follow_consumers(&mut self) {
        let redundancy = self.redundancy.change(self.services.wakes_mut());
        redundancy.peers_mut().set_times(self.services.objects().consumers.entries());
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

    /// Runs the SDO server.
    pub(super) fn serve(&mut self, step: SdoStep, now: Instant, send: &mut dyn FnMut(Frame)) -> bool {
        self.services.serve(step, now, &mut |frame| send(frame))
    }

    /// Puts the result of a self-test into object 2031h (ECSS 6.7b).
    pub fn report_self_test(&mut self, result: SelfTest, now: Instant) {
        self.services.change(now, |objects| objects.extension.self_test = result);
    }

    /// Ends the measurement of a cable: 2044h names no slave.
    pub(crate) fn stop_ranging(&mut self) {
        self.services.network_mut().ranging = Ranging::default();
    }

    /// Returns the active bus, and the correction of the stamps there in nanoseconds.
    pub(crate) fn active_correction(&self) -> (Bus, i32) {
        let bus = self.redundancy.active();
        (bus, self.services.objects().extension.correction().of(bus).unwrap_or(0))
    }

    /// Returns the filters by function codes: heartbeats, SDO responses, EMCY, SYNCs of another master, PDOs, and
    /// requests to the SDO server of the master.
    pub fn filters(&self) -> Filters {
        (0..=FUNCTIONS).map(|number| self.filter(number)).collect()
    }

    /// Returns a filter: all COB-IDs of one function code, heartbeats again if none of these is needed, or the
    /// requests to this server.
    pub(super) fn filter(&self, number: usize) -> Filter {
        let is_of = |id: CobId| usize::from(id.raw() >> 7) == number;
        let node = NodeId::MASTER;
        let raw = D::RAW_FRAMES.iter().copied();
        let sync = self.services.written_sync_id();
        let own = [CobId::heartbeat(node), CobId::sdo_response(node), CobId::emcy(node), sync];
        let mut wanted = own
            .into_iter()
            .chain(self.of_other_master())
            .chain(self.services.rpdo_ids())
            .chain(raw)
            .filter(|id| is_of(*id));
        match wanted.next() {
            _ if number == FUNCTIONS => Filter::exact(CobId::sdo_request(node)),
            Some(id) => Filter::function(id),
            None => Filter::function(CobId::heartbeat(node)),
        }
    }

    /// Returns the COB-IDs of another master that this one takes: claims, and the spacecraft time.
    fn of_other_master(&self) -> impl Iterator<Item = CobId> {
        let pair = self.redundancy.standby().map(|standby| *standby.pair());
        let ids = pair.map(|pair| pair.both_claims());
        let time = pair.and_then(|_| self.services.time_pdo()).map(|pdo| pdo.id);
        ids.into_iter().flatten().chain(time)
    }

    /// Looks for flipped bits, a little with each heartbeat: in its Node-ID and in COB-IDs (ECSS 6.10d, k). Reports those that the
    /// board found.
    pub(super) fn scrub(&mut self, turn: &Turn) {
        self.services.compare_node_ids(&mut { NodeId::MASTER });
        let written = written_redundancy(&self.services, &self.initial);
        let is_wrong = [
            self.redundancy.no_sooner().refresh(written, turn.now),
            self.clock.compare(self.services.time_mut().clock_mut()),
            self.compare_assignments(),
        ];
        if is_wrong.contains(&true) {
            self.services.report_flipped();
        }
        self.services.refresh_derived(self.redundancy.state(), turn.now);
        self.redundancy.no_sooner().peers_mut().set_times(self.services.objects().consumers.entries());
        if self.services.compare_cob_ids(turn.now) {
            self.follow(Address::new(SYNC_COB_ID, 0), turn.now);
            // A bus may have taken a filter from the object that was wrong.
            self.note_filters();
        }
        if !self.sync.agrees(&self.services.objects().communication.sync) {
            let sync = self.sync.change(self.services.wakes_mut());
            sync.restore(&self.services.objects().communication.sync, turn.now);
            self.services.report_flipped();
        }
        self.services.report_upsets();
    }

    /// Notes that filters may have changed.
    pub(super) fn note_filters(&mut self) {
        self.filters.change(self.services.wakes_mut()).note_all(FUNCTIONS);
    }

    /// Sends both buses the filters that may have changed, as a standby, too.
    pub(super) fn run_filters(&mut self, turn: &mut Turn) {
        if self.filters.earliest().is_some() {
            let mut filters = *self.filters;
            filters.send(&Bus::ALL, |number| self.filter(number), turn);
            *self.filters.no_sooner() = filters;
        }
    }
}
