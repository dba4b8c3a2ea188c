//! The numbers of a flight in machine-readable form, with its verdict.

use std::collections::BTreeMap;

use can_twin::pulses::Errors;
use can_twin::wire::time::Time;
use serde::Serialize;

use super::aborted::{self, AbortedFrames};
use super::checks::{Check, checks};
use super::emergencies::{self, EqualEmergencies};
use super::flight::Flight;
use super::meaning::{Meaning, Scope};
use super::origin::Origin;
use super::pdos::{PdoValues, SheetName, Sheets};
use super::plan::{BoardPlan, BusAccess};
use super::record::{Bus, Node, is_master};
use super::track::Track;
use super::unjudged::Unjudged;
use super::verdict::Verdict;

/// `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// `verdict`: `passed`, `failed` or `interrupted`; `reasons`: why it did not pass.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// The checks of the verdict: `name`, `limit`, `measured`, and `result`: `held`, `failed` or `not judged`.
    pub checks: Vec<Check>,
    /// Date, commit and images.
    #[serde(flatten)]
    pub origin: Origin,
    /// Number of boards: masters and their slaves.
    pub boards: usize,
    /// Number of master boards.
    pub masters: usize,
    /// Number of slaves of the minimal set.
    pub minimal: usize,
    /// Number of those with one controller and two transceivers.
    pub one_controller: usize,
    /// Model of the boards.
    pub board: String,
    /// Mission profile of the shipped images.
    pub profile: &'static str,
    /// File names of the images of the user's, by node; empty when all are the shipped ones.
    pub own_images: BTreeMap<Node, String>,
    /// Seed of crystals, places and power-on times.
    pub seed: u64,
    /// Planned length of the flight in virtual time.
    pub planned_seconds: f64,
    /// Actual length of the flight in virtual time.
    pub virtual_seconds: f64,
    /// Length of the flight on this computer, without building images.
    pub wall_seconds: f64,
    /// Instructions of all emulated CPUs per microsecond of wall time.
    pub emulated_mips: f64,
    /// Second at which the standby of two masters was reset, `null` without that.
    pub standby_reset_at_seconds: Option<f64>,
    /// Second of the cut, `null` without one.
    pub cut_at_seconds: Option<f64>,
    /// Second at which the active one of two masters lost its power, `null` without that.
    pub master_lost_at_seconds: Option<f64>,
    /// Time from its last heartbeat to the first message of the board that took over. `null` without a takeover.
    pub takeover_ms: Option<f64>,
    /// Source of the stamps of the relevant frames: `capture` if all were measured by hardware, `interrupt` if none
    /// was, otherwise `mixed`; `unknown` if there was no such frame.
    pub stamp_source: &'static str,
    /// Largest distance between a measured stamp of SYNC and the true end of its frame, ns; `null` without one.
    pub stamp_worst_error_ns: Option<f64>,
    /// Clock of each slave against the master's, ns: root mean square from 20 s after the first spacecraft time that it received;
    /// `null` when the flight was too short.
    pub clock_rms_error_ns: BTreeMap<Node, Option<f64>>,
    /// Likewise, the largest error.
    pub clock_worst_error_ns: BTreeMap<Node, Option<f64>>,
    /// Slaves whose clock is not judged, with the cause.
    pub clock_not_judged: BTreeMap<Node, String>,
    /// Frames that completed, per bus.
    pub frames: BTreeMap<&'static str, u64>,
    /// Load of each bus over the whole flight, percent.
    pub bus_load_percent: BTreeMap<&'static str, f64>,
    /// Number of emergency messages that completed.
    pub emergencies: u64,
    /// The emergency messages, equal ones of a node as one entry, in the order of their first appearance.
    pub equal_emergencies: Vec<EqualEmergencies>,
    /// Data sheet of each board that has one, by node.
    pub data_sheets: BTreeMap<Node, SheetName>,
    /// Last values of each PDO of the boards with a data sheet: the shipped images, and those with `--eds`.
    pub pdo_values: Vec<PdoValues>,
    /// Receive PDOs that do not match their transmit PDOs, by the data sheets.
    pub pdo_mismatches: Vec<String>,
    /// Number of changes of bus of the first master.
    pub bus_changes: usize,
    /// Heartbeats of each node that completed; 127 is the second master.
    pub heartbeats: BTreeMap<Node, u64>,
    /// Longest time without a heartbeat of a node, up to the end of the flight while it has power; `null` without any.
    pub heartbeat_longest_gap_ms: BTreeMap<Node, Option<f64>>,
    /// Access of each slave to the buses: `parallel` or `selective`. For an image of the user's it is found by its first heartbeat
    /// after a change of bus of the master; `null` without that.
    pub access: BTreeMap<Node, Option<&'static str>>,
    /// Commands and telemetry; only of flights with shipped images alone.
    #[serde(flatten)]
    pub mission: Option<MissionCounts>,
    /// Per slave, from the cut to the first TC due or TM on the other bus; with an image of the user's in the flight,
    /// to the first heartbeat as operational there. `null` if that did not occur, or not before the loss of the active
    /// master.
    pub failover_ms: BTreeMap<Node, Option<f64>>,
    /// Likewise, from the loss of the active master to the first TC due or TM, or heartbeat as operational, after the takeover.
    pub takeover_failover_ms: BTreeMap<Node, Option<f64>>,
    /// Slaves that are operational on some bus at the end.
    pub slaves_operational_at_end: usize,
    /// Frames admitted by a filter and never handled by the node, all boards.
    pub lost_frames: u64,
    /// Transmissions aborted by all boards, for example on leaving a bus.
    pub aborted_frames: u64,
    /// These transmissions by board, bus and COB-ID.
    pub aborted: Vec<AbortedFrames>,
    /// Events that an application was too slow to take, all boards.
    pub app_overflows: u64,
    /// Resets by the firmware or the watchdog, commanded ones included, all boards.
    pub resets: u64,
    /// Lock-ups of a CPU, all boards.
    pub lockups: u64,
    /// Panics of the firmware, all boards.
    pub panics: u64,
}

