//! Time objects in PDOs that a client or the application maps, and in those of a bus or a boot after the first one.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::link::Stamp;
use ecss_can::node::extend::LinkEvent;
use ecss_can::node::{Device, DeviceTime, Master, SpacecraftDevice};
use ecss_can::od::Objects;
use ecss_can::pdo::{PdoObjects, PdoSet};
use ecss_can::profile::Profile;
use ecss_can::time::LocalUtc;
use ecss_can::types::{FineInstant, Scet, Utc, UtcRelation};

use super::devices::{Coarse, Keeper, Node, Producer, Universal, operational};
use super::{run, scet, sync, time};
use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms};
use crate::device::fixture::{done, map_tpdo, payloads, read, refused, write, write_all};
use crate::instrument::STANDARD;

/// Declares no PDO.
#[derive(Debug, Objects)]
#[objects(device)]
struct Bare {
    /// Value
    #[object(0x6000, rw)]
    value: u8,
}

impl Device for Bare {
    type Pdos = PdoObjects<2, 2>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::NONE;
}

/// Keeps UTC, SCET 0 was day 100, and declares no PDO; has six of each direction.
#[derive(Debug, Objects)]
#[objects(device, time)]
struct Vacant {
    /// Time
    #[objects]
    utc: LocalUtc,
}

impl Device for Vacant {
    type Pdos = PdoObjects<6, 6>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::NONE;
}

impl DeviceTime for Vacant {
    const UTC: Option<UtcRelation> =
        Some(UtcRelation { scet: Scet::new(0, 0).unwrap(), utc: Utc::new(100, 0, 0).unwrap() });

    fn utc(&mut self) -> Option<&mut LocalUtc> {
        Some(&mut self.utc)
    }
}

/// Steps that map these objects to the PDO with parameters at `index`.
fn steps_of(index: u16, id: u16, transmission: u8, objects: &[u32]) -> Vec<(u16, u8, Vec<u8>)> {
    let cob_id = |flags: u32| (index, 1, (flags | u32::from(id)).to_le_bytes().to_vec());
    let mapping = index + 0x200;
    let mut steps = vec![cob_id(0xC000_0000), (mapping, 0, vec![0])];
    steps.extend((1..).zip(objects).map(|(sub, object)| (mapping, sub, object.to_le_bytes().to_vec())));
    steps.extend([(mapping, 0, vec![objects.len() as u8]), (index, 2, vec![transmission])]);
    steps.push(cob_id(0x4000_0000));
    steps
}

/// Figure 7-1: fine time, coarse time of Local SCET Get.
const LOCAL: [u32; 2] = [0x2011_0218, 0x2011_0120];
/// 1.5 s in Figure 7-1.
const AT_1500: [u8; 7] = [0, 0, 0x80, 1, 0, 0, 0];

/// Maps Local SCET Set to RPDO 1, 181h.
fn map_scet_set<D: SpacecraftDevice>(slave: &mut Node<D>, transmission: u8) {
    let steps: [(u16, u8, &[u8]); 7] = [
        (0x1400, 1, &[0x81, 1, 0, 0xC0]),
        (0x1600, 0, &[0]),
        (0x1600, 1, &0x2010_0218_u32.to_le_bytes()),
        (0x1600, 2, &0x2010_0120_u32.to_le_bytes()),
        (0x1600, 0, &[2]),
        (0x1400, 2, &[transmission]),
        (0x1400, 1, &[0x81, 1, 0, 0x40]),
    ];
    write_all(slave, &steps);
}

/// Takes Local SCET Get out of TPDO 1.
fn unmap_local_time<D: SpacecraftDevice>(slave: &mut Node<D>, id: u8) {
    write_all(slave, &[(0x1800, 1, &[id, 1, 0, 0xC0]), (0x1A00, 0, &[0])]);
}

