//! The thermometer of `firmware/examples` with its master: a device that is none of the demonstration mission's.

use std::cell::Cell;
use std::rc::Rc;

use ecss_can::prelude::*;
use host_worlds::can_wire::fault::Fault;
use host_worlds::{Events, Handle, MockBoard, NEXT_TO_MASTER_M, Time, World, idle};
use thermometer::{CHANGE, PROFILE, Thermometer};
use thermometer_master::{Ground, THERMOMETER, is_kept, write_table};

type Node = Slave<Thermometer<Vec<u8>>>;

const PERIOD: Duration = Duration::from_millis(100);
/// The sensor's register at 25 °C and at 85.125 °C.
const AT_25_DEGREES: i16 = 0x1900;
const ABOVE_85_DEGREES: i16 = 0x5520;

/// What the sensor answers, which the test sets.
type Sensor = Rc<Cell<Option<i16>>>;

fn slave(board: MockBoard) -> Node {
    thermometer::slave(board.node_id, vec![0; 2048]).with_retained(board.retained).with_store(board.store)
}

/// As the image has it: measures ten times a second.
async fn application(slave: Handle<Node>, mut events: Events<Node>, sensor: Sensor) {
    let measure = async {
        let mut due = Instant::ZERO;
        loop {
            slave.change(|thermometer| thermometer.measured(sensor.get()));
            due += PERIOD;
            slave.wait_until(due).await;
        }
    };
    let listen = async {
        loop {
            match events.next().await {
                SlaveEvent::State(NmtState::Operational) => {
                    slave.with(|slave, now| slave.send_pdo(CHANGE.slot(), now));
                }
                SlaveEvent::ResetNode => events.reset(),
                _ => {}
            }
        }
    };
    let _: ((), ()) = futures_util::future::join(measure, listen).await;
}

/// A running world, the thermometer's clock 90 ppm fast; and its sensor.
fn running() -> (World, Sensor) {
    let sensor = Sensor::new(Cell::new(Some(AT_25_DEGREES)));
    let given = sensor.clone();
    let mut world = World::builder()
        .master(|board| Master::new(&PROFILE, Ground::default(), board.store), idle)
        .slave(THERMOMETER, slave, move |slave, events| application(slave, events, given.clone()))
        .drift(THERMOMETER, 90)
        .drift(NodeId::MASTER, -90)
        .build();
    world.run_until(Time::from_ms(1_000));
    assert!(world.all_operational());
    (world, sensor)
}

/// What the master knows by PDO: temperature and alarm.
fn known(world: &World) -> (i16, u8) {
    world.master().with(|master: &mut Master<Ground>, _| {
        let ground = &master.objects().application.device;
        (ground.temperature, ground.alarm)
    })
}

/// When the active bus is cut the measurement goes on over the other one.
#[test]
fn a_change_reaches_the_master_before_and_after_a_cut() {
    let (mut world, sensor) = running();
    assert_eq!(known(&world), (250, Thermometer::<Vec<u8>>::WITHIN));
    world.cut(Bus::Nominal, NEXT_TO_MASTER_M);
    world.run_for(Time::from_ms(1_000));
    assert!(world.all_operational());
    assert_eq!(world.master_bus(), Bus::Redundant);
    sensor.set(Some(ABOVE_85_DEGREES));
    world.run_for(Time::from_ms(201));
    assert_eq!(known(&world), (851, Thermometer::<Vec<u8>>::ABOVE));
}

/// The master hears by PDO that there is no temperature.
#[test]
fn a_silent_sensor_reaches_the_master_as_such() {
    let (mut world, sensor) = running();
    sensor.set(None);
    world.run_for(Time::from_ms(201));
    assert_eq!(known(&world), (i16::MIN, Thermometer::<Vec<u8>>::NO_SENSOR));
    sensor.set(Some(AT_25_DEGREES));
    world.run_for(Time::from_ms(201));
    assert_eq!(known(&world), (250, Thermometer::<Vec<u8>>::WITHIN));
}

/// The master writes the table over noisy wires and saves it.
#[test]
fn the_table_survives_noise_and_a_loss_of_power() {
    let (mut world, _) = running();
    Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::BitErrors { rate: 1e-5, seed: 3 }));
    let sdo = world.master().sdo();
    let written = world.spawn(NodeId::MASTER, async move { write_table(sdo).await });
    world.run_for(Time::from_ms(500));
    assert_eq!(written.take().map(|(_, result)| result), Some(Ok(())));
    Bus::ALL.into_iter().for_each(|bus| world.heal(bus));

    world.power_off(THERMOMETER);
    world.run_for(Time::from_ms(1_000));
    world.power_on(THERMOMETER);
    world.run_for(Time::from_ms(1_000));
    assert!(world.all_operational());
    let sdo = world.master().sdo();
    let kept = world.spawn(NodeId::MASTER, async move { is_kept(sdo).await });
    world.run_for(Time::from_ms(200));
    assert_eq!(kept.take().map(|(_, result)| result), Some(Ok(true)));
    // Entry 612 of the table adds nine tenths.
    assert_eq!(known(&world).0, 259);
}

#[test]
#[should_panic(expected = "is no ")]
fn a_slave_of_another_device_is_a_mistake_of_the_test() {
    let (world, _) = running();
    world.slave::<Thermometer<[u8; 4]>>(THERMOMETER);
}
