//! 2012h and 2013h, with the clock behind them.
//!
//! Verifies: ECSS 7.1.1c, 7.1.1d, 7.1.3a

use ecss_can::types::Utc;

use super::devices::{Node, Universal, operational};
use super::{run, scet, sync, us};
use crate::bench::{NOMINAL, frame, ms};
use crate::device::fixture::{ask, done, read, refused, write};

fn utc(day: u16, ms: u32, micros: u16) -> Utc {
    Utc::new(day, ms, micros).unwrap()
}

fn time<const MICROS: bool>(slave: &mut Node<Universal<MICROS>>, time: Utc) {
    slave.receive(NOMINAL, 0x181, &time.encode());
}

/// 3 s after power-on: day 100, 3000 ms.
///
/// Verifies: ECSS 7.1.1b, 7.1.3c
/// Notices: ECSS 7.1.1b: a read of UTC by a client takes no sample.
/// Notices: ECSS 7.1.3a: Local UTC Get is missing at 2013h.
/// Notices: ECSS 7.1.3c: sub-index 3 of UTC takes no sample.
#[test]
fn all_sub_indices_are_of_one_sample() {
    let mut slave = operational::<Universal<true>>();
    run(&mut slave, us(2_999_998));
    assert_eq!(read(&mut slave, 0x2013, 3), 998_u32.to_le_bytes());
    run(&mut slave, ms(3_500));
    assert_eq!(read(&mut slave, 0x2013, 2), 2_999_u32.to_le_bytes());
    assert_eq!(read(&mut slave, 0x2013, 1), [100, 0, 0, 0]);
    assert_eq!(read(&mut slave, 0x2013, 2), 3_500_u32.to_le_bytes());
}

/// Verifies: ECSS 7.1.3b, 7.1.3c
/// Notices: ECSS 7.1.3c: the day that is read is that of the relation.
#[test]
fn three_writes_are_one_step_of_both_clocks() {
    let mut slave = operational::<Universal<true>>();
    run(&mut slave, ms(1_000));
    let parts: [(u8, &[u8]); 3] = [(3, &[0xE7, 3]), (1, &[101, 0]), (2, &[0xE8, 3, 0, 0])];
    for (sub, value) in parts {
        assert_eq!(slave.node.scet(slave.now), scet(1, 0), "before {sub}");
        assert_eq!(write(&mut slave, 0x2012, sub, value), done(0x2012, sub));
    }
    // A day and 1.000999 s: 0.000999 x 2^24 = 16,760.4.
    assert_eq!(slave.node.scet(slave.now), scet(86_401, 16_760));
    assert_eq!(read(&mut slave, 0x2013, 1), [101, 0, 0, 0]);
}

/// Given values beyond a day with a leap second or beyond a millisecond, then they are refused. The last ones below are
/// taken.
///
/// Verifies: ECSS 7.1.1b, 7.1.3b, 7.1.3d, 6.1a
/// Notices: ECSS 7.1.1c: no time within a leap second can be written.
/// Notices: ECSS 7.1.3b: 1000 submilliseconds are taken, and set nothing.
/// Notices: ECSS 7.1.1b: a time within a leap second is written, and sets nothing.
#[test]
fn what_no_day_and_no_millisecond_has_is_refused() {
    let mut slave = operational::<Universal<true>>();
    let most = 86_401_000_u32.to_le_bytes();
    assert_eq!(write(&mut slave, 0x2012, 2, &most), refused(0x2012, 2, 0x0609_0031));
    assert_eq!(write(&mut slave, 0x2012, 3, &[0xE8, 3]), refused(0x2012, 3, 0x0609_0031));
    // 86,400,999 ms and 999 us.
    assert_eq!(write(&mut slave, 0x2012, 2, &86_400_999_u32.to_le_bytes()), done(0x2012, 2));
    assert_eq!(write(&mut slave, 0x2012, 3, &[0xE7, 3]), done(0x2012, 3));
    assert_eq!(write(&mut slave, 0x2012, 1, &[100, 0]), done(0x2012, 1));
    // 86,400.999999 s after 0:00 of day 100: 0.999999 x 2^24 = 16,777,199.2.
    assert_eq!(slave.node.scet(slave.now), scet(86_400, 16_777_199));
}

