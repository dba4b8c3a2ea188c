//! How a slave leaves a bus: the EMCY that goes before, and the choice of its application.
//!
//! Verifies: ECSS 8.2.3a

use crate::instrument::STANDARD;
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::node::extend::BusCommand;
use ecss_can::node::{FailCause, Node as _, ParallelAccess, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::redundancy::BusCause;
use ecss_can::types::{Bus, CobId, NmtState, NodeId};

use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms};
use crate::slave::{TestSlave, powered};

const SELECTIVE: Profile = Profile { selective: &[NodeId::of::<5>()], ..STANDARD };

/// The EMCY of a missed master.
const MISSED: [u8; 8] = [0x30, 0x81, 0x11, 1, 0, 0, 0, 0];

/// A slave that switches when it misses the master, at 260 ms: Ttoggle 1.
fn missing_its_master() -> Bench<TestSlave> {
    let mut slave = powered(&Profile { ttoggle: 1, ..STANDARD });
    slave.run_until(ms(10));
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.run_until(ms(259));
    slave.clear();
    slave.is_acknowledged = false;
    slave.run_until(ms(260));
    assert_eq!(slave.frames()[0], (NOMINAL, frame(0x085, &MISSED)));
    assert_eq!(slave.node.status(slave.now).active, NOMINAL, "it waits for the result");
    slave.clear();
    slave
}

/// Verifies: ECSS 8.3.3e, 6.4a.2, 8.3.3e.2
#[test]
fn switch_waits_for_the_result_of_the_emcy() {
    for is_sent in [true, false] {
        let mut slave = missing_its_master();
        slave.run_until(ms(261));
        assert_eq!(slave.events, []);
        match is_sent {
            true => slave.transmitted(NOMINAL, frame(0x085, &MISSED)),
            false => slave.failed(NOMINAL, frame(0x085, &MISSED), FailCause::Aborted),
        }
        let toggled = SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Toggled };
        assert_eq!((slave.events.as_slice(), slave.now), (&[toggled][..], ms(261)));
    }
}

/// Verifies: ECSS 8.3.3e, 8.3.3e.2
#[test]
fn switch_waits_two_milliseconds_at_most() {
    let mut slave = missing_its_master();
    assert_eq!(slave.node.deadline(), Some(ms(262)));
    slave.run_until(ms(262));
    assert_eq!(slave.events, [SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Toggled }]);
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Abandon)]);
}

/// A result of another frame, or of an earlier EMCY, is none.
#[test]
fn switch_waits_for_no_other_frame() {
    let mut slave = missing_its_master();
    slave.transmitted(NOMINAL, frame(0x705, &[0x7F]));
    slave.transmitted(NOMINAL, frame(0x085, &[0x20, 0x81, 0x11, 0, 0, 0, 0, 0]));
    assert_eq!(slave.node.status(slave.now).active, NOMINAL);
}

/// A heartbeat in these two milliseconds ends the search before the switch.
///
/// Verifies: ECSS 8.3.3k
/// Notices: ECSS 8.3.3k: a heartbeat between the miss and the switch does not end the search.
#[test]
fn heartbeat_while_the_switch_waits_keeps_the_bus() {
    let mut slave = missing_its_master();
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.transmitted(NOMINAL, frame(0x085, &MISSED));
    slave.run_until(ms(270));
    assert_eq!(slave.node.status(slave.now).active, NOMINAL);
}

/// Given a slave that is the first node on its bus, When it becomes error passive for want of acknowledgements, Then it records no
/// error.
///
/// Verifies: ECSS 5.6.2b
/// Notices: ECSS 5.6.2b: the application hears of bus-off alone, not of error passive.
#[test]
fn first_slave_on_a_bus_reports_no_passive_controller() {
    let mut slave = powered(&STANDARD);
    let unacknowledged = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };
    let errors = |slave: &mut Bench<TestSlave>| {
        slave.receive(NOMINAL, 0x605, &[0x40, 0x03, 0x10, 0, 0, 0, 0, 0]);
        slave.frames().iter().rfind(|(_, frame)| frame.id().raw() == 0x585).map(|(_, frame)| frame.data()[4])
    };
    slave.health(NOMINAL, unacknowledged);
    assert_eq!(slave.events.last(), Some(&SlaveEvent::Health { bus: NOMINAL, health: unacknowledged }));
    assert_eq!(errors(&mut slave), Some(0));
    slave.health(NOMINAL, Health { last_error: LastError::BitRecessive, ..unacknowledged });
    assert_eq!(errors(&mut slave), Some(1));
}