/// Commands and telemetry of the shipped mission.
#[derive(Clone, Debug, Serialize)]
pub struct MissionCounts {
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
}

impl Summary {
    /// Makes the summary of a finished flight.
    pub fn of(flight: &Flight, origin: Origin, sheets: &Sheets) -> Summary {
        let wall_seconds = flight.wall.as_secs_f64();
        let instructions: u64 = flight.boards.iter().map(|board| board.instructions).sum();
        let heartbeats = || flight.boards.iter().map(|board| (board.node, flight.heartbeats(board.node)));
        let own = |board: &BoardPlan| Some((board.node, board.own_image.clone()?));
        let operational = flight.observer.slaves().filter(|(_, track)| track.operational_on().is_some());
        Summary {
            verdict: Verdict::of(flight),
            checks: checks(flight),
            origin,
            boards: flight.boards.len(),
            masters: flight.masters(),
            minimal: flight.plan.boards.iter().filter(|board| board.is_minimal).count(),
            one_controller: flight.plan.boards.iter().filter(|board| board.has_one_controller).count(),
            board: flight.plan.flown().name().to_owned(),
            profile: flight.plan.profile.name(),
            own_images: flight.plan.boards.iter().filter_map(own).collect(),
            seed: flight.plan.seed,
            planned_seconds: rounded(flight.plan.end.as_secs_f64(), 6),
            virtual_seconds: rounded(flight.end.as_secs_f64(), 6),
            wall_seconds: rounded(wall_seconds, 3),
            emulated_mips: rounded(instructions as f64 / 1e6 / wall_seconds, 2),
            standby_reset_at_seconds: flight.standby_reset().map(|(at, _)| at.as_secs_f64()),
            cut_at_seconds: flight.cut().map(|(at, _)| at.as_secs_f64()),
            master_lost_at_seconds: flight.loss().map(|(at, _)| at.as_secs_f64()),
            takeover_ms: flight.takeover().map(|takeover| milliseconds(takeover.took())),
            stamp_source: stamp_source(flight),
            stamp_worst_error_ns: (flight.stamp_errors.compared > 0)
                .then(|| rounded(flight.stamp_errors.worst_ns, 1)),
            clock_rms_error_ns: clock_errors(flight, Errors::rms_ns),
            clock_worst_error_ns: clock_errors(flight, Errors::worst_ns),
            clock_not_judged: clock_not_judged(flight, sheets),
            frames: Bus::ALL
                .map(|bus| (bus.name(), flight.frames().filter(|(_, seen)| seen.bus == bus).count() as u64))
                .into(),
            bus_load_percent: Bus::ALL.map(|bus| (bus.name(), rounded(flight.load(bus) * 100.0, 2))).into(),
            emergencies: flight.emergencies().count() as u64,
            equal_emergencies: emergencies::folded(flight),
            data_sheets: sheets.names(),
            pdo_values: sheets.values(flight),
            pdo_mismatches: sheets.mismatches(&flight.plan),
            bus_changes: flight.bus_changes(),
            heartbeats: heartbeats().map(|(node, heartbeats)| (node, heartbeats.count)).collect(),
            heartbeat_longest_gap_ms: heartbeats()
                .map(|(node, heartbeats)| (node, heartbeats.longest_gap.map(milliseconds)))
                .collect(),
            access: flight.observer.slaves().map(|(node, track)| (node, access(track))).collect(),
            mission: (flight.plan.scope() == Scope::Mission).then(|| MissionCounts::of(flight)),
            failover_ms: per_slave(flight, |track| track.failover),
            takeover_failover_ms: per_slave(flight, |track| track.takeover),
            slaves_operational_at_end: operational.count(),
            lost_frames: flight.boards.iter().map(|board| board.lost_frames).sum(),
            aborted_frames: flight.boards.iter().map(|board| board.aborted.len() as u64).sum(),
            aborted: aborted::by_cob_id(flight),
            app_overflows: flight.boards.iter().map(|board| u64::from(board.diagnostics.app_overflows)).sum(),
            resets: flight.boards.iter().map(|board| board.resets).sum(),
            lockups: flight.boards.iter().map(|board| board.lockups).sum(),
            panics: flight.boards.iter().map(|board| board.panics).sum(),
        }
    }
}

