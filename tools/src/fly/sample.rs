//! A made-up flight of a master and two slaves, for the tests of summary and report; [`standby`] is one of two masters.
//!
//! 40 s, cut at 20 s, switch 600 ms later; slave 2 (parallel) follows at once, slave 4 (selective) 12.5 s later.

pub mod standby;

use std::time::Duration;

use can_twin::bxcan::Attempt;
use can_twin::crystal::Crystal;
use can_twin::pulses::{Errors, Sample};
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::time::Time;

use super::clocks::Clock;
use super::fault::Fault;
use super::flight::{AbortedFrame, BoardCount, Flight};
use super::line::Line;
use super::meaning::{Meaning, NmtState, Scope};
use super::narrator::Narrator;
use super::observer::Observer;
use super::origin::{ImageFile, Origin};
use super::phase::Phase;
use super::plan::{BoardPlan, Plan};
use super::record::{Bus, CutPlan, FlightEvent, Level, Node, Nodes, Occurrence, Seen};
use super::stamps::StampErrors;
use super::unjudged::Unjudged;
use crate::images::support::board::{Board, Profile};
use crate::images::support::counters::Counters;
use crate::images::support::diagnostics::{Diagnostics, Stamps};

const CUT_MS: u64 = 20_000;
const SWITCH_MS: u64 = 20_600;
const SELECTIVE_SWITCH_MS: u64 = 32_350;
const CUT: CutPlan = CutPlan { bus: Bus::Nominal, at: Time::from_ms(CUT_MS), position_m: 0.5 };

/// TC frames that complete: slave 2 has no gap but the isolation of the master, frames to slave 4 are sent
/// nevertheless.
pub const COMMANDS_ON_THE_WIRE: u64 = 2 * (195 + 194);

/// TC frames that slave 2 and slave 4 have to execute.
pub const COMMANDS_DUE: u64 = (195 + 194) + (195 + 76);

/// First TC on the redundant bus 20.605 s, cut 20 s.
pub const PARALLEL_FAILOVER_MS: f64 = 605.0;

/// First TC after the start at 32.36 s.
pub const SELECTIVE_FAILOVER_MS: f64 = 12_406.0;

/// Makes an event at this millisecond.
pub fn at(ms: u64, what: FlightEvent) -> Occurrence {
    Occurrence { at: Time::from_ms(ms), what }
}

/// A frame of the mission, from a board, with the boards that it reached.
pub fn frame(ms: u64, bus: Bus, from: Node, id: u16, data: &[u8], reached: &[Node]) -> Occurrence {
    let reached: Nodes = reached.iter().copied().collect();
    let frame = WireFrame::standard(id, data);
    at(ms, FlightEvent::Frame(Seen::new(bus, frame, Scope::Mission, from, reached)))
}

/// Makes a log line of a board.
pub fn log(ms: u64, node: Node, level: Level, text: &str) -> Occurrence {
    at(ms, FlightEvent::Log { node, level, text: text.into() })
}

/// Bus of the master at `ms`; `None` while no node acknowledges.
fn master_bus(ms: u64) -> Option<Bus> {
    match ms {
        ..CUT_MS => Some(Bus::Nominal),
        SWITCH_MS.. => Some(Bus::Redundant),
        _ => None,
    }
}

fn records() -> Vec<Occurrence> {
    let mut records = vec![
        at(20, FlightEvent::PowerOn(1)),
        at(110, FlightEvent::PowerOn(2)),
        at(230, FlightEvent::PowerOn(4)),
        log(25, 1, Level::Info, "master, nominal bus"),
        frame(112, Bus::Nominal, 2, 0x702, &[0], &[1]),
        frame(232, Bus::Nominal, 4, 0x704, &[0], &[1, 2]),
        frame(240, Bus::Nominal, 1, 0x000, &[1, 0], &[2, 4]),
        at(CUT_MS, FlightEvent::Cut(CUT)),
        log(SWITCH_MS - 1, 1, Level::Warn, "nominal bus isolated, switching"),
        frame(SELECTIVE_SWITCH_MS, Bus::Redundant, 4, 0x704, &[0x7F], &[1, 2]),
        frame(SELECTIVE_SWITCH_MS + 10, Bus::Redundant, 1, 0x000, &[1, 4], &[2, 4]),
    ];
    for ms in (50..40_000).step_by(250) {
        let Some(bus) = master_bus(ms) else { continue };
        let all: &[Node] = if bus == Bus::Nominal || ms > SELECTIVE_SWITCH_MS { &[2, 4] } else { &[2] };
        records.push(frame(ms, bus, 1, 0x701, &[0x05], all));
        if ms % 5000 == 50 {
            records.push(frame(ms, bus, 1, 0x080, &[], all));
        }
        if ms % 10_000 == 50 {
            records.push(frame(ms, bus, 1, 0x181, &[0, 0, 0, (ms / 1000) as u8, 0, 0, 0], all));
        }
    }
    records.push(frame(SWITCH_MS, Bus::Redundant, 1, 0x701, &[0x05], &[2]));
    for ms in (300..40_000).step_by(250) {
        let follows = if ms < SWITCH_MS { Bus::Nominal } else { Bus::Redundant };
        records.push(frame(ms, follows, 2, 0x702, &[0x05], &[1]));
        let (bus, state) = match ms {
            ..22_250 => (Bus::Nominal, 0x05),
            22_250..SELECTIVE_SWITCH_MS => (Bus::Nominal, 0x7F),
            _ => (Bus::Redundant, 0x05),
        };
        if !(SELECTIVE_SWITCH_MS..SELECTIVE_SWITCH_MS + 20).contains(&ms) {
            records.push(frame(ms + 3, bus, 4, 0x704, &[state], &[1, 2]));
        }
    }
    for ms in (505..40_000).step_by(100) {
        let Some(bus) = master_bus(ms) else { continue };
        for node in [2, 4] {
            let offset = u64::from(node == 4);
            let listens = node == 2 || bus == Bus::Nominal || ms > SELECTIVE_SWITCH_MS + 10;
            let reached: &[Node] = if listens { &[2, 4] } else { &[2] };
            let request = 0x400 + u16::from(node);
            records.push(frame(ms + offset, bus, 1, 0x300 + u16::from(node), &[1, 0, 7], reached));
            records.push(frame(ms + offset + 40, bus, 1, request, &[0x04, 0x01], reached));
            if listens {
                let reply = 0x380 + u16::from(node);
                records.push(frame(ms + offset + 41, bus, node, reply, &[0x04, 0x01, 1], &[1]));
            }
        }
    }
    records.sort_by_key(|record| record.at);
    records
}

