//! NMT state machine and module control.
//!
//! Verifies: ECSS 6.5.1a, 6.5.4a

use async_canopen::nmt::machine::{NmtSlave, Reaction};
use async_canopen::nmt::{Command, ErrorBehaviour, NmtMessage, NmtStartup, Target};
use async_canopen::types::{AbortCode, NmtState, NodeId};

use crate::bench::{frame, node};

const COMMANDS: [(u8, Command); 5] = [
    (0x01, Command::Start),
    (0x02, Command::Stop),
    (0x80, Command::EnterPreOperational),
    (0x81, Command::ResetNode),
    (0x82, Command::ResetCommunication),
];

fn at(state: NmtState) -> NmtSlave {
    match state {
        NmtState::Initialising => NmtSlave::new(false),
        NmtState::PreOperational => in_state(Command::EnterPreOperational),
        NmtState::Operational => in_state(Command::Start),
        NmtState::Stopped => in_state(Command::Stop),
    }
}

fn in_state(command: Command) -> NmtSlave {
    let mut slave = NmtSlave::new(false);
    slave.boot();
    slave.on_command(command);
    slave
}

#[test]
fn node_ids_are_1_to_127() {
    assert_eq!(NodeId::new(0), None);
    assert_eq!(NodeId::new(1), Some(NodeId::MASTER));
    assert_eq!(NodeId::new(127).map(NodeId::get), Some(127));
    assert_eq!(NodeId::new(128), None);
}

/// Verifies: ECSS 6.5.1a.1, 6.5.1a.2, 6.5.1a.3, 6.5.1a.4, 6.5.1a.5
/// Notices: ECSS 6.5.1a: commands to node 127 are not decoded.
#[test]
fn commands_on_the_wire() {
    for (byte, command) in COMMANDS {
        let all = NmtMessage { command, target: Target::All };
        assert_eq!(all.encode(), frame(0x000, &[byte, 0]));
        assert_eq!(NmtMessage::decode(&frame(0x000, &[byte, 0])), Some(all));
        for id in 1..=127 {
            let one = NmtMessage { command, target: Target::Node(node(id)) };
            assert_eq!(one.encode(), frame(0x000, &[byte, id]));
            assert_eq!(NmtMessage::decode(&frame(0x000, &[byte, id])), Some(one));
        }
    }
}

#[test]
fn malformed_commands_are_none() {
    for data in [&[][..], &[0x01], &[0x01, 0, 0], &[0x00, 0], &[0x03, 0], &[0x7F, 5], &[0x01, 128]] {
        assert_eq!(NmtMessage::decode(&frame(0x000, data)), None, "{data:?}");
    }
}

#[test]
fn a_command_addresses_one_node_or_all() {
    assert!(Target::All.includes(node(5)));
    assert!(Target::Node(node(5)).includes(node(5)));
    assert!(!Target::Node(node(5)).includes(node(6)));
}

/// Verifies: ECSS 6.5.2a, 6.5.3a
#[test]
fn heartbeat_bytes_of_the_states() {
    let bytes = [NmtState::Initialising, NmtState::Stopped, NmtState::Operational, NmtState::PreOperational]
        .map(NmtState::byte);
    assert_eq!(bytes, [0x00, 0x04, 0x05, 0x7F]);
    for byte in bytes {
        assert_eq!(NmtState::from_byte(byte).map(NmtState::byte), Some(byte));
    }
    assert_eq!([0x01, 0x06].map(NmtState::from_byte), [None; 2]);
}

/// Bit 7 toggles in node guarding (CiA 301 7.2.8.3.2.1).
///
/// Verifies: ECSS 6.5.2a
#[test]
fn bit_7_of_a_heartbeat_is_ignored_but_in_80h() {
    for byte in 0x81..=0xFF {
        assert_eq!(NmtState::from_byte(byte), NmtState::from_byte(byte & 0x7F), "{byte:02X}h");
    }
    assert_eq!(NmtState::from_byte(0xFF), Some(NmtState::PreOperational));
    assert_eq!(NmtState::from_byte(0x80), None, "no boot-up message");
}

/// Verifies: ECSS 11.1b
/// Notices: ECSS 6.5.4a: SDO, SYNC and emergencies go on in Stopped.
/// Notices: ECSS 11.1b: emergencies, which are optional, go out in Stopped.
#[test]
fn services_by_state() {
    use NmtState::{Initialising, Operational, PreOperational, Stopped};
    let states = [Initialising, PreOperational, Operational, Stopped];
    assert_eq!(states.map(NmtState::allows_pdo), [false, false, true, false]);
    for service in [NmtState::allows_sync, NmtState::allows_sdo, NmtState::allows_emcy] {
        assert_eq!(states.map(service), [false, true, true, false]);
    }
}

