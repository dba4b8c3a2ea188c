//! A slave node on the bench, profile `standard`: heartbeat 100 ms, consumer time 250 ms, Ttoggle 2.

use crate::instrument::{self, Instrument, Outgoing, STANDARD, TELEMETRY_TPDO};
use ecss_can::link::port::{ErrorState, Filter, Health, LastError};
use ecss_can::node::extend::{BusCommand, LinkEvent};
use ecss_can::node::{DeviceNode, FailCause, Node, Slave, SlaveEvent};
use ecss_can::od::U48;
use ecss_can::profile::Profile;
use ecss_can::redundancy::BusCause;
use ecss_can::time::Step;
use ecss_can::types::{Bus, CobId, Instant, NmtState, PerBus, Scet};

use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, node, pdos, stamp};

const SELECTIVE: Profile = Profile { selective: &[ecss_can::types::NodeId::of::<5>()], ..STANDARD };

pub type TestSlave = Slave<Instrument>;

pub fn powered(profile: &Profile) -> Bench<TestSlave> {
    Bench::new(instrument::slave(node(5), profile, vec![0; 1024]))
}

/// Operational on the nominal bus at 10 ms, the master heard at 10 ms.
pub fn operational(profile: &Profile) -> Bench<TestSlave> {
    let mut slave = powered(profile);
    slave.run_until(ms(10));
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.receive(NOMINAL, 0x000, &[0x01, 0x05]);
    slave.clear();
    slave
}

fn status_counters(slave: &mut Bench<TestSlave>) -> PerBus<ecss_can::node::Counters> {
    slave.node.status(slave.now).counters
}

/// A telecommand or a telemetry request on the wire.
const MESSAGE: [u8; 8] = [0x34, 0x12, 9, 0, 0, 0, 0, 0];

/// Verifies: ECSS 8.2.1a.2, 8.3.2a, 6.5.3a, 8.2.1a, 8.2.2a
/// Notices: ECSS 6.5.3a: the boot-up message has the state Pre-operational.
/// Notices: ECSS 8.2.1a: a node with parallel access and Bdefault 1 does not join the nominal bus.
/// Notices: ECSS 8.2.2a: a node with parallel access and Bdefault 1 does not join the nominal bus.
#[test]
fn power_on_joins_boots_up_on_default_bus_waits_pre_operational() {
    for bus in Bus::ALL {
        let slave = powered(&Profile { bdefault: bus, ..STANDARD });
        assert_eq!(slave.controls, [(NOMINAL, BusCommand::Join), (REDUNDANT, BusCommand::Join)]);
        assert_eq!(slave.frames(), [(bus, frame(0x705, &[0]))]);
        assert_eq!(
            slave.events,
            [
                SlaveEvent::ActiveBus { bus, cause: BusCause::PowerOn },
                SlaveEvent::State(NmtState::PreOperational)
            ]
        );
    }
}

/// Verifies: ECSS 8.2.1a, 8.2.1a.1, 8.3.2a
/// Notices: ECSS 8.2.1a: selective access of the profile is taken for parallel access.
#[test]
fn with_selective_access_it_joins_the_default_bus_only() {
    assert_eq!(powered(&SELECTIVE).controls, [(NOMINAL, BusCommand::Join)]);
}

/// Verifies: ECSS 6.3a, 6.5.2b, 6.10a
/// Notices: ECSS 6.3a: no filter of a slave admits SYNC.
#[test]
fn its_filters_are_exact() {
    let slave = instrument::slave(node(5), &STANDARD, vec![]);
    // PDOs that are not valid repeat what is admitted anyhow.
    let mut expected = vec![0x000, 0x080, 0x605, 0x701];
    // What 1016h monitors: the master, so far.
    expected.extend([0x701, 0, 0, 0, 0, 0, 0, 0]);
    expected.extend([0x181, 0x305, 0x405, 0, 0, 0, 0, 0]);
    // Another node with this Node-ID.
    expected.push(0x705);
    let filters: Vec<Filter> = slave.filters().into_iter().collect();
    let expected = expected.into_iter().map(|raw| Filter::exact(CobId::new(raw).unwrap()));
    assert_eq!(filters, expected.collect::<Vec<_>>());
}

