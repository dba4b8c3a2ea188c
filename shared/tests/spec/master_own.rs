//! What the master has as a device of its own: SDO server, self-test, last reset, state of its controllers, commands in 1F82h.

use ecss_can::emcy::PostMortem;
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::extend::LinkEvent;
use ecss_can::node::{MasterEvent, MasterRequest, SelfTest};
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Duration, NodeId};

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, frame, ms, node};
use crate::console;
use crate::device::fixture;
use crate::instrument::STANDARD;
use crate::master_device::{powered, read, write};

/// What it sent as an SDO server since the last clear.
fn answers(master: &Bench<Master>) -> Vec<[u8; 8]> {
    let sent = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x581);
    sent.map(|sent| sent.frame.padded()).collect()
}

/// CiA 302-2, object 1F82h: 4 stop, 5 start, 6 reset node, 7 reset communication, 127 Pre-operational; sub-index 128 is all
/// nodes. CiA 301 7.3.2.2: the commands on the bus.
///
/// Verifies: ECSS 6.5.1a.1, 6.5.1a.2, 6.5.1a.3, 6.5.1a.4, 6.5.1a.5
/// Notices: ECSS 6.5.1a.2: a stop that is requested in 1F82h sends Enter pre-operational.
#[test]
fn each_value_of_request_nmt_is_a_command() {
    for (value, command) in [(4, 0x02), (5, 0x01), (6, 0x81), (7, 0x82), (127, 0x80)] {
        for (sub, target) in [(2, 2), (127, 127), (128, 0)] {
            let mut master = powered(&STANDARD);
            assert_eq!(write(&mut master, 0x1F82, sub, value, 1), Ok(()));
            assert!(
                master.frames().contains(&(NOMINAL, frame(0x000, &[command, target]))),
                "{value} to {sub}"
            );
        }
    }
}

/// Given a master whose active bus is the redundant one, then each command that a client asks for in 1F82h goes out there, and there
/// alone.
///
/// Verifies: ECSS 6.5.1a.1, 6.5.1a.2, 6.5.1a.3, 6.5.1a.4, 6.5.1a.5
/// Notices: ECSS 6.5.1a.1: the master commands slaves on the nominal bus.
#[test]
fn each_request_nmt_goes_out_on_the_active_redundant_bus() {
    for (value, command) in [(4, 0x02), (5, 0x01), (6, 0x81), (7, 0x82), (127, 0x80)] {
        for (sub, target) in [(2, 2), (127, 127), (128, 0)] {
            let mut master = powered(&STANDARD);
            master.request(MasterRequest::SwitchBus(REDUNDANT));
            master.run_until(ms(10));
            master.transmitted(REDUNDANT, frame(0x701, &[0x05]));
            assert_eq!(master.node.status(master.now).active, REDUNDANT);
            master.clear();
            master.receive(REDUNDANT, 0x601, &[0x2F, 0x82, 0x1F, sub, value, 0, 0, 0]);
            let sent = master.frames().into_iter().filter(|(_, frame)| frame.id().raw() == 0);
            let expected = [(REDUNDANT, frame(0x000, &[command, target]))];
            assert_eq!(sent.collect::<Vec<_>>(), expected, "{value} to {sub}");
        }
    }
}

/// CiA 301 7.2.4.3.3: a number may come in a segment, too.
///
/// Verifies: ECSS 6.1a
/// Notices: ECSS 6.1a: the four bytes of the size are written as the value.
#[test]
fn a_number_is_downloaded_in_a_segment() {
    let mut master = powered(&STANDARD);
    master.receive(NOMINAL, 0x601, &[0x21, 0x06, 0x10, 0, 4, 0, 0, 0]);
    assert_eq!(answers(&master), [[0x60, 0x06, 0x10, 0, 0, 0, 0, 0]]);
    assert_eq!(master.node.objects().communication.sync.cycle_period, 100_000);
    // Three of seven bytes do not count, and no segment follows.
    master.clear();
    master.receive(NOMINAL, 0x601, &[0x07, 0x20, 0x4E, 0, 0, 0, 0, 0]);
    assert_eq!(answers(&master), [[0x20, 0, 0, 0, 0, 0, 0, 0]]);
    assert_eq!(read(&mut master, 0x1006, 0), 20_000);
}

