//! One mistake in a declaration is one error, whatever else uses the declaration.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, Slave};
use ecss_can::od::{Field, Objects, Record};
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, Rpdo, Tpdo};
use ecss_can::types::{AbortCode, Address};

#[derive(Objects)]
#[objects(check = Heater::may_write, device)]
struct Heater {
    /// Power
    #[object(0x6000, ro, pod)]
    power: u8,
    /// Setpoint
    #[object(0x6001, rww, pdo)]
    setpoint: i16,
    /// Channels
    #[object(0x6002.., record)]
    channels: [Channel; 2],
    #[objects]
    group: Group,
}

impl Heater {
    fn may_write(&self, at: Address, _: &[u8]) -> Result<(), AbortCode> {
        if at == Heater::SETPOINT.address() { Err(AbortCode::ValueRange) } else { Ok(()) }
    }
}

#[derive(Record)]
struct Channel {
    /// Gain
    #[sub(1, rw, pdo, lo = 1)]
    gain: u8,
    /// Offsets
    #[sub(2.., rw, pdo)]
    offsets: [u8; 2],
}

#[derive(Objects)]
struct Group {
    /// Levels
    #[object(0x6100, array, pdo)]
    levels: [u8; 3],
    /// Flag
    #[object(0x6101, rw, pdo)]
    flag: bool,
}

const SENT: Tpdo = Pdo::<()>::new(CobIdOf::node(0x180))
    .map(Heater::POWER)
    .map(Heater::CHANNELS.nth(1).field(Channel::GAIN))
    .map(Heater::CHANNELS.nth(1).field(Channel::OFFSETS.nth(1)))
    .map(Group::LEVELS.sub(2))
    .transmit(1);
const RECEIVED: Rpdo = Pdo::<()>::new(CobIdOf::node(0x200)).map(Heater::SETPOINT).map(Group::FLAG).receive(1);

impl Device for Heater {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(&[RECEIVED], &[SENT]);
}

#[derive(Objects)]
#[objects(devise)]
struct Valve {
    /// Opening
    #[object(0x6000, rw)]
    opening: u8,
}

impl Device for Valve {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(&[], &[]);
}

/// Attributes with wrong names or in a wrong form.
#[derive(Objects)]
struct Names {
    /// Speed
    #[objct(0x6000, rw)]
    speed: u8,
    /// No comma
    #[object(0x6001 rw)]
    comma: u8,
    /// No index
    #[object(rw, pdo)]
    index: u8,
    /// No parentheses
    #[object]
    bare: u8,
    #[objekts]
    valve: Valve,
    #[skipp]
    hidden: u8,
    /// Several
    #[object(0x6010.., rw)]
    several: u8,
}

#[derive(Record)]
struct Entries {
    /// Gain
    #[sbu(1, rw)]
    gain: u8,
}

const ALL: [Field<u8>; 4] = [Names::SPEED, Names::COMMA, Names::INDEX, Names::BARE];
const SEVERAL: Address = Names::SEVERAL.nth(1).sub(0).address();

fn sum(heater: Slave<Heater>, names: Names) -> u8 {
    heater.objects().application.power + names.speed + names.valve.opening
}

fn main() {}
