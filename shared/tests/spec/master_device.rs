//! The master as a CANopen device: its dictionary over SDO, and the objects of boot-up.

use crate::instrument::STANDARD;
use ecss_can::boot::{AssignedSlave, BootCause, BootError, BootFailure, BootProgress, Expected};
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::{MasterEvent, MasterRequest, Node, SelfTest};
use ecss_can::profile::Profile;
use ecss_can::types::{Address, NmtState, NodeId};

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, frame, ms, node, span};
use crate::console;

pub(crate) const TWO: NodeId = NodeId::of::<2>();

pub(crate) const BOOTS_TWO: Profile = Profile {
    slaves: &[AssignedSlave {
        node: TWO,
        mandatory: true,
        expected: Expected { device_type: 0, identity: [0, 0x5015, 0, 0], stamp: [0; 2] },
    }],
    ..STANDARD
};

pub(crate) fn powered(profile: &Profile) -> Bench<Master> {
    let mut master = Bench::new(console::master(profile));
    master.run_until(ms(1));
    master.clear();
    master
}

/// The answer to an SDO request.
pub(crate) fn ask(master: &mut Bench<Master>, request: [u8; 8]) -> [u8; 8] {
    master.sent.clear();
    master.receive(NOMINAL, 0x601, &request);
    if master.sent.iter().all(|sent| sent.frame.id().raw() != 0x581) {
        // A save is answered when it has ended.
        master.finish_save();
    }
    let answers: Vec<[u8; 8]> = master
        .sent
        .iter()
        .filter(|sent| sent.frame.id().raw() == 0x581)
        .map(|sent| sent.frame.padded())
        .collect();
    assert_eq!(answers.len(), 1, "{request:02X?}");
    answers[0]
}

/// The answer of a slave without this object: abort code 0602 0000h.
pub(crate) fn absent(index: u16, sub: u8) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    [0x80, low, high, sub, 0, 0, 0x02, 0x06]
}

/// Slave 2 answers that it has no PDOs and no emergencies: neither 1400h nor 1014h and 1800h to 1807h.
pub(crate) fn has_no_cob_ids<N: Node>(master: &mut Bench<N>) {
    let tpdos = (0x1800..0x1808).map(|index| (index, 1));
    for (index, sub) in [(0x1400, 1), (0x1014, 0)].into_iter().chain(tpdos) {
        master.receive(NOMINAL, 0x582, &absent(index, sub));
    }
}

pub(crate) fn read(master: &mut Bench<Master>, index: u16, sub: u8) -> u32 {
    let [low, high] = index.to_le_bytes();
    let [command, _, _, _, a, b, c, d] = ask(master, [0x40, low, high, sub, 0, 0, 0, 0]);
    assert!([0x43, 0x47, 0x4B, 0x4F].contains(&command), "{index:04X} sub {sub}: {command:02X}");
    u32::from_le_bytes([a, b, c, d])
}

pub(crate) fn write(master: &mut Bench<Master>, index: u16, sub: u8, value: u32, len: u8) -> Result<(), u32> {
    let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
    let answer = ask(master, [0x23 | (4 - len) << 2, low, high, sub, a, b, c, d]);
    match answer[0] {
        0x60 => Ok(()),
        0x80 => Err(u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]])),
        other => panic!("{other:02X}"),
    }
}

/// The SDO requests sent to slave 2 since the last clear.
pub(crate) fn requests(master: &Bench<Master>) -> Vec<[u8; 8]> {
    let sent = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x602);
    sent.map(|sent| sent.frame.padded()).collect()
}

/// Verifies: ECSS 6.8a, 8.3.1b
/// Notices: ECSS 8.3.1b: Ntoggle of a master has the value of Ttoggle.
#[test]
fn its_dictionary_is_read_over_sdo() {
    let mut master = powered(&BOOTS_TWO);
    for (index, sub, value) in [
        (0x1005, 0, 0x4000_0080),
        (0x1006, 0, 100_000),
        (0x1016, 1, 2 << 16 | 250),
        (0x1017, 0, 100),
        (0x1018, 2, 0x5015),
        (0x1019, 0, 0),
        (0x1280, 1, 0x8000_0000),
        (0x1280, 2, 0x8000_0000),
        (0x1280, 3, 0),
        (0x1F80, 0, 1),
        (0x1F81, 2, 0b1101),
        (0x1F81, 3, 0),
        (0x1F86, 2, 0x5015),
        (0x1F89, 0, 5_000),
        (0x2000, 0, 4),
        (0x2000, 1, 0),
        (0x2000, 2, 2),
        (0x2000, 3, 255),
        (0x2000, 4, 0),
        (0x2040, 2, BootProgress::Awaited as u32),
        (0x2041, 2, 0),
    ] {
        assert_eq!(read(&mut master, index, sub), value, "{index:04X} sub {sub}");
    }
}

