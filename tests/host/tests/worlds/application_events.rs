//! Reactions of the applications to events that nodes of a world rarely report. A script replaces the node's events.

use std::collections::VecDeque;
use std::future::pending;

use ecss_can::boot::{BootCause, BootError, BootFailure, BootProgress, Difference};
use ecss_can::emcy::{Emergency, ErrorCode, ErrorRegister};
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::nmt::Command as NmtCommand;
use ecss_can::node::minimal::{MinimalEvent, MinimalSlave};
use ecss_can::node::{Device as _, MasterEvent, SlaveEvent};
use ecss_can::pdo::{ReceivedPdo, SetRpdo};
use ecss_can::redundancy::BabblingStep;
use ecss_can::runner::EventSource;
use ecss_can::time::Step;
use ecss_can::types::{Address, Bus, CobId, Instant, NmtState, Scet};
use ecss_can_worlds::{Builder, MockBoard, World};
use mission::application::{master, minimal, slave};
use mission::minimal::MinimalMission;
use mission::{CommanderObjects, MissionObjects, STANDARD};

use crate::indicators::{IndicatorLog, Shown};
use crate::log_lines;
use crate::support::*;

const ACTIVE: Health = Health { state: ErrorState::Active, tec: 8, rec: 1, last_error: LastError::Stuff };
const PASSIVE: Health = Health { state: ErrorState::Passive, tec: 136, rec: 1, last_error: LastError::Ack };
const DIFFERENCE: Difference = Difference { at: Address::new(0x1020, 1), expected: 0x1A2B, found: 7 };

/// Reports these events, each once, and then none.
struct Script<E>(VecDeque<E>);

impl<E: Copy> Script<E> {
    fn of(events: &[E]) -> Self {
        Script(events.iter().copied().collect())
    }
}

impl<E> EventSource for Script<E> {
    type Event = E;

    async fn next(&mut self) -> E {
        match self.0.pop_front() {
            Some(event) => event,
            None => pending().await,
        }
    }
}

/// Runs a node alone for a millisecond. Returns the log and the indicators of its application.
fn alone(node: impl FnOnce(Builder, IndicatorLog) -> Builder) -> (Vec<String>, IndicatorLog) {
    let indicators = IndicatorLog::default();
    log_lines::keep();
    let mut world = node(World::builder(), indicators.clone()).build();
    world.run_until(ms(1));
    (log_lines::take(), indicators)
}

/// Runs the application of slave 2 with these events, and returns its log and its indicators.
fn slave(events: &'static [SlaveEvent]) -> (Vec<String>, Shown) {
    let (lines, indicators) = alone(|world, indicators| {
        let node = |board: MockBoard| mission::slave(board.node_id, &STANDARD, vec![0; 64].leak()).build();
        world.slave(TWO, node, move |slave, own| {
            let indicators = indicators.of(TWO, own.reset_line());
            let application = slave::Application::new(slave, Script::of(events), indicators);
            async move { application.run().await }
        })
    });
    (lines, indicators.shown(TWO))
}

/// Runs the application of minimal slave 2 with these events, and returns its log.
fn minimal(events: &'static [MinimalEvent]) -> Vec<String> {
    let (lines, _) = alone(|world, indicators| {
        let node =
            |board: MockBoard| MinimalSlave::builder(board.node_id, &STANDARD, MinimalMission::new()).build();
        world.board(TWO, node, move |slave, own| {
            let indicators = indicators.of(TWO, own.reset_line());
            let application = minimal::Application::new(slave, Script::of(events), indicators);
            async move { application.run().await }
        })
    });
    lines
}

/// Runs the application of the master with these events, and returns its log.
fn master(events: &'static [MasterEvent]) -> Vec<String> {
    let (lines, _) = alone(|world, indicators| {
        let node = |_: MockBoard| mission::master(&STANDARD).build();
        world.master(node, move |master, own| {
            let (indicators, cables) = (indicators.of(MASTER, own.reset_line()), Box::leak(Box::default()));
            let application = master::Application::new(master, Script::of(events), indicators, cables, &[]);
            async move { application.run().await }
        })
    });
    lines
}

fn step() -> Step {
    Step { from: Scet::new(3, 0).expect("a time"), to: Scet::new(1_000, 0).expect("a time") }
}

