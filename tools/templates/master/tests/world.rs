//! Both applications as they run in the images, on two simulated buses, in virtual time.

use std::cell::RefCell;
use std::rc::Rc;

use ecss_can::prelude::*;
use ecss_can_worlds::{MockBoard, NEXT_TO_MASTER_M, Time, World};

use {{crate}}::{Ground, HEATER, Report, SCHEDULE, SETPOINT, START};

use {{slave_crate}}::{Heater, PROFILE};

/// COB-ID of the heartbeat of the heater.
const BOOT_UP: u16 = 0x700 + {{node}};

/// What the master has reported since the test last took it.
type Reports = Rc<RefCell<Vec<Report>>>;

fn master(board: MockBoard) -> Master<Ground> {
    Master::builder(&PROFILE, Ground::default())
        .hardware(board.hardware)
        .build()
}

fn slave(board: MockBoard) -> Slave<Heater> {
    Slave::builder(board.node_id, &PROFILE, Heater::default())
        .hardware(board.hardware)
        .build()
}

/// Both nodes, 3 s after power-on.
fn running() -> (World, Reports) {
    let reports = Reports::default();
    let written = reports.clone();
    let mut world = World::builder()
        .master(master, move |master, events| {
            let written = written.clone();
            {{crate}}::application(master, events, move |report| {
                written.borrow_mut().push(report)
            })
        })
        .slave(HEATER, slave, |slave, events| {
            let reset = events.reset_line();
            {{slave_crate}}::application(slave, events, move || reset.reset())
        })
        .build();
    world.run_for(Time::from_ms(3_000));
    assert!(world.all_operational());
    (world, reports)
}

/// Setpoint and schedule of the heater.
fn settings(world: &World) -> (i16, Vec<u8>) {
    world
        .slave::<Heater>(HEATER)
        .read(|heater| (heater.setpoint, heater.schedule.as_bytes().to_vec()))
}

#[test]
fn the_heater_is_prepared_and_both_buses_are_tried() {
    let (world, reports) = running();
    let expected = [
        Report::Power(100),
        Report::Prepared {
            power: 100,
            is_same: true,
        },
        Report::ActiveBus(Bus::Redundant),
        Report::BothBuses,
        Report::ActiveBus(Bus::Nominal),
    ];
    assert_eq!(reports.take(), expected);
    assert_eq!(settings(&world), (SETPOINT, SCHEDULE.to_vec()));
    // The clock of the heater follows that of the master, within 1 ms.
    let time = world.status(HEATER).scet.micros_since(START);
    assert!(time.abs_diff(3_000_000) < 1_000, "{time} µs");
}

#[test]
fn the_power_arrives_on_the_other_bus_when_one_is_cut() {
    let (mut world, reports) = running();
    reports.take();
    world.cut(Bus::Nominal, NEXT_TO_MASTER_M);
    world.run_for(Time::from_ms(1_000));
    world.write(HEATER, Heater::SETPOINT.address(), &200_i16.to_le_bytes());
    world.run_for(Time::from_ms(10));
    assert_eq!(
        reports.take(),
        [Report::ActiveBus(Bus::Redundant), Report::Power(0)]
    );
}

#[test]
fn a_heater_that_is_too_hot_is_reset_and_keeps_its_settings() {
    const TOO_HOT: DeviceError = DeviceError::new(ErrorCode::TEMPERATURE, 1);
    let (mut world, reports) = running();
    reports.take();
    world.slave::<Heater>(HEATER).raise(TOO_HOT, [0; 4]);
    world.run_for(Time::from_ms(1_000));
    assert_eq!(reports.take(), [Report::Emergency(ErrorCode::TEMPERATURE)]);
    let frames = world.frames(Bus::Nominal).iter();
    let boot_ups = frames.filter(|sent| sent.id() == Some(BOOT_UP) && sent.frame.payload() == [0]);
    assert_eq!(boot_ups.count(), 2);
    assert!(world.all_operational());
    assert_eq!(settings(&world), (SETPOINT, SCHEDULE.to_vec()));
}
