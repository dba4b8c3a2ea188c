//! Services of the master that its dictionary shows and moves: errors of its buses, consumer times, expected stamps.

use std::task::Waker;

use crate::instrument::STANDARD;
use ecss_can::boot::{AssignedSlave, Expected, Setting};
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::node::MasterEvent;
use ecss_can::node::extend::{ClientNode, LinkEvent};
use ecss_can::profile::Profile;
use ecss_can::sdo::Mode;
use ecss_can::types::{Address, Bus, NodeId};

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, frame, ms, node, span};
use crate::master_device::{TWO, absent, powered, read, requests, write};

fn state(state: ErrorState) -> Health {
    Health { state, ..Health::default() }
}

/// The register 1001h and the last two errors of 1003h, with the bus behind the code.
fn errors(master: &mut Bench<Master>) -> (u32, u32, u32) {
    let count = read(master, 0x1003, 0);
    let last = |nth, master: &mut _| if count < nth { 0 } else { read(master, 0x1003, nth as u8) };
    (read(master, 0x1001, 0), last(1, master), last(2, master))
}

/// Verifies: ECSS 5.3.3.2.3g, 5.6.2b, 5.6.2c, 6.4a.2, 6.4b
/// Notices: ECSS 5.3.3.2.3g: the end of error passive on the redundant bus is not reported.
/// Notices: ECSS 5.6.2b: the application hears of the active bus alone.
/// Notices: ECSS 5.6.2c: the object of the redundant bus has the counters of the nominal one.
/// Notices: ECSS 6.4a.2: the recovery from bus-off has another code than 8140h.
/// Notices: ECSS 6.4b: frames that were lost (8110h) are not reported.
#[test]
fn errors_of_its_buses_stand_in_its_dictionary() {
    for (bus, health, source) in [(NOMINAL, 0x2020, 0), (REDUNDANT, 0x2021, 1 << 16)] {
        let mut master = powered(&STANDARD);
        master.transmitted(NOMINAL, frame(0x701, &[0]));
        assert_eq!(errors(&mut master), (0, 0, 0));
        // Not for want of an acknowledgement: that of a first node on a bus is no error.
        let last_error = LastError::BitDominant;
        let passive = Health { tec: 130, last_error, ..state(ErrorState::Passive) };
        master.health(bus, passive);
        assert!(master.events.contains(&MasterEvent::Health { bus, health: passive }));
        assert_eq!(errors(&mut master), (0x11, 0x8120 | source, 0));
        assert_eq!((read(&mut master, health, 1), read(&mut master, health, 2)), (1, 130));
        master.health(bus, state(ErrorState::Active));
        assert_eq!(errors(&mut master), (0, 0x8120 | source, 0));
        assert_eq!(read(&mut master, health, 1), 0);
        master.health(bus, state(ErrorState::BusOff));
        assert_eq!(errors(&mut master).0, 0, "told when it is over");
        assert_eq!(read(&mut master, health, 1), 2);
        master.health(bus, state(ErrorState::Active));
        assert_eq!(errors(&mut master), (0, 0x8140 | source, 0x8120 | source));
        // Frames that were lost, by the receiver and by the node.
        master.link(bus, LinkEvent::Overrun { lost: 3 });
        assert_eq!(errors(&mut master), (0, 0x8110 | source, 0x8140 | source));
        assert_eq!(read(&mut master, health, 7), 3);
        assert_eq!(write(&mut master, 0x1003, 0, 0, 1), Ok(()));
        // One emergency each 100 ms (1015h): while that of the overrun waits, another loss is not reported again.
        let until = master.now + span(1_000);
        master.run_until(until);
        master.link(bus, LinkEvent::Unsent { frames: 2 });
        assert_eq!(errors(&mut master), (0, 0x8110 | source, 0));
        assert_eq!(read(&mut master, health, 10), 2);
    }
}

