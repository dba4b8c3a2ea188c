//! The Spacecraft Time PDO at a consumer, and its Local Time PDO.
//!
//! Verifies: ECSS 7.2.1a, 7.2.3c

use ecss_can::link::Stamp;
use ecss_can::node::extend::LinkEvent;
use ecss_can::node::{Node as _, SlaveEvent};
use ecss_can::time::Step;
use ecss_can::types::{Duration, Scet};

use super::devices::{Coarse, Keeper, Node, operational};
use super::{run, scet, sync, time, us};
use crate::bench::{NOMINAL, REDUNDANT, frame, ms};
use crate::device::fixture::{done, map_tpdo, read, write, write_all};

/// How far the clock is from `scet` at the present, microseconds.
fn off(slave: &Node<Keeper>, truth: Scet) -> i64 {
    slave.node.scet(slave.now).micros_since(truth)
}

fn late(slave: &mut Node<Keeper>) -> [u8; 4] {
    read(slave, 0x2015, 6)
}

fn has_stepped(slave: &Node<Keeper>) -> bool {
    slave.events.iter().any(|event| matches!(event, SlaveEvent::Step(_)))
}

/// A SYNC every 100 ms up to and with that at `last`, and 300 us later its time: SYNC at 100 ms was 1000.1 s.
fn follow(slave: &mut Node<Keeper>, last: u64) {
    let first = slave.now.as_micros() / 100_000 + 1;
    for nth in first..=last / 100 {
        run(slave, us(nth * 100_000));
        sync(slave);
        run(slave, us(nth * 100_000 + 300));
        time(slave, at(nth * 100));
    }
}

/// The spacecraft time of a local instant, milliseconds.
fn at(ms: u64) -> Scet {
    scet(1_000, 0).plus(crate::bench::span(ms))
}

/// The same in microseconds.
fn at_us(us: u64) -> Scet {
    scet(1_000, 0).plus(Duration::from_micros(us))
}

/// The PDO of the time with the parameters at `index` gets this transmission type: 1400h is the spacecraft time, 1800h the local one.
fn set_transmission(slave: &mut Node<Keeper>, index: u16, transmission: u8) {
    let id = if index == 0x1400 { 0x81 } else { 0x85 };
    let steps: [(u16, u8, &[u8]); 3] =
        [(index, 1, &[id, 1, 0, 0xC0]), (index, 2, &[transmission]), (index, 1, &[id, 1, 0, 0x40])];
    write_all(slave, &steps);
}

/// The value holds for the SYNC before it, and takes effect when it arrives: not at the SYNC after it.
///
/// Verifies: ECSS 7.2.2c, 7.2.3f, 7.2.3g
/// Notices: ECSS 7.2.3c: the value is taken for the time of its arrival.
/// Notices: ECSS 7.2.3f: a time of types 2 to 240 waits for the next SYNC.
#[test]
fn a_synchronous_time_is_that_of_the_last_sync() {
    for transmission in [1, 2, 240] {
        let mut slave = operational::<Keeper>();
        set_transmission(&mut slave, 0x1400, transmission);
        slave.clear();
        run(&mut slave, ms(50));
        sync(&mut slave);
        run(&mut slave, ms(52));
        time(&mut slave, scet(1_000, 0));
        // 2 ms x 2^24 = 33,554.4.
        assert_eq!(slave.node.scet(slave.now), scet(1_000, 33_554), "type {transmission}");
        let step = Step { from: scet(0, 838_861), to: scet(1_000, 0) };
        assert_eq!(slave.events[1..], [SlaveEvent::Time(scet(1_000, 0)), SlaveEvent::Step(step)]);
    }
}

