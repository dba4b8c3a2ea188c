//! The master of the demonstration mission: a telecommand, a telemetry request, telemetry and local time for each slave.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Communication, Device, Identity, Master, Refusal};
use ecss_can::od::{Objects, Record, U24, U40, U48};
use ecss_can::pdo::{CobIdOf, PdoObjects, PdoSet, Rpdo, Tpdo};
use ecss_can::profile::Profile;
#[cfg(not(feature = "standby"))]
use ecss_can::redundancy::OneBoard;
use ecss_can::redundancy::{MasterBoards, Strap, TwoBoards};
use ecss_can::runner::{Handle, MasterHandle, Platform};
use ecss_can::store::ParameterStore;
use ecss_can::time::{LocalScet, ScetGet};
use ecss_can::types::{NodeId, Scet};

use crate::{Message, Outgoing};

/// Slaves of the mission: those that straps can number, 2 to 15.
pub const SLAVES: usize = 14;
const FIRST: u8 = 2;

/// Place of a slave among those of the mission, from zero.
pub const fn slot(node: NodeId) -> Option<usize> {
    match node.get() {
        id if id < FIRST || id >= FIRST + SLAVES as u8 => None,
        id => Some((id - FIRST) as usize),
    }
}

/// Transmit PDOs: the time, then telecommands to all slaves, then telemetry requests.
const TELECOMMANDS: usize = 1;
const REQUESTS: usize = TELECOMMANDS + SLAVES;
/// Receive PDOs: local times of all slaves, then their telemetry.
const LOCAL_TIMES: usize = 0;
const TELEMETRY: usize = LOCAL_TIMES + SLAVES;

/// The spacecraft time at the last SYNC, 181h (ECSS 7.2.3). Its period is that of the profile.
const SPACECRAFT_TIME: Tpdo = Tpdo::new(1, CobIdOf::fixed(0x181))
    .transmission(1)
    .map(LocalScet::SCET_GET.field(ScetGet::FINE))
    .map(LocalScet::SCET_GET.field(ScetGet::COARSE));

/// Telecommand to a slave: 300h + node.
const fn telecommand(nth: u16) -> Tpdo {
    let object = CommanderObjects::TELECOMMANDS.nth(nth);
    Tpdo::new(TELECOMMANDS as u16 + nth + 1, CobIdOf::fixed(0x300 + FIRST as u16 + nth))
        .map(object.field(Telecommanding::CODE))
        .map(object.field(Telecommanding::DATA))
        .map(object.field(Telecommanding::SEQUENCE))
}

/// Telemetry request to a slave: 400h + node.
const fn telemetry_request(nth: u16) -> Tpdo {
    let object = CommanderObjects::REQUESTS.nth(nth);
    Tpdo::new(REQUESTS as u16 + nth + 1, CobIdOf::fixed(0x400 + FIRST as u16 + nth))
        .map(object.field(Outgoing::CODE))
        .map(object.field(Outgoing::DATA))
}

/// Local time of a slave: 180h + node.
const fn local_time(nth: u16) -> Rpdo {
    let object = CommanderObjects::LOCAL_TIMES.nth(nth);
    Rpdo::new(LOCAL_TIMES as u16 + nth + 1, CobIdOf::fixed(0x180 + FIRST as u16 + nth))
        .map(object.field(LocalTime::FINE))
        .map(object.field(LocalTime::COARSE))
}

/// Telemetry of a slave: 380h + node.
const fn telemetry(nth: u16) -> Rpdo {
    let object = CommanderObjects::TELEMETRY.nth(nth);
    Rpdo::new(TELEMETRY as u16 + nth + 1, CobIdOf::fixed(0x380 + FIRST as u16 + nth))
        .map(object.field(Incoming::CODE))
        .map(object.field(Incoming::DATA))
}

const TPDOS: [Tpdo; REQUESTS + SLAVES] = {
    let mut all = [SPACECRAFT_TIME; REQUESTS + SLAVES];
    let mut nth = 0;
    while nth < SLAVES {
        all[TELECOMMANDS + nth] = telecommand(nth as u16);
        all[REQUESTS + nth] = telemetry_request(nth as u16);
        nth += 1;
    }
    all
};

