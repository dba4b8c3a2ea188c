//! Heartbeats whose bit 7 is set, as some nodes send them: the toggle bit of node guarding (CiA 301 7.2.8.3.2.1), reserved in a
//! heartbeat (7.2.8.3.2.2).

use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::minimal::MinimalEvent;
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::redundancy::{BusCause, SwitchCause};
use ecss_can::types::{Bus, NmtState};

use crate::bench::{NOMINAL, REDUNDANT, frame, ms, node};
use crate::instrument::STANDARD;
use crate::{canopen_slave, master_device, minimal, pair, slave};

/// The states a heartbeat may have, with bit 7.
const TOGGLED: [(u8, NmtState); 3] =
    [(0x84, NmtState::Stopped), (0x85, NmtState::Operational), (0xFF, NmtState::PreOperational)];
/// Bytes of no state: 80h is no boot-up message.
const NO_STATE: [u8; 5] = [0x80, 0x81, 0x86, 0xFE, 0x06];

/// Given a master that sends every heartbeat, or every second one, with bit 7, then its slave follows for ever. Each such heartbeat is
/// counted.
///
/// Verifies: ECSS 6.5.2b, 6.5.2a, 8.3.3c
/// Notices: ECSS 6.5.2b: heartbeats of a master that is not Operational do not count.
#[test]
fn slave_follows_a_master_with_bit_7() {
    for (byte, _) in TOGGLED {
        for every in [1, 2] {
            let mut slave = slave::operational(&STANDARD);
            for beat in 1..=50 {
                slave.run_until(ms(10 + beat * 100));
                let byte = if beat % every == 0 { byte } else { byte & 0x7F };
                slave.receive(NOMINAL, 0x701, &[byte]);
            }
            let status = slave.node.status(slave.now);
            assert_eq!(status.state, NmtState::Operational);
            assert_eq!(u64::from(status.counters.nominal.malformed), 50 / every);
            let heard = slave.events.iter().filter(|event| matches!(event, SlaveEvent::Heartbeat { .. }));
            assert_eq!(heard.count(), 50, "{byte:02X}h");
            assert!(slave.times(NOMINAL, 0x085).is_empty());
        }
    }
}

/// Given a slave that misses its master, when a heartbeat with bit 7 comes on the other bus, then the search ends there.
///
/// Verifies: ECSS 8.3.3g, 8.3.3k
#[test]
fn heartbeat_with_bit_7_ends_a_search() {
    for (byte, _) in TOGGLED {
        let mut slave = slave::operational(&STANDARD);
        slave.run_until(ms(300));
        slave.clear_events();
        slave.receive(REDUNDANT, 0x701, &[byte]);
        let found = SlaveEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Found };
        assert!(slave.events.contains(&found), "{:?}", slave.events);
    }
}

/// Verifies: ECSS 8.3.3c, 8.3.3e, 6.5.2b, 8.3.3e.1
/// Notices: ECSS 8.3.3c: a malformed heartbeat on the active bus counts as one of the master.
/// Notices: ECSS 8.3.3e: a malformed heartbeat on the active bus counts as one of the master.
#[test]
fn bytes_of_no_state_are_no_heartbeats_of_the_master() {
    for byte in NO_STATE {
        let mut slave = slave::operational(&STANDARD);
        slave.run_until(ms(200));
        slave.receive(NOMINAL, 0x701, &[byte]);
        slave.receive(REDUNDANT, 0x701, &[byte]);
        let counters = slave.node.status(slave.now).counters;
        assert_eq!((counters.nominal.malformed, counters.redundant.malformed), (1, 1), "{byte:02X}h");
        slave.run_until(ms(260));
        assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational, "{byte:02X}h");
        assert_eq!(slave.node.status(slave.now).active, Bus::Nominal);
    }
}

/// Verifies: ECSS 6.10h
#[test]
fn double_node_id_with_bit_7_is_a_clash() {
    let mut slave = slave::operational(&STANDARD);
    slave.transmitted(NOMINAL, frame(0x705, &[0]));
    slave.run_until(ms(240));
    slave.receive(NOMINAL, 0x705, &[0x80]);
    assert!(!slave.events.contains(&SlaveEvent::Clash { bus: NOMINAL, yields: true }));
    slave.receive(NOMINAL, 0x705, &[0x85]);
    assert!(slave.events.iter().any(|event| matches!(event, SlaveEvent::Clash { bus: NOMINAL, .. })));
    assert_eq!(slave.node.status(slave.now).counters.nominal.malformed, 2);
}

/// Given a node that 1016h monitors, when it sends bit 7, then it is not missed and its state is known.
///
/// Verifies: ECSS 6.5.2a, 6.5.2b
/// Notices: ECSS 6.5.2b: a plain slave takes no heartbeat with bit 7.
#[test]
fn consumer_takes_heartbeats_with_bit_7() {
    for (byte, state) in TOGGLED {
        let mut slave = canopen_slave::operational();
        for beat in 0..20 {
            slave.run_until(ms(beat * 100));
            slave.receive(NOMINAL, 0x701, &[byte]);
        }
        let one = node(1);
        assert_eq!(slave.events, [async_canopen::node::Event::PeerState { node: one, state }]);
        assert_eq!(slave.node.counters().malformed, 20);
        assert_eq!(slave.node.state(), NmtState::Operational);
        slave.receive(NOMINAL, 0x701, &[0x80]);
        assert_eq!((slave.events.len(), slave.node.counters().malformed), (1, 21), "no boot-up");
    }
}

