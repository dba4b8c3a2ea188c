//! The master of the demonstration mission: it commands each slave, and receives its telemetry and its local time.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Communication, Device, Identity, LOCAL_TIME_PDO, MASTER_TIME, Master, MasterBuilder};
use ecss_can::od::{Objects, Record};
use ecss_can::pdo::{PdoObjects, PdoSet, ReceivedPdo, Rpdo};
use ecss_can::profile::Profile;
#[cfg(not(feature = "standby"))]
use ecss_can::redundancy::OneBoard;
#[cfg(feature = "standby")]
use ecss_can::redundancy::TwoBoards;
use ecss_can::types::{NodeId, Scet};

use crate::{Message, MissionObjects};

/// Number of slaves of the mission: Node-IDs that straps can set, 2 to 15.
pub const SLAVES: usize = 14;
const FIRST: u8 = 2;

/// Returns the index of a slave among those of the mission, from zero. `None` for another node.
pub const fn slot(node: NodeId) -> Option<usize> {
    match node.get() {
        id if id < FIRST || id >= FIRST + SLAVES as u8 => None,
        id => Some((id - FIRST) as usize),
    }
}

/// Local times of all slaves, then their telemetry.
const RPDOS: [Rpdo; 2 * SLAVES] = {
    let mut all = [LOCAL_TIME_PDO.of(NodeId::of::<FIRST>()).receive(1); 2 * SLAVES];
    let mut nth = 0;
    while nth < SLAVES {
        let node = NodeId::new(FIRST + nth as u8).unwrap();
        all[nth] = LOCAL_TIME_PDO.of(node).receive(nth as u16 + 1);
        all[SLAVES + nth] = <MissionObjects>::TELEMETRY_PDO.of(node).receive((SLAVES + nth) as u16 + 1);
        nth += 1;
    }
    all
};

/// Objects of the master of the mission besides those of every master.
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
}

impl Device for CommanderObjects {
    type Pdos = PdoObjects<{ RPDOS.len() }, 1>;
    type Consumers = HeartbeatConsumers<SLAVES>;

    const PDOS: PdoSet = PdoSet::new(&RPDOS, &[MASTER_TIME]);

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

/// Propagation delay of a signal from the master to a slave.
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
    /// Value of the progress: the measurement runs.
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

/// Returns the builder of the master of the mission: the only one, or [`one_of_two`](MasterBuilder::one_of_two).
pub fn master(profile: &Profile) -> MasterBuilder<'_, CommanderObjects> {
    Master::builder(profile, CommanderObjects::default())
}

/// Content of a receive PDO of the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// Telemetry.
    Telemetry(Message),
    /// Local time of the sender at the last SYNC.
    LocalTime(Scet),
}

/// Returns sender and content of a receive PDO of the master. `None` if it is malformed.
pub fn received(pdo: &ReceivedPdo) -> Option<(NodeId, Received)> {
    if let Some((node, _)) = pdo.from(LOCAL_TIME_PDO) {
        return Some((node, Received::LocalTime(Scet::decode(pdo.data.get(..7)?)?)));
    }
    let (node, _) = pdo.from(<MissionObjects>::TELEMETRY_PDO)?;
    Some((node, Received::Telemetry(Message::from_payload(&pdo.data)?)))
}