/// Given each event of a slave about its environment, then the application logs one line: an error if action is needed,
/// a warning if a fault may follow.
#[test]
fn slave_logs_each_event_of_its_surroundings() {
    let (bus, id) = (Bus::Redundant, Address::new(0x6210, 0));
    let cases: &[(SlaveEvent, &str)] = &[
        (SlaveEvent::State(NmtState::Stopped), "INFO Stopped"),
        (SlaveEvent::BusStalled { bus }, "ERROR Redundant neither joined nor left, trying on"),
        (SlaveEvent::BusFailed { bus }, "ERROR Redundant failed: bus-off too often"),
        (
            SlaveEvent::Clash { bus, yields: true },
            "ERROR another node with this Node-ID on Redundant, yields: true",
        ),
        (SlaveEvent::ClashOver, "INFO the other node with this Node-ID is silent"),
        (
            SlaveEvent::ResetIgnored { bus, command: NmtCommand::ResetNode },
            "WARN ResetNode on Redundant ignored: the master is not heard",
        ),
        (SlaveEvent::BdefaultNoted { bus, is_kept: true }, "INFO Bdefault Redundant kept"),
        (SlaveEvent::BdefaultNoted { bus, is_kept: false }, "WARN Bdefault Redundant not kept"),
        (
            SlaveEvent::Health { bus, health: ACTIVE },
            "INFO Redundant: error Active, TEC 8, REC 1, last Stuff",
        ),
        (
            SlaveEvent::Health { bus, health: PASSIVE },
            "WARN Redundant: error Passive, TEC 136, REC 1, last Ack",
        ),
        (SlaveEvent::Step(step()), "INFO clock set: 1000 s, was 3 s"),
        (
            SlaveEvent::NotSent {
                bus,
                id: CobId::new(0x383).expect("a COB-ID"),
                data: [1, 2, 3, 4, 5, 6, 7, 0xA8],
            },
            "WARN 383h not sent on Redundant: [01, 02, 03, 04, 05, 06, 07, A8]",
        ),
        (SlaveEvent::Written(id), "INFO 6210h:0 written"),
    ];
    let events: Vec<SlaveEvent> = cases.iter().map(|(event, _)| *event).collect();
    let lines: Vec<&str> = cases.iter().map(|(_, line)| *line).collect();
    assert_eq!(slave(events.leak()).0, lines);
}

/// Given a PDO that is neither a command nor a request, with the data of a command, then the application does not execute it.
#[test]
fn slave_executes_commands_of_their_own_pdo_alone() {
    let led = [1, 0, 1, 0, 0, 0, 0, 0];
    let pdo = |number| {
        SlaveEvent::Pdo(ReceivedPdo::new(&<MissionObjects>::PDOS, number, Bus::Nominal, led, Instant::ZERO))
    };
    let others: Vec<SlaveEvent> = (0..8).filter(|number| ![1, 2].contains(number)).map(pdo).collect();
    assert_eq!(slave(others.leak()), (vec![], Shown::default()));
    let (lines, shown) = slave(vec![pdo(1)].leak());
    assert_eq!((lines.len(), shown.states), (0, vec![true]));
}

/// Given events of a minimal slave about its controllers, then the application logs one line each.
#[test]
fn minimal_slave_logs_the_errors_of_its_buses() {
    let bus = Bus::Redundant;
    let events = vec![
        MinimalEvent::BusStalled { bus },
        MinimalEvent::BusFailed { bus },
        MinimalEvent::Health { bus, health: PASSIVE },
    ];
    assert_eq!(
        minimal(events.leak()),
        [
            "ERROR Redundant neither joined nor left, trying on",
            "ERROR Redundant failed: bus-off too often",
            "INFO Redundant: error Passive, TEC 136, REC 1",
        ]
    );
}