/// Given a slave without PDOs, when a client maps Local SCET Get to its TPDO 1, then the PDO has the local time: with SYNC, or by event.
///
/// Verifies: ECSS 7.2.2e, 7.2.2f, 7.2.3h, 7.2.3i, 7.2.3j
/// Notices: ECSS 7.2.2e: a Local Time PDO that a client maps has no sample.
/// Notices: ECSS 7.2.3h: a client maps Local SCET Get where no PDO had it before: it is never sampled.
/// Notices: ECSS 7.2.3j: a slave that gets no time at SYNC samples no local time.
/// Notices: ECSS 7.2.3j: a Local Time PDO that a client maps in Operational is not sent until the next start.
/// Notices: ECSS 7.2.2f: a slave sends no local time on the redundant bus.
#[test]
fn client_maps_local_time_where_no_pdo_had_it() {
    for (transmission, bus) in [(1, NOMINAL), (254, NOMINAL), (1, REDUNDANT), (254, REDUNDANT)] {
        let mut slave = operational::<Bare>();
        map_tpdo(&mut slave, 1, transmission, &LOCAL);
        run(&mut slave, ms(1_500));
        slave.receive(bus, 0x701, &[5]);
        slave.clear();
        let stamp = Stamp::captured(ms(1_500).into());
        slave.link(bus, LinkEvent::Received { frame: frame(0x080, &[]), stamp });
        slave.touch(|slave, now| slave.send_pdo(0, now));
        assert_eq!(slave.frames(), [(bus, frame(0x185, &AT_1500))], "type {transmission}");
    }
}

/// Given a slave without PDOs, when a client maps Local SCET Set or Local UTC Set to RPDO 6, and the Get object to TPDO 6, then a time that
/// comes sets the clock, and a SYNC a second later brings the local time.
///
/// Verifies: ECSS 7.2.2c, 7.2.2e, 7.2.3g, 7.2.3h
/// Notices: ECSS 7.2.2c: a client cannot map Local UTC Set.
/// Notices: ECSS 7.2.2c: a time that a fifth or later receive PDO brings sets no clock.
/// Notices: ECSS 7.2.3g: Local SCET Set is of effect in the first four receive PDOs alone.
#[test]
fn client_maps_scet_or_utc_to_the_last_pdos() {
    // 1000.5 s, which is day 100, 1,000,500 ms; then a second later.
    let scet_objects: &[u32] = &[0x2010_0218, 0x2010_0120];
    let utc_objects: &[u32] = &[0x2012_0310, 0x2012_0220, 0x2012_0110];
    let utc = |ms| Utc::new(100, ms, 0).unwrap().encode().to_vec();
    let as_scet = |coarse| scet(coarse, 0x80_0000).encode().to_vec();
    let cases =
        [(scet_objects, as_scet(1_000), as_scet(1_001)), (utc_objects, utc(1_000_500), utc(1_001_500))];
    for (objects, brought, sent) in cases {
        let mut slave = operational::<Vacant>();
        let get: Vec<_> = objects.iter().map(|object| object + 0x1_0000).collect();
        let steps = [steps_of(0x1405, 0x181, 1, objects), steps_of(0x1805, 0x185, 1, &get)].concat();
        for (index, sub, value) in steps {
            assert_eq!(write(&mut slave, index, sub, &value), done(index, sub), "{index:04X}h sub {sub}");
        }
        run(&mut slave, ms(50));
        sync(&mut slave);
        slave.receive(NOMINAL, 0x181, &brought);
        assert_eq!(slave.node.scet(slave.now), scet(1_000, 0x80_0000), "{brought:02X?}");
        run(&mut slave, ms(1_050));
        slave.clear();
        sync(&mut slave);
        assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &sent))]);
    }
}

/// Given a master with UTC and without PDOs, when its application maps Local UTC Get to 181h by its first or last TPDO, then 181h has the
/// UTC of the last SYNC.
///
/// Verifies: ECSS 7.2.2a, 7.2.3a, 7.1.3e
/// Notices: ECSS 7.2.2a: Local UTC Get cannot be mapped after power-on.
#[test]
fn utc_is_mapped_at_a_master_that_had_none() {
    for index in [0x1800, 0x1805] {
        let profile = Profile { autostart: true, ..STANDARD };
        let mut master = Bench::new(Master::builder(&profile, Vacant::default()).build());
        master.transmitted(NOMINAL, frame(0x701, &[0]));
        for (index, sub, value) in steps_of(index, 0x181, 1, &[0x2013_0310, 0x2013_0220, 0x2013_0110]) {
            assert_eq!(master.write((index, sub), &value), Ok(()), "{index:04X}h sub {sub}");
        }
        master.run_until(ms(1_500));
        master.clear();
        let stamp = Stamp::captured(ms(1_500).into());
        master.link(NOMINAL, LinkEvent::Transmitted { frame: frame(0x080, &[]), stamp });
        let sent: Vec<_> = master.frames().into_iter().filter(|(_, sent)| sent.id().raw() == 0x181).collect();
        assert_eq!(sent, [(NOMINAL, frame(0x181, &[0, 0, 0xDC, 5, 0, 0, 100, 0]))], "{index:04X}h");
    }
}

