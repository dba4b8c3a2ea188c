//! The numbers of a flight, for machines, with its verdict.

use std::collections::BTreeMap;

use serde::Serialize;

use super::flight::Flight;
use super::message::Message;
use super::plan::PROFILE;
use super::record::{Bus, MASTER, Node};
use super::verdict::Verdict;

/// `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// `verdict`: `passed`, `failed` or `interrupted`; `reasons`: why it did not pass.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Number of boards: one master and its slaves.
    pub boards: usize,
    /// Model of the boards.
    pub board: &'static str,
    /// Mission profile of both images.
    pub profile: &'static str,
    /// Seed of crystals, places and power-on times.
    pub seed: u64,
    /// Length of the flight in virtual time, as asked for.
    pub planned_seconds: f64,
    /// Length of the flight in virtual time, as flown.
    pub virtual_seconds: f64,
    /// Length of the flight on this computer, without building images.
    pub wall_seconds: f64,
    /// Instructions of all emulated CPUs per microsecond of wall time.
    pub emulated_mips: f64,
    /// Second of the cut, `null` without one.
    pub cut_at_seconds: Option<f64>,
    /// Where the boards took the stamps of frames that matter from: `capture` when all of them were measured by hardware,
    /// `interrupt` when none was, else `mixed`; `unknown` when there was no such frame.
    pub stamp_source: &'static str,
    /// Largest distance between a measured stamp of SYNC and the true end of its frame, ns; `null` without one.
    pub stamp_worst_error_ns: Option<f64>,
    /// Frames that completed, per bus.
    pub frames: BTreeMap<&'static str, u64>,
    /// TC frames that completed on a wire.
    pub tc_sent: u64,
    /// TC frames that completed while the addressee was operational on that bus and in reach.
    pub tc_due: u64,
    /// TCs executed, by the slaves' own count.
    pub tc_executed: u64,
    /// TCs that arrived again and that slaves dropped: CAN delivers at least once.
    pub tc_repeats: u64,
    /// TM request frames that completed on a wire.
    pub tm_requested: u64,
    /// TM replies received, by the master's own count.
    pub tm_received: u64,
    /// Per slave, from the cut to the first TC due or TM on the other bus; `null` when that never came.
    pub failover_ms: BTreeMap<Node, Option<f64>>,
    /// Slaves that are operational on some bus at the end.
    pub slaves_operational_at_end: usize,
    /// Frames admitted by a filter and never handled by the node, all boards.
    pub lost_frames: u64,
    /// Transmissions given up by all boards, for example on leaving a bus.
    pub aborted_frames: u64,
    /// Events that an application was too slow to take, all boards.
    pub app_overflows: u64,
    /// Lock-ups of a CPU, all boards.
    pub lockups: u64,
    /// Panics of the firmware, all boards.
    pub panics: u64,
}

impl Summary {
    /// Of a finished flight.
    pub fn of(flight: &Flight) -> Summary {
        let wall_seconds = flight.wall.as_secs_f64();
        let instructions: u64 = flight.boards.iter().map(|board| board.instructions).sum();
        let messages = || flight.frames().filter_map(|(_, seen)| Message::decode(&seen.frame));
        let slave_counts = || flight.boards.iter().filter(|board| board.node != MASTER);
        let master_counts = || flight.boards.iter().filter(|board| board.node == MASTER);
        let count = |predicate: fn(&Message) -> bool| messages().filter(predicate).count() as u64;
        Summary {
            verdict: Verdict::of(flight),
            boards: flight.boards.len(),
            board: flight.plan.board.name(),
            profile: PROFILE.name(),
            seed: flight.plan.seed,
            planned_seconds: rounded(flight.plan.end.as_secs_f64(), 6),
            virtual_seconds: rounded(flight.end.as_secs_f64(), 6),
            wall_seconds: rounded(wall_seconds, 3),
            emulated_mips: rounded(instructions as f64 / 1e6 / wall_seconds, 2),
            cut_at_seconds: flight.cut().map(|(at, _)| at.as_secs_f64()),
            stamp_source: stamp_source(flight),
            stamp_worst_error_ns: (flight.stamp_errors.compared > 0)
                .then(|| rounded(flight.stamp_errors.worst_ns, 1)),
            frames: Bus::BOTH
                .map(|bus| (bus.name(), flight.frames().filter(|(_, seen)| seen.bus == bus).count() as u64))
                .into(),
            tc_sent: count(|message| matches!(message, Message::Telecommand { .. })),
            tc_due: flight.observer.slaves().map(|(_, track)| track.tc_due).sum(),
            tc_executed: slave_counts().map(|board| u64::from(board.telltale.commands)).sum(),
            tc_repeats: slave_counts().map(|board| u64::from(board.telltale.repeats)).sum(),
            tm_requested: count(|message| matches!(message, Message::TelemetryRequest { .. })),
            tm_received: master_counts().map(|board| u64::from(board.telltale.telemetry_replies)).sum(),
            failover_ms: flight
                .observer
                .slaves()
                .map(|(node, track)| (node, track.failover.map(|took| rounded(took.as_secs_f64() * 1e3, 3))))
                .collect(),
            slaves_operational_at_end: flight
                .observer
                .slaves()
                .filter(|(_, track)| track.operational_on().is_some())
                .count(),
            lost_frames: flight.boards.iter().map(|board| board.lost_frames).sum(),
            aborted_frames: flight.boards.iter().map(|board| board.aborted_frames).sum(),
            app_overflows: flight.boards.iter().map(|board| u64::from(board.telltale.app_overflows)).sum(),
            lockups: flight.boards.iter().map(|board| board.lockups).sum(),
            panics: flight.boards.iter().map(|board| board.panics).sum(),
        }
    }
}

