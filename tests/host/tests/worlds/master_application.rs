//! The application of the master image, on mock boards.

use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;
use ecss_can::nmt::{Command as NmtCommand, Target};
use ecss_can::node::MasterRequest;
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::types::{Bus, NodeId};
use ecss_can_worlds::NodeKey;
use ecss_can_worlds::world::Sent;
use mission::application::master;
use mission::{STANDARD, TWO_MASTERS};

use crate::log_lines;
use crate::support::*;

const HEARD: NodeId = NodeId::of::<5>();
const SILENT: NodeId = NodeId::of::<6>();

/// Slave 2 and two minimal ones.
const SPACECRAFT: Profile = Profile {
    minimal: &[
        MinimalNode { node: HEARD, has_heartbeat: true },
        MinimalNode { node: SILENT, has_heartbeat: false },
    ],
    ..STANDARD
};

fn busy(slaves: u8, end: Time) -> MissionWorld {
    let mut world = MissionWorld::busy(STANDARD, slaves, |world| world);
    world.run_until(end);
    assert!(world.all_operational());
    world
}

fn payloads(frames: &[Sent]) -> Vec<&[u8]> {
    frames.iter().map(|sent| sent.frame.payload()).collect()
}

/// Sends an SDO request of 8 bytes to the master, and returns its answer.
fn sdo(world: &mut MissionWorld, request: [u8; 8]) -> [u8; 8] {
    let from = world.now();
    let bus = world.master_bus();
    world.inject(bus, standard(0x601, &request));
    world.run_for(ms(20));
    let answers = since(world, bus, 0x581, from);
    assert_eq!(answers.len(), 1, "{request:02X?}");
    answers[0].frame.payload().try_into().expect("8 bytes")
}

/// Writes one byte.
fn write(world: &mut MissionWorld, index: u16, sub: u8, value: u8) {
    let [low, high] = index.to_le_bytes();
    let answer = sdo(world, [0x2F, low, high, sub, value, 0, 0, 0]);
    assert_eq!(answer, [0x60, low, high, sub, 0, 0, 0, 0]);
}

/// Reads a number of at most four bytes.
fn read(world: &mut MissionWorld, index: u16, sub: u8) -> u32 {
    let [low, high] = index.to_le_bytes();
    let answer = sdo(world, [0x40, low, high, sub, 0, 0, 0, 0]);
    let unused = usize::from(answer[0] >> 2 & 3);
    let mut value = [0; 4];
    value[..4 - unused].copy_from_slice(&answer[4..8 - unused]);
    u32::from_le_bytes(value)
}

/// Given a slave that became operational, then the commands to it switch its LED on, set value 1, switch it off and set value 3, and
/// so on, each with the next sequence, one every 100 ms.
///
/// Verifies: ECSS 6.2a
#[test]
fn commands_alternate_between_led_and_value() {
    let world = busy(1, ms(2_000));
    let commands = since(&world, Bus::Nominal, 0x302, ms(0));
    let expected: [[u8; 8]; 6] = [
        [1, 0, 1, 0, 0, 0, 0, 0],
        [2, 0, 1, 0, 0, 0, 0, 1],
        [1, 0, 0, 0, 0, 0, 0, 2],
        [2, 0, 3, 0, 0, 0, 0, 3],
        [1, 0, 1, 0, 0, 0, 0, 4],
        [2, 0, 5, 0, 0, 0, 0, 5],
    ];
    assert_eq!(payloads(&commands[..6]), expected);
    assert!(periods_us(&commands).iter().all(|us| us.abs_diff(100_000) < 1_000), "{commands:?}");
    // A slave may take a command for a repeat of one before a reset of the master until 110 ms after it.
    assert!(commands[0].start >= ms(110) && commands[0].start < ms(400), "{} us", commands[0].start.as_us());
}

