//! The master asks new nodes who they are, and reports those that do not answer and those that speak in its name.
//!
//! Profile `standard`: SDO timeout 500 ms, Ttoggle consumer times 500 ms.

use crate::instrument::STANDARD;
use crate::master_device::has_no_cob_ids;
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::node::{MasterEvent, MasterRequest};
use ecss_can::profile::Profile;
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::NodeId;

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, frame, ms, node, span};
use crate::master_device::{BOOTS_TWO, powered, read};

const WHO: [u8; 8] = [0x40, 0, 0x10, 0, 0, 0, 0, 0];
const SOMEBODY: [u8; 8] = [0x43, 0, 0x10, 0, 0, 0, 0, 0];

/// When each node was asked, milliseconds.
fn questions(master: &Bench<Master>) -> Vec<(u16, u64)> {
    let asked = master.sent.iter().filter(|sent| sent.frame.data() == WHO);
    asked.map(|sent| (sent.frame.id().raw() - 0x600, sent.at.as_micros() / 1_000)).collect()
}

#[test]
fn new_nodes_are_asked_one_at_a_time() {
    let mut master = powered(&STANDARD);
    for raw in [0x705, 0x706, 0x707] {
        master.receive(NOMINAL, raw, &[0x05]);
    }
    assert_eq!(questions(&master), [(5, 1)]);
    master.receive(NOMINAL, 0x585, &SOMEBODY);
    assert_eq!(questions(&master), [(5, 1), (6, 1)]);
    // An abort is an answer, too.
    master.receive(NOMINAL, 0x586, &[0x80, 0, 0x10, 0, 0, 0, 2, 6]);
    assert_eq!(questions(&master), [(5, 1), (6, 1), (7, 1)]);
}

/// Heartbeats of these nodes every 100 ms, until `end` in milliseconds.
fn heartbeats(master: &mut Bench<Master>, ids: &[u16], end: u64) {
    for at in (master.now.as_micros() / 1_000 / 100 * 100 + 50..end).step_by(100) {
        master.run_until(ms(at));
        ids.iter().for_each(|id| master.receive(NOMINAL, *id, &[0x05]));
    }
}

fn unknown_nodes(master: &Bench<Master>) -> Vec<NodeId> {
    let unknown = |event: &MasterEvent| match event {
        MasterEvent::UnknownNode { node } => Some(*node),
        _ => None,
    };
    master.events.iter().filter_map(unknown).collect()
}

/// Given two nodes that send heartbeats and answer no SDO, Then each is asked three times, and reported the first
/// time. Between two questions the client is free for others as long as one takes.
#[test]
fn a_node_without_an_answer_is_asked_three_times() {
    let mut master = powered(&STANDARD);
    heartbeats(&mut master, &[0x705, 0x706], 4_400);
    let asked = [(5, 50), (6, 1_050), (5, 2_050), (6, 3_050), (5, 4_050)];
    assert_eq!(questions(&master), asked);
    assert_eq!(unknown_nodes(&master), [node(5), node(6)]);
    heartbeats(&mut master, &[0x705, 0x706], 9_000);
    assert_eq!(questions(&master), [&asked[..], &[(6, 5_050)]].concat());
    assert_eq!(unknown_nodes(&master), [node(5), node(6)]);
    // Its next boot-up message makes it be asked again.
    master.receive(NOMINAL, 0x705, &[0x00]);
    heartbeats(&mut master, &[0x705], 9_200);
    assert_eq!(questions(&master).len(), 7);
}

/// Given a question to a new node, When an assigned slave boots up, Then the master does nothing until the answer, and then
/// checks the slave.
#[test]
fn boot_up_of_a_slave_waits_for_the_answer_of_a_new_node() {
    let mut master = powered(&BOOTS_TWO);
    master.receive(NOMINAL, 0x705, &[0x05]);
    assert_eq!(questions(&master), [(5, 1)]);
    master.receive(NOMINAL, 0x702, &[0x00]);
    master.settle();
    assert_eq!(questions(&master), [(5, 1)]);
    master.receive(NOMINAL, 0x585, &SOMEBODY);
    assert_eq!(questions(&master), [(5, 1), (2, 1)]);
}

/// Given forged heartbeats of a node that does not exist, When they end, Then the master asks no more.
#[test]
fn a_node_that_is_not_heard_is_not_asked_again() {
    let mut master = powered(&STANDARD);
    heartbeats(&mut master, &[0x705], 400);
    master.run_until(ms(3_000));
    assert_eq!(questions(&master), [(5, 50)]);
    heartbeats(&mut master, &[0x705], 3_100);
    assert_eq!(questions(&master), [(5, 50), (5, 3_050)]);
}