/// Given a transfer that its client does not go on with, then it is aborted after the SDO timeout (0504 0000h).
///
/// Verifies: ECSS 6.1a
/// Notices: ECSS 6.1a: the SDO server of a master has no timeout.
#[test]
fn a_client_that_falls_silent_is_aborted() {
    let mut master = powered(&STANDARD);
    master.receive(NOMINAL, 0x601, &[0x21, 0x06, 0x10, 0, 4, 0, 0, 0]);
    master.clear();
    master.run_until(ms(1) + STANDARD.sdo_timeout - Duration::from_micros(1));
    assert_eq!(answers(&master), [[0; 8]; 0]);
    master.run_until(ms(1) + STANDARD.sdo_timeout);
    assert_eq!(answers(&master), [[0x80, 0x06, 0x10, 0, 0, 0, 0x04, 0x05]]);
}

/// CiA 301 7.2.4.3: requests have eight bytes.
///
/// Verifies: ECSS 6.1a
/// Notices: ECSS 6.1a: a request of four bytes is answered.
#[test]
fn a_request_of_another_length_is_counted_and_not_answered() {
    let mut master = powered(&STANDARD);
    master.receive(NOMINAL, 0x601, &[0x40, 0x06, 0x10, 0]);
    assert_eq!(answers(&master), [[0; 8]; 0]);
    assert_eq!(master.node.status(master.now).counters.nominal.malformed, 1);
}

/// Verifies: ECSS 6.7c
/// Notices: ECSS 6.7c: the result of the self-test of a master is not in its dictionary.
#[test]
fn the_result_of_its_self_test_is_in_the_dictionary() {
    let mut master = powered(&STANDARD);
    let result = SelfTest { progress: SelfTest::FAILED, failures: 0x12 };
    master.touch(|master, now| master.report_self_test(result, now));
    assert_eq!(
        (read(&mut master, 0x2031, 1), read(&mut master, 0x2031, 2)),
        (u32::from(SelfTest::FAILED), 0x12)
    );
}

/// Given a self-test that failed, when the master or a slave resets its communication, then the result is still there. It belongs
/// to no communication object.
///
/// Verifies: ECSS 6.7c
/// Notices: ECSS 6.7c: Reset communication erases the result of the self-test.
#[test]
fn result_of_the_self_test_outlives_reset_communication() {
    let result = SelfTest { progress: SelfTest::FAILED, failures: 0x12 };
    let mut master = powered(&STANDARD);
    master.touch(|master, now| master.report_self_test(result, now));
    master.request(MasterRequest::Nmt(NmtMessage {
        command: Command::ResetCommunication,
        target: Target::Node(NodeId::MASTER),
    }));
    assert_eq!((read(&mut master, 0x2031, 1), read(&mut master, 0x2031, 2)), (3, 0x12));
    let mut slave = fixture::operational();
    slave.touch(|slave, now| slave.report_self_test(result, now));
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(fixture::read(&mut slave, 0x2031, 1), [3, 0, 0, 0]);
    assert_eq!(fixture::read(&mut slave, 0x2031, 2), [0x12, 0, 0, 0]);
}

/// Given a record of the last reset, then an emergency follows the boot-up message: 6100h, generic (01h), program counter.
///
/// Verifies: ECSS 6.4a.1, 6.4a.2
#[test]
fn its_last_reset_is_reported() {
    let record = PostMortem { cause: PostMortem::WATCHDOG, row: 3, pc: 0x0800_1234, ..PostMortem::default() };
    let master = Master::builder(&STANDARD, console::Console::default()).post_mortem(record).build();
    let mut master = Bench::new(master);
    assert_eq!(read(&mut master, 0x1014, 0), 0x81);
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    master.run_until(ms(50));
    let emergency = master.sent.iter().find(|sent| sent.frame.id().raw() == 0x081).expect("an emergency");
    assert_eq!(emergency.frame.data(), [0x00, 0x61, 0x01, PostMortem::WATCHDOG, 0x34, 0x12, 0x00, 0x08]);
    assert_eq!((read(&mut master, 0x2032, 2), read(&mut master, 0x2032, 3)), (3, 0x0800_1234));
}