/// Verifies: ECSS 6.4a.1, 8.2.1a.1, 8.3.3d, 8.3.3h
/// Notices: ECSS 6.4a.1: the choice of a bus, which is no error, is reported by an EMCY.
/// Notices: ECSS 8.2.3a: the bus cannot be chosen while the master is heard.
#[test]
fn application_chooses_the_bus_with_selective_access() {
    let mut slave = powered(&SELECTIVE);
    slave.run_until(ms(10));
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.receive(NOMINAL, 0x000, &[0x01, 0x05]);
    slave.clear();
    // When it chooses the redundant bus
    slave.touch(|slave, _| slave.select_bus(REDUNDANT).unwrap());
    // Then the slave is there, Pre-operational, and says so
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Leave), (REDUNDANT, BusCommand::Join)]);
    assert_eq!(
        slave.events,
        [
            SlaveEvent::State(NmtState::PreOperational),
            SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Selected }
        ]
    );
    assert_eq!(slave.frames(), [(REDUNDANT, frame(0x705, &[0x7F]))]);
    assert_eq!(slave.node.status(slave.now).redundancy.ctoggle, 0);
    // And searches from there on: 500 ms later it is back
    slave.clear();
    slave.run_until(ms(510));
    assert_eq!(slave.events, [SlaveEvent::ActiveBus { bus: NOMINAL, cause: BusCause::Toggled }]);
}

/// Given a slave that is next due at its heartbeat, when its application chooses the other bus, then the choice is due at once.
///
/// Notices: ECSS 8.2.3a: the choice waits until the node is due for another reason.
#[test]
fn choice_of_a_bus_is_due_at_once() {
    let mut slave = powered(&SELECTIVE);
    slave.run_until(ms(10));
    assert!(slave.node.deadline() > Some(ms(10)));
    slave.node.select_bus(REDUNDANT).unwrap();
    assert!(slave.node.deadline().is_some_and(|due| due <= ms(10)));
    slave.settle();
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT);
}

/// Given a slave with selective access that toggles never, because Ttoggle or Ntoggle is zero, when its application chooses the other
/// bus and then Bdefault again, then the slave goes there each time, and stays.
///
/// Verifies: ECSS 8.2.1a, 8.2.1a.1, 8.3.3h, 8.3.3i
/// Notices: ECSS 8.2.1a: a slave with selective access stays on the redundant bus when it returns to the nominal one.
/// Notices: ECSS 8.2.3a: with toggling disabled the application cannot choose the bus.
/// Notices: ECSS 8.2.3a: the application cannot choose Bdefault.
/// Notices: ECSS 8.3.3i: with Ntoggle 0 a slave changes the bus once.
#[test]
fn bus_is_chosen_also_with_toggling_disabled() {
    for disabled in [Profile { ttoggle: 0, ..SELECTIVE }, Profile { ntoggle: 0, ..SELECTIVE }] {
        let mut slave = powered(&disabled);
        for bus in [REDUNDANT, NOMINAL] {
            slave.clear();
            slave.touch(|slave, _| slave.select_bus(bus).unwrap());
            assert_eq!(slave.controls, [(bus.other(), BusCommand::Leave), (bus, BusCommand::Join)]);
            let until = slave.now + ecss_can::types::Duration::from_millis(10_000);
            slave.run_until(until);
            assert_eq!(slave.node.status(slave.now).active, bus);
        }
    }
}

/// Verifies: ECSS 8.3.3h
/// Notices: ECSS 8.3.3h: the toggling time does not begin anew with the choice of the bus.
#[test]
fn choice_of_the_same_bus_begins_a_search_there() {
    let mut slave = powered(&SELECTIVE);
    slave.run_until(ms(300));
    slave.clear();
    slave.touch(|slave, _| slave.select_bus(NOMINAL).unwrap());
    assert_eq!(slave.events, [SlaveEvent::ActiveBus { bus: NOMINAL, cause: BusCause::Selected }]);
    assert_eq!(slave.controls, []);
    slave.run_until(ms(799));
    assert_eq!(slave.node.status(slave.now).active, NOMINAL);
    slave.run_until(ms(800));
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT);
}

