//! Times that contradict the clock, and what is reported of them.
//!
//! Verifies: ECSS 7.2.1a

use ecss_can::link::Stamp;
use ecss_can::node::extend::LinkEvent;
use ecss_can::node::{MasterEvent, SpacecraftDevice};
use ecss_can::profile::Profile;
use ecss_can::types::{Instant, Scet};

use super::devices::{Keeper, Node, operational};
use super::{run, scet, sync, time, us};
use crate::bench::{Bench, Master, NOMINAL, frame, ms};
use crate::console;
use crate::device::fixture::{read, write, write_all};
use crate::instrument::STANDARD;

/// Emergencies of slave 5 so far: code, and the first byte of the manufacturer.
fn emergencies<D: SpacecraftDevice>(slave: &mut Node<D>) -> Vec<(u16, u8)> {
    let of_slave = slave.sent.iter().filter(|sent| sent.frame.id().raw() == 0x085);
    let decode = |data: [u8; 8]| (u16::from_le_bytes([data[0], data[1]]), data[3]);
    of_slave.map(|sent| decode(sent.frame.padded())).collect()
}

/// The spacecraft time of a local instant, with lowest bits that are not zero.
fn at(ms: u64) -> Scet {
    Scet::from_units(scet(1_000, 0).plus(crate::bench::span(ms)).units() | 1)
}

/// A SYNC each 100 ms, up to and with that at `last`, and 300 us later times that differ by `off` milliseconds.
fn follow(slave: &mut Node<Keeper>, last: u64, off: &[u64]) {
    let first = slave.now.as_micros() / 100_000 + 1;
    for nth in first..=last / 100 {
        run(slave, us(nth * 100_000));
        sync(slave);
        for (late, off) in (3..).zip(off) {
            run(slave, us(nth * 100_000 + late * 100));
            time(slave, at(nth * 100 + off));
        }
    }
    run(slave, slave.now + crate::bench::span(50));
}

/// Two spacecraft times 0.5 s off move no clock; three do, and an emergency reports the step. The first time of all is none.
///
/// Verifies: ECSS 6.4a.1, 6.4a.2
/// Notices: ECSS 6.4a.2: a step of the clock has a code other than 9000h.
#[test]
fn step_of_a_clock_is_an_emergency() {
    let mut slave = operational::<Keeper>();
    follow(&mut slave, 1_000, &[0]);
    follow(&mut slave, 1_200, &[500]);
    assert_eq!(emergencies(&mut slave), []);
    assert_eq!(read(&mut slave, 0x2015, 5), [1, 0, 0, 0], "steps");
    follow(&mut slave, 1_300, &[500]);
    assert_eq!(emergencies(&mut slave)[..1], [(0x9000, 0x10)]);
    assert_eq!(read(&mut slave, 0x2015, 5), [2, 0, 0, 0], "steps");
    assert!(u32::from_le_bytes(read(&mut slave, 0x2015, 1)) > 500_000_000, "not confirmed");
}

/// Two nodes send the spacecraft time: after the third SYNC with two times it is an emergency, until a SYNC has one.
///
/// Verifies: ECSS 7.2.2d, 6.4a.2
/// Notices: ECSS 7.2.2d: two times after each SYNC are taken as they come.
/// Notices: ECSS 7.2.2d: a second producer with another time is not noticed.
#[test]
fn second_producer_of_the_time_is_an_emergency() {
    let mut slave = operational::<Keeper>();
    follow(&mut slave, 1_000, &[0]);
    follow(&mut slave, 1_300, &[0, 1]);
    assert_eq!(emergencies(&mut slave), []);
    follow(&mut slave, 1_400, &[0, 1]);
    assert_eq!(emergencies(&mut slave), [(0x8150, 0x81)]);
    follow(&mut slave, 1_600, &[0]);
    // It is reset: with the code of the error that is gone.
    assert_eq!(emergencies(&mut slave), [(0x8150, 0x81), (0x0000, 0x50)]);
    // Its times moved nothing.
    assert_eq!(read(&mut slave, 0x2015, 5), [1, 0, 0, 0], "steps");
}

/// Given a slave whose time comes without SYNC, by type 254 or 255, when a second producer sends times that are 0.5 s off, in turn with
/// the first one, then the clock keeps to the first one, and each time of the other one is counted as refused.
///
/// Verifies: ECSS 7.2.2d, 7.2.2c
/// Notices: ECSS 7.2.2d: a time of a second producer by event sets the clock.
#[test]
fn second_producer_by_event_moves_no_clock() {
    for transmission in [254, 255] {
        let mut slave = operational::<Keeper>();
        let steps: [(u16, u8, &[u8]); 3] = [
            (0x1400, 1, &[0x81, 1, 0, 0xC0]),
            (0x1400, 2, &[transmission]),
            (0x1400, 1, &[0x81, 1, 0, 0x40]),
        ];
        write_all(&mut slave, &steps);
        for nth in 1..=20 {
            run(&mut slave, ms(100 * nth));
            time(&mut slave, at(100 * nth));
            run(&mut slave, ms(100 * nth + 50));
            time(&mut slave, at(100 * nth + 550));
        }
        assert_eq!(read(&mut slave, 0x2015, 5), [1, 0, 0, 0], "steps, type {transmission}");
        assert_eq!(read(&mut slave, 0x2015, 7), [20, 0, 0, 0], "refused, type {transmission}");
        assert!(slave.node.scet(slave.now).micros_since(at(2_050)).abs() < 1_000);
    }
}