/// Emergencies that the master sent: code and source.
fn emergencies(master: &Bench<Master>) -> Vec<[u8; 4]> {
    let sent = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x081);
    sent.map(|sent| [0, 1, 2, 3].map(|nth| sent.frame.data()[nth])).collect()
}

/// Error passive for want of an acknowledgement.
const UNACKNOWLEDGED: Health =
    Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };

/// Given an error before the boot-up message left, then its emergency, which would win arbitration, waits for that message.
///
/// Verifies: ECSS 6.5.3a, 6.4a.2
/// Notices: ECSS 6.5.3a: the emergency of a master goes out before its boot-up message.
#[test]
fn emergency_waits_for_the_boot_up_message() {
    let mut master = Bench::new(console::master(&STANDARD));
    master.run_until(ms(1));
    master.health(NOMINAL, Health { last_error: LastError::BitRecessive, ..UNACKNOWLEDGED });
    master.run_until(ms(90));
    assert_eq!(emergencies(&master), [] as [[u8; 4]; 0]);
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    assert_eq!(emergencies(&master), [[0x20, 0x81, 0x11, 0]]);
}

/// Given a master that is the first node on its bus, when it becomes error passive because nobody acknowledges, then that is
/// no error. When another node was there, it is one.
///
/// Verifies: ECSS 5.6.2b, 6.4a, 6.4a.1, 6.4a.2
/// Notices: ECSS 6.4a: an end of error passive is reported as a recovery from bus-off.
/// Notices: ECSS 6.4a.1: a controller that was error passive is said to have recovered from bus-off.
/// Notices: ECSS 6.4a.2: error passive has another code than 8120h.
#[test]
fn first_node_on_a_bus_reports_no_passive_controller() {
    let mut master = powered(&STANDARD);
    master.health(NOMINAL, UNACKNOWLEDGED);
    assert_eq!((read(&mut master, 0x1003, 0), read(&mut master, 0x2020, 1)), (0, 1));
    // A client's requests and their answers are frames of two nodes.
    for _ in 0..8 {
        read(&mut master, 0x1001, 0);
    }
    master.health(NOMINAL, Health::default());
    master.health(NOMINAL, UNACKNOWLEDGED);
    assert_eq!((read(&mut master, 0x1003, 0), read(&mut master, 0x1003, 1)), (1, 0x8120));
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    assert_eq!(emergencies(&master).last(), Some(&[0x20, 0x81, 0x11, 0]));
}

/// Verifies: ECSS 5.6.2a, 8.3.3b
/// Notices: ECSS 8.3.3b: the master stays on the bus whose controller failed.
#[test]
fn a_controller_that_fails_is_told_once_and_its_bus_is_left() {
    let mut master = powered(&STANDARD);
    master.clear_events();
    master.link(REDUNDANT, LinkEvent::Stalled);
    assert_eq!(master.events, [MasterEvent::BusStalled { bus: REDUNDANT }]);
    let health = |state, tec| Health { state, tec, rec: 0, last_error: LastError::BitRecessive };
    let mut failed = 0;
    for at in 1..=u64::from(STANDARD.bus_off.attempts) + 1 {
        assert_eq!((master.node.status(master.now).active, failed), (NOMINAL, 0));
        master.run_until(ms(1 + 5 * at));
        master.clear();
        master.health(NOMINAL, health(ErrorState::BusOff, 255));
        failed +=
            master.events.iter().filter(|event| **event == MasterEvent::BusFailed { bus: NOMINAL }).count();
        if failed == 0 {
            master.health(NOMINAL, Health::default());
        }
    }
    assert_eq!((master.node.status(master.now).active, failed), (REDUNDANT, 1));
}

