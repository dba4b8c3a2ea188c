//! PDOs that an application uses in a wrong way: each is one error, at its place.

use ecss_can::prelude::*;

/// A heater.
#[derive(Objects)]
#[objects(device)]
struct Heater {
    /// Setpoint
    #[object(0x6000, rww, pdo)]
    setpoint: i16,
    /// Power
    #[object(0x6001, ro, pdo)]
    power: u8,
    /// Mode
    #[object(0x6002, rw)]
    mode: u8,
}

/// A cooler.
#[derive(Objects)]
#[objects(device)]
struct Cooler {
    /// Speed
    #[object(0x6000, ro, pdo)]
    speed: u16,
}

const COMMAND: Pdo<Heater, (i16,)> = Pdo::new(CobIdOf::node(0x200)).map(Heater::SETPOINT);
const CHANGE: Pdo<Heater, (u8,)> = Pdo::new(CobIdOf::node(0x280)).map(Heater::POWER);
const SPEED: Pdo<Cooler, (u16,)> = Pdo::new(CobIdOf::node(0x280)).map(Cooler::SPEED);

const OTHER_TYPE: Pdo<Heater, (i16,)> = Pdo::new(CobIdOf::node(0x380)).map(Heater::POWER);
const TWO_VALUES: Pdo<Heater, (u8,)> = Pdo::new(CobIdOf::node(0x380)).map(Heater::POWER).map(Heater::POWER);
const NO_PDO: Pdo<Heater, (u8,)> = Pdo::new(CobIdOf::node(0x380)).map(Heater::MODE);

impl Device for Heater {
    type Pdos = PdoObjects<4, 4>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(&[COMMAND.receive(1)], &[CHANGE.transmit(1)]);
}

impl Device for Cooler {
    type Pdos = PdoObjects<4, 4>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(&[], &[SPEED.transmit(1)]);
}

fn pdo_of_another_device(heater: Handle<impl Platform, Slave<Heater>>) {
    heater.send(SPEED);
}

fn number_instead_of_a_name(heater: Handle<impl Platform, Slave<Heater>>) {
    heater.send(1);
}

fn event_of_the_other_role(event: SlaveEvent) -> bool {
    matches!(event, MasterEvent::Pdo(_))
}

fn values_of_another_type(master: Handle<impl Platform, Master<Cooler>>, node: NodeId) {
    let _ = master.send_to(node, COMMAND, (40.0,));
}

fn too_few_values(master: Handle<impl Platform, Master<Cooler>>, node: NodeId) {
    let _ = master.send_to(node, COMMAND, ());
}

fn method_of_the_other_role(heater: Handle<impl Platform, Slave<Heater>>, node: NodeId) {
    heater.reset(node);
}

fn read_as_another_type(pdo: ReceivedPdo, node: NodeId) -> Option<(i8,)> {
    pdo.get(CHANGE.of(node))
}

fn main() {}