/// Verifies: ECSS 6.5.2a, 8.3.3d
#[test]
fn heartbeats_go_out_on_the_active_bus_and_live_one_period() {
    let mut slave = powered(&STANDARD);
    slave.clear();
    slave.run_until(ms(250));
    assert_eq!(slave.times(NOMINAL, 0x705), [100, 200]);
    assert_eq!(slave.sent[0].frame, frame(0x705, &[0x7F]));
    assert_eq!(slave.sent[0].expires, ms(200));
}

/// Verifies: ECSS 6.5.4a, 6.5.1a, 6.5.1a.1, 6.5.1a.2
/// Notices: ECSS 6.5.1a.1: a slave does not obey a Start to all nodes.
#[test]
fn a_command_changes_the_state_and_the_heartbeat_tells_at_once() {
    let mut slave = powered(&STANDARD);
    slave.run_until(ms(30));
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x01, 0x00]);
    assert!(slave.events.contains(&SlaveEvent::State(NmtState::Operational)));
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x705, &[0x05]))]);
    slave.receive(NOMINAL, 0x000, &[0x02, 0x05]);
    assert_eq!(slave.events.last(), Some(&SlaveEvent::State(NmtState::Stopped)));
}

/// Verifies: ECSS 6.5.1a, 6.5.1a.2
/// Notices: ECSS 6.5.1a.2: a slave obeys a Stop for another node.
#[test]
fn a_command_to_another_node_is_not_obeyed() {
    let mut slave = operational(&STANDARD);
    slave.receive(NOMINAL, 0x000, &[0x02, 0x06]);
    assert_eq!(slave.events, []);
}

/// Given a slave in Pre-operational, Operational or Stopped, when the master sends a heartbeat with any of these states every 200 ms, then
/// the slave misses the master 250 ms after the last heartbeat, and not before.
///
/// Verifies: ECSS 8.3.3c, 6.5.2b
/// Notices: ECSS 8.3.3c: a slave that is stopped takes no heartbeat of the master.
/// Notices: ECSS 8.3.3c: only a master that is Operational is heard.
#[test]
fn master_is_heard_in_any_state_of_it_and_of_the_slave() {
    let missed = SlaveEvent::MasterMissed { bus: NOMINAL };
    for command in [0x80, 0x01, 0x02] {
        let mut slave = operational(&STANDARD);
        slave.receive(NOMINAL, 0x000, &[command, 5]);
        for (at, state) in [(200, 0x05), (400, 0x7F), (600, 0x04), (800, 0x7F), (1_000, 0x04)] {
            slave.run_until(ms(at));
            slave.receive(NOMINAL, 0x701, &[state]);
        }
        slave.run_until(ms(1_249));
        assert!(!slave.events.contains(&missed), "{command:02X}h");
        slave.run_until(ms(1_250));
        assert!(slave.events.contains(&missed), "{command:02X}h");
    }
}

/// Given a slave that is stopped, when it misses the master, then it enters Pre-operational, and goes to the other bus after that.
///
/// Verifies: ECSS 8.3.3e, 8.3.3e.1, 8.3.3d, 8.3.3e.2, 8.3.3h
/// Notices: ECSS 8.3.3e.1: a slave that is stopped stays so when it misses the master.
#[test]
fn stopped_slave_that_misses_the_master_is_pre_operational() {
    let mut slave = operational(&STANDARD);
    slave.receive(NOMINAL, 0x000, &[0x02, 5]);
    slave.clear();
    slave.run_until(ms(260));
    let entered = SlaveEvent::State(NmtState::PreOperational);
    assert_eq!(slave.events, [SlaveEvent::MasterMissed { bus: NOMINAL }, entered]);
    slave.clear();
    slave.run_until(ms(510));
    assert_eq!(slave.events, [SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Toggled }]);
    assert_eq!(slave.frames().last(), Some(&(REDUNDANT, frame(0x705, &[0x7F]))));
}

/// Verifies: ECSS 8.3.3d, 8.3.3e, 8.3.3e.1, 8.3.3e.2, 8.3.3h
/// Notices: ECSS 8.3.3d: a slave that searches sends its heartbeat on Bdefault.
/// Notices: ECSS 8.3.3e.1: the slave enters Pre-operational only when it changes the bus.
#[test]
fn master_missed_pre_operational_switch_heartbeat_there() {
    let mut slave = operational(&STANDARD);
    slave.run_until(ms(259));
    assert_eq!(slave.events, []);
    slave.run_until(ms(260));
    assert_eq!(
        slave.events,
        [SlaveEvent::MasterMissed { bus: NOMINAL }, SlaveEvent::State(NmtState::PreOperational)]
    );
    slave.run_until(ms(509));
    slave.clear();
    slave.run_until(ms(510));
    assert_eq!(slave.events, [SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Toggled }]);
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Abandon)]);
    assert_eq!(slave.frames(), [(REDUNDANT, frame(0x705, &[0x7F]))]);
    slave.run_until(ms(720));
    assert_eq!(slave.times(REDUNDANT, 0x705), [510, 610, 710]);
    assert_eq!(slave.times(NOMINAL, 0x705), [0; 0]);
}