/// Given each event of a master about its slaves and its buses, then the application logs one line.
#[test]
fn master_logs_each_event_of_its_surroundings() {
    let (bus, node) = (Bus::Redundant, THREE);
    let emergency =
        Emergency { code: ErrorCode::HARDWARE, register: ErrorRegister::GENERIC, info: [0x48, 0, 0, 0, 10] };
    let cases: &[(MasterEvent, &str)] = &[
        (MasterEvent::SlaveUnheard { node }, "WARN slave 3: never heard on either bus"),
        (MasterEvent::UnknownNode { node }, "WARN node 3 does not answer: it does not count as a slave"),
        (MasterEvent::SecondMaster { bus }, "ERROR another master sends 701h on Redundant: EMCY 8150h"),
        (MasterEvent::SecondMasterSilent { bus }, "INFO no more 701h of others on Redundant"),
        (
            MasterEvent::SyncUncaptured,
            "ERROR SYNCs are not captured, check the wires: EMCY 9000h, clocks to 10 us",
        ),
        (MasterEvent::Clash { node }, "ERROR two nodes have Node-ID 3: EMCY 8150h"),
        (MasterEvent::ClashOver { node }, "INFO one node has Node-ID 3 again"),
        (
            MasterEvent::OverBudget { id: CobId::new(0x302).expect("a COB-ID") },
            "ERROR sends too much: 302h refused",
        ),
        (
            MasterEvent::Babbling { node, step: BabblingStep::Stopped },
            "ERROR slave 3: sends too much, Stopped",
        ),
        (MasterEvent::SlaveReturned { node, bus }, "INFO slave 3: back on Redundant"),
        (
            MasterEvent::Emergency { node, bus, emergency },
            "WARN slave 3: EMCY 5000h, error register 01h, [48, 00, 00, 00, 0A]",
        ),
        (
            MasterEvent::ErrorsRead { node },
            "WARN slave 3: active errors are others than it reported, see 2048h",
        ),
        (MasterEvent::ErrorNotKept { node }, "ERROR slave 3: no room for its error in 2048h"),
        (
            MasterEvent::NotSent { bus, id: CobId::new(0x303).expect("a COB-ID"), data: [0; 8] },
            "WARN 303h not sent on Redundant: [00, 00, 00, 00, 00, 00, 00, 00]",
        ),
        (MasterEvent::Boot { node, progress: BootProgress::Checking }, "DEBUG slave 3: boot-up, Checking"),
        (MasterEvent::Boot { node, progress: BootProgress::Started }, "INFO slave 3: boot-up, Started"),
        (MasterEvent::Boot { node, progress: BootProgress::Booted }, "INFO slave 3: boot-up, Booted"),
        (
            MasterEvent::ConfigurationLost { node, difference: DIFFERENCE },
            "WARN slave 3: configuration lost, 1020h sub 1 is 00000007h, expected 00001A2Bh; configured again",
        ),
        (MasterEvent::BootCompleted, "INFO all mandatory slaves booted and synchronised"),
        (MasterEvent::Written(Address::new(0x1F82, 3)), "INFO object 1F82h sub 3 written"),
        (MasterEvent::Step(step()), "INFO clock set: 1000 s, was 3 s"),
        (MasterEvent::GaveUp { bus }, "WARN no slave heard in Ntoggle changes: staying on Redundant"),
        (MasterEvent::Refused { node }, "DEBUG slave 3: command not sent"),
        (
            MasterEvent::Health { bus, health: ACTIVE },
            "INFO Redundant: error Active, TEC 8, REC 1, last Stuff",
        ),
        (
            MasterEvent::Health { bus, health: PASSIVE },
            "WARN Redundant: error Passive, TEC 136, REC 1, last Ack",
        ),
        (MasterEvent::BusStalled { bus }, "ERROR Redundant neither joined nor left, trying on"),
        (MasterEvent::BusFailed { bus }, "ERROR Redundant failed: bus-off too often"),
    ];
    let events: Vec<MasterEvent> = cases.iter().map(|(event, _)| *event).collect();
    let lines: Vec<&str> = cases.iter().map(|(_, line)| *line).collect();
    assert_eq!(master(events.leak()), lines);
}

/// Given a boot-up that failed, then the line has the letter of CiA 302-2, and the object and the values of the cause.
#[test]
fn master_logs_why_a_boot_up_failed() {
    let at = Address::new(0x1800, 1);
    let id = CobId::new(0x183).expect("a COB-ID");
    let cases = [
        (BootError::Silent, BootCause::Silence, "'E' (Silent)"),
        (
            BootError::Configuration,
            BootCause::Difference(DIFFERENCE),
            "'J' (Configuration): 1020h sub 1 is 00000007h, expected 00001A2Bh",
        ),
        (
            BootError::Configuration,
            BootCause::CobIdInUse { at, id, other: FOUR },
            "'J' (Configuration): 1800h sub 1 is 183h, which node 4 sends",
        ),
        (BootError::Configuration, BootCause::TooManyCobIds, "'J' (Configuration): too many COB-IDs"),
        (
            BootError::NoResponse,
            BootCause::Transfer { at: Address::new(0x1000, 0), code: 0x0504_0000 },
            "'B' (NoResponse): 1000h sub 0, abort code 05040000h",
        ),
    ];
    let failed = |(error, cause, _): &(BootError, BootCause, &str)| MasterEvent::BootFailed {
        node: THREE,
        failure: BootFailure { error: *error, cause: *cause },
    };
    let events: Vec<MasterEvent> = cases.iter().map(failed).collect();
    let lines = cases.map(|(_, _, text)| format!("WARN slave 3: boot-up failed, error {text}"));
    assert_eq!(master(events.leak()), lines);
}

/// Given PDOs of slave 2 with a telemetry code that the mission does not have, with a time before the first SYNC, and of a number
/// that it does not use, then the application logs the first one alone.
#[test]
fn master_logs_unknown_telemetry() {
    let data = [0x34, 0x12, 0, 0, 0, 0, 0, 0];
    let pdo = |number| {
        MasterEvent::Pdo(ReceivedPdo::new(&CommanderObjects::PDOS, number, Bus::Nominal, data, Instant::ZERO))
    };
    assert_eq!(master(vec![pdo(14), pdo(0), pdo(28)].leak()), ["WARN slave 2: unknown telemetry 1234h"]);
}

/// Given events that come with every frame, then the master logs none of them.
#[test]
fn master_does_not_log_what_each_frame_brings() {
    let time = Scet::new(3, 0).expect("a time");
    let events =
        vec![MasterEvent::Time(time), MasterEvent::Synchronised(SetRpdo::new(&CommanderObjects::PDOS, 1))];
    assert_eq!(master(events.leak()), Vec::<String>::new());
}