/// Given a slave on the nominal bus, when its application chooses the redundant bus and at once the nominal one, then the second
/// choice holds: the slave stays.
///
/// Notices: ECSS 8.2.3a: the first of two choices that come together holds.
#[test]
fn the_last_of_two_choices_of_a_bus_holds() {
    let mut slave = powered(&SELECTIVE);
    slave.run_until(ms(300));
    slave.clear();
    slave.touch(|slave, _| {
        slave.select_bus(REDUNDANT).unwrap();
        slave.select_bus(NOMINAL).unwrap();
    });
    assert_eq!(slave.events, [SlaveEvent::ActiveBus { bus: NOMINAL, cause: BusCause::Selected }]);
    assert_eq!(slave.controls, []);
}

#[test]
fn application_chooses_no_bus_with_parallel_access() {
    let mut slave = powered(&STANDARD);
    slave.clear();
    for bus in Bus::ALL {
        slave.touch(|slave, _| assert_eq!(slave.select_bus(bus), Err(ParallelAccess)));
    }
    assert_eq!((slave.events.len(), slave.controls.len()), (0, 0));
}

/// Commands on the other bus are counted there, and no more.
///
/// Verifies: ECSS 6.5.1a, 8.3.3g
/// Notices: ECSS 6.5.1a: commands on the bus that is not active are obeyed.
/// Notices: ECSS 8.3.3g: a command on the other bus moves a slave that hears its master.
#[test]
fn command_on_the_other_bus_is_counted_as_ignored() {
    let mut slave = powered(&STANDARD);
    slave.run_until(ms(10));
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.clear();
    for command in [[0x01, 5], [0x80, 0], [0x81, 0], [0x82, 5], [0x02, 6]] {
        slave.receive(REDUNDANT, CobId::NMT.raw(), &command);
    }
    let counters = slave.node.status(slave.now).counters;
    assert_eq!((counters.redundant.ignored, slave.events.len()), (5, 0));
    assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational);
}

/// Given a slave with selective access whose master was heard on the nominal bus, and has moved to the redundant one, when its application
/// chooses the redundant bus, then the slave finds its master there and stays. The same the other way round.
///
/// Verifies: ECSS 8.2.1a.1, 8.3.3k, 8.3.3l
/// Notices: ECSS 8.2.3a: a slave that chose the bus of its master goes back after a toggling time.
#[test]
fn slave_that_chooses_the_bus_of_its_master_stays_there() {
    for ttoggle in [2, 0] {
        let mut slave = powered(&Profile { ttoggle, ..SELECTIVE });
        slave.run_until(ms(10));
        slave.receive(NOMINAL, 0x701, &[0x05]);
        for (chosen, from) in [(REDUNDANT, 50), (NOMINAL, 20_050)] {
            slave.run_until(ms(from));
            slave.clear();
            slave.touch(|slave, _| slave.select_bus(chosen).unwrap());
            for at in (from + 100..from + 20_000).step_by(100) {
                slave.run_until(ms(at));
                slave.receive(chosen, 0x701, &[0x05]);
                assert_eq!(slave.node.status(slave.now).active, chosen, "{at} ms");
            }
            assert_eq!(slave.controls, [(chosen.other(), BusCommand::Leave), (chosen, BusCommand::Join)]);
            let buses = slave.events.iter().filter(|event| matches!(event, SlaveEvent::ActiveBus { .. }));
            let [selected, found] = [BusCause::Selected, BusCause::Found]
                .map(|cause| SlaveEvent::ActiveBus { bus: chosen, cause });
            assert_eq!(buses.collect::<Vec<_>>(), [&selected, &found]);
            assert_eq!(slave.node.status(slave.now).redundancy.bdefault, chosen);
        }
    }
}

/// Given a slave with selective access that is Operational or Stopped, when its application chooses the other bus, then the slave goes
/// there and is Pre-operational.
///
/// Verifies: ECSS 8.2.1a.1
/// Notices: ECSS 8.2.3a: the bus of a slave that is stopped cannot be chosen.
#[test]
fn bus_is_chosen_in_each_state() {
    for command in [0x01, 0x02] {
        let mut slave = powered(&SELECTIVE);
        slave.run_until(ms(10));
        slave.receive(NOMINAL, 0x701, &[0x05]);
        slave.receive(NOMINAL, 0x000, &[command, 5]);
        slave.clear();
        slave.touch(|slave, _| slave.select_bus(REDUNDANT).unwrap());
        assert_eq!(slave.controls, [(NOMINAL, BusCommand::Leave), (REDUNDANT, BusCommand::Join)]);
        assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational, "command {command:02X}h");
    }
}
