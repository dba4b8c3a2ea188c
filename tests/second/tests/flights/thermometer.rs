//! A user's own slave and master: `firmware/examples/thermometer` and `firmware/examples/thermometer-master`.

use std::sync::LazyLock;

use can_twin::devices::Lm75;
use can_twin::spacecraft::Bus;
use ecss_can_cli::images::Package;
use flight::*;

const THERMOMETER: u8 = 3;
/// Its PDOs: a change, and with every SYNC.
const CHANGE: u16 = 0x283;
const CYCLE: u16 = 0x483;

/// The master, the thermometer, and another one, which acknowledges the master's frames while the first one resets.
const SETUPS: [BoardSetup; 3] =
    [standby::setup(1, 12.0, 0.0, 20), standby::setup(3, -31.0, 4.0, 60), standby::setup(4, 40.0, 9.0, 90)];

static IMAGES: LazyLock<Images> = LazyLock::new(|| {
    ["thermometer-master", "thermometer"].map(|package| {
        let built = Package::of_workspace(package).build(None).unwrap();
        parsed(&built[0])
    })
});

/// Returns the temperature in 0.1 °C of the last frame `id`, and the byte after it.
fn last(flight: &Flight, id: u16) -> (i16, u8) {
    let data = flight.sent(THERMOMETER, Bus::Nominal, id).last().unwrap().data();
    (i16::from_le_bytes([data[0], data[1]]), data[2])
}

/// Returns a flight with a thermometer at 25 °C that has its table and was reset.
fn calibrated() -> Flight {
    let mut flight = Flight::with(&SETUPS, &IMAGES);
    flight.fly_to(2_000);
    flight
}

/// Given a thermometer without a table, when its master has booted it, then the table arrives by block transfer, is saved, and
/// is the same after a reset of the chip.
#[test]
fn the_table_survives_a_reset_of_the_thermometer() {
    let flight = calibrated();
    let saved = flight.assert_said(1, "TableSaved", ms(0));
    let kept = flight.assert_said(1, "TableKept", saved);
    assert_eq!(flight.emulated(THERMOMETER).counters().system_resets, 1);
    assert_eq!(flight.lost_frames(THERMOMETER), 0, "frames before the reset are not of this life");
    let boots = flight.heartbeats(THERMOMETER, Bus::Nominal);
    let booted = boots.iter().filter(|(_, state)| *state == BOOT_UP).map(|(at, _)| *at).next_back().unwrap();
    assert!(saved < booted && booted < kept);
    // Initiate block download of 6030h with CRC and size, initiate block upload of it.
    let request = |command| move |seen: &&Seen| seen.data()[..4] == [command, 0x30, 0x60, 0];
    assert_eq!(flight.sent(1, Bus::Nominal, 0x603).filter(request(0xC6)).count(), 1);
    assert_eq!(flight.sent(1, Bus::Nominal, 0x603).filter(request(0xA4)).count(), 1);
}

/// At 25 °C entry 612 of the table adds 0.9 °C, at 90 °C entry 872 adds 1.3 °C. The upper limit is 85 °C.
#[test]
fn a_warmer_sensor_sends_its_change_at_once() {
    let mut flight = calibrated();
    assert_eq!(last(&flight, CHANGE), (259, 0));
    let changes = flight.sent(THERMOMETER, Bus::Nominal, CHANGE).count();

    flight.emulated_mut(THERMOMETER).set_temperature(90.0);
    flight.fly_to(2_210);

    assert_eq!(flight.sent(THERMOMETER, Bus::Nominal, CHANGE).count(), changes + 1);
    assert_eq!(last(&flight, CHANGE), (913, 1));
    assert_eq!(last(&flight, CYCLE).0, 913);
    // The master has received it, into its dictionary.
    flight.assert_said(1, "Measured { temperature: 913, alarm: Above }", ms(2_000));
}

/// Given a running thermometer, when its sensor is unplugged, with or without the pull-ups of both lines, then it
/// reports that there is no temperature, raises EMCY 5000h once and continues. When the sensor is back, it clears the
/// error and measures again.
#[test]
fn a_missing_sensor_is_reported_until_it_is_back() {
    for has_pull_ups in [true, false] {
        let mut flight = calibrated();
        let emergencies = |flight: &Flight| -> Vec<u16> {
            let sent = flight.emergencies(THERMOMETER, ms(2_000));
            sent.map(|data| u16::from_le_bytes([data[0], data[1]])).collect()
        };
        flight.emulated_mut(THERMOMETER).detach_i2c(1);
        if has_pull_ups {
            flight.emulated_mut(THERMOMETER).attach_i2c(1, Lm75::new(0x4F, 25.0));
        }
        flight.fly_to(2_600);
        assert_eq!(last(&flight, CHANGE), (i16::MIN, 3), "pull-ups: {has_pull_ups}");
        assert_eq!(emergencies(&flight), [0x5000]);
        assert_eq!(last(&flight, CYCLE).0, i16::MIN);

        flight.emulated_mut(THERMOMETER).attach_i2c(1, Lm75::new(Lm75::ADDRESS, 30.0));
        flight.fly_to(3_000);
        // Entry 632 adds nine tenths as well.
        assert_eq!(last(&flight, CHANGE), (309, 0), "pull-ups: {has_pull_ups}");
        assert_eq!(emergencies(&flight), [0x5000, 0x0000]);
        assert_eq!(flight.emulated(THERMOMETER).counters().system_resets, 1);
    }
}

/// Given the command "forget the highest temperature", when the master sends it as a PDO, then it is obeyed.
#[test]
fn a_command_of_the_master_is_obeyed() {
    let flight = calibrated();
    let commands: Vec<&Seen> = flight.sent(1, Bus::Nominal, 0x203).collect();
    assert_eq!(commands.iter().map(|seen| seen.data()).collect::<Vec<_>>(), [[1]]);
    flight.assert_said(THERMOMETER, "commanded; highest temperature: 259", commands[0].end);
}

/// Given a SYNC every 100 ms, then the temperature follows each.
#[test]
fn the_temperature_comes_with_every_sync() {
    let flight = calibrated();
    let from = flight.assert_said(1, "TableKept", ms(0));
    let after = |id| flight.on(Bus::Nominal).filter(move |seen| seen.id() == Some(id) && seen.end > from);
    let (syncs, answers) = (after(0x080).count(), after(CYCLE).count());
    assert!(syncs >= 10 && syncs.abs_diff(answers) <= 1, "{syncs} SYNCs, {answers} answers");
}

/// Given a cut next to the master, when the temperature rises above its limit before the master is heard on the other
/// bus, then the master knows alarm and value there at once. The other thermometer acknowledged the first frame.
#[test]
fn an_alarm_while_the_bus_fails_reaches_the_master() {
    for after_ms in [5, 60] {
        let mut flight = calibrated();
        flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
        flight.fly_to(2_000 + after_ms);
        flight.emulated_mut(THERMOMETER).set_temperature(90.0);
        flight.fly_to(3_000);
        println!("an alarm after {after_ms} ms\n{}", flight.log(THERMOMETER));
        flight.assert_said(1, "Measured { temperature: 913, alarm: Above }", ms(2_000));
    }
}
