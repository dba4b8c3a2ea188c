//! The Spacecraft Time PDO at its producer.
//!
//! Verifies: ECSS 7.2.3a, 7.2.3b

use ecss_can::link::Stamp;
use ecss_can::node::MasterRequest;
use ecss_can::node::extend::LinkEvent;
use ecss_can::profile::Profile;
use ecss_can::types::{Bus, Duration, FineInstant};

use super::devices::{Keeper, Producer, operational};
use super::{run, scet, sync, us};
use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, frame, ms};
use crate::console;
use crate::device::fixture::{map_tpdo, payloads, write_all};
use crate::instrument::STANDARD;
use crate::master_device::{read, write};
use crate::pair::time::Calendar;

/// The payload of 181h, and until when it lives.
fn sent(master: &Bench<Master>) -> Vec<([u8; 8], Duration)> {
    let of_time = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x181);
    of_time.map(|sent| (sent.frame.padded(), sent.expires.since(sent.at))).collect()
}

/// SYNC every 100 ms, its time with every `cycle`-th.
fn high_resolution(cycle: u8) -> Bench<Master> {
    let mut master = Bench::new(console::master(&Profile { autostart: true, ..STANDARD }));
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    for (sub, value, len) in [(1, 0xC000_0181, 4), (2, u32::from(cycle), 1), (1, 0x4000_0181, 4)] {
        assert_eq!(write(&mut master, 0x1800, sub, value, len), Ok(()));
    }
    assert_eq!(read(&mut master, 0x1800, 2), u32::from(cycle));
    master.clear();
    master
}

/// The SYNC left `late` after it was due, and ended at this instant.
fn sync_sent(master: &mut Bench<Master>, at: FineInstant) {
    let stamp = Stamp::captured(at);
    master.link(NOMINAL, LinkEvent::Transmitted { frame: frame(0x080, &[]), stamp });
}

/// SYNC ended at 1 s and 0.25 us; it is reported 60 us later.
///
/// Verifies: ECSS 7.2.3c, 7.2.3e, 7.2.3f, 7.1.2f
/// Notices: ECSS 7.2.3b: a PDO at SYNC is sent only while another one is withheld.
#[test]
fn types_1_to_240_send_the_time_at_the_end_of_the_last_sync() {
    let mut master = high_resolution(1);
    master.request(MasterRequest::SetTime(scet(1_000, 0)));
    master.run_until(us(1_000_060));
    master.clear();
    sync_sent(&mut master, FineInstant::from_units(256_000_064));
    // 1001 s, and 0.25 us are 4.19 units of 2^-24 s.
    let [(value, lifetime)] = sent(&master)[..] else { panic!("one") };
    assert_eq!(value, [4, 0, 0, 0xE9, 3, 0, 0, 0]);
    // It must be gone before the next SYNC: consumers would take it for that one's.
    assert_eq!(lifetime, Duration::from_millis(50));
}

/// Given a master whose Spacecraft Time PDO is not valid, then it is no time producer, and sends its SYNC all the same.
///
/// Verifies: ECSS 7.2.3d
/// Notices: ECSS 7.2.3d: a master without a time PDO produces no SYNC.
#[test]
fn master_that_produces_no_time_produces_sync() {
    let mut master = high_resolution(1);
    assert_eq!(write(&mut master, 0x1800, 1, 0xC000_0181, 4), Ok(()));
    master.clear();
    for nth in 1..=3 {
        let until = ms(100 * nth);
        master.run_until(until);
        sync_sent(&mut master, until.into());
    }
    let syncs = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x080).count();
    assert_eq!((syncs, sent(&master)), (3, vec![]));
}

