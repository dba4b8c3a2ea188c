//! A made-up flight of two masters and two slaves, for the tests of summary and report.
//!
//! 40 s. The standby is reset at 5 s. The nominal bus is cut between the slaves at 10 s, and the active master moves to the redundant
//! one 1.2 s later. It loses its power at 20 s; the other master takes over 399 ms after its last heartbeat.

use can_twin::wire::time::Time;

use super::{at, frame};
use crate::fly::fault::{Cause, Fault};
use crate::fly::flight::{BoardCount, Flight};
use crate::fly::plan::{BoardPlan, Plan};
use crate::fly::record::{Bus, CutPlan, FlightEvent, MASTER, Node, Occurrence, SECOND_MASTER};
use crate::images::support::board::Profile;
use crate::images::support::counters::Counters;

const RESET_MS: u64 = 5_000;
const CUT_MS: u64 = 10_000;
const SWITCH_MS: u64 = 11_200;
const LOSS_MS: u64 = 20_000;
const TAKEOVER_MS: u64 = 20_300;

/// Consumer time of the slaves, after the last heartbeat of the master that reached them.
const CONSUMER_MS: u64 = 250;
const PERIOD_MS: u64 = 100;

const CUT: CutPlan = CutPlan { bus: Bus::Nominal, at: Time::from_ms(CUT_MS), position_m: 10.6 };

fn plan() -> Plan {
    let mut plan = Plan {
        profile: Profile::Standby,
        faults: vec![
            Fault::new(Time::from_ms(RESET_MS), Cause::ResetStandby),
            Fault::cut(CUT),
            Fault::new(Time::from_ms(LOSS_MS), Cause::LoseActive),
        ],
        ..super::plan()
    };
    plan.boards.push(BoardPlan { node: SECOND_MASTER, position_m: 31.0, ..plan.boards[0].clone() });
    plan
}

/// The active master at `ms`, its bus, and the slaves that hear it.
fn active(ms: u64) -> Option<(Node, Bus, &'static [Node])> {
    match ms {
        900..CUT_MS => Some((MASTER, Bus::Nominal, &[2, 4])),
        CUT_MS..SWITCH_MS => Some((MASTER, Bus::Nominal, &[2])),
        SWITCH_MS..LOSS_MS => Some((MASTER, Bus::Redundant, &[2, 4])),
        TAKEOVER_MS.. => Some((SECOND_MASTER, Bus::Redundant, &[2, 4])),
        _ => None,
    }
}

/// Bus of a slave at `ms`, and the state in its heartbeat.
fn slave(node: Node, ms: u64) -> (Bus, u8) {
    let bus = if ms < SWITCH_MS { Bus::Nominal } else { Bus::Redundant };
    let misses = |from: u64, until| (from - PERIOD_MS + CONSUMER_MS..until).contains(&ms);
    let is_waiting = misses(LOSS_MS, TAKEOVER_MS) || node == 4 && misses(CUT_MS, SWITCH_MS);
    (bus, if is_waiting { 0x7F } else { 0x05 })
}

fn records() -> Vec<Occurrence> {
    let mut records: Vec<Occurrence> =
        [1, 2, 4, SECOND_MASTER].map(|node| at(20, FlightEvent::PowerOn(node))).into();
    records.extend([
        at(RESET_MS, FlightEvent::Reset(SECOND_MASTER)),
        at(CUT_MS, FlightEvent::Cut(CUT)),
        at(LOSS_MS, FlightEvent::PowerOff(MASTER)),
        frame(100, Bus::Nominal, 2, 0x702, &[0], &[]),
        frame(110, Bus::Nominal, 4, 0x704, &[0], &[]),
        frame(890, Bus::Nominal, MASTER, 0x701, &[0], &[2, 4]),
        frame(TAKEOVER_MS, Bus::Redundant, SECOND_MASTER, 0x701, &[0], &[2, 4]),
    ]);
    for ms in [901, SWITCH_MS + 2, TAKEOVER_MS + 2] {
        let (master, bus, reached) = active(ms).expect("a master is active");
        records.push(frame(ms, bus, master, 0x000, &[1, 0], reached));
    }
    for ms in (900..40_000).step_by(PERIOD_MS as usize) {
        if let Some((master, bus, reached)) = active(ms) {
            records.push(frame(ms + 1, bus, master, 0x701, &[5], reached));
            let strap = u8::from(master == SECOND_MASTER);
            for bus in Bus::ALL {
                records.push(frame(ms + 1, bus, master, 0x680 + u16::from(strap), &[2, strap], &[]));
            }
            for node in [2, 4_u8] {
                records.push(frame(ms + 5, bus, master, 0x300 + u16::from(node), &[1, 0, 7], reached));
            }
        }
        for node in [2, 4_u8] {
            let (bus, state) = slave(node, ms + 50);
            records.push(frame(ms + 50, bus, node, 0x700 + u16::from(node), &[state], &[]));
        }
    }
    records.sort_by_key(|record| record.at);
    records
}

/// The flight.
pub fn flight() -> Flight {
    let plan = plan();
    let records = records();
    let (observer, story) = super::watched(&plan, &records);
    let boards = plan.boards.iter().map(|board| {
        let commands = observer.nodes[&board.node].tc_due as u32;
        let counters = Some(Counters { commands, ..Counters::default() });
        BoardCount { node: board.node, instructions: 30_000_000, counters, ..BoardCount::default() }
    });
    Flight { boards: boards.collect(), plan, records, story, observer, ..super::flight() }
}