/// Given a slave that lost the master, when the master boots up on either bus, then the search ends there.
///
/// Verifies: ECSS 8.3.3g, 8.3.3k
/// Notices: ECSS 8.3.3g: the boot-up message of the master does not end a search.
#[test]
fn boot_up_message_of_the_master_ends_the_search() {
    for bus in Bus::ALL {
        let mut slave = operational(&STANDARD);
        slave.run_until(ms(300));
        assert_eq!(slave.events[0], SlaveEvent::MasterMissed { bus: NOMINAL });
        slave.clear();
        slave.receive(bus, 0x701, &[0x00]);
        let found = SlaveEvent::ActiveBus { bus, cause: BusCause::Found };
        assert_eq!(slave.events, [found, SlaveEvent::Heartbeat { bus }]);
        // The search would change the bus 500 ms after the last heartbeat, at 510 ms.
        slave.run_until(ms(549));
        assert_eq!(slave.node.status(slave.now).active, bus);
    }
}

/// Verifies: ECSS 8.2.1a, 8.2.1a.1, 8.3.3e.2, 8.3.3g
/// Notices: ECSS 8.2.1a.1: a slave with selective access does not leave the old bus.
/// Notices: ECSS 8.2.1a: a node with selective access joins a bus and stays on the other one.
#[test]
fn with_selective_access_it_leaves_one_bus_and_joins_the_other() {
    let mut slave = operational(&SELECTIVE);
    slave.run_until(ms(510));
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Leave), (REDUNDANT, BusCommand::Join)]);
    slave.clear();
    // What the bus it left still had to tell is of the past.
    slave.receive(NOMINAL, 0x701, &[0x05]);
    assert_eq!(slave.events, []);
    slave.receive(REDUNDANT, 0x701, &[0x05]);
    assert_eq!(
        slave.events,
        [
            SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Found },
            SlaveEvent::Heartbeat { bus: REDUNDANT }
        ]
    );
}

/// Given a slave with selective access whose bus is bus-off, when it leaves that bus before the recovery, then there is none.
///
/// Verifies: ECSS 8.2.1a.1, 8.2.1a
/// Notices: ECSS 8.2.1a.1: a bus that was left while bus-off is recovered later.
/// Notices: ECSS 8.2.1a: a bus in bus-off is not left, so that the node is on both.
#[test]
fn with_selective_access_it_recovers_no_bus_that_it_left() {
    let mut slave = operational(&SELECTIVE);
    slave.run_until(ms(505));
    slave.health(NOMINAL, Health { state: ErrorState::BusOff, tec: 255, ..Health::default() });
    slave.clear();
    slave.run_until(ms(700));
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Leave), (REDUNDANT, BusCommand::Join)]);
}

/// Given a slave that searches on the redundant bus, when a stray Start makes it Operational and no heartbeat follows, then it is
/// Pre-operational again after a consumer time, and goes on with its search so.
///
/// Verifies: ECSS 8.3.3e.1, 8.3.3h, 6.5.1a.1, 8.3.3k
/// Notices: ECSS 8.3.3e.1: a slave that a stray Start made Operational changes the bus in that state.
/// Notices: ECSS 8.3.3h: a slave that a stray Start made Operational changes the bus in that state.
#[test]
fn slave_started_by_a_stray_command_goes_on_in_pre_operational() {
    let mut slave = operational(&STANDARD);
    slave.run_until(ms(520));
    slave.receive(REDUNDANT, 0x000, &[0x01, 0x05]);
    let state = |slave: &Bench<TestSlave>| {
        let status = slave.node.status(slave.now);
        (status.state, status.active)
    };
    for (until, expected) in [
        (769, (NmtState::Operational, REDUNDANT)),
        (770, (NmtState::PreOperational, REDUNDANT)),
        (1_009, (NmtState::PreOperational, REDUNDANT)),
        (1_010, (NmtState::PreOperational, NOMINAL)),
    ] {
        slave.run_until(ms(until));
        assert_eq!(state(&slave), expected, "{until} ms");
    }
}