/// Verifies: ECSS 7.1.3e, 7.2.2c, 7.2.2e, 7.2.3g, 7.2.3h
#[test]
fn utc_comes_and_goes_by_pdos() {
    let mut slave = operational::<Universal<true>>();
    run(&mut slave, ms(50));
    sync(&mut slave);
    run(&mut slave, ms(51));
    time(&mut slave, utc(110, 5, 250));
    run(&mut slave, ms(1_050));
    slave.clear();
    sync(&mut slave);
    // A second later: microseconds, milliseconds, days.
    let expected = utc(110, 1_005, 250).encode();
    assert_eq!(expected, [250, 0, 0xED, 3, 0, 0, 110, 0]);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &expected))]);
}

/// Given a frame of Figure 7-2 with day 110, 43,200,123 ms and 250 us, when it sets the clock of a node, then a client reads these parts, each in
/// its size, and the node sends them in a frame that is the same. A client that writes the parts sets them alike.
///
/// Verifies: ECSS 7.1.3b, 7.1.3c, 7.1.3d, 7.1.3e
/// Notices: ECSS 7.1.3d: of the milliseconds of a day 16 bits are got.
/// Notices: ECSS 7.1.3e: day and submilliseconds of Local UTC Get are exchanged.
#[test]
fn frame_of_figure_7_2_is_set_and_got_in_a_node() {
    const FRAME: [u8; 8] = [250, 0, 0x7B, 0x2E, 0x93, 0x02, 110, 0];
    for by_client in [false, true] {
        let mut slave = operational::<Universal<true>>();
        run(&mut slave, ms(50));
        sync(&mut slave);
        if by_client {
            for (sub, value) in [(1, &[110, 0][..]), (2, &[0x7B, 0x2E, 0x93, 0x02]), (3, &[250, 0])] {
                assert_eq!(write(&mut slave, 0x2012, sub, value), done(0x2012, sub));
            }
        } else {
            slave.receive(NOMINAL, 0x181, &FRAME);
        }
        for answer in [
            [0x4B, 0x13, 0x20, 1, 110, 0, 0, 0],
            [0x43, 0x13, 0x20, 2, 0x7B, 0x2E, 0x93, 0x02],
            [0x4B, 0x13, 0x20, 3, 250, 0, 0, 0],
        ] {
            let sub = answer[3];
            assert_eq!(ask(&mut slave, [0x40, 0x13, 0x20, sub, 0, 0, 0, 0]), answer, "client: {by_client}");
        }
        slave.clear();
        sync(&mut slave);
        assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &FRAME))], "client: {by_client}");
    }
}

/// Twenty years from the time of the relation, as the first time that arrives.
///
/// Verifies: ECSS 7.1.1b, 7.1.3e, 7.2.3f, 7.1.3b, 7.1.3c
/// Notices: ECSS 7.1.1d: a UTC that a PDO brings is read as SCET.
/// Notices: ECSS 7.2.3f: UTC in a synchronous PDO waits for the next SYNC and sets no clock.
/// Notices: ECSS 7.1.1b: UTC in a PDO is not sampled.
/// Notices: ECSS 7.1.1b: UTC that is set loses its submilliseconds.
#[test]
fn utc_is_right_far_from_the_relation() {
    let mut slave = operational::<Universal<true>>();
    run(&mut slave, ms(50));
    sync(&mut slave);
    time(&mut slave, utc(7_405, 43_200_123, 456));
    run(&mut slave, ms(1_050));
    slave.clear();
    sync(&mut slave);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &utc(7_405, 43_201_123, 456).encode()))]);
}

/// Without submilliseconds the mean of what is cut off, 499.5 us, is added to what arrives.
///
/// Verifies: ECSS 7.1.3f, 7.1.3g
/// Notices: ECSS 7.1.3f: a device without submilliseconds sends those of its clock.
/// Notices: ECSS 7.1.3g: submilliseconds above zero set the clock of a device without them.
#[test]
fn device_without_submilliseconds_sends_zero_and_ignores_them() {
    let mut slave = operational::<Universal<false>>();
    run(&mut slave, ms(50));
    sync(&mut slave);
    time(&mut slave, utc(100, 1_000, 777));
    assert_eq!(slave.node.scet(ms(50)), scet(1, 8_380));
    run(&mut slave, us(1_050_900));
    slave.clear();
    sync(&mut slave);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &[0, 0, 0xD1, 7, 0, 0, 100, 0]))], "2001 ms");
}

