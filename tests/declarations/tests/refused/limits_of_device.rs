//! Limits that exclude each other are one error, whatever else uses the objects.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, Slave};
use ecss_can::od::{Objects, Record};
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};
use ecss_can::profile::Profile;
use ecss_can::types::NodeId;

#[derive(Objects)]
#[objects(device)]
struct Heater {
    /// Setpoint
    #[object(0x6000, rww, pdo, low = 850, high = -400)]
    setpoint: i16,
    /// Power
    #[object(0x6001, ro, pdo, low = 1, high = 100, default = 0)]
    power: u8,
    /// Channels
    #[object(0x6002.., record)]
    channels: [Channel; 2],
}

#[derive(Record)]
struct Channel {
    /// Gain
    #[sub(1, rww, pdo, low = 2, high = 1)]
    gain: u8,
}

impl Device for Heater {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(
        &[Pdo::<()>::new(CobIdOf::node(0x200)).map(Heater::SETPOINT).receive(1)],
        &[Pdo::<()>::new(CobIdOf::node(0x180)).map(Heater::POWER).transmit(1)],
    );
}

fn main() {
    let heater: Slave<Heater> = Slave::builder(NodeId::of::<5>(), &Profile::DEFAULT, Heater::default()).build();
    assert_eq!(heater.objects().application.power, 0);
}