/// Verifies: ECSS 6.9c, 6.9d, 6.3b
/// Notices: ECSS 6.9d: a new period in 1006h ends SYNC.
/// Notices: ECSS 6.3b: the counter of SYNC goes above 1019h.
#[test]
fn sync_follows_its_objects_and_is_counted_when_1019h_says_so() {
    let mut master = powered(&STANDARD);
    assert_eq!(write(&mut master, 0x1019, 0, 3, 1), Err(0x0800_0022), "while SYNC is produced");
    assert_eq!(write(&mut master, 0x1006, 0, 0, 4), Ok(()));
    assert_eq!(write(&mut master, 0x1019, 0, 3, 1), Ok(()));
    assert_eq!(write(&mut master, 0x1006, 0, 10_000, 4), Ok(()));
    master.clear();
    master.run_until(ms(51));
    let counters: Vec<Vec<u8>> = master
        .sent
        .iter()
        .filter(|sent| sent.frame.id().raw() == 0x080)
        .map(|sent| sent.frame.data().to_vec())
        .collect();
    assert_eq!(counters, [[1], [2], [3], [1], [2]]);
}

/// Given a master that produces SYNC, when bit 30 of 1005h is cleared, then it sends no SYNC. When the bit is set again with another
/// COB-ID, then SYNC has this COB-ID.
///
/// Verifies: ECSS 6.9c, 6.3b, 6.10a, 6.10c
/// Notices: ECSS 6.9c: a write of 1005h does not reach the producer of SYNC.
/// Notices: ECSS 6.10c: SYNC keeps its COB-ID when 1005h is written.
#[test]
fn sync_follows_bit_30_and_cob_id_of_1005h() {
    let mut master = powered(&STANDARD);
    assert_eq!(write(&mut master, 0x1005, 0, 0x80, 4), Ok(()));
    master.clear();
    master.run_until(ms(300));
    assert_eq!(master.times(NOMINAL, 0x080), []);
    assert_eq!(write(&mut master, 0x1005, 0, 0x4000_0082, 4), Ok(()));
    master.run_until(ms(650));
    assert_eq!(master.times(NOMINAL, 0x080), []);
    assert_eq!(master.times(NOMINAL, 0x082).len(), 3);
}

/// Given a written 1017h, then a heartbeat of the master lives at most one period.
#[test]
fn its_heartbeat_lives_no_longer_than_1017h() {
    let mut master = powered(&STANDARD);
    for (period, lifetime) in [(30, 30), (100, 100), (1_000, 100)] {
        assert_eq!(write(&mut master, 0x1017, 0, period, 2), Ok(()));
        master.clear();
        let until = master.now + span(1_000);
        master.run_until(until);
        let beat = master.sent.iter().find(|sent| sent.frame.id().raw() == 0x701).expect("a heartbeat");
        assert_eq!(beat.expires.since(beat.at), span(lifetime), "{period} ms");
    }
}

/// 2043h is the largest delay of a SYNC in microseconds. The grid of the period stays.
#[test]
fn sync_is_dithered_when_2043h_says_so() {
    let mut master = powered(&STANDARD);
    assert_eq!(write(&mut master, 0x2043, 0, 1_001, 2), Err(0x0609_0031));
    assert_eq!(write(&mut master, 0x1006, 0, 10_000, 4), Ok(()));
    assert_eq!(write(&mut master, 0x2043, 0, 900, 2), Ok(()));
    let start = master.now.as_micros();
    master.clear();
    master.run_until(ms(301));
    let syncs = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x080);
    let late: Vec<u64> =
        (1..).zip(syncs).map(|(n, sent): (u64, _)| sent.at.as_micros() - start - n * 10_000).collect();
    assert!(late.len() >= 29 && late.iter().all(|late| *late <= 900), "{late:?}");
    assert!(late.iter().any(|late| *late < 300) && late.iter().any(|late| *late > 600), "{late:?}");
}