/// Given a device without submilliseconds, when a client or a PDO brings any number in that field, then the clock is set as if the
/// field were not there.
///
/// Verifies: ECSS 7.1.3g, 7.1.3b
/// Notices: ECSS 7.1.3g: a device without submilliseconds refuses 1000 or more of them.
#[test]
fn submilliseconds_a_device_lacks_may_have_any_value() {
    for [low, high] in [999_u16, 1_000, u16::MAX].map(u16::to_le_bytes) {
        let mut slave = operational::<Universal<false>>();
        let parts: [(u8, &[u8]); 3] = [(3, &[low, high]), (1, &[100, 0]), (2, &[0xE8, 3, 0, 0])];
        for (sub, value) in parts {
            assert_eq!(write(&mut slave, 0x2012, sub, value), done(0x2012, sub));
        }
        // 1000 ms, and the mean of what is cut off.
        assert_eq!(slave.node.scet(slave.now), scet(1, 8_380));

        let mut slave = operational::<Universal<false>>();
        run(&mut slave, ms(50));
        sync(&mut slave);
        slave.receive(NOMINAL, 0x181, &[low, high, 0xE8, 3, 0, 0, 100, 0]);
        assert_eq!(slave.node.scet(ms(50)), scet(1, 8_380));
        assert_eq!(slave.node.status(slave.now).counters.nominal.malformed, 0);
    }
}

/// Given a device without submilliseconds and SYNCs that are captured, when the lowest bits of that field are zero in each time, or in
/// none, then the clock is as good: the bits do not say how the producer stamps.
///
/// Verifies: ECSS 7.1.3g
/// Notices: ECSS 7.1.3g: a device without submilliseconds takes zeros in their place for a producer without capture.
#[test]
fn submilliseconds_a_device_lacks_leave_the_quality_alone() {
    for micros in [0, 8, 777] {
        let mut slave = operational::<Universal<false>>();
        for second in 1..=8 {
            run(&mut slave, ms(1_000 * second));
            sync(&mut slave);
            time(&mut slave, utc(100, 1_000 * second as u32, micros));
        }
        assert_eq!(read(&mut slave, 0x2015, 2), [2, 0, 0, 0], "{micros} us");
    }
}

/// Given a device with submilliseconds, when a PDO brings 1000 of them, then its clock stays as it is, and the frame counts as malformed.
///
/// Verifies: ECSS 7.1.3d
/// Notices: ECSS 7.1.3d: a PDO with 1000 submilliseconds sets the clock.
#[test]
fn pdo_with_1000_submilliseconds_sets_no_clock() {
    let mut slave = operational::<Universal<true>>();
    run(&mut slave, ms(50));
    sync(&mut slave);
    let before = slave.node.scet(slave.now);
    slave.receive(NOMINAL, 0x181, &[0xE8, 3, 0xE8, 3, 0, 0, 100, 0]);
    assert_eq!(slave.node.scet(slave.now), before);
    assert_eq!(slave.node.status(slave.now).counters.nominal.malformed, 1);
}

/// Given a device without submilliseconds, when 50.9 ms have passed, then a client reads none, and a SYNC that is stamped in the
/// interrupt brings none.
///
/// Verifies: ECSS 7.1.3f, 7.1.3c
/// Notices: ECSS 7.1.3f: a client reads submilliseconds that the device does not have.
/// Notices: ECSS 7.1.3f: without capture the device sends submilliseconds.
#[test]
fn device_without_submilliseconds_has_none_for_a_client_and_without_capture() {
    let mut slave = operational::<Universal<false>>();
    run(&mut slave, us(50_900));
    assert_eq!(read(&mut slave, 0x2013, 3), [0; 4]);
    assert_eq!(read(&mut slave, 0x2013, 2), [50, 0, 0, 0]);
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &[0, 0, 50, 0, 0, 0, 100, 0]))]);
}

/// 0.999 s after power-on, of which the fine time is 0.999 x 2^24 = 16,760,438.8; parts of 2011h and 2013h.
const SAMPLE: [(u16, u8, u32); 5] =
    [(0x2011, 1, 0), (0x2011, 2, 16_760_439), (0x2013, 1, 100), (0x2013, 2, 999), (0x2013, 3, 0)];

