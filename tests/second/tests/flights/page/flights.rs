//! Flights of the image of the page on the board of the page, with the shipped master and a shipped slave built for the same board.

use std::path::Path;

use can_twin::board::BoardConfig;
use can_twin::description::Description;
use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::time::Time;
use ecss_can_cli::images::BoardCrate;
use flight::*;

const HEATER: u8 = 5;
/// The shipped slave, for which the master stays on its bus while the heater hangs.
const SHIPPED: u8 = 2;
/// Time at which all nodes are operational.
const STARTED: Time = ms(1_000);
/// Cause of a reset by the watchdog, in the emergency (docs/decisions/diagnostics.md).
const WATCHDOG: u8 = 5;
/// Setpoint that is saved, and one that is written after that: 0.1 °C.
const SAVED: u16 = 400;
const UNSAVED: u16 = 300;

/// Given master, slave and heater on the board of the page, when the nominal bus is cut, then the heater is on the
/// redundant bus. When its application hangs, the watchdog resets it. It reports that, and has the saved values.
pub fn fly(top: &Path) {
    let (mut flight, guest) = on_board(top);
    flight.fly(STARTED);
    flight.assert_operational([MASTER, SHIPPED, HEATER], Bus::Nominal);

    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly(STARTED + ms(1_000));
    flight.assert_operational([HEATER], Bus::Redundant);
    assert_eq!(flight.lost_frames(HEATER), 0);

    write_setpoint(&mut flight, guest, SAVED);
    // "save" to 1010h sub 1.
    sdo(&mut flight, guest, [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'], 0x60);
    write_setpoint(&mut flight, guest, UNSAVED);
    assert_eq!(setpoint(&mut flight, guest), UNSAVED);

    let reset = hang(&mut flight);
    flight.fly(reset + ms(1_500));
    flight.assert_operational([HEATER], Bus::Redundant);
    let first = flight.of(HEATER).find(|seen| seen.end > reset).expect("a frame after the reset");
    assert_eq!((first.id(), first.data()), (Some(0x705), &[BOOT_UP][..]));
    // CiA 301 7.2.7.1: error code 6101h, generic bit of the error register; then the error is over.
    let reported: Vec<&[u8]> = flight.emergencies(HEATER, reset).collect();
    assert_eq!(reported[0][..4], [0x00, 0x61, 0x01, WATCHDOG], "{}", flight.log(HEATER));
    assert_eq!(reported[1][..6], [0, 0, 0, 0, 0x61, WATCHDOG], "{}", flight.log(HEATER));
    assert_eq!(setpoint(&mut flight, guest), SAVED);
}

/// The master at the left end, the slave and the heater, on the board of the page, and a guest of the redundant bus.
fn on_board(top: &Path) -> (Flight, GuestId) {
    let folder = top.join("h405");
    let description = Description::read(&folder).unwrap_or_else(|wrong| panic!("{wrong}"));
    let shipped = ecss_can_cli::images::build(BoardCrate::Elsewhere(&folder), "standard").expect("images");
    let images = [parsed(&shipped.master), parsed(&shipped.slave)];
    let heater = parsed(&top.join("heater/target/firmware/heater"));
    let straps = description.model.pins.straps.expect("straps");
    let [master, slave, other, _] = MASTER_AND_THREE;
    let setups = [master, slave, BoardSetup { node: HEATER, ..other }];
    let mut flight = Flight::of(&setups, |setup| BoardConfig {
        model: description.model,
        image: if setup.node == HEATER { heater.clone() } else { setup.with(&images).image },
        straps: if setup.node == MASTER { Vec::new() } else { straps.closed(setup.node) },
        ..setup.with(&images)
    });
    let guest = flight.twin.add_guest(Bus::Redundant, 30.0);
    (flight, guest)
}

/// Lets the application of the heater hang with interrupts off. Returns the time of the reset.
fn hang(flight: &mut Flight) -> Time {
    let task = task_named(flight, HEATER, b"appl");
    let reset = end_program(flight, HEATER, task, &halfwords(&HANG_WITHOUT_INTERRUPTS));
    assert_eq!(flight.emulated(HEATER).counters().watchdog_resets, 1);
    reset
}

/// Sends a request of SDO to the heater. Returns the data of its answer, which has this command.
fn sdo(flight: &mut Flight, guest: GuestId, request: [u8; 8], command: u8) -> [u8; 4] {
    let answer = flight.ask(guest, HEATER, request);
    assert_eq!(answer[0], command, "{answer:02X?}\n{}", flight.log(HEATER));
    answer[4..].try_into().expect("four bytes")
}

/// Writes 6000h, two bytes.
fn write_setpoint(flight: &mut Flight, guest: GuestId, value: u16) {
    let [low, high] = value.to_le_bytes();
    sdo(flight, guest, [0x2B, 0x00, 0x60, 0, low, high, 0, 0], 0x60);
}

/// Reads 6000h, two bytes.
fn setpoint(flight: &mut Flight, guest: GuestId) -> u16 {
    let [low, high, ..] = sdo(flight, guest, [0x40, 0x00, 0x60, 0, 0, 0, 0, 0], 0x4B);
    u16::from_le_bytes([low, high])
}