/// Verifies: ECSS 6.5.1a.1, 6.5.1a.2, 6.5.1a.3, 6.5.1a.4, 6.5.1a.5
/// Notices: ECSS 6.5.1a: the command to stop is obeyed in Operational alone.
#[test]
fn every_transition_of_the_state_diagram() {
    use NmtState::{Initialising, Operational, PreOperational, Stopped};
    use Reaction::{Entered, ResetCommunication, ResetNode, Unchanged};
    // One column for each command: start, stop, enter Pre-operational, reset node, reset communication.
    let diagram = [
        (Initialising, [Unchanged; 5]),
        (PreOperational, [Entered(Operational), Entered(Stopped), Unchanged, ResetNode, ResetCommunication]),
        (Operational, [Unchanged, Entered(Stopped), Entered(PreOperational), ResetNode, ResetCommunication]),
        (Stopped, [Entered(Operational), Unchanged, Entered(PreOperational), ResetNode, ResetCommunication]),
    ];
    for (before, reactions) in diagram {
        for ((_, command), expected) in COMMANDS.into_iter().zip(reactions) {
            let mut slave = at(before);
            assert_eq!(slave.on_command(command), expected, "{command:?} in {before:?}");
            let after = match expected {
                Unchanged => before,
                Entered(state) => state,
                ResetNode | ResetCommunication => Initialising,
            };
            assert_eq!(slave.state(), after, "{command:?} in {before:?}");
        }
    }
}

#[test]
fn initialising_ends_in_pre_operational() {
    for command in [Command::ResetCommunication, Command::ResetNode] {
        let mut slave = in_state(Command::Start);
        slave.on_command(command);
        assert_eq!(slave.boot(), NmtState::PreOperational);
        assert_eq!(slave.state(), NmtState::PreOperational);
    }
}

#[test]
fn while_initialising_nothing_changes_the_state() {
    let mut slave = NmtSlave::new(false);
    assert_eq!(slave.on_master_missed(), Reaction::Unchanged);
    for behaviour in [ErrorBehaviour::PreOperational, ErrorBehaviour::Unchanged, ErrorBehaviour::Stopped] {
        assert_eq!(slave.on_communication_error(behaviour), Reaction::Unchanged);
    }
    assert_eq!(slave.state(), NmtState::Initialising);
}

#[test]
fn a_communication_error_leads_where_1029h_says() {
    use ErrorBehaviour as B;
    use NmtState::{Operational, PreOperational, Stopped};
    use Reaction::{Entered, Unchanged};
    let table = [
        (Operational, [Entered(PreOperational), Unchanged, Entered(Stopped)]),
        (PreOperational, [Unchanged, Unchanged, Entered(Stopped)]),
        (Stopped, [Unchanged; 3]),
    ];
    for (before, reactions) in table {
        for (behaviour, expected) in [B::PreOperational, B::Unchanged, B::Stopped].into_iter().zip(reactions)
        {
            let mut slave = at(before);
            assert_eq!(slave.on_communication_error(behaviour), expected, "{behaviour:?} in {before:?}");
            let after = if let Entered(state) = expected { state } else { before };
            assert_eq!(slave.state(), after);
        }
    }
}

#[test]
fn error_behaviour_is_0_1_or_2() {
    assert_eq!(ErrorBehaviour::default(), ErrorBehaviour::PreOperational);
    let behaviours = [ErrorBehaviour::PreOperational, ErrorBehaviour::Unchanged, ErrorBehaviour::Stopped];
    for (byte, behaviour) in behaviours.into_iter().enumerate() {
        assert_eq!(ErrorBehaviour::from_byte(byte as u8), Ok(behaviour));
    }
    for byte in 3..=255 {
        assert_eq!(ErrorBehaviour::from_byte(byte), Err(AbortCode::ValueRange));
    }
}

#[test]
fn autostart_goes_to_operational_by_itself() {
    let mut slave = NmtSlave::new(true);
    assert_eq!(slave.boot(), NmtState::Operational);
}

#[test]
fn bit_2_of_1f80h_keeps_a_node_from_going_operational_by_itself() {
    let mut slave = NmtSlave::new(false);
    for (raw, state) in [(0, NmtState::Operational), (4, NmtState::PreOperational)] {
        let startup = NmtStartup::from_raw(raw);
        slave.set_autostart(startup.autostart());
        assert_eq!(slave.boot(), state);
        slave.on_command(Command::ResetCommunication);
        assert_eq!(NmtStartup::of_slave(startup.autostart()).raw(), raw);
    }
    assert!(!NmtStartup::from_raw(0xFFFF_FFFF).autostart());
}

/// Verifies: ECSS 8.3.3e.1, 8.3.3e
#[test]
fn a_missed_master_leads_to_pre_operational_from_any_state() {
    for command in [Command::Start, Command::Stop] {
        let mut slave = in_state(command);
        assert_eq!(slave.on_master_missed(), Reaction::Entered(NmtState::PreOperational));
    }
    assert_eq!(in_state(Command::EnterPreOperational).on_master_missed(), Reaction::Unchanged);
}
