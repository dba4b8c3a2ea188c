//! 2010h, 2011h, 2014h and 2015h by SDO.
//!
//! Verifies: ECSS 7.1.1a, 7.1.2a, 7.1.2d

use ecss_can::link::Stamp;
use ecss_can::node::SlaveEvent;
use ecss_can::node::extend::LinkEvent;
use ecss_can::time::Step;
use ecss_can::types::{Duration, FineInstant};

use super::devices::{Coarse, Keeper, Node, operational};
use super::{run, scet, sync, sync_at, time, us};
use crate::bench::{NOMINAL, REDUNDANT, frame, ms};
use crate::device::fixture::{ask, ask_on, done, map_tpdo, read, refused, write, write_all, write_on};

fn steps(slave: &Node<Keeper>) -> Vec<Step> {
    let step = |event: &SlaveEvent| match event {
        SlaveEvent::Step(step) => Some(*step),
        _ => None,
    };
    slave.events.iter().filter_map(step).collect()
}

/// Fine time at 0.999 s, coarse time 2 ms later: 0.999 s, not 1.999 s.
///
/// Verifies: ECSS 7.1.2e
/// Notices: ECSS 7.1.1a: the fine time is sent in microseconds, not in units of 2^-24 s.
/// Notices: ECSS 7.1.2d: each read of the coarse time takes a new sample.
#[test]
fn both_sub_indices_are_of_one_sample_whichever_is_read_first() {
    for (first, second) in [(1, 2), (2, 1)] {
        let mut slave = operational::<Keeper>();
        run(&mut slave, ms(999));
        let mut values = [[0; 4]; 2];
        values[first as usize - 1] = read(&mut slave, 0x2011, first);
        run(&mut slave, ms(1_001));
        values[second as usize - 1] = read(&mut slave, 0x2011, second);
        // 0.999 x 2^24 = 16,760,438.8.
        assert_eq!(values, [[0; 4], [0x77, 0xBE, 0xFF, 0]], "{first} first");
        // What was read is a new sample.
        assert_eq!(read(&mut slave, 0x2011, 1), [1, 0, 0, 0]);
    }
}

/// Given a clock that a client sets to half a second before its end, then it counts all 32 bits of seconds, and begins
/// again with zero.
///
/// Verifies: ECSS 7.1.2c, 7.1.2e
/// Notices: ECSS 7.1.1a: the coarse time wraps after 2^24 s.
/// Notices: ECSS 7.1.2e: the coarse time has 31 bits.
#[test]
fn the_coarse_time_counts_32_bits_and_begins_again() {
    let mut slave = operational::<Keeper>();
    run(&mut slave, ms(1_000));
    assert_eq!(write(&mut slave, 0x2010, 1, &[0xFF; 4]), done(0x2010, 1));
    assert_eq!(write(&mut slave, 0x2010, 2, &[0, 0, 0x80]), done(0x2010, 2));
    assert_eq!(read(&mut slave, 0x2011, 1), [0xFF; 4]);
    assert_eq!(read(&mut slave, 0x2011, 2), [0, 0, 0x80, 0]);
    run(&mut slave, ms(1_750));
    assert_eq!(read(&mut slave, 0x2011, 1), [0; 4]);
    assert_eq!(read(&mut slave, 0x2011, 2), [0, 0, 0x40, 0], "a quarter of a second");
}

#[test]
fn a_sample_outlives_a_pdo_in_between_but_not_ten_seconds() {
    let mut slave = operational::<Keeper>();
    run(&mut slave, ms(999));
    assert_eq!(read(&mut slave, 0x2011, 1), [0; 4]);
    run(&mut slave, ms(1_500));
    sync(&mut slave);
    assert_eq!(read(&mut slave, 0x2011, 2), [0x77, 0xBE, 0xFF, 0], "0.999 s");
    assert_eq!(read(&mut slave, 0x2011, 1), [1, 0, 0, 0]);
    run(&mut slave, ms(11_500));
    assert_eq!(read(&mut slave, 0x2011, 2), [0, 0, 0x80, 0], "11.5 s");
}