/// Given a slave whose server misses the first questions, or answers each question 120 ms too late, Then it counts: its silence
/// moves the master.
///
/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.3b: a slave that did not answer the first question does not count, and its silence moves nobody.
#[test]
fn a_slave_with_a_slow_server_counts() {
    for (answers, is_late) in [(1, false), (2, false), (3, false), (1, true)] {
        let mut master = powered(&STANDARD);
        while questions(&master).len() < answers {
            let end = master.now.as_micros() / 1_000 + 101;
            heartbeats(&mut master, &[0x705], end);
        }
        if is_late {
            heartbeats(&mut master, &[0x705], 620);
        }
        master.receive(NOMINAL, 0x585, &SOMEBODY);
        heartbeats(&mut master, &[0x705], 6_000);
        assert_eq!(questions(&master).len(), answers);
        let is_reported = answers > 1 || is_late;
        assert_eq!(unknown_nodes(&master).len(), usize::from(is_reported));
        master.clear_events();
        master.run_until(ms(6_300));
        let left =
            MasterEvent::BusSwitched { from: NOMINAL, to: REDUNDANT, cause: SwitchCause::SlavesSilent };
        assert!(master.events.contains(&left), "{answers} {is_late}: {:?}", master.events);
    }
}

#[test]
fn assigned_slaves_are_booted_before_foreign_nodes_are_asked() {
    let mut master = powered(&BOOTS_TWO);
    master.receive(NOMINAL, 0x702, &[0x7F]);
    master.receive(NOMINAL, 0x705, &[0x7F]);
    assert_eq!(questions(&master), [(2, 1)], "the device type of the slave that boots");
    master.receive(NOMINAL, 0x582, &SOMEBODY);
    master.receive(NOMINAL, 0x582, &[0x43, 0x18, 0x10, 2, 0x15, 0x50, 0, 0]);
    has_no_cob_ids(&mut master);
    assert_eq!(questions(&master), [(2, 1), (5, 1)]);
}

#[test]
fn a_question_lost_with_its_bus_is_asked_again_on_the_other() {
    let mut master = powered(&STANDARD);
    master.receive(NOMINAL, 0x705, &[0x05]);
    assert_eq!(questions(&master), [(5, 1)]);
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    master.transmitted(REDUNDANT, frame(0x701, &[0x05]));
    master.run_until(ms(20));
    assert_eq!(questions(&master), [(5, 1)], "not before it is heard there");
    master.receive(REDUNDANT, 0x705, &[0x05]);
    assert_eq!(questions(&master), [(5, 1), (5, 20)]);
}

/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.3b: an acknowledged frame does not end the isolation of a master.
#[test]
fn any_acknowledged_frame_ends_isolation() {
    let mut master = powered(&STANDARD);
    master.receive(NOMINAL, 0x702, &[0x05]);
    master.receive(NOMINAL, 0x582, &SOMEBODY);
    master.run_until(ms(10));
    let health = Health { state: ErrorState::Passive, tec: 135, rec: 0, last_error: LastError::Ack };
    master.health(NOMINAL, health);
    master.clear_events();
    // 91 us before the grace of 2 ms ends.
    master.run_until(ecss_can::types::Instant::from_micros(11_909));
    master.transmitted(NOMINAL, frame(0x302, &[1, 0, 0, 0, 0, 0, 0, 0]));
    master.run_until(ecss_can::types::Instant::from_micros(13_908));
    assert_eq!(master.events, []);
    master.run_until(ecss_can::types::Instant::from_micros(13_909));
    let left = MasterEvent::BusSwitched { from: NOMINAL, to: REDUNDANT, cause: SwitchCause::Isolated };
    assert_eq!(master.events, [left]);
}

/// Verifies: ECSS 6.4a, 6.4a.2, 8.1a
/// Notices: ECSS 8.1a: a second master on the other bus is not noticed.
/// Notices: ECSS 6.4a: a second master stays an error when it is silent.
#[test]
fn a_second_master_is_a_collision_of_its_bus_until_it_is_silent() {
    for bus in [NOMINAL, REDUNDANT] {
        let mut master = powered(&STANDARD);
        for at in [10, 60, 110] {
            master.run_until(ms(at));
            master.receive(bus, 0x701, &[0x05]);
        }
        assert_eq!(master.events, [MasterEvent::SecondMaster { bus }]);
        assert_eq!(read(&mut master, 0x1001, 0), 0x11);
        assert_eq!(read(&mut master, 0x1003, 1), 0x8150 | u32::from(bus.bdefault()) << 16);
        master.run_until(ms(609));
        assert_eq!(read(&mut master, 0x1001, 0), 0x11);
        master.run_until(ms(610));
        assert_eq!(read(&mut master, 0x1001, 0), 0);
        assert_eq!(
            master.events,
            [MasterEvent::SecondMaster { bus }, MasterEvent::SecondMasterSilent { bus }]
        );
    }
}

