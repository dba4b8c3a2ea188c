//! What a slave takes for its master, and what it does when the master is missed: profile `standard`, heartbeat 100 ms, consumer time
//! 250 ms, Ttoggle 2.

use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::node::SlaveEvent;
use ecss_can::node::extend::BusCommand;
use ecss_can::profile::Profile;
use ecss_can::redundancy::BusCause;
use ecss_can::types::{Bus, NmtState, NodeId};

use crate::bench::{NOMINAL, REDUNDANT, frame, ms};
use crate::device::fixture::{done, write};
use crate::instrument::STANDARD;
use crate::slave::{operational, powered};

const SELECTIVE: Profile = Profile { selective: &[NodeId::of::<5>()], ..STANDARD };

/// Given a slave that heard its master at 10 ms, when slave 2 sends heartbeats on either bus, then the slave misses the master at 260 ms,
/// also if 1016h names slave 2.
///
/// Verifies: ECSS 8.3.3c, 6.5.2b, 8.3.3e
/// Notices: ECSS 8.3.3c: the heartbeat of any node counts as that of the master.
#[test]
fn heartbeats_of_another_slave_are_not_those_of_the_master() {
    for (bus, is_consumed) in [(NOMINAL, false), (NOMINAL, true), (REDUNDANT, false), (REDUNDANT, true)] {
        let mut slave = operational(&STANDARD);
        if is_consumed {
            // Slave 2, 400 ms.
            assert_eq!(write(&mut slave, 0x1016, 2, &[0x90, 1, 2, 0]), done(0x1016, 2));
        }
        for at in (20..=250).step_by(10) {
            slave.run_until(ms(at));
            slave.receive(bus, 0x702, &[if at == 20 { 0 } else { 5 }]);
        }
        let missed = SlaveEvent::MasterMissed { bus: NOMINAL };
        slave.run_until(ms(259));
        assert!(!slave.events.contains(&missed), "{bus:?}, in 1016h: {is_consumed}");
        slave.run_until(ms(260));
        assert!(slave.events.contains(&missed), "{bus:?}, in 1016h: {is_consumed}");
        assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational);
    }
}

/// Given a slave in any state that hears its master, when Start, Stop or Enter Pre-operational comes for all nodes, then it obeys, and
/// its heartbeat reports the new state at once.
///
/// Verifies: ECSS 6.5.1a, 6.5.1a.1, 6.5.1a.2, 6.5.1a.3
/// Notices: ECSS 6.5.1a.3: a slave does not obey Enter Pre-operational for all nodes.
#[test]
fn commands_to_all_nodes_change_the_state() {
    const COMMANDS: [(u8, NmtState, u8); 3] = [
        (0x01, NmtState::Operational, 0x05),
        (0x02, NmtState::Stopped, 0x04),
        (0x80, NmtState::PreOperational, 0x7F),
    ];
    for (before, ..) in COMMANDS {
        for (command, state, reported) in COMMANDS.into_iter().filter(|(command, ..)| *command != before) {
            let mut slave = operational(&STANDARD);
            slave.receive(NOMINAL, 0x000, &[before, 5]);
            slave.clear();
            slave.receive(NOMINAL, 0x000, &[command, 0]);
            assert_eq!(slave.events, [SlaveEvent::State(state)], "{command:02X}h after {before:02X}h");
            assert_eq!(slave.frames(), [(NOMINAL, frame(0x705, &[reported]))]);
        }
    }
}

/// Given a slave that misses its master, when a command comes on the same bus before the switch, then this bus is the active one: the
/// slave obeys and does not switch. A heartbeat within a consumer time confirms it; without one the search goes on.
///
/// Verifies: ECSS 8.3.3g, 8.3.3k, 6.5.1a.1
/// Notices: ECSS 8.3.3k: a command between the miss and the switch does not end the search.
#[test]
fn command_on_same_bus_between_miss_and_switch_ends_search() {
    for is_confirmed in [true, false] {
        let mut slave = operational(&STANDARD);
        slave.run_until(ms(300));
        slave.clear();
        slave.receive(NOMINAL, 0x000, &[0x01, 0x05]);
        let found = SlaveEvent::ActiveBus { bus: NOMINAL, cause: BusCause::Found };
        assert_eq!(slave.events, [found, SlaveEvent::State(NmtState::Operational)]);
        // Ttoggle: 510 ms. The consumer time after the command: 550 ms.
        slave.run_until(ms(540));
        if is_confirmed {
            slave.receive(NOMINAL, 0x701, &[0x05]);
        }
        slave.run_until(ms(549));
        let status = slave.node.status(slave.now);
        assert_eq!((status.active, status.state), (NOMINAL, NmtState::Operational));
        slave.run_until(ms(700));
        let status = slave.node.status(slave.now);
        let expected = if is_confirmed {
            (NOMINAL, NmtState::Operational)
        } else {
            (REDUNDANT, NmtState::PreOperational)
        };
        assert_eq!((status.active, status.state), expected);
    }
}