const RPDOS: [Rpdo; TELEMETRY + SLAVES] = {
    let mut all = [local_time(0); TELEMETRY + SLAVES];
    let mut nth = 0;
    while nth < SLAVES {
        all[LOCAL_TIMES + nth] = local_time(nth as u16);
        all[TELEMETRY + nth] = telemetry(nth as u16);
        nth += 1;
    }
    all
};

/// What the master of the mission has beside the objects of every master: one of a row for each slave.
#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
pub struct CommanderObjects {
    /// Pulses per second
    ///
    /// At the pulse output of the board, at equal parts of a second of the spacecraft time.
    #[object(0x6310, rw, low = 1, high = 1000, default = 1)]
    pub pulses: u16,
    /// Cable measurement
    ///
    /// Of the active bus, from the master to a slave.
    #[object(0x6320, record)]
    pub cable: CableMeasurement,
    /// Telecommand to slave {}
    #[object(0x6200.., record)]
    pub telecommands: [Telecommanding; SLAVES],
    /// Telemetry request to slave {}
    #[object(0x6240.., record)]
    pub requests: [Outgoing; SLAVES],
    /// Telemetry of slave {}
    #[object(0x6280.., record)]
    pub telemetry: [Incoming; SLAVES],
    /// Local time of slave {}
    #[object(0x62C0.., record)]
    pub local_times: [LocalTime; SLAVES],
}

impl Device for CommanderObjects {
    type Pdos = PdoObjects<{ RPDOS.len() }, { TPDOS.len() }>;
    type Consumers = HeartbeatConsumers<SLAVES>;

    const PDOS: PdoSet = PdoSet::new(&RPDOS, &TPDOS);

    fn communication(id: NodeId) -> Communication {
        Communication {
            device_name: "ECSS-E-ST-50-15C master",
            software_version: env!("CARGO_PKG_VERSION"),
            identity: Identity { vendor: 0, product: 0x5015, revision: 1 << 16, serial: 1 },
            ..Communication::new(id)
        }
    }

    fn consumers(_: NodeId) -> Self::Consumers {
        let nodes = core::array::from_fn(|nth| (u32::from(FIRST) + nth as u32) << 16);
        HeartbeatConsumers { consumer_heartbeat: nodes }
    }
}

/// The last telecommand to a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Telecommanding {
    /// Code
    #[sub(1, ro, pdo)]
    pub code: u16,
    /// Data
    #[sub(2, ro, pdo)]
    pub data: U40,
    /// Sequence
    #[sub(3, ro, pdo)]
    pub sequence: u8,
}

/// The last telemetry of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Incoming {
    /// Code
    #[sub(1, rww, pdo)]
    pub code: u16,
    /// Data
    #[sub(2, rww, pdo)]
    pub data: U48,
}

/// The time of a slave at the last SYNC that it answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct LocalTime {
    /// Coarse time
    ///
    /// Seconds.
    #[sub(1, rww, pdo)]
    pub coarse: u32,
    /// Fine time
    ///
    /// Multiples of 2^-24 s.
    #[sub(2, rww, pdo)]
    pub fine: U24,
}

/// How long a signal takes from the master to a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct CableMeasurement {
    /// Node-ID
    ///
    /// Written, it starts for a slave, 2 to 127, whose clock follows the master's SYNCs; others mean nothing.
    #[sub(1, rw, high = 127)]
    pub node: u8,
    /// Progress
    ///
    /// 0 never run, 1 running, 2 measured, 3 failed.
    #[sub(2, ro)]
    pub progress: u8,
    /// Abort code
    ///
    /// Of the transfer that failed; zero for none.
    #[sub(3, ro)]
    pub abort: u32,
    /// Bus
    ///
    /// 0 nominal, 1 redundant.
    #[sub(4, ro)]
    pub bus: u8,
    /// Delay
    ///
    /// Nanoseconds.
    #[sub(5, ro)]
    pub delay: i32,
}

impl CableMeasurement {
    /// Value of the progress: it runs.
    pub const RUNNING: u8 = 1;
    /// Value of the progress: bus and delay are those of the node.
    pub const MEASURED: u8 = 2;
    /// Value of the progress: the abort code says why.
    pub const FAILED: u8 = 3;
}

