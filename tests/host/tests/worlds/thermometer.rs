//! The thermometer of `firmware/examples` with its master. The device is not part of the demonstration mission.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use ecss_can::od::{Field, NotWritable, Readable};
use ecss_can::prelude::*;
use ecss_can::sdo::Error;
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::wire::fault::Fault;
use ecss_can_worlds::{Builder, MockBoard, NEXT_TO_MASTER_M, ResetLine, Time, World, idle};
use thermometer::{Alarm, Change, Hardware, Mode, PROFILE, Thermometer};
use thermometer_master::{Ground, Report, THERMOMETER, is_kept, write_table};

eds! {
    /// The thermometer as a maker of another master knows it. `ecss-can eds --package thermometer` wrote the file.
    struct Described = "tests/worlds/thermometer.eds";
}

type Node = Slave<Thermometer<Vec<u8>>>;

/// The sensor's register at 25 °C and at 85.125 °C.
const AT_25_DEGREES: i16 = 0x1900;
const ABOVE_85_DEGREES: i16 = 0x5520;

/// The board of the thermometer, controlled by the test.
#[derive(Clone, Default)]
struct Sensor {
    /// Register value that the sensor returns.
    register: Rc<Cell<Option<i16>>>,
    /// Highest temperature after each command.
    commanded: Rc<RefCell<Vec<i16>>>,
    /// Number of resets of the chip.
    resets: Rc<Cell<u32>>,
}

/// A sensor on a board that can be reset.
struct Fitted(Sensor, ResetLine);

impl Hardware for Fitted {
    async fn temperature(&mut self) -> Option<i16> {
        self.0.register.get()
    }

    fn log_command(&mut self, highest: i16) {
        self.0.commanded.borrow_mut().push(highest);
    }

    fn reset(&mut self) {
        self.0.resets.set(self.0.resets.get() + 1);
        self.1.reset();
    }
}

fn slave(board: MockBoard) -> Node {
    thermometer::slave(board.node_id, vec![0; 2048]).hardware(board.hardware).build()
}

/// A world with the application of the thermometer, the thermometer's clock 90 ppm fast; and its sensor.
fn with_thermometer(world: Builder) -> (World, Sensor) {
    let sensor = Sensor::default();
    sensor.register.set(Some(AT_25_DEGREES));
    let given = sensor.clone();
    let world = world
        .slave(THERMOMETER, slave, move |slave, events| {
            let hardware = Fitted(given.clone(), events.reset_line());
            thermometer::application(slave, events, hardware)
        })
        .drift(THERMOMETER, 90)
        .drift(NodeId::MASTER, -90)
        .build();
    (world, sensor)
}

fn master(board: MockBoard) -> Master<Ground> {
    Master::builder(&PROFILE, Ground::default()).hardware(board.hardware).build()
}

/// A running world with a master that has no application.
fn running() -> (World, Sensor) {
    let (mut world, sensor) = with_thermometer(World::builder().master(master, idle));
    world.run_until(Time::from_ms(1_000));
    assert!(world.all_operational());
    (world, sensor)
}

/// Returns the last values that the master received by PDO.
fn known(world: &World) -> Change {
    let change = |event: &NodeEvent| match event {
        NodeEvent::Master(MasterEvent::Pdo(pdo)) => pdo.get(<Thermometer>::CHANGE.of(THERMOMETER)),
        _ => None,
    };
    world.log_of(NodeId::MASTER).iter().rev().find_map(|(_, event)| change(event)).expect("a change")
}

/// Given an active bus that is cut, then measurements continue over the other one.
///
/// Verifies: ECSS 6.2a, 8.3.3b
#[test]
fn a_change_reaches_the_master_before_and_after_a_cut() {
    let (mut world, sensor) = running();
    assert_eq!(known(&world), Change { temperature: 250, alarm: Alarm::Within });
    world.cut(Bus::Nominal, NEXT_TO_MASTER_M);
    world.run_for(Time::from_ms(1_000));
    assert!(world.all_operational());
    assert_eq!(world.master_bus(), Bus::Redundant);
    sensor.register.set(Some(ABOVE_85_DEGREES));
    world.run_for(Time::from_ms(201));
    assert_eq!(known(&world), Change { temperature: 851, alarm: Alarm::Above });
}

/// Given a sensor that does not answer, then the master learns by PDO that there is no temperature.
///
/// Verifies: ECSS 6.2a
#[test]
fn a_silent_sensor_reaches_the_master_as_such() {
    let (mut world, sensor) = running();
    sensor.register.set(None);
    world.run_for(Time::from_ms(201));
    assert_eq!(known(&world), Change { temperature: i16::MIN, alarm: Alarm::NoSensor });
    sensor.register.set(Some(AT_25_DEGREES));
    world.run_for(Time::from_ms(201));
    assert_eq!(known(&world), Change { temperature: 250, alarm: Alarm::Within });
}