/// Verifies: ECSS 8.3.3j, 8.3.3d, 8.3.3i
/// Notices: ECSS 8.3.3d: a slave that gave up its search sends no heartbeat.
#[test]
fn slave_gives_up_after_ntoggle_switches_and_keeps_heartbeat() {
    let mut slave = powered(&Profile { ntoggle: 2, ..STANDARD });
    slave.run_until(ms(1_500));
    assert_eq!(slave.events.last(), Some(&SlaveEvent::GaveUp { bus: NOMINAL }));
    slave.clear();
    slave.run_until(ms(2_000));
    assert_eq!(slave.events, []);
    assert_eq!(slave.times(NOMINAL, 0x705).len(), 5);
}

/// Verifies: ECSS 8.2.1a.2, 8.3.3g, 8.3.3d, 8.2.1a
/// Notices: ECSS 8.2.1a.2: a slave with parallel access leaves the bus that is not active.
/// Notices: ECSS 8.2.1a: a slave joins both buses, and leaves the old one when it follows the master.
#[test]
fn parallel_slave_follows_heartbeat_and_stays_operational() {
    let mut slave = operational(&STANDARD);
    slave.run_until(ms(60));
    slave.receive(REDUNDANT, 0x701, &[0x05]);
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Abandon)]);
    assert_eq!(
        slave.events,
        [
            SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Followed },
            SlaveEvent::Heartbeat { bus: REDUNDANT }
        ]
    );
    assert_eq!(slave.frames(), [(REDUNDANT, frame(0x705, &[0x05]))]);
    slave.clear();
    slave.receive(REDUNDANT, 0x305, &MESSAGE);
    assert_eq!(slave.events.len(), 1);
}

/// Verifies: ECSS 8.3.3g, 6.5.1a.1, 8.3.3d
#[test]
fn start_while_searching_moves_slave_to_its_bus_and_is_obeyed() {
    let mut slave = powered(&STANDARD);
    slave.run_until(ms(50));
    slave.clear();
    slave.receive(REDUNDANT, 0x000, &[0x01, 0x05]);
    assert_eq!(
        slave.events,
        [
            SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Found },
            SlaveEvent::State(NmtState::Operational)
        ]
    );
    assert_eq!(slave.frames(), [(REDUNDANT, frame(0x705, &[0x05]))]);
}

/// Given a slave that searches, when a command for another node arrives on the other bus, then that bus is the active one. The slave
/// does not obey.
///
/// Verifies: ECSS 8.3.3g, 8.3.3d
/// Notices: ECSS 8.3.3g: a command for another node does not end a search.
/// Notices: ECSS 8.3.3g: a Stop for another node does not end a search.
#[test]
fn command_for_another_node_shows_the_active_bus_to_a_searching_slave() {
    for command in [0x01, 0x02, 0x80, 0x81, 0x82] {
        let mut slave = powered(&STANDARD);
        slave.run_until(ms(50));
        slave.clear();
        slave.receive(REDUNDANT, 0x000, &[command, 0x06]);
        let found = SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Found };
        assert_eq!(slave.events, [found], "{command:02X}h");
        assert_eq!(slave.frames(), [(REDUNDANT, frame(0x705, &[0x7F]))]);
    }
}

/// Verifies: ECSS 6.5.1a, 8.3.3g
/// Notices: ECSS 6.5.1a: a command without a Node-ID is obeyed.
/// Notices: ECSS 8.3.3g: a malformed command or heartbeat ends a search.
#[test]
fn a_malformed_command_or_heartbeat_is_no_master_message() {
    let mut slave = powered(&STANDARD);
    slave.clear();
    slave.run_until(ms(50));
    for (id, data) in
        [(0x000, &[0x01][..]), (0x000, &[0x33, 5]), (0x701, &[]), (0x701, &[0x01]), (0x701, &[5, 0])]
    {
        slave.receive(REDUNDANT, id, data);
    }
    assert_eq!(slave.events, []);
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.receive(NOMINAL, 0x000, &[0x01, 0x05]);
    let counters = status_counters(&mut slave);
    assert_eq!((counters.redundant.malformed, counters.redundant.received), (5, 5));
    assert_eq!(counters.nominal.malformed, 0);
}