impl MissionCounts {
    fn of(flight: &Flight) -> MissionCounts {
        let messages = || flight.frames().filter_map(|(_, seen)| seen.meaning);
        let counts = |of_master| {
            let boards = flight.boards.iter().filter(move |board| is_master(board.node) == of_master);
            boards.filter_map(|board| board.counters.as_ref())
        };
        let count = |predicate: fn(&Meaning) -> bool| messages().filter(predicate).count() as u64;
        MissionCounts {
            tc_sent: count(|message| matches!(message, Meaning::Telecommand { .. })),
            tc_due: flight.observer.slaves().map(|(_, track)| track.tc_due).sum(),
            tc_executed: counts(false).map(|counters| u64::from(counters.commands)).sum(),
            tc_repeats: counts(false).map(|counters| u64::from(counters.repeats)).sum(),
            tm_requested: count(|message| matches!(message, Meaning::TelemetryRequest { .. })),
            tm_received: counts(true).map(|counters| u64::from(counters.replies)).sum(),
        }
    }
}

/// Returns a figure of each slave's settled clock.
fn clock_errors(flight: &Flight, figure: fn(&Errors) -> f64) -> BTreeMap<Node, Option<f64>> {
    let of = |node| flight.clocks.iter().find(|clock| clock.node == node)?.settled();
    let slaves = flight.observer.slaves();
    slaves.map(|(node, _)| (node, of(node).map(|settled| rounded(figure(&settled), 1)))).collect()
}

/// COB-ID of the spacecraft time.
const SPACECRAFT_TIME: u16 = 0x181;

/// Returns the causes for which clocks are not judged, also by the data sheets.
fn clock_not_judged(flight: &Flight, sheets: &Sheets) -> BTreeMap<Node, String> {
    let text = |(node, cause): (Node, Unjudged)| {
        let lacks = cause.may_lack_object() && sheets.receives(node, SPACECRAFT_TIME) == Some(false);
        let object = if lacks { "; its data sheet has no receive PDO with COB-ID 181h" } else { "" };
        (node, format!("{cause}{object}"))
    };
    flight.unjudged_clocks().into_iter().map(text).collect()
}

