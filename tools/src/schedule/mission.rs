//! The messages of the demonstration mission, from the objects of its master and its slaves at power-on.

use std::time::Duration;

use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::{Communication, NodeObjects, SpacecraftDevice};
use ecss_can::od::{CobIdEntry, INVALID};
use ecss_can::pdo::{Mapping, NodePdo, PdoParameters, PdoSlots};
use ecss_can::profile::Profile;
use ecss_can::sdo::SdoServerObjects;
use ecss_can::types::{self, CobId, NodeId};
use mission::{COMMAND_PERIOD, MissionObjects, TELEMETRY_PERIOD};

use super::message::{Message, nanos};

/// Data bytes of a heartbeat, of an emergency and of an SDO frame (CiA 301).
const HEARTBEAT_BYTES: u8 = 1;
const EMCY_BYTES: u8 = 8;
const SDO_BYTES: u8 = 8;
/// Largest transmission type of a synchronous PDO.
const LAST_SYNCHRONOUS: u8 = 240;

/// A message with its name.
#[derive(Clone, Debug)]
pub struct Named {
    /// Service and node.
    pub name: String,
    /// Its frames.
    pub message: Message,
}

/// Assumptions that no object states.
#[derive(Clone, Copy, Debug)]
pub struct Assumed {
    /// Slaves: nodes 2, 3, and so on.
    pub slaves: u8,
    /// Each slave gets an SDO request at most once in this time. `None`: once in a heartbeat period.
    pub sdo: Option<Duration>,
    /// Release jitter of every frame: software and timers.
    pub jitter: Duration,
}

/// All messages, from the highest priority.
pub fn messages(profile: &Profile, assumed: &Assumed) -> Vec<Named> {
    let master = mission::master(profile).build();
    let mut set = Set { profile, assumed, all: Vec::new() };
    let (sync, cycle) = set.sync(&master.objects().communication);
    set.node("master", sync, cycle, master.objects());
    for id in (2..=assumed.slaves + 1).filter_map(NodeId::new) {
        let slave = mission::slave(id, profile, Vec::new()).build();
        let name = format!("slave {}", id.get());
        set.nmt(&name, id);
        set.sdo(&name, &slave.objects().sdo);
        set.node(&name, sync, cycle, slave.objects());
        // The master has no objects for its messages to a slave.
        set.command(format!("telecommand {name}"), mission::TELECOMMAND.of(id));
        set.command(format!("request {name}"), mission::REQUEST.of(id));
        set.follow(<MissionObjects>::TELEMETRY_PDO.of(id), mission::REQUEST.of(id));
    }
    set.sorted()
}

struct Set<'a> {
    profile: &'a Profile,
    assumed: &'a Assumed,
    all: Vec<Named>,
}