/// Given a client that writes an object of SYNC, when a SYNC and 2 ms later its time follow, then the clock is set to the time of that
/// SYNC.
///
/// Notices: ECSS 7.2.3c: after a write to an object of SYNC the ends of SYNCs are not noted.
#[test]
fn time_holds_at_the_sync_after_a_write_to_its_objects() {
    let writes: [(u16, &[u8]); 3] = [(0x1005, &[0x80, 0, 0, 0]), (0x1007, &[0; 4]), (0x1019, &[0])];
    for (index, value) in writes {
        let mut slave = operational::<Keeper>();
        assert_eq!(write(&mut slave, index, 0, value), done(index, 0));
        run(&mut slave, ms(50));
        sync(&mut slave);
        run(&mut slave, ms(52));
        time(&mut slave, scet(1_000, 0));
        // 2 ms x 2^24 = 33,554.4.
        assert_eq!(slave.node.scet(slave.now), scet(1_000, 33_554), "{index:04X}h");
    }
}

/// Given a slave in Operational, when a client gives the spacecraft time of type 1 to its second RPDO, behind or before another object, and
/// the frame comes 2 ms after a SYNC, then the clock is set to the time of that SYNC. The first RPDO has type 255.
///
/// Verifies: ECSS 7.2.2c, 7.2.3g, 6.2a
/// Notices: ECSS 7.2.2c: Local SCET Set that a client maps sets no clock until the next boot.
/// Notices: ECSS 7.2.3g: a time is taken only if it is mapped last.
/// Notices: ECSS 7.2.3g: the transmission type of RPDO 1 holds for the time in another RPDO.
/// Notices: ECSS 7.2.3g: a time is taken only if it is mapped first.
#[test]
fn the_spacecraft_time_may_be_another_pdo_of_the_slave() {
    // Object 0005h is a dummy of 8 bits.
    let time = [0x2010_0218_u32, 0x2010_0120];
    let behind = [time[0], time[1], 0x0005_0008];
    let before = [0x0005_0008, time[0], time[1]];
    let frames = [(behind, [0, 0, 0, 0xE8, 3, 0, 0, 9]), (before, [9, 0, 0, 0, 0xE8, 3, 0, 0])];
    for (objects, data) in frames {
        let mut slave = operational::<Keeper>();
        let objects = objects.map(u32::to_le_bytes);
        let steps: [(u16, u8, &[u8]); 11] = [
            (0x1400, 1, &[0x81, 1, 0, 0xC0]),
            (0x1400, 2, &[255]),
            (0x1401, 1, &[0x05, 3, 0, 0xC0]),
            (0x1601, 0, &[0]),
            (0x1601, 1, &objects[0]),
            (0x1601, 2, &objects[1]),
            (0x1601, 3, &objects[2]),
            (0x1601, 0, &[3]),
            (0x1401, 2, &[1]),
            (0x1401, 1, &[0x81, 1, 0, 0xC0]),
            (0x1401, 1, &[0x81, 1, 0, 0x40]),
        ];
        write_all(&mut slave, &steps);
        run(&mut slave, ms(50));
        sync(&mut slave);
        run(&mut slave, ms(52));
        slave.receive(NOMINAL, 0x181, &data);
        // 2 ms x 2^24 = 33,554.4.
        assert_eq!(slave.node.scet(slave.now), scet(1_000, 33_554), "{data:02X?}");
    }
}

#[test]
fn a_time_without_a_sync_before_it_is_of_no_use() {
    let mut slave = operational::<Keeper>();
    run(&mut slave, ms(50));
    time(&mut slave, scet(1_000, 0));
    assert_eq!(slave.node.scet(ms(50)), scet(0, 838_861));
    assert_eq!(late(&mut slave), [1, 0, 0, 0]);
    // Nor is a SYNC before Operational was left: others may have come since.
    sync(&mut slave);
    slave.receive(NOMINAL, 0x000, &[0x80, 5]);
    slave.receive(NOMINAL, 0x000, &[0x01, 5]);
    time(&mut slave, scet(1_000, 0));
    assert_eq!(late(&mut slave), [2, 0, 0, 0]);
}