/// Given a master without PDOs, when its application maps Local SCET Get to 181h, then 181h has the spacecraft time: with SYNC, or by
/// event.
///
/// Verifies: ECSS 7.2.2a, 7.2.2b, 7.2.3a, 7.2.3b, 7.1.2f
/// Notices: ECSS 7.2.2a: a Spacecraft Time PDO that is mapped after power-on has no sample.
/// Notices: ECSS 7.2.3a: Local SCET Get is sampled only if it was mapped at power-on.
#[test]
fn spacecraft_time_is_mapped_at_a_master_that_had_none() {
    for transmission in [1, 254] {
        let profile = Profile { autostart: true, ..STANDARD };
        let mut master = Bench::new(Master::builder(&profile, Bare::default()).build());
        master.transmitted(NOMINAL, frame(0x701, &[0]));
        let [fine, coarse] = LOCAL.map(u32::to_le_bytes);
        let steps: [((u16, u8), &[u8]); 6] = [
            ((0x1800, 1), &[0x81, 1, 0, 0xC0]),
            ((0x1A00, 1), &fine),
            ((0x1A00, 2), &coarse),
            ((0x1A00, 0), &[2]),
            ((0x1800, 2), &[transmission]),
            ((0x1800, 1), &[0x81, 1, 0, 0x40]),
        ];
        for (at, value) in steps {
            assert_eq!(master.write(at, value), Ok(()), "{at:04X?}");
        }
        master.run_until(ms(1_500));
        master.clear();
        let stamp = Stamp::captured(ms(1_500).into());
        master.link(NOMINAL, LinkEvent::Transmitted { frame: frame(0x080, &[]), stamp });
        if transmission == 254 {
            assert_eq!(master.touch(|master, now| master.send_pdo(0, now)), Ok(()));
        }
        let sent: Vec<_> = master.frames().into_iter().filter(|(_, sent)| sent.id().raw() == 0x181).collect();
        assert_eq!(sent, [(NOMINAL, frame(0x181, &AT_1500))], "type {transmission}");
    }
}

/// Asserts: after "reset communication" TPDO 1, `id`, has the local time again, which a client had taken out of it.
fn assert_restored<D: SpacecraftDevice>(id: u16, syncs: usize) {
    let mut slave = operational::<D>();
    unmap_local_time(&mut slave, id as u8);
    run(&mut slave, ms(100));
    sync(&mut slave);
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    slave.settle();
    run(&mut slave, ms(1_500));
    slave.clear();
    (0..syncs).for_each(|_| sync(&mut slave));
    assert_eq!(payloads(&slave, id), [AT_1500]);
}

/// Given a consumer or a producer of the time, when a client took Local SCET Get out of its PDO and the communication is reset, then
/// the PDO has the time again.
///
/// Verifies: ECSS 7.2.2a, 7.2.2e, 7.2.3a, 7.2.3h, 6.5.1a.5
/// Notices: ECSS 7.2.2a: the time producer takes no sample after a reset of its communication.
/// Notices: ECSS 7.2.3a: PDOs with Local SCET Get are noted at power-on alone.
/// Notices: ECSS 7.2.2e: the Local Time PDO has no sample after a reset of the communication.
/// Notices: ECSS 7.2.3h: a mapping that the reset restores is not noted.
/// Notices: ECSS 6.5.1a.5: reset communication keeps a mapping that a client has written.
#[test]
fn reset_communication_restores_time_in_pdos() {
    assert_restored::<Keeper>(0x185, 1);
    assert_restored::<Producer>(0x181, 2);
}

