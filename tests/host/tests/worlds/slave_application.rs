//! The application of the slave image, on mock boards.

use can_twin::wire::fault::Fault;
use ecss_can::nmt::{Command as NmtCommand, Target};
use ecss_can::node::{MasterRequest, Refusal, SelfTest};
use ecss_can::od::Field;
use ecss_can::profile::Profile;
use ecss_can::types::{Address, Bus, NmtState, NodeId};
use mission::application::slave;
use mission::{Command, MissionObjects, STANDARD};

use crate::log_lines;
use crate::support::*;

/// Sends a frame with an identifier of the master from a foreign node, and runs for 20 ms.
fn send(world: &mut MissionWorld, id: u16, data: &[u8]) {
    world.inject(Bus::Nominal, standard(id, data));
    world.run_for(ms(20));
}

/// Sends a telemetry request to slave 2, and returns the data of its answers.
fn ask(world: &mut MissionWorld, data: &[u8]) -> Vec<Vec<u8>> {
    let from = world.now();
    send(world, 0x402, data);
    since(world, Bus::Nominal, 0x382, from).iter().map(|sent| sent.frame.payload().to_vec()).collect()
}

/// Returns the numbers of executed commands and of dropped repeats, from telemetry.
fn executed(world: &mut MissionWorld) -> (u32, u16) {
    let answers = ask(world, &[0x03, 0x01]);
    let [3, 1, a, b, c, d, low, high] = answers[0][..] else { panic!("{answers:?}") };
    (u32::from_le_bytes([a, b, c, d]), u16::from_le_bytes([low, high]))
}

/// Returns the logged warnings.
fn warnings() -> Vec<String> {
    log_lines::take().into_iter().filter(|line| line.starts_with("WARN")).collect()
}

/// Starts the self-test of a slave by the master, and returns the result.
fn self_test(world: &mut MissionWorld, node: NodeId) -> SelfTest {
    let start = Field::raw(Address::new(0x2030, 0));
    let task = world.on_master(|master| async move { master.sdo(node).write_bytes(start, &[1]).await });
    world.run_for(ms(20));
    assert_eq!(task.take().expect("the transfer ended").1, Ok(()));
    world.slave(node, |slave| slave.objects().extension.self_test)
}

/// Given a slave that runs, when it is commanded to switch its LED and to keep a value, then the LED follows, and telemetry and the
/// dictionary have the value.
///
/// Verifies: ECSS 6.2a
#[test]
fn commands_switch_the_led_and_set_the_value() {
    let mut world = running(STANDARD, 1);
    send(&mut world, 0x302, &[1, 0, 1, 0, 0, 0, 0, 0]);
    send(&mut world, 0x302, &[1, 0, 0, 0, 0, 0, 0, 1]);
    send(&mut world, 0x302, &[1, 0, 1, 0, 0, 0, 0, 2]);
    assert_eq!(world.indicators(TWO).states, [true, false, true]);
    send(&mut world, 0x302, &[2, 0, 0x78, 0x56, 0x34, 0x12, 0, 3]);
    assert_eq!(ask(&mut world, &[0x02, 0x01]), [[0x02, 0x01, 0x78, 0x56, 0x34, 0x12, 0, 0]]);
    assert_eq!(world.slave(TWO, |slave| slave.objects().application.value), 0x1234_5678);
    assert_eq!(executed(&mut world), (4, 0));
}

/// Given a command that CAN delivers three times, then the slave executes it once and counts two repeats. The same command with the
/// next sequence is another one.
///
/// Verifies: ECSS 6.2a
#[test]
fn a_repeated_command_is_executed_once() {
    let mut world = running(STANDARD, 1);
    for _ in 0..3 {
        send(&mut world, 0x302, &[1, 0, 1, 0, 0, 0, 0, 9]);
    }
    assert_eq!(world.indicators(TWO).states, [true]);
    assert_eq!(executed(&mut world), (1, 2));
    send(&mut world, 0x302, &[1, 0, 1, 0, 0, 0, 0, 10]);
    assert_eq!(world.indicators(TWO).states, [true, true]);
    assert_eq!(executed(&mut world), (2, 2));
    let reactions: Vec<Reaction> = world.reactions(TWO).into_iter().map(|(_, reaction)| reaction).collect();
    let led = Reaction::Executed(Command::SetLed(true));
    assert_eq!(reactions, [led, Reaction::Repeated(1), Reaction::Repeated(1), led]);
}