/// Plan of the flight.
pub fn plan() -> Plan {
    let board = |node, crystal_ppm, position_m, power_on| BoardPlan {
        node,
        own_image: None,
        is_minimal: false,
        has_one_controller: false,
        crystal: Crystal::ppm(crystal_ppm),
        position_m,
        power_on: Time::from_ms(power_on),
    };
    Plan {
        board: Board::shipped(Board::DEFAULT),
        own_board: Board::shipped(Board::DEFAULT),
        profile: Profile::Librecube,
        seed: 1,
        boards: vec![board(1, 12.0, 0.0, 20), board(2, -31.5, 4.2, 110), board(4, 48.0, 17.0, 230)],
        end: Time::from_ms(40_000),
        faults: vec![Fault::cut(CUT)],
        criteria: Vec::new(),
    }
}

/// Origin of the flight.
pub fn origin() -> Origin {
    let file = |file: &str, digit: &str| ImageFile { file: file.into(), sha256: digit.repeat(64) };
    Origin {
        date: "2026-11-26T07:30:00Z".into(),
        commit: "0123456789abcdef0123456789abcdef01234567".into(),
        modified: Some(true),
        images: [(1, file("master", "a")), (2, file("slave", "b")), (4, file("slave", "b"))].into(),
    }
}

/// Summary of a flight without data sheets.
#[cfg(test)]
pub(in crate::fly) fn summary(flight: &Flight) -> crate::fly::summary::Summary {
    crate::fly::summary::Summary::of(flight, origin(), &crate::fly::pdos::Sheets::default())
}

/// Adds a record to a flight, in the order of time.
#[cfg(test)]
pub(in crate::fly) fn insert(flight: &mut Flight, record: Occurrence) {
    let place = flight.records.partition_point(|earlier| earlier.at < record.at);
    flight.records.insert(place, record);
}

/// Returns observer and story after the records of a flight.
fn watched(plan: &Plan, records: &[Occurrence]) -> (Observer, Vec<Line>) {
    let (mut observer, mut narrator) = (Observer::new(plan), Narrator::new(plan));
    let story = records.iter().flat_map(|record| narrator.narrate(record, &observer.on(record))).collect();
    observer.conclude(plan.end);
    (observer, story)
}

/// The flight.
pub fn flight() -> Flight {
    let plan = plan();
    let records = records();
    let (observer, story) = watched(&plan, &records);
    let answers = records.iter().filter(|record| {
        let FlightEvent::Frame(seen) = &record.what else { return false };
        matches!(seen.meaning, Some(Meaning::Telemetry { .. }))
    });
    let stamps = Stamps { captured: 1, ..Stamps::default() };
    let count = |node, commands, replies| BoardCount {
        node,
        instructions: 30_000_000,
        diagnostics: Diagnostics { stamps, ..Diagnostics::default() },
        counters: Some(Counters { commands, replies, ..Counters::default() }),
        ..BoardCount::default()
    };
    let aborted = [
        (20_100, 0x701, Some(Attempt::Failed)),
        (20_350, 0x701, Some(Attempt::Failed)),
        (20_400, 0x302, None),
    ];
    let aborted = aborted.map(|(ms, id, last)| AbortedFrame {
        at: Time::from_ms(ms),
        bus: Bus::Nominal,
        id: WireId::Standard(id),
        last,
    });
    let aborted = aborted.to_vec();
    let boards = vec![
        BoardCount { aborted, ..count(1, 780, answers.count() as u32) },
        count(2, 195 + 194, 0),
        count(4, 195 + 76, 0),
    ];
    let operational = Phase::Nmt(NmtState::Operational);
    assert!(observer.slaves().all(|(_, track)| track.now().phase == operational));
    let samples = [(11.0, 2500.0), (12.0, -120.0), (31.0, 30.0), (32.0, -40.0)];
    let errors =
        Errors { samples: samples.map(|(at, error_ns)| Sample { at, error_ns }).into(), unpaired: 0 };
    let clocks = vec![Clock { node: 2, set: Time::from_ms(10_050), errors }];
    let stamp_errors = StampErrors { compared: 24, worst_ns: 11.94, squares_ns2: 1140.0 };
    Flight {
        end: plan.end,
        interrupted: None,
        plan,
        wall: Duration::from_secs(10),
        records,
        story,
        observer,
        boards,
        refused: Vec::new(),
        stamp_errors,
        clocks,
        uncompared: [(4, Unjudged::NotReceived { since: Time::ZERO })].into(),
        busy: [Time::from_ms(900), Time::from_ms(600)],
    }
}