/// Verifies: ECSS 7.1.2a, 7.1.2c, 8.3.1c, 8.3.3a, 6.5.2a
/// Notices: ECSS 8.3.1c: a written 1017h of a master takes effect at the next write.
/// Notices: ECSS 7.1.2a: a master takes no sample of its time for a client.
/// Notices: ECSS 8.3.3a: a written 1017h ends the heartbeat of the master.
/// Notices: ECSS 6.5.2a: a written 1017h has no effect on the heartbeat of the master.
#[test]
fn the_heartbeat_follows_1017h_and_time_is_set_by_2010h() {
    let mut master = powered(&STANDARD);
    assert_eq!(write(&mut master, 0x1017, 0, 20, 2), Ok(()));
    master.clear();
    master.run_until(ms(61));
    assert_eq!(master.times(NOMINAL, 0x701), [21, 41, 61]);
    assert_eq!(write(&mut master, 0x2010, 1, 1_000, 4), Ok(()));
    assert_eq!(write(&mut master, 0x2010, 2, 0, 3), Ok(()));
    assert_eq!(read(&mut master, 0x2011, 1), 1_000);
}

/// Given a master whose heartbeat a client ended by a 1017h of zero, when 1017h gets a period again, or Reset communication restores
/// that of the profile, then its heartbeats are periodic again.
///
/// Verifies: ECSS 8.3.1b, 8.3.1c, 8.3.3a, 6.5.1a.5, 6.5.2a
/// Notices: ECSS 8.3.1c: 1017h that was zero begins no heartbeat of the master.
/// Notices: ECSS 8.3.3a: 1017h that was zero begins no heartbeat of the master.
/// Notices: ECSS 8.3.1b: after Reset communication the master keeps the 1017h that was written.
/// Notices: ECSS 8.3.3a: after Reset communication the master keeps the 1017h that was written.
/// Notices: ECSS 6.5.1a.5: after Reset communication the master keeps the 1017h that was written.
/// Notices: ECSS 6.5.2a: a master whose 1017h is zero sends heartbeats.
#[test]
fn heartbeat_of_the_master_resumes_after_a_1017h_of_zero() {
    for (is_reset, period) in [(false, 50), (true, 100)] {
        let mut master = powered(&STANDARD);
        assert_eq!(write(&mut master, 0x1017, 0, 0, 2), Ok(()));
        master.clear();
        master.run_until(ms(501));
        assert_eq!(master.times(NOMINAL, 0x701), []);
        if is_reset {
            let command = Command::ResetCommunication;
            master.request(MasterRequest::Nmt(NmtMessage { command, target: Target::Node(node(1)) }));
        } else {
            assert_eq!(write(&mut master, 0x1017, 0, 50, 2), Ok(()));
        }
        master.clear();
        master.run_until(ms(801));
        let times = master.times(NOMINAL, 0x701);
        assert!(times.len() as u64 >= 300 / period, "{times:?}");
        assert!(times.windows(2).all(|pair| pair[1] - pair[0] == period), "{times:?}");
        assert_eq!(read(&mut master, 0x1017, 0), u32::try_from(period).unwrap());
    }
}

/// Verifies: ECSS 6.5.1a.2, 6.5.1a.4
/// Notices: ECSS 6.5.1a.4: a request to reset all nodes in 1F82h is sent to node 128.
#[test]
fn request_nmt_commands_a_slave_and_tells_its_state() {
    let mut master = powered(&STANDARD);
    assert_eq!(read(&mut master, 0x1F82, 2), 0);
    master.receive(NOMINAL, 0x702, &[0x05]);
    assert_eq!(read(&mut master, 0x1F82, 2), 5);
    assert_eq!(write(&mut master, 0x1F82, 2, 4, 1), Ok(()));
    assert!(master.frames().contains(&(NOMINAL, frame(0x000, &[0x02, 2]))));
    assert_eq!(read(&mut master, 0x1F82, 2), 5, "as it was heard last");
    assert_eq!(write(&mut master, 0x1F82, 128, 6, 1), Ok(()));
    assert!(master.frames().contains(&(NOMINAL, frame(0x000, &[0x81, 0]))));
    assert_eq!(write(&mut master, 0x1F82, 2, 9, 1), Err(0x0609_0030));
    for _ in 0..4 {
        let until = master.now + ecss_can::types::Duration::from_millis(100);
        master.run_until(until);
    }
    assert_eq!(master.node.objects().application.network.request_nmt[1], 1, "missing");
}