/// Given a master on a bus that is dominant because of a short, when the recovery of its controller never ends, then the master uses
/// the redundant bus after three attempts of 10 ms and 50 ms.
///
/// Verifies: ECSS 5.3.3.2.3i, 5.6.2a, 8.3.3b
/// Notices: ECSS 5.3.3.2.3i: a master stays on a bus on which its recovery never ends.
/// Notices: ECSS 5.6.2a: a recovery that never ends is waited for.
/// Notices: ECSS 8.3.3b: the master stays on a bus on which its recovery never ends.
#[test]
fn bus_on_which_recovery_never_ends_is_left() {
    let mut master = powered(&STANDARD);
    master.clear();
    master.health(NOMINAL, Health { state: ErrorState::BusOff, tec: 255, ..Health::default() });
    master.run_until(ms(170));
    assert_eq!(master.node.status(master.now).active, NOMINAL);
    master.run_until(ms(190));
    let (from, to) = (NOMINAL, REDUNDANT);
    assert!(master.events.contains(&MasterEvent::BusFailed { bus: from }), "{:?}", master.events);
    let switched = MasterEvent::BusSwitched { from, to, cause: SwitchCause::BusOff };
    assert!(master.events.contains(&switched), "{:?}", master.events);
}

/// Data sheets are written from the dictionary of a master that never ran.
#[test]
fn its_dictionary_is_there_without_it() {
    let objects = console::master(&STANDARD).into_objects();
    assert_eq!(objects.communication.heartbeat.time, 100);
    assert_eq!(objects.consumers.consumer_heartbeat[0], u32::from(node(2).get()) << 16 | 250);
}

/// Counters of the SYNCs that it sent since the last clear.
fn counters(master: &Bench<Master>) -> Vec<u8> {
    let sent = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x080);
    sent.map(|sent| sent.frame.data()[0]).collect()
}

/// Given SYNCs with a counter, when the master was stopped and started, then the first SYNC has counter 1 (CiA 301 7.2.5.2).
/// SYNC goes on in Pre-operational, and so does its counter.
///
/// Verifies: ECSS 6.9c, 6.3b, 6.5.4a
/// Notices: ECSS 6.9c: the counter starts again in Operational, not after Stopped.
/// Notices: ECSS 6.5.4a: a stopped master sends SYNC.
#[test]
fn sync_counter_begins_with_1_after_the_master_was_stopped() {
    let own = |command| MasterRequest::Nmt(NmtMessage { command, target: Target::Node(NodeId::MASTER) });
    let (start, stop, enter) = (Command::Start, Command::Stop, Command::EnterPreOperational);
    let cases: [(&[Command], [u8; 2]); 6] = [
        (&[stop, start], [1, 2]),
        (&[stop, enter], [1, 2]),
        (&[stop, enter, start], [1, 2]),
        (&[stop, stop, start, stop, start], [1, 2]),
        (&[enter, start], [4, 5]),
        (&[start], [4, 5]),
    ];
    for (commands, expected) in cases {
        let mut master = powered(&STANDARD);
        for (index, value, len) in [(0x1006, 0, 4), (0x1019, 10, 1), (0x1006, 10_000, 4)] {
            assert_eq!(write(&mut master, index, 0, value, len), Ok(()));
        }
        master.clear();
        master.run_until(ms(35));
        assert_eq!(counters(&master), [1, 2, 3]);
        master.clear();
        commands.iter().for_each(|command| master.request(own(*command)));
        master.run_until(ms(55));
        assert_eq!(counters(&master), expected, "{commands:?}");
        // A pause of several periods.
        master.request(own(stop));
        master.clear();
        master.run_until(ms(205));
        assert_eq!(counters(&master), []);
        master.request(own(start));
        master.run_until(ms(225));
        assert_eq!(counters(&master)[..2], [1, 2], "{commands:?}");
    }
}
