//! Mappings of senders and receivers: a world detects those that do not match.

use ecss_can::node::Device;
use ecss_can::od::Field;
use ecss_can::prelude::*;
use ecss_can_worlds::{Time, World, idle, plain_master};
use mission::STANDARD;

use crate::support::running;

const FIVE: NodeId = NodeId::of::<5>();
const SIX: NodeId = NodeId::of::<6>();

#[derive(Debug, Objects)]
#[objects(device)]
struct Heater {
    /// Power
    #[object(0x6000, ro, pdo)]
    power: u8,
    /// State
    #[object(0x6001, ro, pdo)]
    state: u8,
    /// Temperature
    #[object(0x6002, ro, pdo)]
    temperature: i16,
}

impl Device for Heater {
    type Pdos = PdoObjects<1, 2>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(
        &[],
        &[Pdo::<()>::new(CobIdOf::node(0x280))
            .map(Heater::POWER)
            .map(Heater::STATE)
            .map(Heater::TEMPERATURE)
            .transmit(2)],
    );
}

/// A slave that receives 285h with a mapping that depends on `WAY`: 0 as it is sent, 1 with two values swapped, 2 with
/// an additional value, 3 with another COB-ID.
#[derive(Debug, Objects)]
#[objects(device)]
struct Display<const WAY: usize = 0> {
    /// Power
    #[object(0x6100, rww, pdo)]
    power: u8,
    /// State
    #[object(0x6101, rww, pdo)]
    state: u8,
    /// Temperature
    #[object(0x6102, rww, pdo)]
    temperature: i16,
    /// Voltage
    #[object(0x6103, rww, pdo)]
    voltage: u16,
}

const ID: CobIdOf = CobIdOf::fixed(0x285);
const POWER: Field<u8> = Display::<0>::POWER;
const STATE: Field<u8> = Display::<0>::STATE;
const TEMPERATURE: Field<i16> = Display::<0>::TEMPERATURE;
const WAYS: [PdoSet; 4] = [
    PdoSet::new(&[Pdo::<()>::new(ID).map(POWER).map(STATE).map(TEMPERATURE).receive(1)], &[]),
    PdoSet::new(&[Pdo::<()>::new(ID).map(STATE).map(POWER).map(TEMPERATURE).receive(1)], &[]),
    PdoSet::new(
        &[Pdo::<()>::new(ID).map(POWER).map(STATE).map(TEMPERATURE).map(Display::<0>::VOLTAGE).receive(1)],
        &[],
    ),
    PdoSet::new(&[Pdo::<()>::new(CobIdOf::fixed(0x286)).map(POWER).receive(1)], &[]),
];

impl<const WAY: usize> Device for Display<WAY> {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = WAYS[WAY];
}

/// A heater, and a display that receives its power.
fn world<const WAY: usize>() -> World {
    let mut world = World::builder()
        .master(|_| plain_master(&Profile::DEFAULT), idle)
        .slave(
            FIVE,
            |board| Slave::builder(board.node_id, &Profile::DEFAULT, Heater::default()).build(),
            idle,
        )
        .slave(
            SIX,
            |board| Slave::builder(board.node_id, &Profile::DEFAULT, Display::<WAY>::default()).build(),
            idle,
        )
        .build();
    world.run_for(Time::from_ms(10));
    world
}

#[test]
fn mapping_of_another_order_or_length_is_found() {
    assert_eq!(world::<0>().pdo_mismatches(), [""; 0]);
    let swapped = "node 6: RPDO 1 (285h) has State at place 1, TPDO 2 of node 5 has Power there";
    assert_eq!(world::<1>().pdo_mismatches(), [swapped]);
    let longer = "node 6: RPDO 1 (285h) has 6 bytes, TPDO 2 of node 5 has 4: the receiver rejects it";
    assert_eq!(world::<2>().pdo_mismatches(), [longer]);
}

#[test]
fn cob_id_that_no_node_sends_is_found() {
    assert_eq!(world::<0>().unsent_pdos(), [""; 0]);
    assert_eq!(world::<3>().pdo_mismatches(), [""; 0]);
    assert_eq!(world::<3>().unsent_pdos(), ["node 6: RPDO 1 (286h) is sent by no node"]);
}

/// Given the shipped mission, then its mappings match. PDOs without a sender are those of missing slaves, and those
/// that the application of the master sends: telecommands and requests.
#[test]
fn mappings_of_the_shipped_mission_fit() {
    let world = running(STANDARD, 3);
    assert_eq!(world.pdo_mismatches(), [""; 0]);
    let unsent = world.unsent_pdos();
    let (of_master, of_slaves): (Vec<_>, Vec<_>) =
        unsent.iter().partition(|unsent| unsent.starts_with("master: "));
    assert_eq!(of_master.len(), 2 * (14 - 3));
    let is_sent = |unsent: &&String| unsent.contains("RPDO 2 (30") || unsent.contains("RPDO 3 (40");
    assert_eq!(of_slaves.iter().filter(|unsent| is_sent(unsent)).count(), of_slaves.len());
}