/// Given a slave that a client has set to 5000 s, when RPDO 1 has a dummy in place of Local SCET Set, then a frame of this PDO sets no
/// clock.
///
/// Verifies: ECSS 7.2.2c, 7.2.3g
/// Notices: ECSS 7.2.3g: a PDO from which a client has taken Local SCET Set brings the time all the same.
#[test]
fn a_pdo_without_a_time_object_sets_no_clock() {
    for transmission in [1, 254] {
        let mut slave = operational::<Keeper>();
        for (index, sub, value) in steps_of(0x1400, 0x181, transmission, &[0x0005_0008]) {
            assert_eq!(write(&mut slave, index, sub, &value), done(index, sub), "{index:04X}h sub {sub}");
        }
        write_all(&mut slave, &[(0x2010, 1, &[0x88, 0x13, 0, 0]), (0x2010, 2, &[0; 3])]);
        run(&mut slave, ms(1_000));
        sync(&mut slave);
        slave.receive(NOMINAL, 0x181, &[9]);
        sync(&mut slave);
        assert_eq!(slave.node.scet(slave.now), scet(5_001, 0), "type {transmission}");
    }
}

/// Given a slave whose Local Time PDO a client has switched off or given another COB-ID, when the communication is reset, then a SYNC brings
/// the local time once, by 180h and the Node-ID.
///
/// Verifies: ECSS 7.2.2g, 7.2.3j
/// Notices: ECSS 7.2.2g: a Local Time PDO that was switched off stays off after reset communication.
/// Notices: ECSS 7.2.3j: a Local Time PDO keeps another COB-ID after reset communication.
#[test]
fn reset_communication_restores_the_one_local_time_pdo() {
    for cob_id in [0xC000_0185_u32, 0x4000_02C5] {
        let mut slave = operational::<Keeper>();
        write_all(&mut slave, &[(0x1800, 1, &[0x85, 1, 0, 0xC0]), (0x1800, 1, &cob_id.to_le_bytes())]);
        slave.receive(NOMINAL, 0x000, &[0x82, 5]);
        slave.settle();
        run(&mut slave, ms(1_500));
        slave.clear();
        sync(&mut slave);
        assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &AT_1500))], "{cob_id:08X}h");
    }
}

/// Given a consumer that sends no local time, when a SYNC and 2 ms later its time come, then the clock is set to the time of that SYNC.
///
/// Verifies: ECSS 7.2.3c, 7.2.3f, 7.2.3g, 7.2.1a, 7.2.2c
/// Notices: ECSS 7.2.3f: a consumer without a Local Time PDO notes no SYNC, and its clock is never set.
/// Notices: ECSS 7.2.3g: a consumer follows only if it sends its local time.
#[test]
fn consumer_without_local_time_pdo_follows() {
    let mut slave = operational::<Keeper>();
    unmap_local_time(&mut slave, 0x85);
    run(&mut slave, ms(50));
    sync(&mut slave);
    run(&mut slave, ms(52));
    time(&mut slave, scet(1_000, 0));
    // 2 ms x 2^24 = 33,554.4.
    assert_eq!(slave.node.scet(slave.now), scet(1_000, 33_554));
}

/// Given a consumer of UTC that sends no local time, when a SYNC and 2 ms later its time come, then the clock is set to the time of that
/// SYNC.
///
/// Verifies: ECSS 7.1.1b, 7.1.3b, 7.1.3e, 7.2.3c
/// Notices: ECSS 7.1.1b: a consumer of UTC without a Local Time PDO notes no SYNC, and its clock is never set.
#[test]
fn consumer_of_utc_without_local_time_pdo_follows() {
    let mut slave = operational::<Universal<true>>();
    unmap_local_time(&mut slave, 0x85);
    run(&mut slave, ms(50));
    sync(&mut slave);
    run(&mut slave, ms(52));
    slave.receive(NOMINAL, 0x181, &Utc::new(101, 5, 250).unwrap().encode());
    // A day and 5.25 ms, rounded to 88,080 units of 2^-24 s; then 2 ms, 33,554.4.
    assert_eq!(slave.node.scet(slave.now), scet(86_400, 121_634));
}

/// Given a slave that keeps UTC and receives it by 181h, when a client maps Local SCET Set there, then the SCET that comes sets its
/// clock.
///
/// Verifies: ECSS 7.1.1d, 7.1.2a, 7.2.1a, 7.1.2c
/// Notices: ECSS 7.1.1d: a device with UTC takes every spacecraft time for UTC.
/// Notices: ECSS 7.1.2a: a device with UTC cannot be set by Local SCET Set.
#[test]
fn device_with_utc_follows_scet_by_pdo() {
    for transmission in [1, 254] {
        let mut slave = operational::<Universal<true>>();
        map_scet_set(&mut slave, transmission);
        run(&mut slave, ms(50));
        sync(&mut slave);
        time(&mut slave, scet(1_000, 0x80_0000));
        assert_eq!(slave.node.scet(slave.now), scet(1_000, 0x80_0000), "type {transmission}");
    }
}