/// Given a bus whose controller was error passive and then bus-off because of a short, when the controller is error active again, then
/// no error of this bus is left in the register.
///
/// Verifies: ECSS 5.3.3.2.3d, 5.3.3.2.3g, 5.3.3.2.3h, 5.3.3.2.3j
/// Notices: ECSS 5.3.3.2.3g: error passive stays in the register after bus-off.
#[test]
fn register_is_clear_after_error_passive_and_bus_off() {
    for bus in Bus::ALL {
        let mut master = powered(&STANDARD);
        master.transmitted(NOMINAL, frame(0x701, &[0]));
        master.health(
            bus,
            Health { tec: 130, last_error: LastError::BitDominant, ..state(ErrorState::Passive) },
        );
        master.health(bus, state(ErrorState::BusOff));
        assert_eq!(errors(&mut master).0, 0x11);
        master.health(bus, state(ErrorState::Active));
        assert_eq!(errors(&mut master).0, 0, "{bus:?}");
    }
}

/// Verifies: ECSS 6.8a
/// Notices: ECSS 6.8a: 1020h of a master stays when a parameter is written.
#[test]
fn a_parameter_that_is_written_ends_the_verified_configuration() {
    let mut master = powered(&STANDARD);
    let stamp = |master: &mut _| (read(master, 0x1020, 1), read(master, 0x1020, 2));
    let written = [(0x1F84, 2, 1, 4, false), (0x1017, 0, 100, 2, false), (0x2000, 2, 3, 1, false)];
    let others = [(0x1003, 0, 0, 1, true), (0x1F82, 2, 127, 1, true), (0x2030, 0, 1, 1, true)];
    for (index, sub, value, len, stays) in written.into_iter().chain(others) {
        assert_eq!(write(&mut master, 0x1020, 1, 7, 4), Ok(()));
        assert_eq!(write(&mut master, 0x1020, 2, 8, 4), Ok(()));
        assert_eq!(stamp(&mut master), (7, 8));
        assert_eq!(write(&mut master, index, sub, value, len), Ok(()));
        assert_eq!(stamp(&mut master), if stays { (7, 8) } else { (0, 0) }, "{index:04X}");
    }
}

/// Verifies: ECSS 5.6.2c
#[test]
fn error_counters_follow_the_controller_unasked() {
    let mut master = powered(&STANDARD);
    for bus in Bus::ALL {
        master.link(bus, LinkEvent::Counters(Health { tec: 7, rec: 9, ..Health::default() }));
        let objects = &master.node.objects().extension;
        let health = if bus == NOMINAL { &objects.health_nominal } else { &objects.health_redundant };
        assert_eq!((health.tec, health.rec), (7, 9));
    }
}

/// Given counters of a bus, when a client reads them again and again, then they stay as they are; that of received frames counts
/// the requests.
///
/// Verifies: ECSS 5.6.2c
/// Notices: ECSS 5.6.2c: a read of the counters of a bus clears them.
#[test]
fn reading_the_counters_of_a_bus_changes_none() {
    let mut master = powered(&STANDARD);
    master.link(NOMINAL, LinkEvent::Counters(Health { tec: 7, rec: 9, ..Health::default() }));
    master.link(NOMINAL, LinkEvent::Overrun { lost: 3 });
    for _ in 0..3 {
        let received = read(&mut master, 0x2020, 5);
        assert_eq!([2, 3, 7].map(|sub| read(&mut master, 0x2020, sub)), [7, 9, 3]);
        assert_eq!(read(&mut master, 0x2020, 5), received + 4);
    }
}

/// When slave 9, heard at 1 ms on both buses, is lost.
fn lost_at(master: &mut Bench<Master>) -> Option<u64> {
    for bus in Bus::ALL {
        master.receive(bus, 0x709, &[5]);
    }
    master.clear();
    for ms_since in 2..2_000 {
        master.run_until(ms(ms_since));
        if master.events.contains(&MasterEvent::SlaveLost { node: node(9) }) {
            return Some(ms_since);
        }
    }
    None
}