/// What a client reads.
fn part(slave: &mut Node<Universal<true>>, index: u16, sub: u8) -> u32 {
    u32::from_le_bytes(read(slave, index, sub))
}

/// Given a client that reads the parts of a time in any order, when it reads sub-index 0, asks for what is not there, or sends a
/// request that is too short before each of them, then all parts are of one sample.
///
/// Verifies: ECSS 7.1.2d, 7.1.3c, 6.1a
/// Notices: ECSS 6.1a: a read of a sub-index that is not there has an abort code other than 0609 0011h.
#[test]
fn parts_of_a_time_are_of_one_sample_despite_other_reads() {
    let orders: [(u16, &[u8]); 5] = [
        (0x2011, &[1, 2]),
        (0x2011, &[2, 1]),
        (0x2013, &[1, 2, 3]),
        (0x2013, &[3, 1, 2]),
        (0x2013, &[2, 3, 1]),
    ];
    for (index, order) in orders {
        let mut slave = operational::<Universal<true>>();
        for (nth, sub) in (0..).zip(order) {
            run(&mut slave, ms(999 + nth));
            let [low, high] = index.to_le_bytes();
            let count = order.len() as u8;
            assert_eq!(read(&mut slave, index, 0), [count, 0, 0, 0]);
            for none in [count + 1, 8, 8 + sub, 16 + sub, 0xFF] {
                let answer = ask(&mut slave, [0x40, low, high, none, 0, 0, 0, 0]);
                assert_eq!(answer, refused(index, none, 0x0609_0011));
            }
            slave.receive(NOMINAL, 0x605, &[0x40, low, high, *sub]);
            // Sub-index 0 by a block upload of a client that accepts an expedited answer.
            assert_eq!(ask(&mut slave, [0xA0, low, high, 0, 1, 4, 0, 0])[..5], [0x4F, low, high, 0, count]);
            let (_, _, value) = SAMPLE.into_iter().find(|(at, part, _)| (*at, part) == (index, sub)).unwrap();
            assert_eq!(part(&mut slave, index, *sub), value, "{index:04X}h sub {sub} of {order:?}");
        }
        // Each part was read: the next one is of a new sample. 1001 ms, or 1002 ms.
        let after = [(0x2011, 1, 1), (0x2013, 2, 1_002)].into_iter().find(|(at, _, _)| *at == index).unwrap();
        run(&mut slave, ms(1_002));
        assert_eq!(part(&mut slave, after.0, after.1), after.2, "{index:04X}h");
    }
}

/// Given a client that reads SCET and UTC in turns, then the parts of each are of one sample.
///
/// Verifies: ECSS 7.1.2a, 7.1.2b, 7.1.2d, 7.1.3c
/// Notices: ECSS 7.1.2a: a device with UTC takes no sample of its SCET.
/// Notices: ECSS 7.1.2b: Local SCET Get of a device with UTC stays zero.
#[test]
fn scet_and_utc_read_in_turns_are_whole() {
    let mut slave = operational::<Universal<true>>();
    run(&mut slave, ms(999));
    assert_eq!(part(&mut slave, 0x2011, 1), 0);
    assert_eq!(part(&mut slave, 0x2013, 2), 999);
    run(&mut slave, ms(1_001));
    assert_eq!(part(&mut slave, 0x2011, 2), 16_760_439);
    assert_eq!(part(&mut slave, 0x2013, 1), 100);
    assert_eq!(part(&mut slave, 0x2011, 1), 1, "a new sample");
    assert_eq!(part(&mut slave, 0x2013, 3), 0);
}