/// A SYNC has no byte, or its counter: what is longer has no time and needs no stamp.
///
/// Verifies: ECSS 6.3b
/// Notices: ECSS 6.3b: a SYNC of two bytes counts as a SYNC.
#[test]
fn a_sync_of_wrong_length_has_no_time() {
    let mut slave = operational::<Keeper>();
    run(&mut slave, ms(50));
    sync(&mut slave);
    run(&mut slave, ms(60));
    slave.receive(NOMINAL, 0x080, &[1, 2]);
    time(&mut slave, scet(1_000, 0));
    // 10 ms x 2^24 = 167,772.2.
    assert_eq!(slave.node.scet(slave.now), scet(1_000, 167_772));
    let stamped = [(0x080, &[][..]), (0x080, &[1]), (0x080, &[1, 2]), (0x181, &[0; 7]), (0x701, &[5])];
    let is_stamped = |bus| stamped.map(|(id, data)| slave.node.is_stamped(bus, &frame(id, data)));
    assert_eq!(is_stamped(NOMINAL), [true, true, false, false, false]);
    assert_eq!(is_stamped(REDUNDANT), [false; 5], "it is not the active bus");
}

/// Given a slave whose SYNC has another COB-ID, then that one is stamped, and 080h is not.
///
/// Verifies: ECSS 6.3b, 6.10a, 6.10c
/// Notices: ECSS 6.10c: SYNC is stamped by 080h after another COB-ID was written.
#[test]
fn sync_is_stamped_by_its_present_cob_id() {
    let mut slave = operational::<Keeper>();
    assert_eq!(write(&mut slave, 0x1005, 0, &[0xC5, 2, 0, 0]), done(0x1005, 0));
    let frames = [(0x2C5, &[][..]), (0x2C5, &[1]), (0x2C5, &[1, 2]), (0x080, &[]), (0x181, &[0; 7])];
    let is_stamped = |bus| frames.map(|(id, data)| slave.node.is_stamped(bus, &frame(id, data)));
    assert_eq!(is_stamped(NOMINAL), [true, true, false, false, false]);
    assert_eq!(is_stamped(REDUNDANT), [false; 5]);
}

#[test]
fn a_time_that_comes_after_the_next_sync_is_not_paired_with_it() {
    let mut slave = operational::<Keeper>();
    follow(&mut slave, 1_000);
    slave.clear();
    run(&mut slave, ms(1_100));
    sync(&mut slave);
    run(&mut slave, ms(1_200));
    sync(&mut slave);
    time(&mut slave, at(1_100));
    assert!(off(&slave, at(1_200)).abs() < 50, "{} us", off(&slave, at(1_200)));
    assert_eq!(late(&mut slave), [1, 0, 0, 0]);
    assert!(!has_stepped(&slave));
    // Its own still comes, and is taken.
    slave.clear();
    time(&mut slave, at(1_200));
    assert!(slave.events.contains(&SlaveEvent::Time(at(1_200))));
}

/// Its time would be paired with the SYNC before.
#[test]
fn the_time_of_a_sync_that_was_not_heard_moves_nothing() {
    let mut slave = operational::<Keeper>();
    follow(&mut slave, 1_000);
    slave.clear();
    run(&mut slave, us(1_100_300));
    time(&mut slave, at(1_100));
    assert!(off(&slave, at(1_100)).abs() < 400);
    assert!(!has_stepped(&slave));
    assert_eq!(late(&mut slave), [1, 0, 0, 0]);
    follow(&mut slave, 2_000);
    assert!(!has_stepped(&slave));
}

