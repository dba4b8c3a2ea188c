//! Minimal slaves (ECSS 9) fly with the shipped master alone.
//!
//! There are four receive PDOs: 205h keeps bytes, 505h requests them by 485h, and 305h and 405h take commands and
//! requests of the mission, as full slaves do. 285h follows each SYNC, with commands executed and the state of the LED.

use std::sync::LazyLock;

use can_twin::spacecraft::Bus;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::minimal::*;
use flight::*;

/// Three seconds without faults.
static FLIGHT: LazyLock<Recording> = LazyLock::new(|| {
    let mut flight = standard(&[MASTER_SETUP, MASTER_AND_THREE[1], SETUP]);
    flight.fly_to(3_000);
    flight.assert_nothing_lost();
    flight.seen
});

/// Verifies: ECSS 9.4.9.1.1a
/// Verifies: ECSS 9.4.9.2a
#[test]
fn minimal_slave_sends_heartbeats_and_no_boot_up_message() {
    let heartbeats = FLIGHT.heartbeats(MINIMAL, Bus::Nominal);
    assert!(heartbeats.iter().all(|(_, state)| *state == OPERATIONAL), "{heartbeats:?}");
    assert!(heartbeats.len() >= 28, "{heartbeats:?}");
    let ends: Vec<Time> = heartbeats.iter().map(|(at, _)| *at).collect();
    // Up to nine frames may be sent first.
    assert!(gaps(&ends).all(|gap| about(ms(100), Time::from_us(9 * 135)).contains(&gap)));
}

/// Given a minimal slave, then it sends only heartbeats, telemetry and answers to SYNC: no EMCY, no SDO, no time. There
/// is no request by 505h in this flight.
///
/// Verifies: ECSS 9.4.1b
#[test]
fn minimal_slave_sends_objects_of_the_minimal_set_only() {
    assert_eq!(ids_of(&FLIGHT, MINIMAL), [0x285, 0x385, 0x705]);
    assert_eq!(FLIGHT.on(Bus::Redundant).count(), 0);
}

/// Given a minimal slave, then no node sends the time stamp object (100h). The spacecraft time of full slaves is sent
/// by a PDO.
///
/// Verifies: ECSS 9.4.7.1b
#[test]
fn nobody_sends_the_time_stamp_object_to_a_minimal_slave() {
    assert_eq!(FLIGHT.with_id(0x100).count(), 0);
}

/// Given a master that requests ten values in turn, then the slave answers the three that it knows, once a second each,
/// without delay.
///
/// Verifies: ECSS 9.4.3b.1
#[test]
fn the_minimal_slave_answers_each_request_and_no_command() {
    let requests = requests(&FLIGHT);
    assert!(requests.len() >= 6, "{}", requests.len());
    for request in &requests {
        let reply = FLIGHT.first_after(request.end, |seen| seen.id() == Some(0x385)).unwrap();
        assert_eq!(reply.data()[..2], request.data()[..2]);
    }
    let replies = FLIGHT.sent(MINIMAL, Bus::Nominal, 0x385).filter(|seen| seen.end < ms(2_990));
    assert_eq!(replies.count(), requests.len(), "a command is not answered");
}

/// Returns the requests for the three values that the minimal slave knows.
fn requests(flight: &Recording) -> Vec<&Seen> {
    let of_values = |seen: &&Seen| [1, 2, 3].contains(&seen.data()[0]) && seen.end < ms(2_990);
    flight.sent(MASTER, Bus::Nominal, 0x405).filter(of_values).collect()
}