/// Given a slave that gave up its search on the nominal bus, when a heartbeat of the master comes on the redundant bus, then that bus is
/// the active one: the slave sends its heartbeat there, and misses the master there after a consumer time.
///
/// Verifies: ECSS 8.3.3g, 8.3.3k, 8.3.3d, 8.3.3j
/// Notices: ECSS 8.3.3g: a slave that gave up its search hears the master on its own bus alone.
#[test]
fn heartbeat_on_the_other_bus_is_found_after_the_slave_gave_up() {
    let mut slave = powered(&Profile { ntoggle: 2, ..STANDARD });
    slave.run_until(ms(1_550));
    assert_eq!(slave.events.last(), Some(&SlaveEvent::GaveUp { bus: NOMINAL }));
    slave.clear();
    slave.receive(REDUNDANT, 0x701, &[0x05]);
    let bus = REDUNDANT;
    assert_eq!(
        slave.events,
        [SlaveEvent::ActiveBus { bus, cause: BusCause::Found }, SlaveEvent::Heartbeat { bus }]
    );
    assert_eq!(slave.frames(), [(REDUNDANT, frame(0x705, &[0x7F]))]);
    slave.clear();
    slave.run_until(ms(1_799));
    assert_eq!(slave.events, []);
    assert_eq!(slave.times(NOMINAL, 0x705), [0; 0]);
    slave.run_until(ms(1_800));
    assert_eq!(slave.events, [SlaveEvent::MasterMissed { bus }]);
}

/// Given a slave that heard its master, stopped with selective access or started by itself, when it misses the master, then it enters
/// Pre-operational at once, and changes the bus after Ttoggle consumer times.
///
/// Verifies: ECSS 8.3.3e, 8.3.3e.1, 8.3.3e.2, 8.3.3d
/// Notices: ECSS 8.3.3e.1: a slave with selective access that is stopped stays so when it misses the master.
#[test]
fn stopped_selective_and_autostarted_slaves_miss_the_master() {
    const AUTOSTART: Profile = Profile { autostart: true, ..STANDARD };
    const LEAVES: [(Bus, BusCommand); 2] = [(NOMINAL, BusCommand::Leave), (REDUNDANT, BusCommand::Join)];
    const ABANDONS: [(Bus, BusCommand); 1] = [(NOMINAL, BusCommand::Abandon)];
    for (profile, command, state, controls) in [
        (&SELECTIVE, Some(0x02), NmtState::Stopped, &LEAVES[..]),
        (&AUTOSTART, None, NmtState::Operational, &ABANDONS[..]),
    ] {
        let mut slave = powered(profile);
        slave.run_until(ms(10));
        slave.receive(NOMINAL, 0x701, &[0x05]);
        if let Some(command) = command {
            slave.receive(NOMINAL, 0x000, &[command, 5]);
        }
        slave.run_until(ms(259));
        assert_eq!(slave.node.status(slave.now).state, state);
        slave.clear();
        slave.run_until(ms(260));
        let entered = SlaveEvent::State(NmtState::PreOperational);
        assert_eq!(slave.events, [SlaveEvent::MasterMissed { bus: NOMINAL }, entered]);
        slave.run_until(ms(509));
        assert_eq!(slave.controls, []);
        slave.clear();
        slave.run_until(ms(510));
        assert_eq!(slave.events, [SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Toggled }]);
        assert_eq!(slave.controls, controls);
        assert_eq!(slave.frames(), [(REDUNDANT, frame(0x705, &[0x7F]))]);
    }
}

/// Given a slave with selective access, when it gets power, then it joins the bus of Bdefault alone, and boots up there.
///
/// Verifies: ECSS 8.3.2a, 8.2.1a, 8.2.1a.1
/// Notices: ECSS 8.3.2a: a slave with selective access joins the nominal bus whatever Bdefault is.
#[test]
fn selective_slave_boots_up_on_either_default_bus() {
    for bus in Bus::ALL {
        let slave = powered(&Profile { bdefault: bus, ..SELECTIVE });
        assert_eq!(slave.controls, [(bus, BusCommand::Join)]);
        assert_eq!(slave.frames(), [(bus, frame(0x705, &[0]))]);
        assert_eq!(slave.events[0], SlaveEvent::ActiveBus { bus, cause: BusCause::PowerOn });
    }
}

/// Given a slave whose controller of one bus is error passive, when the application reads the error counters twice, then it finds them
/// both times on that bus, and zeros on the other one.
///
/// Verifies: ECSS 5.6.2c
/// Notices: ECSS 5.6.2c: the error counters are shown for the other bus.
/// Notices: ECSS 5.6.2c: the object of a bus has a receive error counter of 127 at most.
#[test]
fn error_counters_of_a_bus_are_read_twice_and_are_the_same() {
    let passive = Health { state: ErrorState::Passive, tec: 130, rec: 7, last_error: LastError::Crc };
    for bus in Bus::ALL {
        let mut slave = operational(&STANDARD);
        slave.health(bus, passive);
        for _ in 0..2 {
            let health = slave.node.status(slave.now).health;
            assert_eq!((health[bus], health[bus.other()]), (passive, Health::default()));
            slave.settle();
        }
    }
    // The objects have all eight bits of both.
    for (bus, low) in [(NOMINAL, 0x20), (REDUNDANT, 0x21)] {
        for count in [1, 127, 128, 255] {
            let mut slave = operational(&STANDARD);
            slave.health(bus, Health { tec: 255 - count, rec: count, ..passive });
            for (sub, value) in [(2, 255 - count), (3, count)] {
                slave.clear();
                slave.receive(NOMINAL, 0x605, &[0x40, low, 0x20, sub, 0, 0, 0, 0]);
                assert_eq!(
                    slave.frames(),
                    [(NOMINAL, frame(0x585, &[0x4F, low, 0x20, sub, value, 0, 0, 0]))]
                );
            }
        }
    }
}