/// Verifies: ECSS 7.2.3f
#[test]
fn time_set_anew_is_followed_by_one_step_at_the_third_time() {
    let mut slave = operational::<Keeper>();
    follow(&mut slave, 1_000);
    slave.clear();
    for (nth, ms) in [(1, 1_100_u64), (2, 1_200), (3, 1_300), (4, 1_400)] {
        run(&mut slave, us(ms * 1_000));
        sync(&mut slave);
        run(&mut slave, us(ms * 1_000 + 300));
        time(&mut slave, scet(77_000, 0).plus(crate::bench::span(ms)));
        assert_eq!(has_stepped(&slave), nth > 2);
    }
    let steps = slave.events.iter().filter(|event| matches!(event, SlaveEvent::Step(_)));
    assert_eq!(steps.count(), 1);
    assert!(off(&slave, scet(77_001, 0).plus(crate::bench::span(400))).abs() < 400);
}

/// 3 ms, below the limit of a step: refused, counted and not reported as a time that is followed.
#[test]
fn disagreeing_time_is_counted_and_moves_nothing() {
    let mut slave = operational::<Keeper>();
    follow(&mut slave, 1_000);
    slave.clear();
    run(&mut slave, ms(1_100));
    sync(&mut slave);
    time(&mut slave, at(1_103));
    assert!(off(&slave, at(1_100)).abs() < 50, "{} us", off(&slave, at(1_100)));
    assert_eq!(read(&mut slave, 0x2015, 7), [1, 0, 0, 0]);
    assert_eq!(late(&mut slave), [0; 4]);
    let is_time = |event: &SlaveEvent| matches!(event, SlaveEvent::Time(_) | SlaveEvent::Step(_));
    assert!(!slave.events.iter().any(is_time), "{:?}", slave.events);
    // The bound says that it may be the clock that is wrong.
    assert!(u32::from_le_bytes(read(&mut slave, 0x2015, 1)) > 3_000_000);
    follow(&mut slave, 1_200);
    assert!(slave.events.contains(&SlaveEvent::Time(at(1_200))));
    assert_eq!(read(&mut slave, 0x2015, 7), [1, 0, 0, 0]);
}

/// By exactly a SYNC period: the first three look late, the next three agree.
#[test]
fn time_set_back_by_a_sync_period_is_followed_at_the_sixth_time() {
    let mut slave = operational::<Keeper>();
    follow(&mut slave, 1_000);
    slave.clear();
    for (nth, ms) in (1..).zip((1_100_u64..=1_600).step_by(100)) {
        run(&mut slave, us(ms * 1_000));
        sync(&mut slave);
        time(&mut slave, at(ms - 100));
        assert_eq!(has_stepped(&slave), nth == 6, "{ms} ms");
    }
}

/// Verifies: ECSS 7.2.2c
/// Notices: ECSS 7.2.1a: a time of type 255 is taken for that of the last SYNC.
/// Notices: ECSS 7.2.1a: a time of type 254 is taken for that of the last SYNC.
#[test]
fn a_time_of_type_254_or_255_holds_when_it_arrives() {
    for transmission in [254, 255] {
        let mut slave = operational::<Keeper>();
        set_transmission(&mut slave, 0x1400, transmission);
        run(&mut slave, ms(50));
        sync(&mut slave);
        run(&mut slave, ms(90));
        time(&mut slave, scet(1_000, 0));
        assert_eq!(slave.node.scet(slave.now), scet(1_000, 0), "type {transmission}");
        assert_eq!(read(&mut slave, 0x2015, 2), [4, 0, 0, 0], "type {transmission}");
    }
}

/// Verifies: ECSS 7.2.3h, 7.2.3i, 7.2.3k
#[test]
fn local_time_pdo_by_event_has_the_time_at_the_last_sync() {
    let mut slave = operational::<Keeper>();
    set_transmission(&mut slave, 0x1800, 254);
    run(&mut slave, ms(1_000));
    sync(&mut slave);
    run(&mut slave, ms(1_050));
    slave.clear();
    slave.touch(|slave, now| slave.send_pdo(0, now));
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &[0, 0, 0, 1, 0, 0, 0]))]);
}