/// Given a slave that follows its master to the redundant bus, when SYNC and the spacecraft time come there, then its clock is set, and
/// with the next SYNC it sends its local time there.
///
/// Verifies: ECSS 7.2.1a, 7.2.2c, 7.2.3f, 7.2.3i, 7.2.3k
/// Notices: ECSS 7.2.1a: a slave takes no time on the redundant bus.
/// Notices: ECSS 7.2.2c: a time of type 254 sets the clock on the nominal bus alone.
/// Notices: ECSS 7.2.3f: a synchronous time sets the clock on the nominal bus alone.
/// Notices: ECSS 7.2.3i: the local time on the redundant bus is an old one.
/// Notices: ECSS 7.2.3k: a SYNC on the redundant bus takes no sample of the local time.
#[test]
fn time_is_taken_and_sent_on_the_redundant_bus() {
    for transmission in [1, 254] {
        let mut slave = operational::<Keeper>();
        map_scet_set(&mut slave, transmission);
        slave.receive(REDUNDANT, 0x701, &[5]);
        let captured = |at| LinkEvent::Received {
            frame: frame(0x080, &[]),
            stamp: Stamp::captured(FineInstant::from(ms(at))),
        };
        slave.run_until(ms(50));
        slave.link(REDUNDANT, captured(50));
        slave.receive(REDUNDANT, 0x181, &scet(1_000, 0).encode());
        assert_eq!(slave.node.scet(slave.now), scet(1_000, 0), "type {transmission}");
        slave.run_until(ms(100));
        slave.receive(REDUNDANT, 0x701, &[5]);
        slave.run_until(ms(175));
        slave.clear();
        slave.link(REDUNDANT, captured(175));
        // An eighth of a second later.
        assert_eq!(slave.frames(), [(REDUNDANT, frame(0x185, &scet(1_000, 0x20_0000).encode()))]);
    }
}

/// Given a device with 8 bits of fine time and SYNCs that are captured, when the lowest bits of each spacecraft time are zero or not,
/// then the clock is as good: bits that the device lacks do not say how the producer stamps.
///
/// Verifies: ECSS 7.1.2h
/// Notices: ECSS 7.1.2h: a device with 8 bits takes zeros in the others for a producer without capture.
#[test]
fn fine_bits_a_device_lacks_leave_the_quality_alone() {
    for lowest in [0, 8, 0x777] {
        let mut slave = operational::<Coarse>();
        for second in 1..=8 {
            run(&mut slave, ms(1_000 * second));
            sync(&mut slave);
            time(&mut slave, scet(second as u32, lowest));
        }
        assert_eq!(read(&mut slave, 0x2015, 2), [2, 0, 0, 0], "lowest bits {lowest:X}h");
    }
}

/// Keeps 22 bits of fine time: one of the three that are zero in times of a producer without capture.
#[derive(Debug, Objects)]
#[objects(device, time)]
struct Almost {
    /// Value
    #[object(0x6000, rw)]
    value: u8,
}

impl Device for Almost {
    type Pdos = PdoObjects<2, 2>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = Keeper::PDOS;
}

impl DeviceTime for Almost {
    const FINE_BITS: u32 = 22;
}

/// Given a device with 22 bits of fine time and SYNCs that are captured, then the lowest of its own bits alone says how the producer
/// stamps (2 in hardware, 3 in the interrupt); the two below it mean nothing.
///
/// Verifies: ECSS 7.1.2h
/// Notices: ECSS 7.1.2h: a device with 22 bits evaluates the two lowest of 24.
#[test]
fn the_two_bits_that_a_device_of_22_lacks_mean_nothing() {
    for (lowest, source) in [(0, 3), (1, 3), (3, 3), (4, 2), (7, 2)] {
        let mut slave = operational::<Almost>();
        for second in 1..=8 {
            run(&mut slave, ms(1_000 * second));
            sync(&mut slave);
            time(&mut slave, scet(second as u32, lowest));
        }
        assert_eq!(read(&mut slave, 0x2015, 2), [source, 0, 0, 0], "lowest bits {lowest}");
    }
}