/// Given commands with an unknown code, an invalid LED state, and an invalid bus, then the slave executes none of them
/// and logs each.
#[test]
fn unknown_commands_are_refused_and_logged() {
    let mut world = running(STANDARD, 1);
    log_lines::keep();
    let commands: [[u8; 8]; 3] =
        [[0x34, 0x12, 0, 0, 0, 0, 0, 0], [1, 0, 2, 0, 0, 0, 0, 1], [4, 0, 2, 0, 0, 0, 0, 2]];
    for command in commands {
        send(&mut world, 0x302, &command);
    }
    let lines = warnings();
    let expected = ["1234", "0001", "0004"].map(|code| format!("WARN unknown command {code}h"));
    assert_eq!(lines, expected);
    assert_eq!(executed(&mut world), (0, 0));
    assert_eq!(world.indicators(TWO).states, [false; 0]);
}

/// Given a slave that executed two commands and dropped a repeat, when it is commanded to reset its counters, then commands, repeats
/// and frames received are counted from zero.
#[test]
fn a_command_resets_the_counters() {
    let mut world = running(STANDARD, 1);
    for sequence in [1, 1, 2] {
        send(&mut world, 0x302, &[1, 0, 1, 0, 0, 0, 0, sequence]);
    }
    assert_eq!(executed(&mut world), (2, 1));
    let before = world.status(TWO).counters.nominal.received;
    send(&mut world, 0x302, &[3, 0, 0, 0, 0, 0, 0, 3]);
    assert_eq!(executed(&mut world), (0, 0));
    let after = world.status(TWO).counters.nominal.received;
    assert!(before >= 25 && after <= 6, "{before}, {after}");
    let reactions = world.reactions(TWO);
    assert_eq!(
        reactions.last().map(|(_, reaction)| *reaction),
        Some(Reaction::Executed(Command::ResetCounters))
    );
}

/// Given a slave with selective access, when it is commanded to the redundant bus, then it goes there. One with parallel access
/// stays where it is and logs the refusal. Both count the command.
///
/// Verifies: ECSS 8.2.3a
#[test]
fn only_a_selective_slave_selects_its_bus() {
    let mut world = running(MIXED, 3);
    log_lines::keep();
    assert_eq!(world.command(FOUR, Command::SelectBus(Bus::Redundant)), Ok(()));
    assert_eq!(world.command(TWO, Command::SelectBus(Bus::Redundant)), Ok(()));
    world.run_for(ms(50));
    assert_eq!((world.active(FOUR), world.active(TWO)), (Some(Bus::Redundant), Some(Bus::Nominal)));
    let lines = log_lines::take();
    let refused = "WARN declined: the master chooses the bus of a slave with parallel access";
    assert_eq!(lines.iter().filter(|line| *line == refused).count(), 1, "{lines:?}");
    assert!(lines.iter().any(|line| line.starts_with("INFO active bus: Redundant")), "{lines:?}");
    for node in [TWO, FOUR] {
        let reactions: Vec<Reaction> =
            world.reactions(node).into_iter().map(|(_, reaction)| reaction).collect();
        assert_eq!(reactions, [Reaction::Executed(Command::SelectBus(Bus::Redundant))], "{node:?}");
    }
}

/// Given each request of the mission, complete or with its code only, then one answer has its code.
///
/// Verifies: ECSS 6.2a
#[test]
fn each_request_has_one_answer_with_its_code() {
    let mut world = running(STANDARD, 1);
    let codes = [0x01, 0x02, 0x03, 0x04, 0x10, 0x11, 0x20, 0x21, 0x30, 0x31];
    for code in codes {
        for request in [&[code, 1][..], &[code, 1, 0, 0], &[code, 1, 0, 0, 0, 0, 0, 0]] {
            let answers = ask(&mut world, request);
            assert_eq!(answers.len(), 1, "{request:02X?}");
            assert_eq!((answers[0].len(), &answers[0][..2]), (8, &[code, 1][..]));
        }
    }
    // 2 s after power-on, in milliseconds.
    let answer = &ask(&mut world, &[0x01, 0x01])[0];
    let uptime = u64::from_le_bytes([answer[2], answer[3], answer[4], answer[5], answer[6], answer[7], 0, 0]);
    assert!(uptime.abs_diff(world.now().as_us() / 1_000) <= 20, "{uptime} ms");
}

/// Given requests with an unknown code, with one byte of a code, and empty, then the slave answers none of them. It
/// logs the unknown code.
#[test]
fn unknown_and_short_requests_are_not_answered() {
    let mut world = running(STANDARD, 1);
    log_lines::keep();
    for request in [&[0x05, 0x01, 0, 0, 0, 0, 0, 0][..], &[0x01], &[]] {
        assert!(ask(&mut world, request).is_empty(), "{request:02X?}");
    }
    assert_eq!(warnings(), ["WARN unknown telemetry request 0105h"]);
    assert_eq!(ask(&mut world, &[0x02, 0x01]).len(), 1);
}