/// Given a slave whose first TPDO is not in use, when a SYNC ends at 1.5 s, then its second TPDO has the local time of that instant.
///
/// Verifies: ECSS 7.2.2e, 7.2.3h, 7.2.3i, 7.2.2f, 7.2.3k
/// Notices: ECSS 7.2.3h: the local time is sampled only where TPDO 1 carries it.
/// Notices: ECSS 7.2.3i: the local time is sampled for TPDO 1 alone.
/// Notices: ECSS 7.2.2e: the local time is sampled for TPDO 1 alone.
#[test]
fn local_time_may_be_another_pdo_of_the_slave() {
    let mut slave = operational::<Keeper>();
    write_all(&mut slave, &[(0x1800, 1, &[0x85, 1, 0, 0xC0]), (0x1A00, 0, &[0])]);
    map_tpdo(&mut slave, 2, 1, &[0x2011_0218, 0x2011_0120]);
    run(&mut slave, ms(1_500));
    slave.clear();
    sync(&mut slave);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x285, &[0, 0, 0x80, 1, 0, 0, 0]))]);
}

/// Given a slave whose first TPDO goes with SYNC and carries another value, then its second TPDO goes with SYNC, too, and has the
/// local time.
///
/// Verifies: ECSS 7.2.2g, 7.2.3j, 6.9b, 7.2.3i
/// Notices: ECSS 7.2.2g: a slave sends the first TPDO that goes with SYNC alone, and so no Local Time PDO.
#[test]
fn local_time_goes_beside_another_pdo_with_sync() {
    let mut slave = operational::<Keeper>();
    write_all(&mut slave, &[(0x1800, 1, &[0x85, 1, 0, 0xC0]), (0x1A00, 0, &[0])]);
    // The source of the clock: never set.
    map_tpdo(&mut slave, 1, 1, &[0x2015_0208]);
    map_tpdo(&mut slave, 2, 1, &[0x2011_0218, 0x2011_0120]);
    run(&mut slave, ms(1_500));
    slave.clear();
    sync(&mut slave);
    let local_time = frame(0x285, &[0, 0, 0x80, 1, 0, 0, 0]);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &[0])), (NOMINAL, local_time)]);
}

/// Given a slave whose spacecraft time is not distributed by SYNC, when the application sends its local time, then that is the present
/// one.
///
/// Verifies: ECSS 7.2.2f, 7.2.2g
/// Notices: ECSS 7.2.1a: a device whose time comes by type 254 sends that of the last SYNC.
/// Notices: ECSS 7.2.2f: the local time is that of the last SYNC where the spacecraft time comes without SYNC.
/// Notices: ECSS 7.2.2f: there is no local time before the clock was set.
/// Notices: ECSS 7.2.2g: the local time by event is withheld until the clock has followed a spacecraft time.
#[test]
fn local_time_pdo_by_event_has_present_time_without_sync_times() {
    let mut slave = operational::<Keeper>();
    [0x1400, 0x1800].into_iter().for_each(|index| set_transmission(&mut slave, index, 254));
    run(&mut slave, ms(1_000));
    sync(&mut slave);
    run(&mut slave, ms(1_500));
    slave.clear();
    slave.touch(|slave, now| slave.send_pdo(0, now));
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &[0, 0, 0x80, 1, 0, 0, 0]))]);
}

/// Synchronous PDOs wait for half of the SYNC period where one of them has the time at the SYNC, else for all of it.
///
/// Verifies: ECSS 7.2.3i
/// Notices: ECSS 7.2.3i: PDOs of a slave whose 1006h is zero expire at once.
#[test]
fn time_at_a_sync_expires_before_it_could_be_that_of_the_next() {
    for (of_time, lifetime) in [(1, 50), (254, 100)] {
        let mut slave = operational::<Keeper>();
        set_transmission(&mut slave, 0x1800, of_time);
        map_tpdo(&mut slave, 2, 1, &[0x2015_0510]);
        run(&mut slave, ms(10));
        slave.clear();
        sync(&mut slave);
        let sent = slave.sent.iter().find(|sent| sent.frame.id().raw() == 0x285).expect("TPDO 2");
        assert_eq!(sent.expires, ms(10 + lifetime), "type {of_time}");
    }
}