/// Given a client that asks by block upload and accepts an expedited answer, when it reads the coarse time at 1.999 s and the fine time
/// 2 ms later, then both are of 1.999 s.
///
/// Verifies: ECSS 6.1a
/// Notices: ECSS 7.1.2a: a block upload of Local SCET Get takes no sample.
/// Notices: ECSS 7.1.2d: a read of the time by block upload takes no sample.
#[test]
fn parts_read_by_block_upload_are_of_one_sample() {
    let mut slave = operational::<Keeper>();
    run(&mut slave, ms(1_999));
    assert_eq!(ask(&mut slave, [0xA0, 0x11, 0x20, 1, 1, 4, 0, 0]), [0x43, 0x11, 0x20, 1, 1, 0, 0, 0]);
    run(&mut slave, ms(2_001));
    // 0.999 x 2^24 = 16,760,438.8, in three bytes.
    assert_eq!(
        ask(&mut slave, [0xA0, 0x11, 0x20, 2, 1, 4, 0, 0]),
        [0x47, 0x11, 0x20, 2, 0x77, 0xBE, 0xFF, 0]
    );
}

/// Coarse time, fine time 100 ms later: one step, as of the second write.
///
/// Verifies: ECSS 7.1.2c, 7.1.2b
/// Notices: ECSS 7.1.2c: the first of two parts sets the clock.
#[test]
fn two_writes_are_one_step() {
    for (first, second) in [(1, 2), (2, 1)] {
        let mut slave = operational::<Keeper>();
        let values: [&[u8]; 2] = [&[100, 0, 0, 0], &[0, 0, 0x80]];
        run(&mut slave, ms(2_000));
        slave.clear();
        assert_eq!(write(&mut slave, 0x2010, first, values[first as usize - 1]), done(0x2010, first));
        run(&mut slave, ms(2_100));
        assert_eq!(slave.node.scet(slave.now), scet(2, 1_677_722), "2.1 s: not set yet");
        assert_eq!(write(&mut slave, 0x2010, second, values[second as usize - 1]), done(0x2010, second));
        assert_eq!(slave.node.scet(slave.now), scet(100, 0x80_0000));
        assert_eq!(steps(&slave), [Step { from: scet(2, 1_677_722), to: scet(100, 0x80_0000) }]);
    }
}

/// Given a slave whose Local Time PDO is not valid, when a client writes Local SCET Set, then the clock is set.
///
/// Verifies: ECSS 7.1.2b, 7.1.2c
/// Notices: ECSS 7.1.2b: Local SCET Set of a node without a valid Local Time PDO sets nothing.
#[test]
fn local_scet_set_works_without_a_local_time_pdo() {
    let mut slave = operational::<Keeper>();
    assert_eq!(write(&mut slave, 0x1800, 1, &[0x85, 1, 0, 0xC0]), done(0x1800, 1));
    assert_eq!(write(&mut slave, 0x2010, 1, &[100, 0, 0, 0]), done(0x2010, 1));
    assert_eq!(write(&mut slave, 0x2010, 2, &[0, 0, 0x80]), done(0x2010, 2));
    assert_eq!(slave.node.scet(slave.now), scet(100, 0x80_0000));
}

/// Verifies: ECSS 7.1.2c
#[test]
fn a_part_alone_sets_nothing_and_is_forgotten_after_ten_seconds() {
    let mut slave = operational::<Keeper>();
    assert_eq!(write(&mut slave, 0x2010, 1, &[100, 0, 0, 0]), done(0x2010, 1));
    run(&mut slave, ms(10_001));
    assert_eq!(write(&mut slave, 0x2010, 2, &[0, 0, 0]), done(0x2010, 2));
    assert_eq!(steps(&slave), []);
    // It begins another pair.
    assert_eq!(write(&mut slave, 0x2010, 1, &[7, 0, 0, 0]), done(0x2010, 1));
    assert_eq!(slave.node.scet(slave.now), scet(7, 0));
}