/// Given a master that runs, then it asks for the ten kinds of telemetry in turn, without data.
///
/// Verifies: ECSS 6.2a
#[test]
fn requests_are_sent_in_turn() {
    let world = busy(1, ms(3_000));
    let requests = since(&world, Bus::Nominal, 0x402, ms(0));
    let codes = [0x01, 0x02, 0x03, 0x04, 0x10, 0x11, 0x20, 0x21, 0x30, 0x31];
    let expected: Vec<[u8; 8]> =
        codes.iter().cycle().take(20).map(|code| [*code, 1, 0, 0, 0, 0, 0, 0]).collect();
    assert_eq!(payloads(&requests[..20]), expected);
    assert!(since(&world, Bus::Nominal, 0x382, ms(0)).len() + 1 >= requests.len(), "each is answered");
}

/// Given three slaves, then each has its own part of the period of 100 ms: a fourteenth of it lies between neighbours.
#[test]
fn turns_of_slaves_are_spread_over_the_period() {
    let world = busy(3, ms(2_000));
    let first = |id| since(&world, Bus::Nominal, id, ms(1_000))[0].start.as_us() % 100_000;
    // Frames of other nodes are sent first, for at most 1 ms.
    for (id, turn) in [(0x302, 0), (0x303, 7_143), (0x304, 14_286)] {
        assert!(first(id).abs_diff(turn) < 1_000, "{id:03X}h: {} us", first(id));
    }
}

/// Given a slave that loses its power, then the master stops commands and requests to it, and resumes them when it is
/// back. Its neighbour is not affected. The sequence continues.
#[test]
fn commands_stop_while_a_slave_is_lost() {
    let mut world = busy(3, ms(2_000));
    world.power_off(TWO);
    world.run_for(ms(500));
    let lost = world.now();
    world.run_for(ms(2_000));
    for id in [0x302, 0x402] {
        assert!(since(&world, Bus::Nominal, id, lost).is_empty(), "{id:03X}h");
    }
    let last = *since(&world, Bus::Nominal, 0x302, ms(0)).last().unwrap().frame.payload().last().unwrap();
    let on = world.now();
    world.power_on(TWO);
    world.run_for(ms(1_000));
    let again = since(&world, Bus::Nominal, 0x302, on);
    assert!(again.len() >= 4, "{}", again.len());
    assert_eq!(again[0].frame.payload()[7], last.wrapping_add(1));
    let neighbour = since(&world, Bus::Nominal, 0x303, ms(2_000));
    assert!(periods_us(&neighbour).iter().all(|us| us.abs_diff(100_000) < 1_500));
}

/// Given a slave that is sent to Pre-operational, then the master sends it no commands until it is Operational again.
#[test]
fn a_slave_in_pre_operational_is_left_out() {
    let mut world = busy(1, ms(2_000));
    world.nmt(NmtCommand::EnterPreOperational, Target::Node(TWO));
    world.run_for(ms(200));
    let held = world.now();
    world.run_for(ms(1_000));
    assert!([0x302, 0x402].iter().all(|id| since(&world, Bus::Nominal, *id, held).is_empty()));
    let start = world.now();
    world.nmt(NmtCommand::Start, Target::Node(TWO));
    world.run_for(ms(1_000));
    assert!(since(&world, Bus::Nominal, 0x302, start).len() >= 8);
}

/// Given minimal slaves that never get power, then the master commands the one without heartbeat, of which it hears nothing, and
/// not the one with heartbeat.
#[test]
fn a_silent_minimal_slave_is_commanded_unheard() {
    let plan = |world: ecss_can_worlds::Builder| {
        world.powered_at(HEARD, Time::NEVER).powered_at(SILENT, Time::NEVER)
    };
    let mut world = MissionWorld::mixed(SPACECRAFT, 1, plan);
    world.run_until(ms(2_050));
    let commands = since(&world, Bus::Nominal, 0x306, ms(0)).len();
    assert!((18..=20).contains(&commands), "{commands}");
    assert!(since(&world, Bus::Nominal, 0x305, ms(0)).is_empty());
}