/// A time that was repeated by the bus, once, is none.
///
/// Verifies: ECSS 6.4a.1
/// Notices: ECSS 6.4a.1: a spacecraft time that the bus repeated is reported as an error.
#[test]
fn repeated_time_is_no_second_producer() {
    let mut slave = operational::<Keeper>();
    follow(&mut slave, 1_000, &[0]);
    for last in [1_100, 1_300, 1_500] {
        follow(&mut slave, last, &[0, 0]);
        follow(&mut slave, last + 100, &[0]);
    }
    assert_eq!(emergencies(&mut slave), []);
}

/// A crystal that is farther off than the profile admits: the clock has no bound, which is an emergency.
///
/// Verifies: ECSS 6.4a.2
#[test]
fn saturated_clock_is_an_emergency() {
    let mut slave = operational::<Keeper>();
    for nth in 1..=40 {
        run(&mut slave, us(nth * 100_000));
        sync(&mut slave);
        run(&mut slave, us(nth * 100_000 + 300));
        // 350 ppm, the profile has 300.
        time(&mut slave, Scet::from_units((at(nth * 100).units() + nth * 587) | 1));
    }
    run(&mut slave, ms(4_050));
    assert_eq!(emergencies(&mut slave), [(0x9000, 0x12)]);
    assert_eq!(read(&mut slave, 0x2015, 1), [0xFF; 4], "no bound");
}

/// Until 2014h is written, the bound has the longest delay of the network: 40 m and its transceivers, 350 ns.
#[test]
fn unknown_delay_is_part_of_the_bound() {
    let mut slave = operational::<Keeper>();
    follow(&mut slave, 3_000, &[0]);
    let unknown = u32::from_le_bytes(read(&mut slave, 0x2015, 1));
    write(&mut slave, 0x2014, 1, &0_i32.to_le_bytes());
    let known = u32::from_le_bytes(read(&mut slave, 0x2015, 1));
    assert!((350..360).contains(&(unknown - known)), "{unknown} and {known} ns");
}

/// The producer's stamps are seen in its times: one that has no capture wires sends 21 binary places.
#[test]
fn times_of_21_places_come_of_a_producer_without_capture() {
    let source = |lowest: u64| {
        let mut slave = operational::<Keeper>();
        for nth in 1..=30 {
            run(&mut slave, us(nth * 100_000));
            sync(&mut slave);
            run(&mut slave, us(nth * 100_000 + 300));
            time(&mut slave, Scet::from_units((at(nth * 100).units() & !7) | lowest));
        }
        let bound = u32::from_le_bytes(read(&mut slave, 0x2015, 1));
        (read(&mut slave, 0x2015, 2)[0], bound)
    };
    let (captured, bound) = source(1);
    assert!(captured == 2 && bound < 2_000, "source {captured}, {bound} ns");
    let (interrupted, bound) = source(0);
    assert!(interrupted == 3 && bound > 8_000, "source {interrupted}, {bound} ns");
}

/// A master that sends a SYNC each 100 ms and its time with each.
fn high_resolution() -> Bench<Master> {
    let mut master = Bench::new(console::master(&Profile { autostart: true, ..STANDARD }));
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    for (sub, value, len) in [(1, 0xC000_0181, 4), (2, 1, 1), (1, 0x4000_0181, 4)] {
        assert_eq!(crate::master_device::write(&mut master, 0x1800, sub, value, len), Ok(()));
    }
    master.clear();
    master
}

/// SYNCs of the master that end each 100 ms and 10 us, with these stamps; fine times that it sends.
fn fine_times(master: &mut Bench<Master>, count: u64, stamp: fn(Instant) -> Stamp) -> Vec<u8> {
    master.clear();
    let first = master.now.as_micros() / 100_000 + 1;
    for nth in first..first + count {
        master.run_until(us(nth * 100_000 + 10));
        let stamp = stamp(us(nth * 100_000 + 10));
        master.link(NOMINAL, LinkEvent::Transmitted { frame: frame(0x080, &[]), stamp });
    }
    let of_time = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x181);
    of_time.map(|sent| sent.frame.padded()[0]).collect()
}

fn lasting_errors(master: &mut Bench<Master>) -> u32 {
    crate::master_device::read(master, 0x1001, 0)
}

fn is_reported(master: &Bench<Master>) -> bool {
    master.events.iter().any(|event| matches!(event, MasterEvent::SyncUncaptured))
}

/// A master without capture wires sends 21 places, from the first time on. After five SYNCs it is an error and an event. Captured
/// SYNCs end both.
#[test]
fn master_without_capture_reports_it_and_sends_21_places() {
    let mut master = high_resolution();
    let times = fine_times(&mut master, 4, Stamp::interrupt);
    assert!(times.len() == 4 && times.iter().all(|fine| fine.is_multiple_of(8)), "{times:?}");
    assert_eq!((lasting_errors(&mut master), is_reported(&master)), (0, false));
    fine_times(&mut master, 1, Stamp::interrupt);
    assert_ne!(lasting_errors(&mut master), 0);
    assert!(is_reported(&master));
    let captured = |at: Instant| Stamp::captured(at.into());
    let times = fine_times(&mut master, 8, captured);
    assert!(times.iter().any(|fine| !fine.is_multiple_of(8)), "{times:?}");
    assert_eq!((lasting_errors(&mut master), is_reported(&master)), (0, false));
}