/// Verifies: ECSS 7.1.2c
#[test]
fn a_time_that_a_pdo_brings_ends_a_pair_that_was_begun() {
    let mut slave = operational::<Keeper>();
    assert_eq!(write(&mut slave, 0x2010, 2, &[0, 0, 0]), done(0x2010, 2));
    sync(&mut slave);
    time(&mut slave, scet(50, 0));
    assert_eq!(write(&mut slave, 0x2010, 1, &[7, 0, 0, 0]), done(0x2010, 1));
    assert_eq!(slave.node.scet(slave.now), scet(50, 0));
}

/// Given a clock that the other one has set, when a client or a PDO brings a time, then this one sets it.
///
/// Verifies: ECSS 7.1.2c, 7.2.3f, 7.2.1a, 7.2.3g
/// Notices: ECSS 7.1.2c: a client does not set a clock that follows a Spacecraft Time PDO.
/// Notices: ECSS 7.2.3f: a clock that a client has set does not follow the PDO.
#[test]
fn a_client_and_a_pdo_set_the_clock_one_after_the_other() {
    for client_first in [true, false] {
        let mut slave = operational::<Keeper>();
        for by_client in [client_first, !client_first] {
            if by_client {
                assert_eq!(write(&mut slave, 0x2010, 1, &[7, 0, 0, 0]), done(0x2010, 1));
                assert_eq!(write(&mut slave, 0x2010, 2, &[0, 0, 0]), done(0x2010, 2));
            } else {
                sync(&mut slave);
                time(&mut slave, scet(50, 0));
            }
            let expected = if by_client { scet(7, 0) } else { scet(50, 0) };
            assert_eq!(slave.node.scet(slave.now), expected, "client first: {client_first}");
        }
    }
}

/// Verifies: ECSS 7.1.2g, 7.1.2h, 7.1.2c
#[test]
fn a_device_with_8_bits_of_fine_time_sends_and_takes_no_more() {
    let mut slave = operational::<Coarse>();
    assert_eq!(write(&mut slave, 0x2010, 2, &[0xFF, 0xFF, 0x81]), done(0x2010, 2));
    assert_eq!(write(&mut slave, 0x2010, 1, &[9, 0, 0, 0]), done(0x2010, 1));
    assert_eq!(slave.node.scet(slave.now), scet(9, 0x81_0000));
    // 3.9 ms later, short of the next of its units: 9 + 81h / 100h + 3.9 ms.
    run(&mut slave, us(3_900));
    assert_eq!(read(&mut slave, 0x2011, 2), [0, 0, 0x81, 0]);
    run(&mut slave, us(3_907));
    assert_eq!(read(&mut slave, 0x2011, 1), [9, 0, 0, 0]);
    assert_eq!(read(&mut slave, 0x2011, 2), [0, 0, 0x82, 0]);
}

/// 1 km of cable, and then some, on the bus of the SYNC; 1 ms less on the other one.
///
/// Verifies: ECSS 7.2.3c, 7.2.3k, 7.2.3i
/// Notices: ECSS 7.2.3k: the delay of the nominal bus corrects SYNCs of both.
#[test]
fn stamps_are_corrected_by_the_delay_of_their_bus() {
    for (bus, delays) in [(NOMINAL, [5_150_i32, -1_000_000]), (REDUNDANT, [-1_000_000, 5_150])] {
        let mut slave = operational::<Keeper>();
        for (sub, delay) in (1..).zip(delays) {
            assert_eq!(write(&mut slave, 0x2014, sub, &delay.to_le_bytes()), done(0x2014, sub));
        }
        run(&mut slave, ms(10));
        slave.receive(bus, 0x701, &[5]);
        // 5.15 us are 1318.4 units of 2^-8 us.
        let stamp = Stamp::captured(FineInstant::from_units(10_000 * 256 + 1_318));
        slave.link(bus, LinkEvent::Received { frame: frame(0x080, &[]), stamp });
        slave.receive(bus, 0x181, &scet(1_000, 0).encode());
        assert_eq!(slave.node.scet(us(10_000)), scet(1_000, 0), "{bus:?}");
        assert_eq!(slave.node.scet(us(11_000)), scet(1_000, 16_777), "{bus:?}");
        // The local time at the SYNC a second later.
        for beat in 1..=10 {
            slave.run_until(ms(beat * 100));
            slave.receive(bus, 0x701, &[5]);
        }
        slave.run_until(us(1_010_006));
        slave.clear();
        let stamp = Stamp::captured(FineInstant::from_units(1_010_000 * 256 + 1_318));
        slave.link(bus, LinkEvent::Received { frame: frame(0x080, &[]), stamp });
        assert_eq!(slave.frames(), [(bus, frame(0x185, &scet(1_001, 0).encode()))], "{bus:?}");
    }
}