/// Given a slave whose TPDO 1 is its Local Time PDO, then no other TPDO of it gets the same COB-ID, whichever of the two has the lower
/// number.
///
/// Verifies: ECSS 7.2.2g, 7.2.3j, 6.10a, 6.10b
/// Notices: ECSS 7.2.2g: a TPDO may get the COB-ID of the Local Time PDO if its number is lower.
/// Notices: ECSS 7.2.3j: the COB-ID of the local time is compared with TPDOs of lower number alone.
/// Notices: ECSS 6.10b: a transmit PDO may have the COB-ID of another one.
#[test]
fn local_time_pdo_shares_its_cob_id_with_no_other() {
    let taken = |index| refused(index, 1, 0x0604_0043);
    let mut slave = operational::<Keeper>();
    map_tpdo(&mut slave, 2, 254, &[0x2015_0208]);
    write_all(&mut slave, &[(0x1801, 1, &[0x85, 2, 0, 0xC0])]);
    assert_eq!(write(&mut slave, 0x1801, 1, &[0x85, 1, 0, 0x40]), taken(0x1801));
    // The other way round: TPDO 2 has the local time and TPDO 1 the source of the time.
    let mut slave = operational::<Keeper>();
    map_tpdo(&mut slave, 1, 254, &[0x2015_0208]);
    write_all(&mut slave, &[(0x1800, 1, &[0x85, 1, 0, 0xC0])]);
    map_tpdo(&mut slave, 2, 1, &LOCAL);
    assert_eq!(write(&mut slave, 0x1800, 1, &[0x85, 2, 0, 0xC0]), done(0x1800, 1));
    assert_eq!(write(&mut slave, 0x1800, 1, &[0x85, 2, 0, 0x40]), taken(0x1800));
}

/// Given a device with submilliseconds, when a PDO with 1000 of them was refused, then a client that writes the three parts of Local UTC
/// Set in any order sets the clock.
///
/// Verifies: ECSS 7.1.3b, 7.1.3c, 7.1.3e
/// Notices: ECSS 7.1.3b: after a time that was refused a client has to write twice.
#[test]
fn client_sets_utc_after_a_time_that_was_refused() {
    for order in [[1, 2, 3], [3, 2, 1], [2, 3, 1]] {
        let mut slave = operational::<Universal<true>>();
        run(&mut slave, ms(50));
        sync(&mut slave);
        slave.receive(NOMINAL, 0x181, &[0xE8, 3, 0xE8, 3, 0, 0, 100, 0]);
        for sub in order {
            let value: &[u8] = [&[110, 0][..], &[5, 0, 0, 0], &[250, 0]][usize::from(sub) - 1];
            assert_eq!(write(&mut slave, 0x2012, sub, value), done(0x2012, sub));
        }
        slave.clear();
        sync(&mut slave);
        let utc = Utc::new(110, 5, 250).unwrap();
        assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &utc.encode()))], "{order:?}");
    }
}

/// Given a client that wrote the day, when a PDO with 1000 submilliseconds is refused, then the other two parts set nothing: the day in
/// Local UTC Set is that of the PDO now.
///
/// Verifies: ECSS 7.1.3b
/// Notices: ECSS 7.1.3b: the clock is set with a part that a refused PDO has brought.
#[test]
fn time_that_was_refused_ends_a_record_begun() {
    let mut slave = operational::<Universal<true>>();
    run(&mut slave, ms(50));
    sync(&mut slave);
    assert_eq!(write(&mut slave, 0x2012, 1, &[110, 0]), done(0x2012, 1));
    slave.receive(NOMINAL, 0x181, &[0xE8, 3, 0xE8, 3, 0, 0, 105, 0]);
    let before = slave.node.scet(slave.now);
    write_all(&mut slave, &[(0x2012, 3, &[250, 0]), (0x2012, 2, &[5, 0, 0, 0])]);
    assert_eq!(slave.node.scet(slave.now), before);
    write_all(&mut slave, &[(0x2012, 1, &[110, 0])]);
    // Ten days and 5.25 ms: 0.00525 x 2^24 = 88,080.4.
    assert_eq!(slave.node.scet(slave.now), scet(864_000, 88_080));
}