/// Given SYNC every 20 ms by 1006h, then a SYNC lives 20 ms, and the time of one is gone before the next one.
///
/// Verifies: ECSS 7.2.3c, 9.4.7.3b.1
/// Notices: ECSS 9.4.7.3b.1: a period that is written to 1006h is not that of SYNC.
#[test]
fn sync_and_its_time_live_no_longer_than_1006h() {
    let mut master = high_resolution(1);
    assert_eq!(write(&mut master, 0x1006, 0, 20_000, 4), Ok(()));
    let until = master.now + Duration::from_millis(20);
    master.run_until(until);
    let sync = master.sent.iter().find(|sent| sent.frame.id().raw() == 0x080).expect("SYNC");
    assert_eq!(sync.expires.since(sync.at), Duration::from_millis(20));
    sync_sent(&mut master, FineInstant::from(until));
    let [(_, lifetime)] = sent(&master)[..] else { panic!("one") };
    assert_eq!(lifetime, Duration::from_millis(10));
}

/// Given a synchronous TPDO of the time that is not valid, then another TPDO lives as long as without it.
#[test]
fn time_pdo_that_is_not_valid_shortens_no_lifetime() {
    let mut slave = operational::<Producer>();
    write_all(&mut slave, &[(0x1800, 1, &[0x81, 1, 0, 0xC0])]);
    // With each SYNC: the source of the time.
    map_tpdo(&mut slave, 2, 1, &[0x2015_0208]);
    slave.clear();
    sync(&mut slave);
    let [sent] = slave.sent[..] else { panic!("one: {:?}", slave.sent) };
    assert_eq!((sent.frame.id().raw(), sent.expires.since(sent.at)), (0x285, Duration::from_millis(100)));
}

/// Given a synchronous RPDO of the time that is not valid, then an event-driven Local Time PDO has the time when it is sent; while the
/// RPDO is valid, it has the time of the last SYNC.
///
/// Verifies: ECSS 7.2.3i, 7.2.3k, 7.2.2f
/// Notices: ECSS 7.2.3i: a Local Time PDO by its event timer has an old time.
#[test]
fn time_pdo_that_is_not_valid_makes_no_time_of_sync() {
    for (valid, fine) in [(true, 0), (false, 0x80_0000_u32)] {
        let mut slave = operational::<Keeper>();
        // Local Time PDO each 500 ms.
        let steps: [(u16, u8, &[u8]); 5] = [
            (0x1400, 1, &[0x81, 1, 0, if valid { 0x40 } else { 0xC0 }]),
            (0x1800, 1, &[0x85, 1, 0, 0xC0]),
            (0x1800, 2, &[255]),
            (0x1800, 5, &[0xF4, 1]),
            (0x1800, 1, &[0x85, 1, 0, 0x40]),
        ];
        write_all(&mut slave, &steps);
        sync(&mut slave);
        slave.clear();
        run(&mut slave, ms(500));
        let [low, mid, high, ..] = fine.to_le_bytes();
        let expected = vec![low, mid, high, 0, 0, 0, 0];
        assert_eq!(payloads(&slave, 0x185), [expected], "valid: {valid}");
    }
}

/// Verifies: ECSS 7.2.3e, 7.2.3f
/// Notices: ECSS 7.2.3f: a single master board withholds its time.
#[test]
fn with_type_3_every_third_sync_brings_it() {
    let mut master = high_resolution(3);
    let mut counts = vec![];
    for nth in 1..=9 {
        master.run_until(ms(100 * nth));
        master.clear();
        sync_sent(&mut master, ms(100 * nth).into());
        counts.push(sent(&master).len());
    }
    assert_eq!(counts, [0, 0, 1, 0, 0, 1, 0, 0, 1]);
}

