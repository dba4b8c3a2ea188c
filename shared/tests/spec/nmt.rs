//! NMT state machine and module control.

use ecss_can::nmt::{Command, NmtMessage, NmtSlave, NmtState, NodeId, Reaction, Target};

use crate::bench::{frame, node};

const COMMANDS: [(u8, Command); 5] = [
    (0x01, Command::Start),
    (0x02, Command::Stop),
    (0x80, Command::EnterPreOperational),
    (0x81, Command::ResetNode),
    (0x82, Command::ResetCommunication),
];

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

#[test]
fn commands_on_the_wire() {
    for (byte, command) in COMMANDS {
        let all = NmtMessage { command, target: Target::All };
        let one = NmtMessage { command, target: Target::Node(node(5)) };
        assert_eq!(all.encode(), frame(0x000, &[byte, 0]));
        assert_eq!(one.encode(), frame(0x000, &[byte, 5]));
        assert_eq!(NmtMessage::decode(&frame(0x000, &[byte, 0])), Some(all));
        assert_eq!(NmtMessage::decode(&frame(0x000, &[byte, 5])), Some(one));
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

#[test]
fn heartbeat_bytes_of_the_states() {
    let bytes = [NmtState::Initialising, NmtState::Stopped, NmtState::Operational, NmtState::PreOperational]
        .map(NmtState::byte);
    assert_eq!(bytes, [0x00, 0x04, 0x05, 0x7F]);
    for byte in bytes {
        assert_eq!(NmtState::from_byte(byte).map(NmtState::byte), Some(byte));
    }
    assert_eq!([0x01, 0x06, 0x80, 0x85, 0xFF].map(NmtState::from_byte), [None; 5]);
}

#[test]
fn services_by_state() {
    use NmtState::{Initialising, Operational, PreOperational, Stopped};
    let states = [Initialising, PreOperational, Operational, Stopped];
    assert_eq!(states.map(NmtState::allows_pdo), [false, false, true, false]);
    assert_eq!(states.map(NmtState::allows_sync), [false, true, true, false]);
}

/// Verifies: ECSS 6.5.4a
#[test]
fn every_transition_of_the_state_diagram() {
    use NmtState::{Operational, PreOperational, Stopped};
    let states = [
        (Command::EnterPreOperational, PreOperational),
        (Command::Start, Operational),
        (Command::Stop, Stopped),
    ];
    for (reach, before) in states {
        for (command, after) in states {
            let mut slave = in_state(reach);
            let expected = if before == after { Reaction::Unchanged } else { Reaction::Entered(after) };
            assert_eq!(slave.on_command(command), expected);
            assert_eq!(slave.state(), after);
        }
        let mut slave = in_state(reach);
        assert_eq!(slave.on_command(Command::ResetNode), Reaction::ResetNode);
        assert_eq!(slave.state(), NmtState::Initialising);
        let mut slave = in_state(reach);
        assert_eq!(slave.on_command(Command::ResetCommunication), Reaction::ResetCommunication);
        assert_eq!(slave.boot(), PreOperational);
    }
}

#[test]
fn while_initialising_nothing_is_obeyed() {
    let mut slave = NmtSlave::new(false);
    for (_, command) in COMMANDS {
        assert_eq!(slave.on_command(command), Reaction::Unchanged);
    }
    assert_eq!(slave.on_master_missed(), Reaction::Unchanged);
    assert_eq!(slave.state(), NmtState::Initialising);
}

/// Verifies: ECSS 6.5.4a
#[test]
fn autostart_goes_to_operational_by_itself() {
    let mut slave = NmtSlave::new(true);
    assert_eq!(slave.boot(), NmtState::Operational);
}

/// Verifies: ECSS 8.3.3e.1
#[test]
fn a_missed_master_leads_to_pre_operational_from_any_state() {
    for command in [Command::Start, Command::Stop] {
        let mut slave = in_state(command);
        assert_eq!(slave.on_master_missed(), Reaction::Entered(NmtState::PreOperational));
    }
    assert_eq!(in_state(Command::EnterPreOperational).on_master_missed(), Reaction::Unchanged);
}