/// A producer with 8 bits: on average it cuts off half a unit of 2^-8 s, 1.95 ms, less half of one of 2^-24 s.
///
/// Verifies: ECSS 7.2.1a
#[test]
fn the_mean_of_what_the_producer_cuts_off_is_added() {
    let mut slave = operational::<Keeper>();
    assert_eq!(write(&mut slave, 0x2014, 3, &[8]), done(0x2014, 3));
    run(&mut slave, ms(10));
    sync(&mut slave);
    time(&mut slave, scet(1_000, 0x12_0000));
    assert!([0x12_7FFF, 0x12_8000].contains(&slave.node.scet(slave.now).fine()));
    assert_eq!(write(&mut slave, 0x2014, 3, &[25]), refused(0x2014, 3, 0x0609_0031));
}

/// Verifies: ECSS 6.1a
#[test]
fn the_quality_of_the_clock_is_there_to_read() {
    let mut slave = operational::<Keeper>();
    assert_eq!(read(&mut slave, 0x2015, 2), [0; 4], "never set");
    assert_eq!(read(&mut slave, 0x2015, 1), [0xFF; 4], "no bound");
    run(&mut slave, ms(10));
    sync(&mut slave);
    time(&mut slave, scet(1_000, 1));
    run(&mut slave, ms(510));
    assert_eq!(read(&mut slave, 0x2015, 2), [2, 0, 0, 0], "captured");
    assert_eq!(read(&mut slave, 0x2015, 3), 500_u32.to_le_bytes());
    assert_eq!(read(&mut slave, 0x2015, 5), [1, 0, 0, 0], "steps");
    let bound = u32::from_le_bytes(read(&mut slave, 0x2015, 1));
    assert!(bound < u32::MAX && bound > 10_000, "{bound} ns: the rate of its crystal is not known yet");
    assert_eq!(write(&mut slave, 0x2015, 2, &[0]), refused(0x2015, 2, 0x0601_0002));
}

/// Verifies: ECSS 6.2a, 6.9b
#[test]
fn the_quality_of_the_clock_travels_by_pdo() {
    let mut slave = operational::<Keeper>();
    // With each SYNC: source and steps.
    map_tpdo(&mut slave, 2, 1, &[0x2015_0208, 0x2015_0510]);
    sync(&mut slave);
    time(&mut slave, scet(1_000, 1));
    slave.clear();
    run(&mut slave, ms(20));
    sync(&mut slave);
    let quality = slave.sent.iter().find(|sent| sent.frame.id().raw() == 0x285).expect("TPDO 2");
    assert_eq!(quality.frame.data(), [2, 1, 0]);
}

/// Given no other TPDO, when the one of the quality is sent, then it has the values of this SYNC.
///
/// Verifies: ECSS 6.2a, 6.9b
#[test]
fn the_quality_of_the_clock_travels_alone() {
    let mut slave = operational::<Keeper>();
    write_all(&mut slave, &[(0x1800, 1, &[0x85, 1, 0, 0xC0]), (0x1A00, 0, &[0])]);
    map_tpdo(&mut slave, 2, 1, &[0x2015_0510]);
    sync(&mut slave);
    time(&mut slave, scet(1_000, 1));
    slave.clear();
    run(&mut slave, ms(20));
    sync(&mut slave);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x285, &[1, 0]))], "one step");
}