/// Verifies: ECSS 6.7b, 6.7c
/// Notices: ECSS 6.7c: the object of the result does not show that the test of a master runs.
#[test]
fn a_self_test_is_the_applications_part() {
    let mut master = powered(&STANDARD);
    assert_eq!(write(&mut master, 0x2030, 0, 1, 1), Ok(()));
    assert_eq!(master.events[0], MasterEvent::SelfTest);
    assert_eq!(read(&mut master, 0x2031, 1), u32::from(SelfTest::RUNNING));
}

/// Given a slave that the master asks, when the answer comes from another node, on the other bus, or to another question, then the
/// master waits for the right one. Then it checks and starts the slave.
///
/// Verifies: ECSS 6.10m, 6.1a
/// Notices: ECSS 6.10m: the master takes the answer of another node for that of the slave that it asked.
/// Notices: ECSS 6.1a: the client takes the value of another object for its answer.
#[test]
fn a_slave_is_asked_checked_and_started() {
    let mut master = powered(&BOOTS_TWO);
    master.receive(NOMINAL, 0x702, &[0x00]);
    assert_eq!(requests(&master), [[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]]);
    // Other servers, other objects and other lengths are not its answer.
    master.receive(NOMINAL, 0x583, &[0x43, 0x00, 0x10, 0, 0, 0, 0, 0]);
    master.receive(NOMINAL, 0x582, &[0x43, 0x18, 0x10, 2, 0x15, 0x50, 0, 0]);
    master.receive(NOMINAL, 0x582, &[0x43, 0x00]);
    master.receive(REDUNDANT, 0x582, &[0x43, 0x00, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(requests(&master).len(), 1);
    let counters = master.node.status(master.now).counters;
    assert_eq!((counters.nominal.ignored, counters.nominal.malformed, counters.redundant.ignored), (2, 1, 1));
    master.receive(NOMINAL, 0x582, &[0x43, 0x00, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(requests(&master)[1], [0x40, 0x18, 0x10, 2, 0, 0, 0, 0]);
    master.receive(NOMINAL, 0x582, &[0x43, 0x18, 0x10, 2, 0x15, 0x50, 0, 0]);
    has_no_cob_ids(&mut master);
    assert!(master.frames().contains(&(NOMINAL, frame(0x000, &[1, 2]))));
    assert_eq!(read(&mut master, 0x2040, 2), BootProgress::Started as u32);
    assert_eq!(read(&mut master, 0x1280, 3), 2);
}

/// Given a master with SDO server and client, then 1200h has the COB-IDs of its server, and 1280h those of the server that it asked
/// last.
///
/// Verifies: ECSS 9.4.10f, 6.8a, 6.10a
/// Notices: ECSS 9.4.10f: 1280h of a master names the first server that it asked.
#[test]
fn sdo_parameters_of_the_master_are_those_in_use() {
    let mut master = powered(&STANDARD);
    assert_eq!([1, 2].map(|sub| read(&mut master, 0x1200, sub)), [0x601, 0x581]);
    for (raw, request, response) in [(3, 0x603, 0x583), (4, 0x604, 0x584)] {
        master.receive(NOMINAL, 0x700 + raw, &[0x7F]);
        let parameters = [1, 2, 3].map(|sub| read(&mut master, 0x1280, sub));
        assert_eq!(parameters, [request, response, u32::from(raw)]);
        master.receive(NOMINAL, 0x580 + raw, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    }
}

#[test]
fn boot_failure_stays_in_dictionary_until_slave_is_started() {
    let mut master = powered(&BOOTS_TWO);
    master.receive(NOMINAL, 0x702, &[0x00]);
    // An abort is asked for once more.
    for _ in 0..2 {
        assert!(!master.events.iter().any(|event| matches!(event, MasterEvent::BootFailed { .. })));
        master.receive(NOMINAL, 0x582, &[0x80, 0x00, 0x10, 0, 0x00, 0x00, 0x02, 0x06]);
    }
    let cause = BootCause::Transfer { at: Address::new(0x1000, 0), code: 0x0602_0000 };
    let failure = BootFailure { error: BootError::NoResponse, cause };
    let failed = MasterEvent::BootFailed { node: TWO, failure };
    assert!(master.events.contains(&failed), "{:?}", master.events);
    assert_eq!(read(&mut master, 0x2041, 2), u32::from(b'B'));
    assert_eq!(read(&mut master, 0x2042, 2), 0x0602_0000);
    master.receive(NOMINAL, 0x702, &[0x7F]);
    assert!(!master.frames().contains(&(NOMINAL, frame(0x000, &[1, 2]))));

    master.receive(NOMINAL, 0x702, &[0x00]);
    master.receive(NOMINAL, 0x582, &[0x43, 0x00, 0x10, 0, 0, 0, 0, 0]);
    master.receive(NOMINAL, 0x582, &[0x43, 0x18, 0x10, 2, 0x15, 0x50, 0, 0]);
    has_no_cob_ids(&mut master);
    assert_eq!((read(&mut master, 0x2041, 2), read(&mut master, 0x2042, 2)), (0, 0));
}

/// Verifies: ECSS 5.3.3.2.3e, 6.1a, 8.3.3b
/// Notices: ECSS 5.3.3.2.3e: a slave in its boot-up process is not booted on the redundant bus.
/// Notices: ECSS 8.3.3b: a request goes out on the new bus before it is announced.
#[test]
fn bus_switch_in_boot_aborts_on_new_bus_once_it_is_announced() {
    let mut master = powered(&BOOTS_TWO);
    master.receive(NOMINAL, 0x702, &[0x00]);
    master.clear();
    master.request(ecss_can::node::MasterRequest::SwitchBus(REDUNDANT));
    assert_eq!(requests(&master), [[0; 8]; 0]);
    master.transmitted(REDUNDANT, frame(0x701, &[0x05]));
    assert_eq!(requests(&master), [[0x80, 0, 0x10, 0, 0x22, 0, 0, 0x08]]);
    // The process begins anew when the slave is heard there.
    master.run_until(ms(20));
    master.clear();
    master.receive(REDUNDANT, 0x702, &[0x7F]);
    assert_eq!(master.frames(), [(REDUNDANT, frame(0x602, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]))]);
}

/// Verifies: ECSS 11.1c, 6.9d
/// Notices: ECSS 11.1c: SYNC does not wait for the mandatory slaves, as in the simplified boot-up.
/// Notices: ECSS 6.9d: SYNC does not begin when the mandatory slaves run.
#[test]
fn sync_waits_for_the_mandatory_slave() {
    let mut master = powered(&BOOTS_TWO);
    master.run_until(ms(450));
    assert!(master.times(NOMINAL, 0x080).is_empty());
    master.receive(NOMINAL, 0x702, &[0x00]);
    master.receive(NOMINAL, 0x582, &[0x43, 0x00, 0x10, 0, 0, 0, 0, 0]);
    master.receive(NOMINAL, 0x582, &[0x43, 0x18, 0x10, 2, 0x15, 0x50, 0, 0]);
    has_no_cob_ids(&mut master);
    master.run_until(ms(650));
    assert_eq!(master.times(NOMINAL, 0x080), [450, 500, 600]);
    master.transmitted(NOMINAL, frame(0x080, &[]));
    master.receive(NOMINAL, 0x702, &[0x05]);
    assert!(master.events.contains(&MasterEvent::BootCompleted));
    let state = MasterEvent::SlaveState { node: TWO, bus: NOMINAL, state: NmtState::Operational };
    assert!(master.events.contains(&state));
}

#[test]
fn an_assignment_written_in_flight_boots_the_slave() {
    let mut master = powered(&STANDARD);
    assert_eq!(write(&mut master, 0x1F81, 9, 0b0101, 4), Ok(()));
    master.receive(NOMINAL, 0x709, &[0x7F]);
    let asked = master.frames().contains(&(NOMINAL, frame(0x609, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0])));
    assert!(asked && !master.frames().contains(&(NOMINAL, frame(0x000, &[1, 9]))));
    assert_eq!(master.events[0], MasterEvent::Boot { node: node(9), progress: BootProgress::Awaited });
    assert_eq!(master.node.objects().application.network.assignment[8], 0b0101);
}