/// Verifies: ECSS 6.5.1a.5, 6.5.3a, 6.5.4a, 8.3.2a, 8.3.3d
/// Notices: ECSS 8.3.2a: after reset communication a slave boots up on the nominal bus.
#[test]
fn reset_communication_boots_up_on_the_bus_in_use() {
    let mut slave = operational(&STANDARD);
    slave.receive(REDUNDANT, 0x701, &[0x05]);
    slave.clear();
    slave.run_until(ms(20));
    slave.receive(REDUNDANT, 0x000, &[0x82, 0x05]);
    assert_eq!(slave.events, [SlaveEvent::State(NmtState::PreOperational)]);
    assert_eq!(slave.frames(), [(REDUNDANT, frame(0x705, &[0]))]);
    slave.run_until(ms(120));
    assert_eq!(slave.times(REDUNDANT, 0x705), [20, 120]);
}

/// Given a slave that got Reset node, when its application does not reset the chip, then the slave is silent, and reports the command
/// again with each frame that it receives.
///
/// Verifies: ECSS 6.5.1a.4
/// Notices: ECSS 6.5.1a.4: the command is reported once, and a full queue of events loses the reset.
#[test]
fn reset_node_silences_it_until_the_application_resets_the_chip() {
    let mut slave = operational(&STANDARD);
    slave.receive(NOMINAL, 0x000, &[0x81, 0x00]);
    assert_eq!(slave.events, [SlaveEvent::ResetNode]);
    slave.clear();
    assert_eq!(slave.node.deadline(), None);
    slave.run_until(ms(5_000));
    slave.receive(NOMINAL, 0x000, &[0x01, 0x00]);
    slave.receive(NOMINAL, 0x701, &[0x05]);
    assert_eq!(slave.frames(), []);
    // An application that missed it is told again.
    assert_eq!(slave.events, [SlaveEvent::ResetNode, SlaveEvent::ResetNode]);
}

/// Verifies: ECSS 6.2a, 6.4a.2, 6.5.1a.3, 6.5.4a
/// Notices: ECSS 6.2a: a command that is shorter than its mapping is taken.
/// Notices: ECSS 6.4a.2: a PDO that is too short has a code other than 8210h.
/// Notices: ECSS 6.5.4a: a slave takes PDOs in Pre-operational.
#[test]
fn commands_are_taken_only_when_operational_on_the_active_bus() {
    let mut slave = operational(&STANDARD);
    slave.receive(NOMINAL, 0x305, &MESSAGE);
    assert_eq!(pdos(&slave.events), [Some((NOMINAL, 1, MESSAGE))]);
    let telecommand = slave.node.objects().application.telecommand;
    assert_eq!((telecommand.code, telecommand.data.get()), (0x1234, 9));
    slave.clear();
    slave.receive(REDUNDANT, 0x305, &MESSAGE);
    slave.receive(REDUNDANT, 0x405, &MESSAGE);
    slave.receive(REDUNDANT, 0x080, &[]);
    slave.receive(NOMINAL, 0x305, &[0x34]);
    assert_eq!(slave.events, []);
    // EMCY: PDO not processed due to length error, of the PDO number 1.
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x085, &[0x10, 0x82, 0x11, 1, 0, 0, 0, 0]))]);
    let counters = status_counters(&mut slave);
    assert_eq!((counters.redundant.ignored, counters.nominal.malformed), (3, 1));
    slave.receive(NOMINAL, 0x000, &[0x80, 0x05]);
    slave.clear();
    slave.receive(NOMINAL, 0x305, &MESSAGE);
    slave.receive(NOMINAL, 0x181, &[0; 7]);
    assert_eq!(slave.events, []);
}

/// Verifies: ECSS 6.2a
#[test]
fn telemetry_goes_out_for_one_period_on_the_active_bus() {
    let mut slave = operational(&STANDARD);
    slave.run_until(ms(20));
    let status = slave.node.status(slave.now);
    assert_eq!(
        (status.uptime.as_millis(), status.state, status.active),
        (20, NmtState::Operational, NOMINAL)
    );
    let tell = |slave: &mut TestSlave, now| {
        slave.change(now, |objects| {
            objects.telemetry = Outgoing { code: 0x0102, data: U48::new(0x0403_0201) }
        });
        slave.send_pdo(TELEMETRY_TPDO, now);
    };
    slave.touch(tell);
    let sent = slave.sent.pop().unwrap();
    assert_eq!((sent.bus, sent.frame), (NOMINAL, frame(0x385, &[0x02, 0x01, 1, 2, 3, 4, 0, 0])));
    assert_eq!(sent.expires, ms(120));
    slave.receive(REDUNDANT, 0x701, &[0x05]);
    slave.clear();
    slave.touch(tell);
    assert_eq!(slave.frames(), [(REDUNDANT, frame(0x385, &[0x02, 0x01, 1, 2, 3, 4, 0, 0]))]);
}