/// Given noisy wires, when the master writes the table and saves it, then the table survives a loss of power.
///
/// Verifies: ECSS 6.1a
#[test]
fn the_table_survives_noise_and_a_loss_of_power() {
    let (mut world, _) = running();
    Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::BitErrors { rate: 1e-5, seed: 3 }));
    let sdo = world.master::<Ground>().sdo(THERMOMETER);
    let written = world.spawn(NodeId::MASTER, async move { write_table(sdo).await });
    world.run_for(Time::from_ms(500));
    assert_eq!(written.take().map(|(_, result)| result), Some(Ok(())));
    Bus::ALL.into_iter().for_each(|bus| world.heal(bus));

    world.power_off(THERMOMETER);
    world.run_for(Time::from_ms(1_000));
    world.power_on(THERMOMETER);
    world.run_for(Time::from_ms(1_000));
    assert!(world.all_operational());
    let sdo = world.master::<Ground>().sdo(THERMOMETER);
    let kept = world.spawn(NodeId::MASTER, async move { is_kept(sdo).await });
    world.run_for(Time::from_ms(200));
    assert_eq!(kept.take().map(|(_, result)| result), Some(Ok(true)));
    // Entry 612 of the table adds nine tenths.
    assert_eq!(known(&world).temperature, 259);
}

/// Returns the error codes of emergencies of the thermometer on the nominal bus.
fn emergencies(world: &World) -> Vec<u16> {
    let frames = world.frames(Bus::Nominal).iter().filter(|sent| sent.id() == Some(0x083));
    frames.map(|sent| u16::from_le_bytes([sent.frame.payload()[0], sent.frame.payload()[1]])).collect()
}

/// Given a sensor that does not answer for a second, then the thermometer raises EMCY 5000h (hardware) once, and clears it once.
///
/// Verifies: ECSS 6.4a, 6.4a.2
#[test]
fn a_silent_sensor_is_one_emergency() {
    let (mut world, sensor) = running();
    assert_eq!(emergencies(&world), [0; 0]);
    sensor.register.set(None);
    world.run_for(Time::from_ms(1_000));
    assert_eq!(emergencies(&world), [0x5000]);
    sensor.register.set(Some(AT_25_DEGREES));
    world.run_for(Time::from_ms(1_000));
    assert_eq!(emergencies(&world), [0x5000, 0x0000]);
}

/// Given a running thermometer, then it measures ten times a second: SYNC answers (483h) show a ramp of 1 °C each 100 ms.
///
/// Verifies: ECSS 6.2a
#[test]
fn the_thermometer_measures_ten_times_a_second() {
    let (mut world, sensor) = running();
    let changes = |world: &World| {
        let frames = world.frames(Bus::Nominal).iter().filter(|sent| sent.id() == Some(0x283));
        frames.map(|sent| i16::from_le_bytes([sent.frame.payload()[0], sent.frame.payload()[1]])).collect()
    };
    let before: Vec<i16> = changes(&world);
    for step in 1..=10 {
        sensor.register.set(Some(AT_25_DEGREES + step * 0x100));
        world.run_for(Time::from_ms(100));
    }
    world.run_for(Time::from_ms(100));
    let expected: Vec<i16> = (26..=35).map(|degrees| degrees * 10).collect();
    assert_eq!(changes(&world)[before.len()..], expected);
}

/// Given the applications of both images, when the thermometer is operational for the first time, then the master writes the table,
/// saves it, resets the thermometer once, finds the table again, and commands it to forget the highest temperature. Later it reports
/// the changes that the thermometer sends, and a change of the bus.
///
/// Verifies: ECSS 6.1a, 6.5.1a.4
#[test]
fn the_master_calibrates_the_thermometer_once() {
    let reports = Rc::new(RefCell::new(Vec::new()));
    let kept = reports.clone();
    let (mut world, sensor) = with_thermometer(World::builder().master(master, move |master, events| {
        let kept = kept.clone();
        thermometer_master::application(master, events, move |report| kept.borrow_mut().push(report))
    }));
    world.run_until(Time::from_ms(3_000));
    assert!(world.all_operational());
    let calibration: Vec<Report> =
        reports.take().into_iter().filter(|report| !matches!(report, Report::Measured { .. })).collect();
    assert_eq!(calibration, [Report::TableSaved, Report::TableKept]);
    assert_eq!((sensor.resets.get(), known(&world).temperature), (1, 259));
    assert_eq!(*sensor.commanded.borrow(), [259]);

    sensor.register.set(Some(ABOVE_85_DEGREES));
    world.run_for(Time::from_ms(201));
    // Entry 852 of the table adds thirteen tenths.
    assert_eq!(reports.take(), [Report::Measured { temperature: 864, alarm: Alarm::Above }]);
    world.cut(Bus::Nominal, NEXT_TO_MASTER_M);
    world.run_for(Time::from_ms(1_000));
    assert!(reports.borrow().contains(&Report::ActiveBus(Bus::Redundant)), "{reports:?}");
    assert_eq!(sensor.resets.get(), 1);
}