/// A producer and a consumer with 8 bits, 3.9 ms, and the oscillator of the consumer: none of it moves the clock by more.
///
/// Verifies: ECSS 7.1.2h
#[test]
fn a_clock_is_steered_by_times_of_8_bits() {
    let mut slave = operational::<Coarse>();
    for nth in 1..=300_u64 {
        // 97.3 ms apart, so that all places of the unit are met.
        let end = nth * 97_300;
        run(&mut slave, us(end));
        sync(&mut slave);
        run(&mut slave, us(end + 300));
        let [_, _, fine, coarse @ ..] = at_us(end).encode();
        let [a, b, c, d] = coarse;
        slave.receive(NOMINAL, 0x181, &[0, 0, fine, a, b, c, d]);
        let off = slave.node.scet(slave.now).micros_since(at_us(end + 300));
        assert!(off.abs() < if nth < 100 { 4_000 } else { 300 }, "{off} us off at SYNC {nth}");
    }
    let steps = slave.events.iter().filter(|event| matches!(event, SlaveEvent::Step(_)));
    assert_eq!(steps.count(), 1);
}

/// Given a device with 8 bits of fine time, when its SYNC is stamped in the interrupt or captured, then its Local Time PDO has these 8 bits
/// and zeros: 0.5 s and 0.1 s make 0.6 s, 153.6 of 256 parts.
///
/// Verifies: ECSS 7.1.2g
/// Notices: ECSS 7.1.2g: without capture a device with 8 bits of fine time sends 21.
/// Notices: ECSS 7.1.2g: with capture a device with 8 bits of fine time sends 24.
#[test]
fn a_device_with_8_bits_sends_no_more_with_and_without_capture() {
    for stamp in [Stamp::interrupt(ms(600)), Stamp::captured(ms(600).into())] {
        let mut slave = operational::<Coarse>();
        run(&mut slave, ms(500));
        run(&mut slave, ms(600));
        slave.clear();
        slave.link(NOMINAL, LinkEvent::Received { frame: frame(0x080, &[]), stamp });
        assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &[0, 0, 153, 0, 0, 0, 0]))], "{stamp:?}");
    }
}

/// Given a device with 8 bits of fine time, when a spacecraft time comes with all 24 bits, then the 16 lowest mean nothing: their mean
/// is added whatever they are, half a unit of 2^-8 s less half of one of 2^-24 s.
///
/// Verifies: ECSS 7.1.2h
/// Notices: ECSS 7.1.2h: the clock takes bits of a PDO that the device lacks.
#[test]
fn a_device_with_8_bits_ignores_the_others_of_a_spacecraft_time() {
    for lowest in [0, 1, 0x8000, 0xFFFF] {
        let mut slave = operational::<Coarse>();
        run(&mut slave, ms(50));
        sync(&mut slave);
        time(&mut slave, scet(1_000, 0x81_0000 | lowest));
        let fine = slave.node.scet(slave.now).fine();
        assert!([0x81_7FFF, 0x81_8000].contains(&fine), "{fine:06X} of {lowest:04X}");
    }
}

/// Types 241 to 251 are reserved. Remote requests, 252 and 253, are not for PDOs (ECSS Table 11-1).
///
/// Verifies: ECSS 7.2.3e, 6.2a, 11.1c
/// Notices: ECSS 7.2.3e: a client cannot set type 240.
/// Notices: ECSS 11.1c: transmission types of remote requests are taken.
#[test]
fn types_241_to_253_are_refused_for_the_time() {
    let mut slave = operational::<Keeper>();
    for index in [0x1400, 0x1800] {
        let id = if index == 0x1400 { 0x181_u32 } else { 0x185 };
        write(&mut slave, index, 1, &(0xC000_0000 | id).to_le_bytes());
        for transmission in [241, 251, 252, 253] {
            let refused = crate::device::fixture::refused(index, 2, 0x0609_0030);
            assert_eq!(write(&mut slave, index, 2, &[transmission]), refused);
        }
        for transmission in [1, 240] {
            assert_eq!(write(&mut slave, index, 2, &[transmission]), done(index, 2), "{transmission}");
        }
    }
}

