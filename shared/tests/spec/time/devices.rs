//! Slaves that consume the time: one that keeps 8 bits of fine time, one that keeps UTC, and one that produces it.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, DeviceTime, Slave, SpacecraftDevice};
use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, Rpdo, Tpdo};
use ecss_can::profile::Profile;
use ecss_can::time::{LocalScet, LocalUtc, ScetGet, ScetSet, UtcGet, UtcSet};
use ecss_can::types::{Scet, Utc, UtcRelation};

use crate::bench::{Bench, NOMINAL, node};
use crate::instrument::STANDARD;

/// 181h: the spacecraft time at the last SYNC.
const SCET: Rpdo = Pdo::<()>::new(CobIdOf::fixed(0x181))
    .map(LocalScet::SCET_SET.field(ScetSet::FINE))
    .map(LocalScet::SCET_SET.field(ScetSet::COARSE))
    .receive(1)
    .transmission(1);
/// 180h + node, with every SYNC.
const LOCAL_SCET: Tpdo = Pdo::<()>::new(CobIdOf::node(0x180))
    .map(LocalScet::SCET_GET.field(ScetGet::FINE))
    .map(LocalScet::SCET_GET.field(ScetGet::COARSE))
    .transmit(1)
    .transmission(1);

/// Keeps the SCET with all 24 bits of fine time.
#[derive(Debug, Objects)]
#[objects(device)]
pub struct Keeper {
    /// Value
    #[object(0x6000, rw)]
    pub value: u8,
}

impl Device for Keeper {
    type Pdos = PdoObjects<2, 2>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(&[SCET], &[LOCAL_SCET]);
}

/// Keeps 8 bits of fine time.
#[derive(Debug, Objects)]
#[objects(device, time)]
pub struct Coarse {
    /// Value
    #[object(0x6000, rw)]
    pub value: u8,
}

impl Device for Coarse {
    type Pdos = PdoObjects<2, 2>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(&[SCET], &[LOCAL_SCET]);
}

impl DeviceTime for Coarse {
    const FINE_BITS: u32 = 8;
}

/// Produces the spacecraft time, of SYNCs that another node produces.
#[derive(Debug, Objects)]
#[objects(device)]
pub struct Producer {
    /// Value
    #[object(0x6000, rw)]
    pub value: u8,
}

impl Device for Producer {
    type Pdos = PdoObjects<2, 2>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(
        &[],
        &[Pdo::<()>::new(CobIdOf::fixed(0x181))
            .map(LocalScet::SCET_GET.field(ScetGet::FINE))
            .map(LocalScet::SCET_GET.field(ScetGet::COARSE))
            .transmit(1)
            .transmission(2)],
    );
}

/// Keeps UTC: SCET 0 was day 100, 0:00. `MICROS`: with submilliseconds.
#[derive(Debug, Objects)]
#[objects(device, time)]
pub struct Universal<const MICROS: bool> {
    /// Time
    #[objects]
    pub utc: LocalUtc,
}

impl<const MICROS: bool> Device for Universal<MICROS> {
    type Pdos = PdoObjects<2, 2>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(
        &[Pdo::<()>::new(CobIdOf::fixed(0x181))
            .map(LocalUtc::UTC_SET.field(UtcSet::SUBMILLISECONDS))
            .map(LocalUtc::UTC_SET.field(UtcSet::MS))
            .map(LocalUtc::UTC_SET.field(UtcSet::DAY))
            .receive(1)
            .transmission(1)],
        &[Pdo::<()>::new(CobIdOf::node(0x180))
            .map(LocalUtc::UTC_GET.field(UtcGet::SUBMILLISECONDS))
            .map(LocalUtc::UTC_GET.field(UtcGet::MS))
            .map(LocalUtc::UTC_GET.field(UtcGet::DAY))
            .transmit(1)
            .transmission(1)],
    );
}

impl<const MICROS: bool> DeviceTime for Universal<MICROS> {
    const UTC: Option<UtcRelation> =
        Some(UtcRelation { scet: Scet::new(0, 0).unwrap(), utc: Utc::new(100, 0, 0).unwrap() });
    const SUBMILLISECONDS: bool = MICROS;

    fn utc(&mut self) -> Option<&mut LocalUtc> {
        Some(&mut self.utc)
    }
}

pub type Node<D> = Bench<Slave<D>>;

/// Node 5 with this device, operational, its master on the nominal bus.
pub fn operational<D: SpacecraftDevice>() -> Node<D> {
    let profile = Profile { autostart: true, ..STANDARD };
    let mut slave = Bench::new(Slave::builder(node(5), &profile, D::default()).build());
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.clear();
    slave
}