fn stamp_source(flight: &Flight) -> &'static str {
    let stamps = || flight.boards.iter().map(|board| &board.telltale.stamps);
    let captured = stamps().any(|stamps| stamps.captured > 0);
    let missed = stamps().any(|stamps| stamps.missed.iter().any(|count| *count > 0));
    match (captured, missed) {
        (true, false) => "capture",
        (true, true) => "mixed",
        (false, true) => "interrupt",
        (false, false) => "unknown",
    }
}

fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (value * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;
    use crate::verdict::faults;

    #[test]
    fn a_good_flight_has_its_numbers_and_no_fault() {
        let flight = sample::flight();
        let summary = Summary::of(&flight);
        assert_eq!(summary.boards, 3);
        assert_eq!(summary.tc_sent, sample::COMMANDS_ON_THE_WIRE);
        assert_eq!(summary.tc_due, sample::COMMANDS_DUE);
        assert_eq!(summary.tc_executed, sample::COMMANDS_DUE);
        assert_eq!(summary.slaves_operational_at_end, 2);
        assert_eq!(summary.failover_ms[&2], Some(sample::PARALLEL_FAILOVER_MS));
        assert_eq!(summary.failover_ms[&4], Some(sample::SELECTIVE_FAILOVER_MS));
        assert_eq!(summary.stamp_source, "capture");
        assert_eq!(summary.stamp_worst_error_ns, Some(11.9));
        assert_eq!(summary.wall_seconds, 10.0);
        assert_eq!(summary.emulated_mips, 9.0, "3 boards with 30 million instructions each in 10 s");
        assert_eq!(faults(&flight), Vec::<String>::new());
    }

    #[test]
    fn the_source_of_stamps_is_that_of_all_boards() {
        let mut flight = sample::flight();
        flight.boards[2].telltale.stamps.missed[3] = 1;
        assert_eq!(Summary::of(&flight).stamp_source, "mixed");
        flight.boards.iter_mut().for_each(|board| board.telltale.stamps.captured = 0);
        assert_eq!(Summary::of(&flight).stamp_source, "interrupt");
        flight.boards[2].telltale.stamps.missed[3] = 0;
        assert_eq!(Summary::of(&flight).stamp_source, "unknown");
    }

    #[test]
    fn what_went_wrong_is_said() {
        let mut flight = sample::flight();
        flight.boards[0].lockups = 1;
        flight.boards[1].panics = 1;
        flight.boards[1].telltale.commands -= 1;
        flight.boards[2].lost_frames = 3;
        flight.boards[2].telltale.repeats = 4;
        let summary = Summary::of(&flight);
        assert_eq!(summary.tc_repeats, 4, "told, and no fault");
        assert_eq!((summary.lockups, summary.panics, summary.lost_frames), (1, 1, 3));
        let faults = faults(&flight);
        assert_eq!(faults.len(), 4, "{faults:?}");
        assert_eq!(faults[0], "master locked up");
        assert_eq!(faults[3], "node 4 lost 3 frames");
    }

    #[test]
    fn the_names_that_others_read_are_there() {
        let json = serde_json::to_value(Summary::of(&sample::flight())).unwrap();
        for key in [
            "verdict",
            "reasons",
            "boards",
            "planned_seconds",
            "virtual_seconds",
            "wall_seconds",
            "emulated_mips",
            "tc_sent",
            "tc_due",
            "tc_executed",
            "tc_repeats",
            "tm_requested",
            "tm_received",
            "failover_ms",
            "slaves_operational_at_end",
            "lost_frames",
            "aborted_frames",
            "lockups",
            "panics",
            "stamp_source",
            "stamp_worst_error_ns",
            "seed",
            "profile",
        ] {
            assert!(json.get(key).is_some(), "{key}");
        }
        assert_eq!(json["failover_ms"]["4"], sample::SELECTIVE_FAILOVER_MS);
        assert_eq!(json["verdict"], "passed");
    }
}