/// Given a slave that sends bit 7, then its master knows its state, starts it, does not lose it and stays on the bus. 80h is no
/// boot-up message: nothing is asked again.
///
/// Verifies: ECSS 8.3.3f, 6.5.2a
#[test]
fn master_keeps_a_slave_with_bit_7() {
    let mut master = master_device::powered(&STANDARD);
    master.receive(NOMINAL, 0x705, &[0xFF]);
    assert!(master.frames().contains(&(NOMINAL, frame(0x000, &[1, 5]))), "started");
    master.receive(NOMINAL, 0x585, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    for beat in 0..50 {
        master.run_until(ms(10 + beat * 100));
        master.receive(NOMINAL, 0x705, &[0x85]);
    }
    assert_eq!(master.node.slave_state(node(5)), Some(NmtState::Operational));
    let is_wrong = |event: &&MasterEvent| {
        matches!(
            event,
            MasterEvent::SlaveLost { .. } | MasterEvent::BusSwitched { .. } | MasterEvent::Clash { .. }
        )
    };
    assert_eq!(master.events.iter().find(is_wrong), None);
    assert_eq!(master.node.status(master.now).counters.nominal.malformed, 51);
    master.clear();
    master.receive(NOMINAL, 0x705, &[0x80]);
    assert_eq!((master.frames(), &master.events[..]), (vec![], &[][..]));
    assert_eq!(master.node.status(master.now).counters.nominal.malformed, 52);
    // 84h: stopped by the application, and so it stays.
    let stop = NmtMessage { command: Command::Stop, target: Target::Node(node(5)) };
    master.request(ecss_can::node::MasterRequest::Nmt(stop));
    master.receive(NOMINAL, 0x705, &[0x84]);
    assert_eq!(master.node.slave_state(node(5)), Some(NmtState::Stopped));
    for byte in NO_STATE {
        master.receive(NOMINAL, 0x705, &[byte]);
    }
    assert_eq!(master.node.slave_state(node(5)), Some(NmtState::Stopped));
}

/// Given a standby that hears master and slaves with bit 7 alone, when it takes over, then they are its slaves: their silence makes it
/// leave the bus.
///
/// Verifies: ECSS 8.1a, 8.3.3b
#[test]
fn standby_knows_slaves_with_bit_7() {
    let mut board = pair::powered(ecss_can::redundancy::Strap::Second);
    for beat in 1..=10 {
        board.run_until(ms(100 * beat));
        board.receive(REDUNDANT, 0x701, &[0x85]);
        board.receive(REDUNDANT, 0x680, &[2, 0]);
        board.receive(REDUNDANT, 0x702, &[0x85]);
        board.receive(REDUNDANT, 0x703, &[0x85]);
    }
    assert_eq!(board.node.status(board.now).counters.redundant.malformed, 30);
    assert_eq!(board.frames(), []);
    board.run_until(ms(1_400));
    board.transmitted(REDUNDANT, frame(0x701, &[0]));
    board.transmitted(REDUNDANT, frame(0x701, &[5]));
    board.clear();
    for at in (1_400..2_300).step_by(100) {
        board.run_until(ms(at));
        board.receive(REDUNDANT, 0x702, &[0x85]);
    }
    let switched = board.events.iter().find_map(|event| match event {
        MasterEvent::BusSwitched { cause, .. } => Some(*cause),
        _ => None,
    });
    assert_eq!(switched, Some(SwitchCause::SlavesSilent), "{:?}", board.events);
}

/// Verifies: ECSS 6.5.2b, 8.3.3c
/// Notices: ECSS 6.5.2b: a minimal slave takes no heartbeat with bit 7.
#[test]
fn minimal_slave_follows_a_master_with_bit_7() {
    for (byte, _) in TOGGLED {
        let mut slave = minimal::powered::<minimal::Probe>();
        for beat in 0..20 {
            slave.run_until(ms(beat * 100));
            slave.receive(NOMINAL, 0x701, &[byte]);
        }
        let heard = slave.events.iter().filter(|event| matches!(event, MinimalEvent::Heartbeat { .. }));
        assert_eq!(heard.count(), 20, "{byte:02X}h");
        assert_eq!(slave.node.counters().nominal.malformed, 20, "{byte:02X}h");
    }
    for byte in NO_STATE {
        let mut slave = minimal::powered::<minimal::Probe>();
        slave.receive(NOMINAL, 0x701, &[byte]);
        assert_eq!((&slave.events[..], slave.node.counters().nominal.malformed), (&[][..], 1));
    }
}