/// Verifies: ECSS 6.9e, 7.2.2e, 7.2.2f, 7.2.2g, 7.2.3k
/// Notices: ECSS 7.2.2f: only a SYNC with a counter is answered by PDOs.
/// Notices: ECSS 7.2.3k: the local time is sampled 60 us after the SYNC.
#[test]
fn sync_is_answered_with_local_time_at_its_end_if_operational() {
    let mut slave = operational(&STANDARD);
    slave.run_until(ms(60));
    // Given the spacecraft time 100 s at 50 ms
    let time = Scet::new(100, 0).unwrap();
    slave.link(NOMINAL, LinkEvent::Received { frame: frame(0x181, &time.encode()), stamp: stamp(ms(50)) });
    let step = Step { from: Scet::new(0, 838_861).unwrap(), to: time };
    assert_eq!(slave.events, [SlaveEvent::Time(time), SlaveEvent::Step(step)]);
    slave.clear();
    // When a SYNC that ended 4.5 s later is handled some microseconds late
    for at in (100..4_550).step_by(50) {
        slave.run_until(ms(at));
        slave.receive(NOMINAL, 0x701, &[0x05]);
    }
    slave.clear();
    slave.run_until(Instant::from_micros(4_550_060));
    slave.clear();
    slave.link(NOMINAL, LinkEvent::Received { frame: frame(0x080, &[]), stamp: stamp(ms(4_550)) });
    // Then the Local Time PDO says 104.5 s
    assert_eq!(slave.events, [SlaveEvent::Sync { bus: NOMINAL, stamp: stamp(ms(4_550)) }]);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x185, &[0, 0, 0x80, 104, 0, 0, 0]))]);
    // And in Pre-operational SYNC is consumed without a PDO
    slave.receive(NOMINAL, 0x000, &[0x80, 0x05]);
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!((slave.events.len(), slave.frames()), (1, vec![]));
    // And one with a counter that object 1019h does not announce is told as an emergency
    slave.receive(NOMINAL, 0x080, &[7]);
    assert_eq!(slave.events.len(), 1);
    assert_eq!(slave.frames()[0], (NOMINAL, frame(0x085, &[0x40, 0x82, 0x11, 0, 0, 0, 0, 0])));
}

/// Verifies: ECSS 6.2a, 7.1.1a
/// Notices: ECSS 6.2a: a Spacecraft Time PDO that lacks a byte sets the clock.
#[test]
fn a_short_time_pdo_is_malformed_and_sets_nothing() {
    let mut slave = operational(&STANDARD);
    slave.receive(NOMINAL, 0x181, &[0xFF; 6]);
    assert_eq!((slave.events.len(), status_counters(&mut slave).nominal.malformed), (0, 1));
    // It counts from power-on still.
    slave.run_until(ms(20));
    assert_eq!(slave.node.status(ms(1_000)).scet, Scet::new(1, 0).unwrap());
}

/// Verifies: ECSS 6.5.2b, 8.3.3c
#[test]
fn heartbeat_that_ended_in_time_counts_however_late_handled() {
    let mut slave = operational(&STANDARD);
    slave.run_until(ms(259));
    slave.now = ms(265);
    slave.link(NOMINAL, LinkEvent::Received { frame: frame(0x701, &[0x05]), stamp: stamp(ms(259)) });
    assert_eq!(slave.events, [SlaveEvent::Heartbeat { bus: NOMINAL }]);
}

/// Given a slave alone on its bus, when it has sent nothing yet, then its heartbeats are boot-up messages, and its emergencies wait:
/// its first frame is a boot-up message. When one was acknowledged, heartbeats have its state.
///
/// Verifies: ECSS 6.5.3a, 6.5.4a
#[test]
fn the_first_frame_of_a_slave_is_its_boot_up_message() {
    let mut slave = Bench::alone(instrument::slave(node(5), &STANDARD, vec![0; 1024]));
    slave.run_until(ms(1));
    let passive =
        Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::BitRecessive };
    slave.health(NOMINAL, passive);
    slave.run_until(ms(250));
    let boot_up = (NOMINAL, frame(0x705, &[0]));
    assert_eq!(slave.frames(), [boot_up; 3]);
    slave.clear();
    slave.transmitted(NOMINAL, frame(0x705, &[0]));
    slave.run_until(ms(310));
    let sent: Vec<_> =
        slave.frames().into_iter().map(|(_, frame)| (frame.id().raw(), frame.data()[0])).collect();
    assert_eq!(sent, [(0x085, 0x20), (0x705, 0x7F)]);
}