/// Given a client that starts the self-test, then it passes while both controllers are error active. With a bus that a driver holds
/// dominant it fails: bit 0 is the nominal bus, bit 1 the redundant one.
///
/// Verifies: ECSS 6.7b, 6.7c
/// Notices: ECSS 6.7c: a failure of the redundant bus sets the bit of the nominal bus.
#[test]
fn self_test_fails_while_a_controller_is_error_passive() {
    for (stuck, failures) in [(Bus::Nominal, 0b01), (Bus::Redundant, 0b10)] {
        let mut world = running(STANDARD, 2);
        world.request(MasterRequest::SwitchBus(stuck.other()));
        world.run_for(ms(1_000));
        assert_eq!(self_test(&mut world, TWO), SelfTest { progress: SelfTest::PASSED, failures: 0 });
        let three = world.index(THREE);
        world.strike(stuck, Fault::StuckDominant(three));
        world.run_for(ms(100));
        assert_eq!(self_test(&mut world, TWO), SelfTest { progress: SelfTest::FAILED, failures });
    }
}

/// Given a client that writes the pulses per second (6310h), then the pulse output has as many.
#[test]
fn pulses_per_second_follow_the_object() {
    let mut world = running(STANDARD, 1);
    let task = world.on_slave(TWO, |slave| async move { slave::pulses_per_second(slave) });
    world.run_for(ms(1));
    let (_, pulses) = task.take().expect("it ended");
    assert_eq!(pulses(), 1, "default");
    let pulses_of = MissionObjects::PULSES;
    let task = world.on_master(|master| async move { master.sdo(TWO).write(pulses_of, 500).await });
    world.run_for(ms(20));
    assert_eq!(task.take().expect("the transfer ended").1, Ok(()));
    assert_eq!(pulses(), 500);
}

/// Given a slave for two seconds, then its LEDs toggled once with each heartbeat, SYNC and spacecraft time of the master.
#[test]
fn leds_toggle_with_heartbeat_sync_and_time() {
    let mut world = running(STANDARD, 1);
    let (from, before) = (world.now(), world.indicators(TWO));
    world.run_for(ms(2_050));
    let after = world.indicators(TWO);
    let sent = [0x701, 0x080, 0x181].map(|id| since(&world, Bus::Nominal, id, from).len() as u32);
    let [heartbeats, syncs, times] = sent;
    assert!(heartbeats >= 20 && syncs >= 20 && times >= 1, "{sent:?}");
    assert_eq!(after.heartbeats - before.heartbeats, heartbeats);
    assert_eq!(after.syncs - before.syncs, syncs);
    assert_eq!(after.times - before.times, times);
    assert_eq!(after.states, [false; 0], "the command LED stays");
}

/// Given a slave that executed commands, when its master resets it, then it resets its chip once, and counts from zero.
///
/// Verifies: ECSS 6.5.1a.4
#[test]
fn a_reset_by_the_master_resets_the_chip() {
    let mut world = running(STANDARD, 1);
    log_lines::keep();
    send(&mut world, 0x302, &[2, 0, 7, 0, 0, 0, 0, 0]);
    assert_eq!((executed(&mut world), world.indicators(TWO).resets), ((1, 0), 0));
    world.nmt(NmtCommand::ResetNode, Target::Node(TWO));
    world.run_for(ms(1_000));
    assert_eq!(world.indicators(TWO).resets, 1);
    assert!(log_lines::take().contains(&"INFO reset by the master".to_owned()));
    assert_eq!(world.state(TWO), Some(NmtState::Operational));
    assert_eq!(executed(&mut world), (0, 0));
}

/// Given a slave in Pre-operational, then it executes no command and answers no request, and its master sends it none.
///
/// Verifies: ECSS 6.5.1a.3, 6.5.4a
#[test]
fn a_slave_in_pre_operational_obeys_no_command() {
    let mut world = running(STANDARD, 1);
    world.nmt(NmtCommand::EnterPreOperational, Target::Node(TWO));
    world.run_for(ms(200));
    send(&mut world, 0x302, &[1, 0, 1, 0, 0, 0, 0, 0]);
    assert!(ask(&mut world, &[0x02, 0x01]).is_empty());
    assert_eq!((world.indicators(TWO).states, world.reactions(TWO).len()), (vec![], 0));
    assert_eq!(world.command(TWO, Command::SetLed(true)), Err(Refusal::NotOperational));
}

/// Given a master that is cut off, then the slave logs its search, the bus on which it ends, and the state of its controller.
#[test]
fn a_slave_logs_its_search_and_its_errors() {
    let mut world = running(Profile { ntoggle: 4, ..STANDARD }, 1);
    log_lines::keep();
    world.power_off(MASTER);
    world.run_for(ms(5_000));
    let lines = log_lines::take();
    for expected in [
        "WARN master missed on Nominal",
        "INFO active bus: Redundant (Toggled)",
        "WARN search given up, listening on ",
        "INFO PreOperational",
        "WARN Nominal: error Passive, TEC 128, REC 0, last Ack",
    ] {
        assert!(lines.iter().any(|line| line.starts_with(expected)), "{expected}: {lines:#?}");
    }
}