/// The bus that was left says nothing any more about itself: what failed there may be whole again.
///
/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.3b: a bus that failed once is never used again by a master with selective access.
#[test]
fn a_selective_master_may_return_to_a_bus_that_failed() {
    const SELECTIVE: Profile = Profile { selective: &[ecss_can::types::NodeId::MASTER], ..STANDARD };
    let off = Health { state: ErrorState::BusOff, ..Health::default() };
    let mut master = powered(&SELECTIVE);
    for bus in [NOMINAL, REDUNDANT, NOMINAL] {
        // The fourth bus-off in a second.
        for _ in 0..4 {
            master.health(bus, off);
            let until = master.now + ecss_can::types::Duration::from_millis(11);
            master.run_until(until);
            master.health(bus, Health::default());
        }
        let left = MasterEvent::BusSwitched { from: bus, to: bus.other(), cause: SwitchCause::BusOff };
        assert!(master.events.contains(&left), "{bus:?}: {:?}", master.events);
        master.clear_events();
        let until = master.now + ecss_can::types::Duration::from_millis(2_000);
        master.run_until(until);
    }
}

/// How often node 32, which 1016h does not name, is lost, heard every `period` ms eight times.
fn losses(answers: bool, period: u64) -> usize {
    let mut master = powered(&STANDARD);
    for beat in 0..8 {
        master.run_until(ms(10 + period * beat));
        master.receive(NOMINAL, 0x720, &[0x05]);
        if beat == 0 && answers {
            master.receive(NOMINAL, 0x5A0, &SOMEBODY);
        }
    }
    master.events.iter().filter(|event| **event == MasterEvent::SlaveLost { node: node(32) }).count()
}

/// Given a node that neither 1F81h nor 1016h names, with a heartbeat period longer than the consumer time, then it is lost before
/// its period is known, and not again at each heartbeat.
#[test]
fn unassigned_node_with_a_long_period_is_not_lost_each_time() {
    for answers in [false, true] {
        for period in [300, 1_000, 2_000] {
            assert_eq!(losses(answers, period), 1, "{period} ms, answers: {answers}");
        }
    }
}

/// Given a node whose period of 1 s is known, when it is silent for two periods, then it is lost; and back in its old period
/// of 100 ms it is lost after the common consumer time.
#[test]
fn unassigned_node_is_lost_after_two_of_its_periods() {
    let lost = MasterEvent::SlaveLost { node: node(32) };
    let mut master = powered(&STANDARD);
    for at in [10, 1_010, 2_010] {
        master.run_until(ms(at));
        master.receive(NOMINAL, 0x720, &[0x05]);
    }
    master.clear_events();
    master.run_until(ms(4_009));
    assert!(!master.events.contains(&lost));
    master.run_until(ms(4_010));
    assert!(master.events.contains(&lost));
    for at in [4_100, 4_200] {
        master.run_until(ms(at));
        master.receive(NOMINAL, 0x720, &[0x05]);
    }
    master.clear_events();
    master.run_until(ms(4_449));
    assert!(!master.events.contains(&lost));
    master.run_until(ms(4_450));
    assert!(master.events.contains(&lost));
}

/// Given a slave that the master asked for its errors, when a second master is silent again, then the master asks once more: the slave
/// may have reported to the other one.
#[test]
fn errors_are_asked_for_after_a_second_master() {
    let mut master = powered(&STANDARD);
    master.has_no_errors = false;
    let heartbeat = frame(0x701, &[5]);
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    master.receive(NOMINAL, 0x704, &[0x05]);
    master.receive(NOMINAL, 0x584, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    let questions = |master: &Bench<Master>| {
        let is_question = |data: &[u8]| data == [0x40, 0x01, 0x10, 0, 0, 0, 0, 0];
        master
            .frames()
            .iter()
            .filter(|(_, frame)| frame.id().raw() == 0x604 && is_question(frame.data()))
            .count()
    };
    let run = |master: &mut Bench<Master>, until: u64, with_rival: bool| {
        while master.now < ms(until) {
            let next = master.now + span(50);
            master.run_until(next);
            master.receive(NOMINAL, 0x704, &[0x05]);
            master.transmitted(NOMINAL, heartbeat);
            if with_rival {
                master.receive(NOMINAL, 0x701, &[5]);
            }
        }
    };
    run(&mut master, 50, false);
    master.receive(NOMINAL, 0x584, &[0x4F, 0x01, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(questions(&master), 1);
    run(&mut master, 300, true);
    run(&mut master, 2_000, false);
    assert!(questions(&master) > 1, "it asked once");
}