/// Number of master boards that images of the mission are built for: one, or with the feature `standby` two.
#[cfg(not(feature = "standby"))]
pub type Boards = OneBoard;
/// Number of master boards that images of the mission are built for: one, or with the feature `standby` two.
#[cfg(feature = "standby")]
pub type Boards = TwoBoards;

/// The master of the mission, with a parameter store if its board has one.
pub fn master(
    profile: &Profile,
    store: Option<&'static mut (dyn ParameterStore + Send)>,
) -> Master<CommanderObjects> {
    Master::new(profile, CommanderObjects::default(), store)
}

/// One of two masters of the mission, `strap` says which one; with a parameter store if its board has one.
pub fn master_of_two(
    profile: &Profile,
    strap: Strap,
    store: Option<&'static mut (dyn ParameterStore + Send)>,
) -> Master<CommanderObjects, TwoBoards> {
    Master::of_two(profile, strap, CommanderObjects::default(), store)
}

/// Sends a telecommand.
///
/// # Errors
/// [`Refusal`]; a node that is none of the mission's is not operational.
pub fn command<B: MasterBoards>(
    master: Handle<impl Platform, Master<CommanderObjects, B>>,
    node: NodeId,
    message: &Message,
) -> Result<(), Refusal> {
    let (number, fill) = command_pdo(node, message)?;
    master.send_pdo_to(node, number, fill)
}

/// Requests telemetry.
///
/// # Errors
/// [`Refusal`]; a node that is none of the mission's is not operational.
pub fn request<B: MasterBoards>(
    master: Handle<impl Platform, Master<CommanderObjects, B>>,
    node: NodeId,
    message: &Message,
) -> Result<(), Refusal> {
    let (number, fill) = request_pdo(node, message)?;
    master.send_pdo_to(node, number, fill)
}

/// Returns the number of the PDO of a telecommand, and a function that fills its object.
///
/// # Errors
/// [`Refusal::NotOperational`] for a node that is none of the mission's.
pub fn command_pdo(
    node: NodeId,
    message: &Message,
) -> Result<(usize, impl FnOnce(&mut CommanderObjects) + Send + use<>), Refusal> {
    let nth = slot(node).ok_or(Refusal::NotOperational)?;
    let [a, b, c, d, e, sequence] = message.data();
    let data = U40::new(u64::from_le_bytes([a, b, c, d, e, 0, 0, 0]));
    let command = Telecommanding { code: message.code(), data, sequence };
    let fill = move |objects: &mut CommanderObjects| {
        if let Some(object) = objects.telecommands.get_mut(nth) {
            *object = command;
        }
    };
    Ok((TELECOMMANDS + nth, fill))
}

/// Returns the number of the PDO of a telemetry request, and a function that fills its object.
///
/// # Errors
/// [`Refusal::NotOperational`] for a node that is none of the mission's.
pub fn request_pdo(
    node: NodeId,
    message: &Message,
) -> Result<(usize, impl FnOnce(&mut CommanderObjects) + Send + use<>), Refusal> {
    let nth = slot(node).ok_or(Refusal::NotOperational)?;
    let request = (*message).into();
    let fill = move |objects: &mut CommanderObjects| {
        if let Some(object) = objects.requests.get_mut(nth) {
            *object = request;
        }
    };
    Ok((REQUESTS + nth, fill))
}

/// Content of a receive PDO of the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// Telemetry.
    Telemetry(Message),
    /// Its time at the last SYNC.
    LocalTime(Scet),
}

/// Sender and content of receive PDO `number`. `None` for a number that the mission does not use, and for malformed data.
pub fn received(number: u16, data: [u8; 8]) -> Option<(NodeId, Received)> {
    let number = usize::from(number);
    let nth = number.checked_sub(TELEMETRY).unwrap_or(number);
    let node = NodeId::new(FIRST + u8::try_from(nth).ok().filter(|nth| usize::from(*nth) < SLAVES)?)?;
    let content = if number < TELEMETRY {
        Received::LocalTime(Scet::decode(data.get(..7)?)?)
    } else {
        Received::Telemetry(Message::from_payload(&data)?)
    };
    Some((node, content))
}