/// Given slave 9 in 1016h, when its heartbeat is missed, then the master sends EMCY 8130h (CiA 301: heartbeat error) with the
/// Node-ID of the slave, and its end when the slave is heard again.
///
/// Verifies: ECSS 6.4a.2, 6.4a, 6.4a.1, 6.5.2a, 8.3.1c
/// Notices: ECSS 6.4a.2: a master reports a missed heartbeat with a code other than 8130h.
/// Notices: ECSS 6.4a.1: the end of a missed heartbeat is not reported.
/// Notices: ECSS 8.3.1c: a written 1016h of a master is not obeyed.
#[test]
fn missed_slave_is_reported_by_emcy_8130h() {
    let mut master = powered(&STANDARD);
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    assert_eq!(write(&mut master, 0x1015, 0, 0, 2), Ok(()));
    assert_eq!(write(&mut master, 0x1016, 8, 9 << 16 | 150, 4), Ok(()));
    master.receive(NOMINAL, 0x709, &[0x7F]);
    master.clear();
    let emergencies = |master: &Bench<Master>| -> Vec<[u8; 8]> {
        let sent = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x081);
        sent.map(|sent| sent.frame.padded()).collect()
    };
    let until = master.now + span(151);
    master.run_until(until);
    assert_eq!(emergencies(&master), [[0x30, 0x81, 0x11, 9, 0, 0, 0, 0]]);
    master.clear();
    master.receive(NOMINAL, 0x709, &[0x7F]);
    assert_eq!(emergencies(&master), [[0, 0, 0, 0x30, 0x81, 9, 0, 0]]);
}

/// Given a download to slave 9, when slave 2 is off the bus and lost, then the download goes on.
///
/// Verifies: ECSS 5.3.3.2.2a, 6.1a
/// Notices: ECSS 5.3.3.2.2a: the loss of one slave aborts the SDO transfer with another one.
#[test]
fn transfer_goes_on_while_another_slave_is_lost() {
    let mut master = powered(&STANDARD);
    master.transmitted(NOMINAL, frame(0x701, &[5]));
    for raw in [2, 8, 9] {
        master.receive(NOMINAL, 0x700 + raw, &[5]);
        // The answer to the question for 1000h.
        master.receive(NOMINAL, 0x580 + raw, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    }
    master.run_until(ms(200));
    master.receive(NOMINAL, 0x708, &[5]);
    master.receive(NOMINAL, 0x709, &[5]);
    master.touch(|master, _| {
        let client = master.claim_sdo(node(9), Waker::noop()).expect("it is free");
        client.start_download(Address::new(0x6300, 0), 5, Mode::Segmented);
        assert_eq!(client.push(&[1, 2, 3, 4, 5]), 5);
    });
    master.clear();
    master.run_until(ms(260));
    // One of three is silent: the master stays on the bus.
    assert_eq!(master.events, [MasterEvent::SlaveLost { node: node(2) }]);
    let requests = |master: &Bench<Master>| -> Vec<[u8; 8]> {
        let sent = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x609);
        sent.map(|sent| sent.frame.padded()).collect()
    };
    assert_eq!(requests(&master), [[0; 8]; 0], "no abort");
    master.receive(NOMINAL, 0x589, &[0x60, 0x00, 0x63, 0, 0, 0, 0, 0]);
    assert_eq!(requests(&master), [[0x05, 1, 2, 3, 4, 5, 0, 0]]);
}