/// Given a master on the nominal or on the redundant bus, when its SYNC ends, then its time goes out once, on that bus alone.
///
/// Verifies: ECSS 7.2.2d, 7.2.2b
/// Notices: ECSS 7.2.2d: the Spacecraft Time PDO goes out on both buses.
#[test]
fn time_goes_out_once_on_the_active_bus() {
    for bus in Bus::ALL {
        let mut master = high_resolution(1);
        if bus == REDUNDANT {
            master.request(MasterRequest::SwitchBus(REDUNDANT));
            master.transmitted(REDUNDANT, frame(0x701, &[5]));
        }
        master.run_until(ms(100));
        master.clear();
        let stamp = Stamp::captured(ms(100).into());
        master.link(bus, LinkEvent::Transmitted { frame: frame(0x080, &[]), stamp });
        let times = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x181);
        assert_eq!(times.map(|sent| sent.bus).collect::<Vec<_>>(), [bus]);
    }
}

/// Given a master whose Spacecraft Time PDO is not its first one, then it has the time of the last SYNC.
///
/// Verifies: ECSS 7.2.2a, 7.2.3c
/// Notices: ECSS 7.2.3a: the time is sampled for the first transmit PDO alone.
#[test]
fn the_spacecraft_time_may_be_another_pdo_of_the_master() {
    let mut master = high_resolution(1);
    let time = [0x2011_0218, 0x2011_0120];
    for (index, sub, value, len) in [
        (0x1800, 1, 0xC000_0181, 4),
        (0x1A00, 0, 0, 1),
        (0x1801, 1, 0xC000_0302, 4),
        (0x1A01, 0, 0, 1),
        (0x1A01, 1, time[0], 4),
        (0x1A01, 2, time[1], 4),
        (0x1A01, 0, 2, 1),
        (0x1801, 2, 1, 1),
        (0x1801, 1, 0xC000_0181, 4),
        (0x1801, 1, 0x4000_0181, 4),
    ] {
        assert_eq!(write(&mut master, index, sub, value, len), Ok(()), "{index:04X}h sub {sub}");
    }
    master.run_until(ms(1_500));
    master.clear();
    sync_sent(&mut master, ms(1_500).into());
    let [(value, _)] = sent(&master)[..] else { panic!("one") };
    assert_eq!(value, [0, 0, 0x80, 1, 0, 0, 0, 0]);
}

/// Given a master whose Spacecraft Time PDO has its Local UTC Get, when a SYNC was sent, then the PDO has the UTC of it.
///
/// Verifies: ECSS 7.2.2a, 7.1.1b, 7.1.3c, 7.1.3e
/// Notices: ECSS 7.2.3a: a master takes no sample of its UTC.
/// Notices: ECSS 7.2.2a: Local UTC Get in a transmit PDO is never sampled.
#[test]
fn the_spacecraft_time_of_a_master_may_be_utc() {
    let profile = Profile { autostart: true, ..STANDARD };
    let mut master = Bench::new(ecss_can::node::Master::builder(&profile, Calendar::default()).build());
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    // 1.5 s: every tenth SYNC has its time.
    for nth in 6..=15 {
        master.run_until(ms(100 * nth));
        master.clear();
        master.link(
            NOMINAL,
            LinkEvent::Transmitted { frame: frame(0x080, &[]), stamp: Stamp::captured(ms(100 * nth).into()) },
        );
    }
    let times: Vec<_> = master.frames().into_iter().filter(|(_, sent)| sent.id().raw() == 0x181).collect();
    assert_eq!(times, [(NOMINAL, frame(0x181, &[0, 0, 0xDC, 5, 0, 0, 100, 0]))]);
}

/// Two slaves of one network: this one hears the SYNC of the master and tells the time.
///
/// Verifies: ECSS 7.2.3d
/// Notices: ECSS 7.2.3d: only consumers of the time note the SYNCs of another node.
#[test]
fn a_node_produces_the_time_of_syncs_that_another_produces() {
    let mut slave = operational::<Producer>();
    run(&mut slave, ms(500));
    sync(&mut slave);
    run(&mut slave, ms(1_500));
    slave.clear();
    sync(&mut slave);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x181, &[0, 0, 0x80, 1, 0, 0, 0]))]);
}