/// Given a client that names a slave in 6320h, then the master measures its cable. The result has the bus, and the
/// delay that the protocol measured. A slave that is not there fails with the abort code of a timeout.
#[test]
fn a_cable_is_measured_by_command() {
    let mut world = busy(2, ms(15_000));
    log_lines::keep();
    assert_eq!(read(&mut world, 0x6320, 2), 0, "never run");
    write(&mut world, 0x6320, 1, 3);
    assert_eq!(read(&mut world, 0x6320, 2), 1, "it runs");
    world.run_for(ms(2_500));
    let result = [2, 3, 4].map(|sub| read(&mut world, 0x6320, sub));
    assert_eq!(result, [2, 0, 0], "measured, no abort, nominal");
    let delay = read(&mut world, 0x6320, 5) as i32;
    // Frames of a world end at all nodes at the same time, and spacecraft times have microseconds.
    assert!(delay != 0 && delay.abs() < 2_000, "{delay} ns");
    let lines = log_lines::take();
    let logged = format!("INFO cable to slave 3: Ok(Cable {{ bus: Nominal, delay_ns: {delay} }})");
    assert!(lines.contains(&logged), "{logged}: {lines:#?}");
    write(&mut world, 0x6320, 1, 9);
    world.run_for(ms(1_000));
    assert_eq!([2, 3].map(|sub| read(&mut world, 0x6320, sub)), [3, 0x0504_0000], "SDO protocol timed out");
}

/// Given a measurement that runs and will fail, when a client names another slave, then the failure is never shown:
/// 6320h shows a running measurement, and then the result of the other slave.
#[test]
fn a_cable_named_later_is_the_one_that_counts() {
    let mut world = busy(2, ms(15_000));
    write(&mut world, 0x6320, 1, 9);
    write(&mut world, 0x6320, 1, 3);
    let reads = (0..300).map(|_| read(&mut world, 0x6320, 2)).skip_while(|progress| *progress == 1);
    assert_eq!(reads.take(1).collect::<Vec<_>>(), [2]);
    assert_eq!([1, 2, 3].map(|sub| read(&mut world, 0x6320, sub)), [3, 2, 0], "slave 3, measured");
}

/// Given a client that names no slave, 0 or the master itself, then no measurement starts.
#[test]
fn a_cable_to_no_slave_is_not_measured() {
    let mut world = busy(1, ms(2_000));
    for node in [0, 1] {
        write(&mut world, 0x6320, 1, node);
        world.run_for(ms(500));
        assert_eq!(read(&mut world, 0x6320, 2), 0, "node {node}");
    }
}

/// Given a client that starts the self-test of the master, then it passes while both controllers are error active. With a bus that a
/// driver holds dominant it fails: bit 0 is the nominal bus, bit 1 the redundant one.
///
/// Verifies: ECSS 6.7b, 6.7c
#[test]
fn master_self_test_fails_with_an_error_passive_controller() {
    for (stuck, failures) in [(Bus::Nominal, 0b01), (Bus::Redundant, 0b10)] {
        let mut world = busy(1, ms(2_000));
        world.request(MasterRequest::SwitchBus(stuck.other()));
        world.run_for(ms(1_000));
        write(&mut world, 0x2030, 0, 1);
        assert_eq!([1, 2].map(|sub| read(&mut world, 0x2031, sub)), [2, 0], "passed");
        let two = world.index(TWO);
        world.strike(stuck, Fault::StuckDominant(two));
        world.run_for(ms(100));
        write(&mut world, 0x2030, 0, 1);
        assert_eq!([1, 2].map(|sub| read(&mut world, 0x2031, sub)), [3, failures], "{stuck:?}");
    }
}

