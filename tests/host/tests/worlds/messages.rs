//! Telecommands and telemetry, and invalid frames.

use can_twin::wire::frame::{WireFrame, WireId};
use ecss_can::nmt::{Command as NmtCommand, Target};
use ecss_can::node::{MasterEvent, Refusal};
use ecss_can::types::{Bus, NmtState, NodeId};
use mission::STANDARD;
use mission::{Command, Received, Request, Telemetry};

use crate::support::*;

/// Sends a request and waits for the answer.
fn ask(world: &mut MissionWorld, node: NodeId, request: Request) -> Telemetry {
    let from = world.now();
    assert_eq!(world.ask(node, request), Ok(()));
    world.run_for(ms(20));
    let answers: Vec<Telemetry> = master_told(world, from)
        .into_iter()
        .filter_map(|event| match event {
            MasterEvent::Pdo(pdo) => match mission::received(&pdo)? {
                (from, Received::Telemetry(message)) if from == node => Telemetry::decode(&message),
                _ => None,
            },
            _ => None,
        })
        .collect();
    assert_eq!(answers.len(), 1, "one answer to {request:?}");
    answers[0]
}

fn malformed(world: &mut MissionWorld, node: NodeId) -> u16 {
    match ask(world, node, Request::Losses(Bus::Nominal)) {
        Telemetry::Losses { malformed, .. } => malformed,
        other => panic!("asked for losses, got {other:?}"),
    }
}

/// Verifies: ECSS 6.2a
#[test]
fn a_command_is_executed_and_telemetry_reads_it_back() {
    let mut world = running(STANDARD, 3);
    let from = world.now();
    assert_eq!(world.command(THREE, Command::SetValue(0xDEAD_BEEF)), Ok(()));
    world.run_for(ms(20));
    let sent = since(&world, Bus::Nominal, 0x303, from);
    assert_eq!(sent.len(), 1);
    assert_eq!(sent[0].frame.payload(), [0x02, 0x00, 0xEF, 0xBE, 0xAD, 0xDE, 0, 0]);
    assert_eq!(ask(&mut world, THREE, Request::Value), Telemetry::Value(0xDEAD_BEEF));
    assert_eq!(ask(&mut world, TWO, Request::Value), Telemetry::Value(0));
    let executed = |node| {
        let reactions = world.reactions(node).into_iter();
        reactions.filter(|(_, reaction)| matches!(reaction, Reaction::Executed(_))).count()
    };
    assert_eq!((executed(TWO), executed(THREE)), (0, 1));
    let asked = since(&world, Bus::Nominal, 0x403, from);
    let answered = since(&world, Bus::Nominal, 0x383, from);
    assert_eq!((asked.len(), answered.len()), (1, 1));
    assert_eq!(answered[0].node, Some(THREE));
}

#[test]
fn a_slave_that_is_not_operational_is_not_commanded() {
    let mut world = running(STANDARD, 2);
    world.nmt(NmtCommand::EnterPreOperational, Target::Node(TWO));
    world.run_for(ms(200));
    let from = world.now();
    assert_eq!(world.command(TWO, Command::SetLed(true)), Err(Refusal::NotOperational));
    world.run_for(ms(200));
    assert!(since(&world, Bus::Nominal, 0x302, from).is_empty());
}

/// Verifies: ECSS 6.5.1a
#[test]
fn malformed_frames_are_ignored_and_counted() {
    let mut world = running(STANDARD, 2);
    let from = world.now();
    let before = malformed(&mut world, TWO);
    let bad = [
        standard(0x000, &[]),
        standard(0x000, &[0x81]),
        standard(0x000, &[0x81, 0, 0]),
        standard(0x000, &[0x03, 0]),
        standard(0x000, &[0x81, 200]),
        standard(0x080, &[1, 2]),
        standard(0x181, &[1, 2, 3, 4, 5, 6]),
        standard(0x302, &[1]),
        standard(0x402, &[]),
        standard(0x701, &[]),
        standard(0x701, &[0x42]),
    ];
    for frame in bad {
        world.inject(Bus::Nominal, frame);
    }
    world.run_for(ms(50));
    assert_eq!(malformed(&mut world, TWO) - before, bad.len() as u16);
    assert!(world.all_operational());
    assert!(told(&world, TWO, from, entered(NmtState::PreOperational)).is_empty());
}

#[test]
fn foreign_extended_and_remote_frames_disturb_nobody() {
    let mut world = running(STANDARD, 2);
    let before = malformed(&mut world, TWO);
    let handled = world.diagnostics(TWO).expect("it has power").handled(Bus::Nominal).get();
    let from = world.now();
    for data in 0..50 {
        let reset = standard(0x000, &[0x81, 0]);
        world.inject(Bus::Nominal, WireFrame { id: WireId::Extended(data), ..reset });
        world.inject(Bus::Nominal, WireFrame { remote: true, data: [0; 8], ..reset });
        world.inject(
            Bus::Nominal,
            WireFrame { id: WireId::Standard(0x702), remote: true, dlc: 1, data: [0; 8] },
        );
        world.inject(Bus::Nominal, standard(0x5FF, &[0; 8]));
    }
    world.run_for(ms(40));
    let foreign = world.frames(Bus::Nominal).iter().filter(|sent| sent.node.is_none()).count();
    assert_eq!(foreign, 200, "all were acknowledged");
    // The frames handled meanwhile are those of the master.
    let ours = [0x000, 0x080, 0x181, 0x302, 0x402, 0x701].into_iter();
    let heard: usize = ours
        .map(|id| {
            let frames = since(&world, Bus::Nominal, id, from);
            frames.iter().filter(|sent| sent.node == Some(MASTER)).count()
        })
        .sum();
    let now_handled = world.diagnostics(TWO).expect("it has power").handled(Bus::Nominal).get();
    assert_eq!((now_handled - handled) as usize, heard);
    assert_eq!(malformed(&mut world, TWO), before);
    assert!(world.all_operational());
}

/// Given a DLC of 9 to 15, which means 8 data bytes (ISO 11898-1), then the frame is an unknown command with six bytes
/// of data.
#[test]
fn a_long_dlc_means_eight_bytes() {
    let mut world = running(STANDARD, 2);
    let command = standard(0x302, &[0x34, 0x12, 1, 2, 3, 4, 5, 6]);
    world.inject(Bus::Nominal, WireFrame { dlc: 15, ..command });
    world.run_for(ms(10));
    let reactions = world.reactions(TWO);
    assert!(reactions.iter().any(|(_, reaction)| *reaction == Reaction::Unknown(0x1234)));
}