/// Given a thermometer that loses its power while the master writes the table, then the master reports the transfer that failed.
///
/// Verifies: ECSS 6.1a
#[test]
fn a_table_that_is_not_written_is_reported() {
    let reports = Rc::new(RefCell::new(Vec::new()));
    let kept = reports.clone();
    let (mut world, _) = with_thermometer(World::builder().master(master, move |master, events| {
        let kept = kept.clone();
        thermometer_master::application(master, events, move |report| kept.borrow_mut().push(report))
    }));
    let block = |world: &World| {
        world
            .frames(Bus::Nominal)
            .iter()
            .any(|sent| sent.id() == Some(0x603) && sent.frame.payload()[0] == 0xC6)
    };
    while !block(&world) {
        world.run_for(Time::from_ms(1));
    }
    world.power_off(THERMOMETER);
    world.run_for(Time::from_ms(5_000));
    let failed = |report: &Report| matches!(report, Report::TransferFailed(_));
    assert_eq!(reports.borrow().iter().filter(|report| failed(report)).count(), 1, "{reports:?}");
    assert!(!reports.borrow().contains(&Report::TableSaved));
}

/// Given a master with nothing but the data sheet of the thermometer, then it reads and writes its objects by SDO, commands it by its
/// receive PDO, and takes the values of its transmit PDO.
///
/// Verifies: ECSS 6.1a, 6.2a
#[test]
fn the_master_knows_the_thermometer_by_its_data_sheet() {
    let (mut world, sensor) = running();
    let sdo = world.master::<Ground>().sdo(THERMOMETER);
    let moved = world.spawn(NodeId::MASTER, async move {
        let before: i16 = sdo.read(Described::UPPER_LIMIT).await?;
        sdo.write(Described::UPPER_LIMIT, 240).await?;
        let (mut name, alarm) = ([0; 32], sdo.read(Described::ALARM).await?);
        let count = sdo.read_bytes(Described::MANUFACTURER_DEVICE_NAME, &mut name).await?;
        Ok::<_, Error>((before, alarm, name[..count].to_vec()))
    });
    world.run_for(Time::from_ms(500));
    let expected = Ok((850, Alarm::Within as u8, b"Thermometer".to_vec()));
    assert_eq!(moved.take().map(|(_, result)| result), Some(expected));

    // 25 °C are above the new limit.
    let last = world.log_of(NodeId::MASTER).iter().rev().find_map(|(_, event)| match event {
        NodeEvent::Master(MasterEvent::Pdo(pdo)) => pdo.get(Described::TPDO_2.of(THERMOMETER)),
        _ => None,
    });
    assert_eq!(last, Some((250, Alarm::Above as u8)));
    assert_eq!(world.master::<Ground>().send_to(THERMOMETER, Described::RPDO_1, (1,)), Ok(()));
    world.run_for(Time::from_ms(10));
    assert_eq!(*sensor.commanded.borrow(), [250]);
}

/// Given a master that reads and writes the enumerations of the thermometer, then it gets their variants. A mode without a name is
/// aborted with 06090030h, and a value that the enumeration of the master does not have is an error.
///
/// Verifies: ECSS 6.1a
#[test]
fn an_enumeration_has_no_other_values_over_sdo() {
    let (mut world, sensor) = running();
    sensor.register.set(None);
    world.run_for(Time::from_ms(201));
    let sdo = world.master::<Ground>().sdo(THERMOMETER);
    let moved = world.spawn(NodeId::MASTER, async move {
        let alarm: Alarm = sdo.read(Thermometer::ALARM).await?;
        sdo.write(Thermometer::MODE, Mode::Corrected).await?;
        let refused = sdo.write(Described::MODE, 2).await;
        let mode: Mode = sdo.read(Thermometer::MODE).await?;
        let alarm_as_mode = Field::<Mode, Readable, NotWritable>::at(Thermometer::ALARM.address());
        Ok::<_, Error>((alarm, refused, mode, sdo.read(alarm_as_mode).await))
    });
    world.run_for(Time::from_ms(500));
    let (aborted, unknown) = (Err(Error::Abort(AbortCode::ValueRange)), Err(Error::UnknownValue(3)));
    let expected = Ok((Alarm::NoSensor, aborted, Mode::Corrected, unknown));
    assert_eq!(moved.take().map(|(_, result)| result), Some(expected));
}

#[test]
#[should_panic(expected = "is no ")]
fn a_slave_of_another_device_is_a_mistake_of_the_test() {
    let (world, _) = running();
    world.slave::<Thermometer<[u8; 4]>>(THERMOMETER);
}