fn access(track: &Track) -> Option<&'static str> {
    let access = if track.has_one_controller { Some(BusAccess::Selective) } else { track.seen_access() };
    access.map(BusAccess::name)
}

fn per_slave(flight: &Flight, time: fn(&Track) -> Option<Time>) -> BTreeMap<Node, Option<f64>> {
    flight.observer.slaves().map(|(node, track)| (node, time(track).map(milliseconds))).collect()
}

fn milliseconds(time: Time) -> f64 {
    rounded(time.as_secs_f64() * 1e3, 3)
}

fn stamp_source(flight: &Flight) -> &'static str {
    let stamps = || flight.boards.iter().map(|board| &board.diagnostics.stamps);
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
    use crate::fly::sample;
    use crate::fly::verdict::faults;

    #[test]
    fn a_good_flight_has_its_numbers_and_no_fault() {
        let flight = sample::flight();
        let summary = sample::summary(&flight);
        assert_eq!(summary.boards, 3);
        let mission = summary.mission.expect("the images are the shipped ones");
        assert_eq!(mission.tc_sent, sample::COMMANDS_ON_THE_WIRE);
        assert_eq!(mission.tc_due, sample::COMMANDS_DUE);
        assert_eq!(mission.tc_executed, sample::COMMANDS_DUE);
        assert_eq!(summary.slaves_operational_at_end, 2);
        assert_eq!(summary.failover_ms[&2], Some(sample::PARALLEL_FAILOVER_MS));
        assert_eq!(summary.failover_ms[&4], Some(sample::SELECTIVE_FAILOVER_MS));
        assert_eq!(summary.stamp_source, "capture");
        assert_eq!(summary.stamp_worst_error_ns, Some(11.9));
        assert_eq!(summary.clock_worst_error_ns, BTreeMap::from([(2, Some(40.0)), (4, None)]));
        assert_eq!(summary.clock_rms_error_ns[&2], Some(35.4), "the root of (30^2 + 40^2) / 2");
        assert_eq!(summary.wall_seconds, 10.0);
        assert_eq!(summary.emulated_mips, 9.0, "3 boards with 30 million instructions each in 10 s");
        assert_eq!(faults(&flight), Vec::<String>::new());
    }

    #[test]
    fn the_source_of_stamps_is_that_of_all_boards() {
        let mut flight = sample::flight();
        flight.boards[2].diagnostics.stamps.missed[3] = 1;
        assert_eq!(sample::summary(&flight).stamp_source, "mixed");
        flight.boards.iter_mut().for_each(|board| board.diagnostics.stamps.captured = 0);
        assert_eq!(sample::summary(&flight).stamp_source, "interrupt");
        flight.boards[2].diagnostics.stamps.missed[3] = 0;
        assert_eq!(sample::summary(&flight).stamp_source, "unknown");
    }

    #[test]
    fn what_went_wrong_is_said() {
        let mut flight = sample::flight();
        flight.boards[0].lockups = 1;
        flight.boards[1].panics = 1;
        flight.boards[1].counters.as_mut().unwrap().commands -= 1;
        flight.boards[2].lost_frames = 3;
        flight.boards[2].counters.as_mut().unwrap().repeats = 4;
        let summary = sample::summary(&flight);
        assert_eq!(summary.mission.map(|mission| mission.tc_repeats), Some(4), "reported, and no fault");
        assert_eq!((summary.lockups, summary.panics, summary.lost_frames), (1, 1, 3));
        let faults = faults(&flight);
        assert_eq!(faults.len(), 4, "{faults:?}");
        assert_eq!(faults[0], "master locked up");
        assert_eq!(faults[3], "node 4 lost 3 frames");
    }

    /// Loads are of 40 s. A master's heartbeat every 250 ms but between 19.8 s and 20.6 s, where no node acknowledged.
    #[test]
    fn buses_and_heartbeats_have_their_numbers() {
        let summary = sample::summary(&sample::flight());
        assert_eq!(summary.bus_load_percent, BTreeMap::from([("nominal", 2.25), ("redundant", 1.5)]));
        assert_eq!(summary.bus_changes, 1);
        assert_eq!(summary.heartbeats[&1], 80 + 78);
        assert_eq!(summary.heartbeat_longest_gap_ms[&1], Some(800.0));
        assert_eq!(summary.heartbeat_longest_gap_ms[&2], Some(250.0));
    }

    /// Cut at 10 s, first TC on the redundant bus at 11.205 s; loss at 20 s, first TC of the other master at 20.305 s.
    #[test]
    fn flight_of_two_masters_has_both_times_of_each_slave() {
        let summary = sample::summary(&sample::standby::flight());
        let faults =
            [summary.standby_reset_at_seconds, summary.cut_at_seconds, summary.master_lost_at_seconds];
        assert_eq!(faults, [Some(5.0), Some(10.0), Some(20.0)]);
        assert_eq!(summary.failover_ms, BTreeMap::from([(2, Some(1_205.0)), (4, Some(1_205.0))]));
        assert_eq!(summary.takeover_failover_ms, BTreeMap::from([(2, Some(305.0)), (4, Some(305.0))]));
        assert_eq!((summary.takeover_ms, summary.bus_changes), (Some(399.0), 1));
    }

    #[test]
    fn unknown_images_have_their_names_and_no_commands() {
        let mut flight = sample::flight();
        flight.plan.boards[2].own_image = Some("own.elf".into());
        let json = serde_json::to_value(sample::summary(&flight)).unwrap();
        assert_eq!(json["own_images"]["4"], "own.elf");
        assert_eq!(json.get("tc_due").or(json.get("tm_received")), None);
        assert!(json.get("failover_ms").is_some());
    }

    /// Given a slave whose pulses do not follow the time that it received, and a data sheet without a PDO for it, then the cause names
    /// the object too.
    #[test]
    fn cause_of_an_unjudged_clock_names_a_missing_object() {
        let mut flight = sample::flight();
        let set = Time::from_ms(10_050);
        flight.uncompared =
            [(2, Unjudged::NoPulse { board: 2, set }), (4, Unjudged::NotSent { since: set })].into();
        flight.clocks.clear();
        let here = tempfile::tempdir().unwrap();
        let file = here.path().join("own.eds");
        std::fs::write(&file, "[DeviceInfo]\n").unwrap();
        let own = [2, 4].map(|node| crate::images::support::fleet::NodeFile { node, file: file.clone() });
        let causes = clock_not_judged(&flight, &Sheets::of(&flight.plan, &own).unwrap());
        let expected = "node 2 raised its pulse pin at no second of the spacecraft time after 10.1 s, when the clock was set; its data \
                        sheet has no receive PDO with COB-ID 181h";
        assert_eq!(causes[&2], expected);
        assert_eq!(causes[&4], "no master sent the spacecraft time (181h) after the reset at 10.1 s");
    }

    /// Given an own image that follows the master at once, then its access is known, also with one controller.
    #[test]
    fn access_of_each_slave_is_there() {
        let mut flight = sample::flight();
        let access = |flight: &Flight| sample::summary(flight).access;
        assert_eq!(access(&flight), BTreeMap::from([(2, Some("parallel")), (4, Some("selective"))]));
        let track = flight.observer.nodes.get_mut(&2).unwrap();
        (track.access, track.follow) = (Some(BusAccess::Unknown), Default::default());
        assert_eq!(access(&flight)[&2], None);
        flight.observer.nodes.get_mut(&2).unwrap().has_one_controller = true;
        assert_eq!(access(&flight)[&2], Some("selective"));
    }

    #[test]
    fn the_names_that_others_read_are_there() {
        let json = serde_json::to_value(sample::summary(&sample::flight())).unwrap();
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
            "takeover_failover_ms",
            "standby_reset_at_seconds",
            "slaves_operational_at_end",
            "lost_frames",
            "aborted_frames",
            "lockups",
            "panics",
            "stamp_source",
            "stamp_worst_error_ns",
            "clock_rms_error_ns",
            "clock_worst_error_ns",
            "clock_not_judged",
            "equal_emergencies",
            "data_sheets",
            "access",
            "aborted",
            "seed",
            "profile",
        ] {
            assert!(json.get(key).is_some(), "{key}");
        }
        assert_eq!(json["failover_ms"]["4"], sample::SELECTIVE_FAILOVER_MS);
        assert_eq!(json["verdict"], "passed");
    }
}
