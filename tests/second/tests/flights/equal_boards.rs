//! Two slave boards with one Node-ID that boot together with equal clocks.
//!
//! Their frames are equal and start in the same bit: on the wire they are one frame, and neither board hears the other.
//! The unique IDs of the chips separate them: see `docs/decisions/node-id-clashes.md`.

use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;
use flight::*;

/// EMCY code 8150h, CAN-ID collision, as on the wire.
const COLLISION: [u8; 2] = [0x50, 0x81];
/// Heartbeat period of profile `standard`.
const PERIOD_MS: u64 = 100;
/// Heartbeat periods within which two boards are separated: 32 bits, and the first heartbeat is on time.
const PERIODS: u64 = 33;
/// Pattern of late heartbeats of slave 2: CRC-32C of its unique ID, 0000_0002h, 3430_3546h, 2054_5749h, computed by a
/// program in another language.
const PATTERN_OF_TWO: u32 = 0x5047_A5AD;
/// Boards of one Node-ID, by their index on the wire.
const EQUAL: [usize; 2] = [2, 3];

/// Master, slave 2, and two boards of Node-ID 3 with equal crystals that are powered together. They fly for the largest
/// number of heartbeat periods that two boards need, and five seconds longer.
fn fly(images: &Images, ppm: f64) -> Flight {
    let [master, two, three, _] = MASTER_AND_THREE;
    let three = BoardSetup { ppm, ..three };
    let equal = BoardSetup { position_m: three.position_m + 0.5, ..three };
    let mut flight = Flight::with(&[master, two, three, equal], images);
    flight.fly_to(three.power_on_ms + PERIODS * PERIOD_MS + 5_000);
    flight
}

/// Returns the frames of a board on the nominal bus with this COB-ID.
fn of(flight: &Flight, board: usize, id: u16) -> impl Iterator<Item = &Seen> {
    flight.on(Bus::Nominal).filter(move |seen| seen.sender == board && seen.id() == Some(id))
}

/// Asserts that one of the equal boards reports a collision within 33 heartbeat periods and is silent afterwards, and
/// that the other one continues.
fn assert_one_yields(images: &Images, ppm: f64) {
    let flight = fly(images, ppm);
    let logs = |board: usize| flight.logs.iter().filter(move |log| log.board.0 == board);
    let yields = |board| Some((board, logs(board).find(|log| log.text.contains("yields: true"))?.at));
    let yielded: Vec<(usize, Time)> = EQUAL.into_iter().filter_map(yields).collect();
    let &[(silent, at)] = yielded.as_slice() else {
        panic!("one board yields, not {yielded:?}\n{}", flight.log(3));
    };
    assert!(at < ms(MASTER_AND_THREE[2].power_on_ms + 300 + PERIODS * PERIOD_MS), "{} us", at.as_us());
    let reports = |board: usize| of(&flight, board, 0x083).any(|seen| seen.data()[..2] == COLLISION);
    // Equal messages of both may merge.
    assert!(EQUAL.into_iter().any(reports), "no board reports it\n{}", flight.log(3));
    // A frame in its mailbox may still be sent.
    let late = flight.on(Bus::Nominal).filter(|seen| seen.sender == silent && seen.end > at + ms(100));
    assert_eq!(late.count(), 0, "board {silent} is silent");
    let other = EQUAL[usize::from(silent == EQUAL[0])];
    let beats = of(&flight, other, 0x703).filter(|seen| seen.end > at + ms(100));
    let [beats, least] = [beats.count() as u64, 5_000 / PERIOD_MS - 1];
    assert!(beats >= least, "{beats} heartbeats of board {other} after {} us", at.as_us());
    flight.assert_operational([2], Bus::Nominal);
    flight.assert_sound();
}

/// Given two boards with one Node-ID, equal crystals and one instant of power-on, when they fly, then one of them hears
/// the other within 33 heartbeat periods, reports it and is silent. The other one continues.
///
/// Verifies: ECSS 6.10h
#[test]
fn one_of_two_equal_boards_yields() {
    for (kbit, ppm) in [(1_000, 0.0), (1_000, 48.0), (125, 48.0)] {
        println!("{kbit} kbit/s, crystals {ppm} ppm off");
        assert_one_yields(&images(kbit), ppm);
    }
}

fn images(kbit: u64) -> Images {
    if kbit == 125 { rates::at(125, "standard") } else { STANDARD.clone() }
}

/// Given a slave, then its heartbeats are late by four of the longest frames if a bit of its unique ID is set, and in
/// the grid of the period otherwise: 540 us at 1 Mbit/s, 4,320 us at 125 kbit/s.
#[test]
fn unique_id_makes_heartbeats_late() {
    for (kbit, delay_us) in [(1_000, 540), (125, 4_320)] {
        let setups = [MASTER_AND_THREE[0], BoardSetup { ppm: 0.0, ..MASTER_AND_THREE[1] }];
        let mut flight = Flight::with(&setups, &images(kbit));
        flight.fly_to(5_000);
        // The last heartbeats: those before may be announced.
        let beats: Vec<u64> =
            flight.heartbeats(2, Bus::Nominal).iter().rev().take(40).map(|(at, _)| at.as_us()).collect();
        assert_eq!(beats.len(), 40);
        let fits = |first: u32, offset: u64| {
            beats.iter().rev().zip(0..).all(|(at, number)| {
                let is_late = PATTERN_OF_TWO >> ((first + number) % 32) & 1 == 1;
                let due = offset + 100_000 * u64::from(number) + if is_late { delay_us } else { 0 };
                // One of them may wait for a command and a request of the master: two of the longest frames, half of the delay.
                at.abs_diff(due) < delay_us / 2
            })
        };
        let begin = beats[39];
        let found = (0..32).any(|first| fits(first, begin) || fits(first, begin - delay_us));
        assert!(found, "{kbit} kbit/s: {beats:?}");
    }
}