/// Given a master that switches to the redundant bus and back, then its LED is on and off, and it logs both.
#[test]
fn led_of_the_master_shows_the_redundant_bus() {
    let mut world = busy(1, ms(1_000));
    log_lines::keep();
    for bus in [Bus::Redundant, Bus::Nominal] {
        world.request(MasterRequest::SwitchBus(bus));
        world.run_for(ms(1_000));
        assert_eq!(world.master_bus(), bus);
    }
    assert_eq!(world.indicators(MASTER).states, [true, false]);
    let lines = log_lines::take();
    let switched: Vec<&String> = lines.iter().filter(|line| line.starts_with("WARN active bus: ")).collect();
    assert_eq!(switched.len(), 2, "{lines:#?}");
    assert!(switched[0].starts_with("WARN active bus: Redundant, no longer Nominal ("), "{switched:?}");
}

/// Given a running master, then its LED toggles once with each SYNC.
#[test]
fn led_of_the_master_toggles_with_each_sync() {
    let world = busy(1, ms(3_050));
    let syncs = since(&world, Bus::Nominal, 0x080, ms(0)).len() as u32;
    assert!(syncs >= 25);
    assert_eq!(world.indicators(MASTER).syncs, syncs);
}

/// Given a client that commands the master to reset itself, then the master resets its chip, boots up again and commands its slaves
/// with sequences from zero.
///
/// Verifies: ECSS 6.5.1a.4
#[test]
fn a_master_that_is_reset_numbers_commands_from_zero() {
    let mut world = busy(1, ms(2_000));
    let reset = world.now();
    world.nmt(NmtCommand::ResetNode, Target::Node(MASTER));
    world.run_for(ms(2_000));
    assert_eq!(world.indicators(MASTER).resets, 1);
    assert!(world.all_operational());
    let commands = since(&world, Bus::Nominal, 0x302, reset + ms(1));
    assert_eq!(commands[0].frame.payload(), [1, 0, 1, 0, 0, 0, 0, 0]);
    assert!(commands[0].start >= reset + ms(110));
}

/// Given two master boards, of which the standby has sent no command, when the active one loses its power, then the
/// standby takes over, commands all slaves with sequences from zero, and logs its role.
///
/// Verifies: ECSS 8.1a
#[test]
fn a_standby_commands_only_when_it_took_over() {
    let mut world = MissionWorld::pair(TWO_MASTERS, 2, |world| world);
    world.run_until(ms(3_000));
    let of_second = |world: &MissionWorld, id, from| -> Vec<Sent> {
        let sent = since(world, Bus::Nominal, id, from).into_iter();
        sent.filter(|sent| sent.key == Some(NodeKey::SECOND_MASTER)).collect()
    };
    assert!(of_second(&world, 0x302, ms(0)).is_empty());
    log_lines::keep();
    let off = world.now();
    world.power_off(NodeKey::MASTER);
    world.run_for(ms(2_000));
    assert_eq!(world.active_masters(), [NodeKey::SECOND_MASTER]);
    let taken = of_second(&world, 0x701, off)[0].start;
    for id in [0x302, 0x303] {
        let commands = of_second(&world, id, off);
        assert!(commands.len() >= 10, "{id:03X}h: {}", commands.len());
        assert_eq!(commands[0].frame.payload()[7], 0);
        assert!(commands[0].start >= taken + ms(105), "{id:03X}h");
    }
    let lines = log_lines::take();
    assert!(
        lines.iter().any(|line| line.starts_with("WARN this master board: Active on Nominal (")),
        "{lines:#?}"
    );
}