/// Given a client that wrote one part, when a PDO brings a time that is not used, then the other part sets nothing: the first one is
/// that of the PDO now.
///
/// Verifies: ECSS 7.1.2c, 7.2.3c
#[test]
fn time_of_a_pdo_that_is_not_used_ends_a_pair_begun() {
    let mut slave = operational::<Keeper>();
    assert_eq!(write(&mut slave, 0x2010, 1, &[7, 0, 0, 0]), done(0x2010, 1));
    // There was no SYNC.
    time(&mut slave, scet(50, 0));
    assert_eq!(write(&mut slave, 0x2010, 2, &[0, 0, 0]), done(0x2010, 2));
    assert_eq!(steps(&slave), []);
    assert_eq!(write(&mut slave, 0x2010, 1, &[8, 0, 0, 0]), done(0x2010, 1));
    assert_eq!(slave.node.scet(slave.now), scet(8, 0));
}

/// Given a client that read one part and wrote another, when the slave follows the master to the other bus, then the client goes on
/// there: what it reads is of one sample, and what it wrote is one step.
///
/// Verifies: ECSS 7.1.2b, 7.1.2c
/// Notices: ECSS 7.1.2b: a sample of Local SCET Get is written to Local SCET Set as well.
#[test]
fn parts_before_a_change_of_the_bus_belong_to_those_after() {
    let mut slave = operational::<Keeper>();
    run(&mut slave, ms(999));
    assert_eq!(write(&mut slave, 0x2010, 1, &[7, 0, 0, 0]), done(0x2010, 1));
    assert_eq!(read(&mut slave, 0x2011, 1), [0; 4]);
    slave.run_until(ms(1_001));
    slave.receive(REDUNDANT, 0x701, &[5]);
    assert_eq!(ask_on(&mut slave, REDUNDANT, [0x40, 0x11, 0x20, 2, 0, 0, 0, 0])[4..], [0x77, 0xBE, 0xFF, 0]);
    assert_eq!(write_on(&mut slave, REDUNDANT, 0x2010, 2, &[0, 0, 0]), done(0x2010, 2));
    assert_eq!(slave.node.scet(slave.now), scet(7, 0));
}

/// Given a clock 16 ns before its first second, when a SYNC ends then, then the local time of that SYNC is rounded up to the second.
///
/// Verifies: ECSS 7.1.2e, 7.2.3k
/// Notices: ECSS 7.1.1a: a fine time that is rounded up does not carry into the seconds.
#[test]
fn time_just_before_a_second_is_rounded_to_that_second() {
    let mut slave = operational::<Keeper>();
    run(&mut slave, ms(1_000));
    slave.clear();
    // 4 units of 2^-8 us are 0.26 units of 2^-24 s.
    sync_at(&mut slave, 256_000_000 - 4);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &[0, 0, 0, 1, 0, 0, 0]))]);
}

/// Given a client that reads and writes three bytes at sub-index 2 of each object of 2000h to 20FFh, then Local SCET Set and Local SCET Get
/// alone have a fine time, and Local SCET Set alone takes one.
///
/// Verifies: ECSS 7.1.2b, 7.1.2e
/// Notices: ECSS 7.1.2b: a node has Local SCET Set at a second index.
#[test]
fn one_object_is_set_and_one_is_got() {
    let mut slave = operational::<Keeper>();
    let (mut set, mut got) = (vec![], vec![]);
    for index in 0x2000..=0x20FF_u16 {
        let next = slave.now + Duration::from_millis(10);
        run(&mut slave, next);
        let [low, high] = index.to_le_bytes();
        if ask(&mut slave, [0x40, low, high, 2, 0, 0, 0, 0])[0] == 0x47 {
            got.push(index);
        }
        if write(&mut slave, index, 2, &[0; 3]) == done(index, 2) {
            set.push(index);
        }
    }
    assert_eq!((set, got), (vec![0x2010], vec![0x2010, 0x2011]));
}