/// Given a client that writes SCET and UTC in turns, then each is one step, with its own parts.
///
/// Verifies: ECSS 7.1.1b, 7.1.2a, 7.1.2b, 7.1.2c, 7.1.3b
/// Notices: ECSS 7.1.1b: UTC has the number of parts of SCET: the clock is set without the submilliseconds.
/// Notices: ECSS 7.1.3b: two of three parts of UTC set the clock.
/// Notices: ECSS 7.1.2b: parts of SCET and UTC are counted as one.
/// Notices: ECSS 7.1.2a: a device with UTC does not take Local SCET Set.
#[test]
fn scet_and_utc_written_in_turns_are_whole() {
    let mut slave = operational::<Universal<true>>();
    let parts: [(u16, u8, &[u8]); 5] = [
        (0x2010, 1, &[7, 0, 0, 0]),
        (0x2012, 1, &[100, 0]),
        (0x2012, 2, &[0xE8, 3, 0, 0]),
        (0x2010, 2, &[0, 0, 0x80]),
        (0x2012, 3, &[0, 0]),
    ];
    let times = [scet(0, 0), scet(0, 0), scet(0, 0), scet(7, 0x80_0000), scet(1, 0)];
    for ((index, sub, value), after) in parts.into_iter().zip(times) {
        assert_eq!(write(&mut slave, index, sub, value), done(index, sub));
        assert_eq!(slave.node.scet(slave.now), after, "{index:04X}h sub {sub}");
    }
}

/// Given a client that asks by block upload and accepts an expedited answer, when it reads the milliseconds at 999 ms and the day and the
/// submilliseconds later, then all are of 999 ms.
///
/// Verifies: ECSS 7.1.3c, 6.1a
/// Notices: ECSS 7.1.3c: a read of UTC by block upload takes no sample.
#[test]
fn utc_read_by_block_upload_is_of_one_sample() {
    let mut slave = operational::<Universal<true>>();
    run(&mut slave, us(999_007));
    let ask = |slave: &mut _, sub| ask(slave, [0xA0, 0x13, 0x20, sub, 1, 4, 0, 0]);
    assert_eq!(ask(&mut slave, 2), [0x43, 0x13, 0x20, 2, 0xE7, 3, 0, 0]);
    run(&mut slave, ms(1_001));
    assert_eq!(ask(&mut slave, 1), [0x4B, 0x13, 0x20, 1, 100, 0, 0, 0]);
    assert_eq!(ask(&mut slave, 3), [0x4B, 0x13, 0x20, 3, 7, 0, 0, 0]);
}

/// Given a device with submilliseconds, when its SYNC is stamped in the interrupt 50.9 ms after power-on, then its Local Time PDO has UTC
/// to the nearest multiple of eight microseconds: 900 us are 904. From 996 us on that is the next millisecond, not 1000 us.
///
/// Verifies: ECSS 7.1.3c, 7.1.1b, 7.1.3d, 7.1.3e, 7.2.2f
/// Notices: ECSS 7.1.3a: Local UTC Get is not sampled at a SYNC without capture.
/// Notices: ECSS 7.2.2f: a Local Time PDO with UTC has an old time.
/// Notices: ECSS 7.1.3d: the submilliseconds alone are rounded, to 1000.
#[test]
fn utc_goes_by_pdo_without_capture() {
    // 904 us are 388h, 992 us are 3E0h.
    let cases = [(900, [0x88, 3, 50]), (995, [0xE0, 3, 50]), (996, [0, 0, 51]), (999, [0, 0, 51])];
    for (micros, [low, high, millis]) in cases {
        let mut slave = operational::<Universal<true>>();
        run(&mut slave, us(50_000 + micros));
        slave.clear();
        slave.receive(NOMINAL, 0x080, &[]);
        let expected = frame(0x185, &[low, high, millis, 0, 0, 0, 100, 0]);
        assert_eq!(slave.frames(), [(NOMINAL, expected)], "{micros} us");
    }
}

/// Given a clock that follows UTC, when the spacecraft time is set ten days ahead, then the clock follows at the third time.
///
/// Verifies: ECSS 7.1.3b, 7.1.1b
/// Notices: ECSS 7.1.1d: a device with UTC follows the first spacecraft time alone.
/// Notices: ECSS 7.1.3b: UTC by PDO sets the clock once.
#[test]
fn utc_that_is_set_anew_is_followed_at_the_third_time() {
    let mut slave = operational::<Universal<true>>();
    for (nth, day) in (1..).zip([100, 100, 110, 110, 110]) {
        run(&mut slave, ms(100 * nth));
        sync(&mut slave);
        time(&mut slave, utc(day, 100 * nth as u32, 0));
    }
    // Ten days and half a second.
    assert_eq!(slave.node.scet(slave.now), scet(864_000, 0x80_0000));
}