/// Given an active board, when it is requested to hand over, then it sends no further command, and the other board
/// sends them.
///
/// Verifies: ECSS 8.1a
#[test]
fn a_board_that_stands_by_stops_its_commands() {
    let mut world = MissionWorld::pair(TWO_MASTERS, 3, |world| world.seed(7));
    world.run_until(ms(3_000));
    world.request(MasterRequest::StandBy);
    world.run_for(ms(2_000));
    assert_eq!(world.active_masters(), [NodeKey::SECOND_MASTER]);
    log_lines::keep();
    let from = world.now();
    world.run_for(ms(1_000));
    let commands = since(&world, Bus::Nominal, 0x302, from);
    assert!((9..=11).contains(&commands.len()));
    assert!(commands.iter().all(|sent| sent.key == Some(NodeKey::SECOND_MASTER)));
    let lines = log_lines::take();
    assert!(!lines.iter().any(|line| line.contains("not sent")), "it does not even try: {lines:#?}");
}

/// Given two master boards and a minimal slave without heartbeat, which gets commands without being heard, when the
/// active board becomes the standby, then it stops commands to that slave, and the other board starts them.
///
/// Verifies: ECSS 8.1a
#[test]
fn a_board_that_stands_by_leaves_a_silent_minimal_slave() {
    let minimal = &[MinimalNode { node: SILENT, has_heartbeat: false }];
    let mut world = MissionWorld::pair(Profile { minimal, ..TWO_MASTERS }, 1, |world| world.seed(7));
    world.run_until(ms(3_000));
    let before = since(&world, Bus::Nominal, 0x306, ms(2_000));
    assert!(before.len() >= 9 && before.iter().all(|sent| sent.key == Some(NodeKey::MASTER)));
    world.request(MasterRequest::StandBy);
    world.run_for(ms(2_000));
    assert_eq!(world.active_masters(), [NodeKey::SECOND_MASTER]);
    log_lines::keep();
    let from = world.now();
    world.run_for(ms(1_000));
    let after = since(&world, Bus::Nominal, 0x306, from);
    assert!(after.len() >= 9 && after.iter().all(|sent| sent.key == Some(NodeKey::SECOND_MASTER)));
    let lines = log_lines::take();
    assert!(!lines.iter().any(|line| line.contains("not sent")), "it does not even try: {lines:#?}");
}

/// Given a client that writes the pulses per second (6310h), then the pulse output of the master has as many.
#[test]
fn pulses_per_second_of_the_master_follow_the_object() {
    let mut world = busy(1, ms(1_000));
    let task = world.on_master(|master| async move { master::pulses_per_second(master) });
    world.run_for(ms(1));
    let (_, pulses) = task.take().expect("it ended");
    assert_eq!(pulses(), 1, "default");
    assert_eq!(sdo(&mut world, [0x2B, 0x10, 0x63, 0, 0xF4, 0x01, 0, 0])[0], 0x60);
    assert_eq!(pulses(), 500);
}

/// Given a master that a client sent to Pre-operational, then it logs the commands and requests that its node refuses,
/// and continues when it is Operational again.
///
/// Verifies: ECSS 6.5.4a
#[test]
fn commands_that_are_refused_are_logged() {
    let mut world = busy(1, ms(2_000));
    log_lines::keep();
    world.nmt(NmtCommand::EnterPreOperational, Target::Node(MASTER));
    world.run_for(ms(10));
    let held = world.now();
    world.run_for(ms(1_000));
    assert!([0x302, 0x402].iter().all(|id| since(&world, Bus::Nominal, *id, held).is_empty()));
    let lines = log_lines::take();
    let refused = lines.iter().filter(|line| line.starts_with("DEBUG slave 2: not sent, ")).count();
    assert!((18..=21).contains(&refused), "{refused}: {lines:#?}");
    let start = world.now();
    world.nmt(NmtCommand::Start, Target::Node(MASTER));
    world.run_for(ms(1_000));
    assert!([0x302, 0x402].iter().all(|id| since(&world, Bus::Nominal, *id, start).len() >= 9));
    let lines = log_lines::take();
    for expected in ["INFO Operational", "DEBUG slave 2: Value", "DEBUG slave 2: clock off by "] {
        assert!(lines.iter().any(|line| line.starts_with(expected)), "{expected}: {lines:#?}");
    }
}