/// Given images for a bit rate, when the master requests telemetry and at most one frame precedes it, then it ends
/// within the stated delay.
///
/// Verifies: ECSS 9.4.4a
#[test]
fn telemetry_comes_within_the_stated_delay_of_its_request() {
    let slow = rates::at(125, "standard");
    let slow_minimal = minimal_image(PYBOARD_V11, "standard+kbit-125");
    let mut flight = Flight::of(&PAIR, |setup| minimal(setup, setup.with(&slow), &slow_minimal));
    flight.fly_to(3_000);
    for (flight, kbit) in [(&*FLIGHT, 1_000), (&flight.seen, 125)] {
        let mut free = 0;
        for request in requests(flight) {
            let reply = flight.first_after(request.end, |seen| seen.id() == Some(0x385)).unwrap();
            let between = |seen: &&Seen| seen.start > request.end && seen.end < reply.start;
            if flight.on(Bus::Nominal).filter(between).count() > 1 {
                continue;
            }
            free += 1;
            let delay = reply.end.since(request.end);
            assert!(delay < telemetry_delay(kbit), "{kbit} kbit/s: {} us", delay.as_us());
        }
        assert!(free >= 4, "{kbit} kbit/s: {free} requests on a free bus");
    }
}

/// Given commands of the master, then each is executed, which the number in 285h after each SYNC shows.
///
/// Verifies: ECSS 9.4.1c
/// Verifies: ECSS 9.4.3b.2
#[test]
fn sync_brings_the_number_of_executed_commands() {
    let from = ms(500);
    let syncs =
        FLIGHT.sent(MASTER, Bus::Nominal, 0x080).filter(|seen| seen.end > from && seen.end < ms(2_990));
    let mut count = 0;
    for sync in syncs {
        let sent = FLIGHT.first_after(sync.end, |seen| seen.id() == Some(0x285)).unwrap();
        assert!(sent.end.since(sync.end) < TELEMETRY_DELAY + QUEUEING);
        let commands = FLIGHT.sent(MASTER, Bus::Nominal, 0x305).filter(|seen| seen.end < sync.end);
        let [a, b, c, d, led] = sent.data().try_into().unwrap();
        let executed = u32::from_le_bytes([a, b, c, d]);
        let commanded = commands.count() as u32;
        assert!(executed == commanded, "{executed} of {commanded}");
        assert!(led <= 1);
        count += 1;
    }
    assert!(count >= 20, "{count}");
}

/// Given any length of a command, of a request and of telemetry, then the slave handles it (Figures 9-1 and 9-2).
///
/// Verifies: ECSS 9.3a
/// Verifies: ECSS 9.4.2a
/// Verifies: ECSS 9.4.3a, 9.4.3c
#[test]
fn commands_requests_and_telemetry_have_any_length() {
    let mut flight = standard(&PAIR);
    let guest = flight.twin.add_guest(Bus::Nominal, 30.0);
    flight.fly_to(400);
    let data = [0xA1, 0xB2, 0xC3, 0xD4, 0xE5, 0xF6, 0x07, 0x18];
    for command in 0..=8 {
        let asked = 8 - command;
        flight.twin.inject(guest, flight.end, WireFrame::standard(0x205, &data[..command]));
        flight.twin.inject(guest, flight.end, WireFrame::standard(0x505, &data[..asked]));
        let request = flight.fly_until(|seen| seen.id() == Some(0x505));
        let reply = flight.fly_until(|seen| seen.id() == Some(0x485));
        assert_eq!(reply.data(), &data[..command]);
        assert!(reply.end.since(request.end) < TELEMETRY_DELAY + QUEUEING);
    }
    // One PDO carries commands and requests. The slave distinguishes them by their first bytes.
    for data in [&[2, 0, 0x78, 0x56, 0x34, 0x12, 0, 200][..], &[0x02, 0x01]] {
        flight.twin.inject(guest, flight.end, WireFrame::standard(0x305, data));
    }
    let reply = flight.fly_until(|seen| seen.id() == Some(0x385) && seen.data()[2] == 0x78);
    assert_eq!(reply.data(), [0x02, 0x01, 0x78, 0x56, 0x34, 0x12, 0, 0]);
    // All objects of Table 9-1 that this device has in use: nine commands by 205h, which bring nothing, and nine requests by 505h.
    assert_eq!(ids_of(&flight, MINIMAL), [0x285, 0x385, 0x485, 0x705]);
    assert_eq!(flight.sent(MINIMAL, Bus::Nominal, 0x485).count(), 9);
    flight.assert_nothing_lost();
}