/// Given a master that reads 1001h of slave 2, when that slave is off the bus and does not answer, then the SDO client is free for
/// slave 9.
///
/// Verifies: ECSS 5.3.3.2.2a, 5.3.3.2.3k, 6.1a
/// Notices: ECSS 5.3.3.2.2a: the SDO client stays taken after a slave that left the bus did not answer.
/// Notices: ECSS 5.3.3.2.3k: the SDO client stays taken after a slave behind the cut did not answer.
#[test]
fn client_is_free_after_a_lost_slave_left_1001h_unanswered() {
    let mut master = powered(&STANDARD);
    master.transmitted(NOMINAL, frame(0x701, &[5]));
    for raw in [2, 8, 9] {
        master.receive(NOMINAL, 0x700 + raw, &[5]);
        // The answer to the question for 1000h.
        master.receive(NOMINAL, 0x580 + raw, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    }
    // Slave 2 boots again: the master reads its error register.
    master.has_no_errors = false;
    master.clear();
    master.receive(NOMINAL, 0x702, &[0]);
    assert_eq!(requests(&master), [[0x40, 0x01, 0x10, 0, 0, 0, 0, 0]]);
    // It is not heard any more. The SDO timeout is 500 ms.
    for at in (100..=700).step_by(100) {
        master.run_until(ms(at));
        [0x708, 0x709].into_iter().for_each(|id| master.receive(NOMINAL, id, &[5]));
    }
    assert!(master.events.contains(&MasterEvent::SlaveLost { node: node(2) }));
    master.clear();
    master.touch(|master, _| {
        let client = master.claim_sdo(node(9), Waker::noop()).expect("it is free");
        client.start_upload(Address::new(0x6300, 0), 4, Mode::Segmented);
    });
    let sent: Vec<_> = master.sent.iter().map(|sent| (sent.frame.id().raw(), sent.frame.padded())).collect();
    assert_eq!(sent, [(0x609, [0x40, 0x00, 0x63, 0, 0, 0, 0, 0])]);
}

/// Given a master that knows the errors of slave 2, when its own controller was bus-off because of a short, then it reads the error
/// register again at the next heartbeat: it may have missed emergencies.
///
/// Verifies: ECSS 5.3.3.2.3j
/// Notices: ECSS 5.3.3.2.3j: errors of slaves that changed while the master was bus-off are not read.
#[test]
fn errors_of_slaves_are_read_again_after_bus_off() {
    let mut master = powered(&STANDARD);
    master.transmitted(NOMINAL, frame(0x701, &[5]));
    master.receive(NOMINAL, 0x702, &[5]);
    // The answer to the question for 1000h.
    master.receive(NOMINAL, 0x582, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    master.has_no_errors = false;
    master.clear();
    master.receive(NOMINAL, 0x702, &[5]);
    assert_eq!(requests(&master), [[0; 8]; 0], "known");
    master.health(NOMINAL, state(ErrorState::BusOff));
    master.health(NOMINAL, state(ErrorState::Active));
    master.receive(NOMINAL, 0x702, &[5]);
    assert_eq!(requests(&master), [[0x40, 0x01, 0x10, 0, 0, 0, 0, 0]]);
}

/// Entry 8 is that of slave 9; the others have 250 ms.
///
/// Verifies: ECSS 8.3.1b, 8.3.1c, 6.5.2a
/// Notices: ECSS 6.5.2a: the longest time of 1016h is that of all slaves.
#[test]
fn a_slave_is_lost_after_its_own_time_of_1016h() {
    let consumer = |master: &mut Bench<Master>, sub, node: u32, time: u32| {
        assert_eq!(write(master, 0x1016, sub, node << 16 | time, 4), Ok(()));
    };
    let mut master = powered(&STANDARD);
    assert_eq!(lost_at(&mut master), Some(251));
    let mut master = powered(&STANDARD);
    consumer(&mut master, 8, 9, 600);
    // What is common to all is the longest.
    assert_eq!(master.node.status(master.now).redundancy.consumer, span(600));
    assert_eq!(lost_at(&mut master), Some(601));
    let mut master = powered(&STANDARD);
    consumer(&mut master, 8, 9, 150);
    assert_eq!(master.node.status(master.now).redundancy.consumer, span(250));
    assert_eq!(lost_at(&mut master), Some(151));
    let mut master = powered(&STANDARD);
    consumer(&mut master, 7, 8, 400);
    assert_eq!(lost_at(&mut master), Some(251));
    // Without a time of its own: the longest of the others.
    let mut master = powered(&STANDARD);
    consumer(&mut master, 8, 0, 0);
    consumer(&mut master, 7, 8, 600);
    assert_eq!(lost_at(&mut master), Some(601));
}

/// Given entries without a Node-ID of 1 to 127 or without a time, then they are not in use (CiA 301 7.5.2.15): the longest consumer
/// time is that of the others, and an entry that names a node again takes no time from it.
///
/// Verifies: ECSS 8.3.1c, 6.5.2a, 8.3.1b
/// Notices: ECSS 6.5.2a: an entry of 1016h with a Node-ID above 127 is in use.
#[test]
fn entries_of_1016h_not_in_use_delay_no_decision() {
    let common = |master: &Bench<Master>| master.node.status(master.now).redundancy.consumer;
    for unused in [0x0000_FFFF, 0x0080_FFFF, 0x00FF_FFFF, 0x0009_0000] {
        let mut master = powered(&STANDARD);
        assert_eq!(write(&mut master, 0x1016, 8, unused, 4), Ok(()));
        assert_eq!(common(&master), span(250), "{unused:08X}h");
        assert_eq!(lost_at(&mut master), Some(251), "{unused:08X}h");
    }
    // Without an entry in use: the time of the profile, not one that was written before.
    let mut master = powered(&STANDARD);
    assert_eq!(write(&mut master, 0x1016, 1, 2 << 16 | 60_000, 4), Ok(()));
    assert_eq!(common(&master), span(60_000));
    for sub in 1..=8 {
        assert_eq!(write(&mut master, 0x1016, sub, 0, 4), Ok(()));
    }
    assert_eq!(common(&master), span(250));
    let mut master = powered(&STANDARD);
    assert_eq!(write(&mut master, 0x1016, 8, 9 << 16, 4), Ok(()));
    assert_eq!(write(&mut master, 0x1016, 7, 9 << 16 | 600, 4), Ok(()));
    assert_eq!(write(&mut master, 0x1016, 6, 8 << 16 | 900, 4), Ok(()));
    assert_eq!(common(&master), span(900));
    assert_eq!(lost_at(&mut master), Some(601), "its own time, not the longest");
}

const STAMP: [u32; 2] = [12_321, 43_200_000];

/// Slave 2 has one setting.
const STAMPED: Profile = Profile {
    slaves: &[AssignedSlave {
        node: TWO,
        mandatory: true,
        expected: Expected { device_type: 0, identity: [0; 4], stamp: STAMP },
    }],
    settings: &[Setting { node: TWO, at: Address::new(0x1029, 1), value: &[1] }],
    ..STANDARD
};

/// The objects of slave 2 that are read (index, sub-index) or written (and value) until it is started; it answers with
/// this stamp, and its setting differs.
fn booted(master: &mut Bench<Master>, stamp: [u32; 2]) -> Vec<(u16, u8, Option<u32>)> {
    master.clear();
    master.receive(NOMINAL, 0x702, &[0x00]);
    let mut transfers = vec![];
    let mut count = 0;
    while let Some([command, low, high, sub, data @ ..]) = requests(master).get(count).copied() {
        count += 1;
        let index = u16::from_le_bytes([low, high]);
        if matches!(index, 0x1400 | 0x1014 | 0x1800..=0x1807) {
            master.receive(NOMINAL, 0x582, &absent(index, sub));
            continue;
        }
        let value = match index {
            0x1020 => stamp[usize::from(sub) - 1],
            _ => 0,
        };
        let is_read = command == 0x40;
        transfers.push((index, sub, (!is_read).then_some(u32::from_le_bytes(data))));
        let size = if index == 0x1029 { 0x4F } else { 0x43 };
        let [a, b, c, d] = value.to_le_bytes();
        let answer =
            if is_read { [size, low, high, sub, a, b, c, d] } else { [0x60, low, high, sub, 0, 0, 0, 0] };
        master.receive(NOMINAL, 0x582, &answer);
    }
    assert!(master.sent.iter().any(|sent| sent.frame.id().raw() == 0 && sent.frame.data() == [1, 2]));
    transfers
}

#[test]
fn the_expected_stamp_decides_whether_a_slave_is_configured() {
    let (read_type, read_date, read_time) = ((0x1000, 0, None), (0x1020, 1, None), (0x1020, 2, None));
    let configures = [(0x1029, 1, None), (0x1029, 1, Some(1))];
    let mut master = powered(&STAMPED);
    assert_eq!([read(&mut master, 0x1F26, 2), read(&mut master, 0x1F27, 2)], STAMP);
    assert_eq!([read(&mut master, 0x1F26, 3), read(&mut master, 0x1F27, 3)], [0, 0]);
    assert_eq!(booted(&mut master, STAMP), [read_type, read_date, read_time]);
    // Another one is expected from now on.
    assert_eq!(write(&mut master, 0x1F26, 2, 12_322, 4), Ok(()));
    let stamps = [(0x1020, 1, Some(12_322)), (0x1020, 2, Some(STAMP[1]))];
    let expected: Vec<_> = [read_type, read_date].into_iter().chain(configures).chain(stamps).collect();
    assert_eq!(booted(&mut master, STAMP), expected);
    assert_eq!(booted(&mut master, [12_322, STAMP[1]]), [read_type, read_date, read_time]);
    assert_eq!(write(&mut master, 0x1F27, 2, 5, 4), Ok(()));
    let stamps = [(0x1020, 1, Some(12_322)), (0x1020, 2, Some(5))];
    let expected: Vec<_> =
        [read_type, read_date, read_time].into_iter().chain(configures).chain(stamps).collect();
    assert_eq!(booted(&mut master, [12_322, STAMP[1]]), expected);
    // None: it is configured at each boot, and not stamped.
    assert_eq!(write(&mut master, 0x1F26, 2, 0, 4), Ok(()));
    assert_eq!(write(&mut master, 0x1F27, 2, 0, 4), Ok(()));
    let expected: Vec<_> = [read_type].into_iter().chain(configures).collect();
    assert_eq!(booted(&mut master, [0, 0]), expected);
}

/// Verifies: ECSS 8.1b
/// Notices: ECSS 8.1b: the redundancy master takes a 1F80h that makes it no NMT master.
#[test]
fn its_own_startup_is_that_of_a_master() {
    let mut master = powered(&STANDARD);
    assert_eq!(read(&mut master, 0x1F80, 0), 1);
    for value in [0, 2, 4, 5, 9, 0x8000_0001] {
        assert_eq!(write(&mut master, 0x1F80, 0, value, 4), Err(0x0609_0030), "{value}");
    }
    assert_eq!(write(&mut master, 0x1F80, 0, 1, 4), Ok(()));
    assert_eq!(read(&mut master, 0x1F80, 0), 1);
}

/// Verifies: ECSS 6.1a
#[test]
fn client_block_download_goes_on_after_the_outbox_was_full() {
    const NINE: NodeId = NodeId::of::<9>();
    const VALUE: [u8; 200] = [0xA5; 200];
    // 29 segments.
    let segments = |master: &Bench<Master>| -> Vec<u8> {
        let sent = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x609);
        sent.map(|sent| sent.frame.data()[0]).collect()
    };
    let mut master = powered(&STANDARD);
    master.touch(|master, _| {
        let client = master.claim_sdo(NINE, Waker::noop()).expect("nobody has it");
        client.start_download(Address::new(0x6300, 0), VALUE.len(), Mode::Block);
        assert_eq!(client.push(&VALUE), VALUE.len());
    });
    assert_eq!(segments(&master).len(), 1, "the request");
    master.clear();
    master.receive(NOMINAL, 0x589, &[0xA4, 0x00, 0x63, 0, 127, 0, 0, 0]);
    let window = segments(&master).len();
    assert!(window > 0 && window < 29, "as many as a bus takes: {window}");
    // Some leave, some never come to the bus: what is behind them follows all the same.
    let mut sent = vec![];
    while sent.len() + segments(&master).len() < 29 {
        let on_their_way: Vec<_> = std::mem::take(&mut master.sent);
        let count = on_their_way.iter().filter(|sent| sent.frame.id().raw() == 0x609).count();
        assert!(count > 0, "it stands still after {} segments", sent.len());
        sent.extend(
            on_their_way.iter().filter(|sent| sent.frame.id().raw() == 0x609).map(|s| s.frame.data()[0]),
        );
        master.link(NOMINAL, LinkEvent::Unsent { frames: count as u16 });
    }
    sent.extend(segments(&master));
    let expected: Vec<u8> = (1..=28).chain([29 | 0x80]).collect();
    assert_eq!(sent, expected);
    // The server has the last ones only, that is none in their turn: all of them come again.
    master.clear();
    master.receive(NOMINAL, 0x589, &[0xA2, 0, 127, 0, 0, 0, 0, 0]);
    assert_eq!(segments(&master)[0], 1);
    for _ in 0..29 {
        let on_their_way = std::mem::take(&mut master.sent);
        on_their_way.iter().for_each(|sent| master.transmitted(sent.bus, sent.frame));
    }
    master.receive(NOMINAL, 0x589, &[0xA2, 29, 127, 0, 0, 0, 0, 0]);
    let end = segments(&master);
    assert_eq!(end.len(), 1);
    assert_eq!(end[0] & 0xE3, 0xC1, "the end of the block");
    master.receive(NOMINAL, 0x589, &[0xA1, 0, 0, 0, 0, 0, 0, 0]);
    let outcome = master.node.claimed_sdo(Waker::noop()).outcome();
    assert_eq!(outcome, Some(Ok(200)));
}