#[test]
fn every_loss_is_counted_by_cause() {
    let mut slave = operational(&STANDARD);
    let heartbeat = frame(0x705, &[5]);
    for cause in [FailCause::BusLeft, FailCause::Expired, FailCause::QueueFull, FailCause::Aborted] {
        slave.failed(NOMINAL, heartbeat, cause);
    }
    slave.transmitted(NOMINAL, heartbeat);
    slave.link(NOMINAL, LinkEvent::Overrun { lost: 3 });
    slave.receive(NOMINAL, 0x000, &[0x80, 0x05]);
    slave.touch(|slave, now| slave.send_pdo(TELEMETRY_TPDO, now));
    let counters = status_counters(&mut slave);
    let nominal = counters.nominal;
    assert_eq!((nominal.bus_left, nominal.expired, nominal.queue_full, nominal.aborted), (1, 1, 1, 1));
    // The boot-up message was sent, too, and the emergency of the overrun.
    assert_eq!((nominal.sent, nominal.lost, nominal.failed()), (3, 3, 5));
    assert_eq!(nominal.refused, 1);
    slave.touch(|slave, _| slave.reset_counters());
    let counters = status_counters(&mut slave);
    assert_eq!((counters.nominal.failed(), counters.nominal.received), (0, 0));
}

/// Verifies: ECSS 5.3.3.2.3d, 5.3.3.2.3h, 5.6.2b, 8.2.2a, 8.2.1a.2
/// Notices: ECSS 5.3.3.2.3d: the redundant controller is not recovered from bus-off.
/// Notices: ECSS 5.3.3.2.3h: the redundant controller is not recovered from bus-off.
/// Notices: ECSS 8.2.2a: bus-off of the redundant controller recovers the nominal one.
/// Notices: ECSS 8.2.1a.2: the redundant controller of a node with parallel access is not recovered.
#[test]
fn error_states_are_told_and_bus_off_is_recovered_after_a_pause() {
    let mut slave = operational(&STANDARD);
    let health = Health { state: ErrorState::BusOff, tec: 255, ..Health::default() };
    slave.health(REDUNDANT, health);
    assert_eq!(slave.events, [SlaveEvent::Health { bus: REDUNDANT, health }]);
    slave.run_until(ms(19));
    assert_eq!(slave.controls, []);
    slave.run_until(ms(20));
    assert_eq!(slave.controls, [(REDUNDANT, BusCommand::Recover)]);
    for _ in 0..3 {
        slave.health(REDUNDANT, Health::default());
        slave.health(REDUNDANT, health);
    }
    assert_eq!(slave.events.last(), Some(&SlaveEvent::BusFailed { bus: REDUNDANT }));
}

/// Given a slave with parallel access whose two controllers are bus-off, then it recovers each of them, though the other one is still off.
///
/// Verifies: ECSS 8.2.2a, 8.2.1a.2, 5.6.2a
/// Notices: ECSS 8.2.2a: the redundant controller is not recovered while the nominal one is bus-off.
#[test]
fn each_controller_recovers_from_bus_off_by_itself() {
    let off = Health { state: ErrorState::BusOff, tec: 255, ..Health::default() };
    for first in Bus::ALL {
        let mut slave = operational(&STANDARD);
        slave.health(first, off);
        slave.run_until(ms(25));
        slave.health(first.other(), off);
        slave.run_until(ms(40));
        assert_eq!(slave.controls, [first, first.other()].map(|bus| (bus, BusCommand::Recover)));
    }
}