/// Given module control, time, SDO, emergencies, and frames of a wrong length, then there is no answer and no change.
///
/// Verifies: ECSS 9.4.6.1a
/// Verifies: ECSS 9.4.7.1a
/// Verifies: ECSS 9.4.8a
#[test]
fn frames_outside_of_the_minimal_set_change_nothing() {
    let mut flight = standard(&PAIR);
    let guest = flight.twin.add_guest(Bus::Nominal, 30.0);
    flight.fly_to(400);
    let frames: [(u16, &[u8]); 13] = [
        (0x000, &[0x01, MINIMAL]),
        (0x000, &[0x02, MINIMAL]),
        (0x000, &[0x80, MINIMAL]),
        (0x000, &[0x81, MINIMAL]),
        (0x000, &[0x82, MINIMAL]),
        (0x100, &[0; 6]),
        (0x605, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]),
        (0x605, &[0xFF; 8]),
        (0x085, &[0x00, 0x10, 1, 0, 0, 0, 0, 0]),
        (0x305, &[]),
        (0x405, &[1]),
        (0x405, &[0xFF, 0xFF]),
        (0x080, &[1]),
    ];
    for (nth, (id, data)) in (0..).zip(frames) {
        flight.twin.inject(guest, ms(450 + 10 * nth), WireFrame::standard(id, data));
    }
    flight.fly_to(1_500);
    assert_eq!(ids_of(&flight, MINIMAL), [0x285, 0x385, 0x705]);
    let syncs = flight.sent(MASTER, Bus::Nominal, 0x080).filter(|seen| seen.end > ms(80));
    assert_eq!(flight.sent(MINIMAL, Bus::Nominal, 0x285).count(), syncs.count());
    assert!(flight.heartbeats(MINIMAL, Bus::Nominal).iter().all(|(_, state)| *state == OPERATIONAL));
    let commanded = flight.sent(MASTER, Bus::Nominal, 0x305).count();
    assert_eq!(flight.executed(MINIMAL) as usize, commanded);
    assert_eq!(flight.emulated(MINIMAL).counters().system_resets, 0);
    flight.assert_nothing_lost();
}

/// Verifies: ECSS 6.10f
#[test]
fn minimal_slave_with_a_wrong_strap_is_silent() {
    for board in [PYBOARD_V11, NUCLEO_F446RE] {
        let mut flight = librecube(&[MASTER_SETUP, BoardSetup { parity: false, board, ..SETUP }]);
        flight.fly_to(300);
        flight.assert_said(MINIMAL, "staying silent", ms(20));
        assert_eq!(flight.frames, [], "nobody acknowledges the master");
    }
}

/// Given a minimal slave, when its program hangs, faults, overflows its stack or reads by a null pointer, then it is reset
/// and takes part again.
#[test]
fn minimal_slave_that_hangs_or_faults_is_reset() {
    for (code, within_ms) in [
        (halfwords(&HANG), 1_400),
        (halfwords(&HANG_WITHOUT_INTERRUPTS), 4_000),
        (halfwords(&UNDEFINED), 1_400),
        (halfwords(&OVERFLOW), 1_400),
        (accessing(LOAD, 0), 1_400),
    ] {
        let mut flight = standard(&PAIR);
        flight.fly_to(400);
        let task = tasks(&flight, MINIMAL)[0];
        let began = flight.end;
        let ended = end_program(&mut flight, MINIMAL, task, &code);
        assert!(ended < began + ms(within_ms), "{code:02X?}: {} us", ended.since(began).as_us());
        flight.fly(ended + ms(400));
        flight.assert_operational([MINIMAL], Bus::Nominal);
        flight.assert_said(MINIMAL, "in a row", ended - ms(10));
    }
}

/// Given a slave on another board than a pyboard (`tests/flight`), then it finds the bus of the master.
#[test]
fn minimal_slave_on_another_board_follows_by_its_search() {
    assert_slaves_followed(&mixed(NUCLEO_F446RE));
}
