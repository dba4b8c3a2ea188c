//! The application of the image on a mock board, and the protocol on two simulated buses, in virtual time.

use ecss_can::prelude::*;
use ecss_can_worlds::{
    Handle, MockBoard, NEXT_TO_MASTER_M, Plain, Time, World, idle, plain_master,
};

use {{crate}}::{Heater, PROFILE, application};

const NODE: NodeId = NodeId::of::<{{node}}>();
/// COB-ID of the PDO with the power.
const CHANGE: u16 = 0x280 + {{node}};

fn slave(board: MockBoard) -> Slave<Heater> {
    Slave::builder(board.node_id, &PROFILE, Heater::default())
        .hardware(board.hardware)
        .build()
}

/// Given a heater on both buses, when the nominal bus is cut and a setpoint is written, then its power is sent on the other bus.
#[test]
fn setpoint_arrives_on_the_other_bus_when_one_is_cut() {
    let mut world = World::builder()
        .master(|_| plain_master(&PROFILE), idle)
        .slave(NODE, slave, |heater, events| {
            let reset = events.reset_line();
            application(heater, events, move || reset.reset())
        })
        .drift(NODE, 80) // ppm
        .build();
    world.run_for(Time::from_ms(1_000));
    assert!(world.all_operational());

    world.cut(Bus::Nominal, NEXT_TO_MASTER_M);
    world.run_for(Time::from_ms(1_000));
    assert!(world.all_operational());
    let master: Handle<Master<Plain>> = world.master();
    let work = async move { master.sdo(NODE).write(Heater::SETPOINT, 400).await };
    let written = world.spawn(NodeId::MASTER, work);
    world.run_for(Time::from_ms(10));
    assert_eq!(written.take().map(|(_, result)| result), Some(Ok(())));
    let mut pdos = world
        .frames(Bus::Redundant)
        .iter()
        .filter(|sent| sent.id() == Some(CHANGE));
    assert_eq!(pdos.next_back().unwrap().frame.payload(), [100]);
}