impl Set<'_> {
    fn add(
        &mut self,
        name: String,
        id: u32,
        bytes: u8,
        period: Duration,
        deadline: Duration,
        after: Option<usize>,
    ) {
        let id = CobIdEntry::from_raw(id).id().raw();
        let message = Message { id, bytes, period, jitter: self.assumed.jitter, deadline, after };
        self.all.push(Named { name, message });
    }

    /// Adds SYNC. Returns its index and period.
    fn sync(&mut self, master: &Communication) -> (usize, Duration) {
        let period = Duration::from_micros(master.sync.cycle_period.into());
        let bytes = u8::from(master.sync.overflow > 0);
        self.add("SYNC".into(), master.sync.cob_id, bytes, period, period, None);
        (self.all.len() - 1, period)
    }

    /// Adds NMT commands. The master starts a slave after its heartbeat; a command is valid for at most a heartbeat
    /// period.
    fn nmt(&mut self, name: &str, id: NodeId) {
        let frame = NmtMessage { command: Command::Start, target: Target::Node(id) }.encode();
        let period = std(self.profile.heartbeat);
        let (id, bytes) = (frame.id().raw().into(), frame.data().len() as u8);
        self.add(format!("NMT {name}"), id, bytes, period, period, None);
    }

    /// Adds requests to each slave in turn. The response is due before the client's timeout.
    fn sdo(&mut self, name: &str, server: &SdoServerObjects) {
        let server = &server.sdo_server;
        let period = self.assumed.sdo.unwrap_or(std(self.profile.heartbeat));
        let (deadline, request) = (std(self.profile.sdo_timeout), Some(self.all.len()));
        self.add(format!("SDO request {name}"), server.request, SDO_BYTES, period, deadline, None);
        self.add(format!("SDO answer {name}"), server.response, SDO_BYTES, period, deadline, request);
    }

    /// Adds heartbeat, emergencies and PDOs of a node.
    fn node<D: SpacecraftDevice>(
        &mut self,
        name: &str,
        sync: usize,
        cycle: Duration,
        objects: &NodeObjects<D>,
    ) {
        let communication = &objects.communication;
        let inhibit = tenths(communication.emcy.inhibit);
        self.add(format!("EMCY {name}"), communication.emcy.cob_id, EMCY_BYTES, inhibit, inhibit, None);
        let own = CobIdEntry::from_raw(communication.emcy.cob_id).id().node();
        if let Some(own) = own {
            // After a period it would be outdated, and after the consumer time missed.
            let period = Duration::from_millis(communication.heartbeat.time.into());
            let deadline = period.min(std(self.profile.consumer).saturating_sub(period));
            let id = CobId::heartbeat(own).raw().into();
            self.add(format!("heartbeat {name}"), id, HEARTBEAT_BYTES, period, deadline, None);
        }
        let (parameters, mappings) = objects.pdos.tpdos();
        let valid =
            parameters.iter().zip(mappings).zip(1..).filter(|((pdo, _), _)| pdo.cob_id & INVALID == 0);
        for ((pdo, mapping), number) in valid {
            let name = format!("TPDO {number} {name}");
            let bits: u32 = mapping.objects().iter().map(|object| object & 0xFF).sum();
            let bytes = bits.div_ceil(8) as u8;
            if pdo.transmission <= LAST_SYNCHRONOUS {
                // It belongs to the last SYNC, and must arrive before the next one.
                let period = cycle * u32::from(pdo.transmission.max(1));
                self.add(name, pdo.cob_id, bytes, period, cycle, Some(sync));
            } else {
                self.add(name, pdo.cob_id, bytes, on_event(pdo), std(self.profile.event), None);
            }
        }
    }

    /// Adds a message of the master's application to a slave.
    fn command<T>(&mut self, name: String, pdo: NodePdo<T>) {
        let period = std(COMMAND_PERIOD).min(std(TELEMETRY_PERIOD));
        self.add(name, pdo.cob_id().raw().into(), pdo.bytes(), period, std(self.profile.event), None);
    }

    /// Makes the frames of one COB-ID the answers to those of another.
    fn follow<A, R>(&mut self, answer: NodePdo<A>, request: NodePdo<R>) {
        let index = |id: CobId| self.all.iter().position(|named| named.message.id == id.raw());
        if let (Some(answer), Some(request)) = (index(answer.cob_id()), index(request.cob_id())) {
            self.all[answer].message.after = Some(request);
        }
    }

    fn sorted(self) -> Vec<Named> {
        let mut order: Vec<usize> = (0..self.all.len()).collect();
        order.sort_by_key(|&index| self.all[index].message.id);
        let mut places = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, &index)| places[index] = place);
        let placed = |&index: &usize| {
            let mut named = self.all[index].clone();
            named.message.after = named.message.after.map(|trigger| places[trigger]);
            named
        };
        order.iter().map(placed).collect()
    }
}

/// Returns the shortest time between two frames of an event-driven PDO: its inhibit time, or else that of the mission.
fn on_event(pdo: &PdoParameters) -> Duration {
    match pdo.inhibit {
        0 => std(COMMAND_PERIOD).min(std(TELEMETRY_PERIOD)),
        inhibit => tenths(inhibit),
    }
}

/// Converts multiples of 100 us, the unit of inhibit times.
fn tenths(multiples: u16) -> Duration {
    Duration::from_micros(100) * u32::from(multiples)
}

fn std(duration: types::Duration) -> Duration {
    Duration::from_micros(duration.as_micros())
}

/// Microseconds, rounded up.
pub(crate) fn micros(span: Duration) -> u64 {
    nanos(span).div_ceil(1_000)
}