/// Given a Local Time PDO by event, when a SYNC of a wrong length comes after a right one, then the PDO has the time at the right one.
///
/// Verifies: ECSS 7.2.3k, 6.3b
/// Notices: ECSS 7.2.3k: a SYNC of a wrong length counts as the last one.
#[test]
fn local_time_is_not_that_of_a_sync_of_wrong_length() {
    let mut slave = operational::<Keeper>();
    set_transmission(&mut slave, 0x1800, 254);
    run(&mut slave, ms(1_000));
    sync(&mut slave);
    run(&mut slave, ms(1_500));
    slave.receive(NOMINAL, 0x080, &[1, 2]);
    slave.clear();
    slave.touch(|slave, now| slave.send_pdo(0, now));
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &[0, 0, 0, 1, 0, 0, 0]))]);
}

/// Given a slave that follows its master on the nominal bus, when a SYNC comes on the redundant bus, then that one takes no sample: the
/// Local Time PDO has the time at the last SYNC on the nominal bus, and so has the spacecraft time that comes.
///
/// Verifies: ECSS 7.2.3k, 7.2.3g
/// Notices: ECSS 7.2.3k: a SYNC on the bus that is not active takes a sample of the local time.
#[test]
fn sync_on_the_bus_that_is_not_active_takes_no_sample() {
    let captured =
        |at| LinkEvent::Received { frame: frame(0x080, &[]), stamp: Stamp::captured(ms(at).into()) };
    let mut slave = operational::<Keeper>();
    set_transmission(&mut slave, 0x1800, 254);
    run(&mut slave, ms(1_000));
    sync(&mut slave);
    run(&mut slave, ms(1_005));
    slave.clear();
    slave.link(REDUNDANT, captured(1_005));
    slave.touch(|slave, now| slave.send_pdo(0, now));
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &[0, 0, 0, 1, 0, 0, 0]))]);
    run(&mut slave, ms(1_010));
    time(&mut slave, scet(5_000, 0));
    // 10 ms x 2^24 = 167,772.2.
    assert_eq!(slave.node.scet(slave.now), scet(5_000, 167_772));
    // With type 1 there is no PDO either.
    let mut slave = operational::<Keeper>();
    run(&mut slave, ms(50));
    slave.clear();
    slave.link(REDUNDANT, captured(50));
    assert_eq!(slave.frames(), []);
}

/// Given a slave whose Local Time PDO has type 3 or 240, then it goes with every third or 240th SYNC, and has the time of that SYNC.
///
/// Verifies: ECSS 6.9e, 7.2.3i, 7.2.3k
/// Notices: ECSS 6.9e: a PDO of type 3 goes with every SYNC.
#[test]
fn local_time_of_type_n_goes_with_every_nth_sync() {
    for transmission in [3, 240] {
        let mut slave = operational::<Keeper>();
        set_transmission(&mut slave, 0x1800, transmission);
        slave.clear();
        let cycle = u64::from(transmission);
        // Each second.
        for nth in 1..=2 * cycle {
            run(&mut slave, ms(1_000 * nth));
            slave.clear();
            sync(&mut slave);
            let expected = frame(0x185, &[0, 0, 0, nth as u8, (nth >> 8) as u8, 0, 0]);
            let expected = if nth.is_multiple_of(cycle) { vec![(NOMINAL, expected)] } else { vec![] };
            assert_eq!(slave.frames(), expected, "type {transmission}, SYNC {nth}");
        }
    }
}