/// Given a slave that followed the master from one bus to the other, when its controller of the bus that was left is bus-off, then it
/// recovers that controller after 10 ms, and likewise that of the bus in use.
///
/// Verifies: ECSS 8.2.1a.2, 8.2.2a, 5.6.2a
/// Notices: ECSS 8.2.1a.2: a slave with parallel access gives up the bus that the master left.
/// Notices: ECSS 8.2.2a: the controller of the bus that the master left is not recovered from bus-off.
/// Notices: ECSS 5.6.2a: the controller of the bus that the master left stays bus-off.
/// Notices: ECSS 5.6.2a: the redundant controller stays bus-off.
#[test]
fn a_parallel_slave_recovers_the_bus_that_the_master_left() {
    for off in Bus::ALL {
        let mut slave = operational(&STANDARD);
        slave.run_until(ms(50));
        slave.receive(REDUNDANT, 0x701, &[0x05]);
        slave.clear();
        slave.health(off, Health { state: ErrorState::BusOff, tec: 255, ..Health::default() });
        slave.run_until(ms(59));
        assert_eq!(slave.controls, []);
        slave.run_until(ms(60));
        assert_eq!(slave.controls, [(off, BusCommand::Recover)]);
    }
}

/// Given a slave with selective access that has changed the bus, when the controller of the old bus reports that it was bus-off, then
/// it is not recovered.
///
/// Verifies: ECSS 8.2.1a, 8.2.1a.1
/// Notices: ECSS 8.2.1a: a bus that was left is recovered when its bus-off is reported late.
#[test]
fn a_selective_slave_does_not_recover_a_bus_it_left() {
    let mut slave = operational(&SELECTIVE);
    slave.run_until(ms(510));
    slave.health(NOMINAL, Health { state: ErrorState::BusOff, ..Health::default() });
    slave.run_until(ms(600));
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Leave), (REDUNDANT, BusCommand::Join)]);
}

/// Given a slave with selective access that left a bus, and a late report of error passive from there, when the slave joins that bus
/// again, then it indicates error active. A controller that joins a bus is error active.
///
/// Verifies: ECSS 5.6.2b
/// Notices: ECSS 5.6.2b: error passive of an earlier stay on a bus is indicated when the slave joins it again.
#[test]
fn selective_slave_indicates_a_joined_bus_as_error_active() {
    let mut slave = operational(&SELECTIVE);
    slave.run_until(ms(510));
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT);
    let passive = Health { state: ErrorState::Passive, tec: 128, ..Health::default() };
    slave.health(NOMINAL, passive);
    assert_eq!(slave.node.status(slave.now).health[NOMINAL], passive);
    slave.run_until(ms(1_010));
    assert_eq!(slave.node.status(slave.now).active, NOMINAL);
    assert_eq!(slave.node.status(slave.now).health[NOMINAL], Health::default());
}

/// Verifies: ECSS 6.5.3a, 6.5.4a, 8.3.3h
/// Notices: ECSS 6.5.3a: the boot-up message of a node that starts by itself has the state Operational.
/// Notices: ECSS 8.3.3h: a slave that started by itself changes the bus in Operational.
#[test]
fn autostart_goes_operational_and_back_when_the_search_toggles() {
    let mut slave = powered(&Profile { autostart: true, ..STANDARD });
    assert_eq!(slave.events.last(), Some(&SlaveEvent::State(NmtState::Operational)));
    assert_eq!(slave.frames().first(), Some(&(NOMINAL, frame(0x705, &[0x00]))));
    slave.run_until(ms(500));
    assert!(slave.events.contains(&SlaveEvent::State(NmtState::PreOperational)));
}

#[test]
fn a_frame_it_has_no_use_for_is_counted() {
    let mut slave = operational(&STANDARD);
    slave.receive(NOMINAL, 0x306, &[1, 2]);
    assert_eq!(status_counters(&mut slave).nominal.ignored, 1);
}

#[test]
fn each_malformed_frame_is_counted_once() {
    let mut slave = operational(&STANDARD);
    let bad: [(u16, &[u8]); 11] = [
        (0x000, &[]),
        (0x000, &[0x81]),
        (0x000, &[0x81, 0, 0]),
        (0x000, &[0x03, 0]),
        (0x000, &[0x81, 200]),
        (0x080, &[1, 2]),
        (0x181, &[1, 2, 3, 4, 5, 6]),
        (0x305, &[1]),
        (0x405, &[]),
        (0x701, &[]),
        (0x701, &[0x42]),
    ];
    for (count, (id, data)) in (1..).zip(bad) {
        slave.receive(NOMINAL, id, data);
        assert_eq!(status_counters(&mut slave).nominal.malformed, count, "{id:03X} {data:?}");
    }
    // Good ones again: what was wrong with their PDOs is over.
    slave.receive(NOMINAL, 0x405, &MESSAGE);
    slave.receive(NOMINAL, 0x181, &[0; 7]);
    assert_eq!(status_counters(&mut slave).nominal.malformed, 11);
}
