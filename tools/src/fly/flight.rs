//! Results of a flight: the input of summary and report.

use std::collections::BTreeMap;
use std::time::Duration;

use can_twin::bxcan::Attempt;
use can_twin::wire::frame::WireId;
use can_twin::wire::time::Time;

use super::change::Takeover;
use super::clocks::Clock;
use super::line::Line;
use super::meaning::Meaning;
use super::observer::Observer;
use super::plan::Plan;
use super::record::{Bus, FlightEvent, Level, MASTER, Node, Occurrence, Seen, frames, is_master};
use super::stamps::StampErrors;
use super::unjudged::Unjudged;
use crate::images::support::counters::Counters;
use crate::images::support::diagnostics::Diagnostics;

/// A finished flight.
#[derive(Clone, Debug)]
pub struct Flight {
    /// Plan of the flight.
    pub plan: Plan,
    /// End of the flight: the first quiet moment after the planned end, or after the interruption.
    pub end: Time,
    /// Reason of an end before the planned one.
    pub interrupted: Option<Interruption>,
    /// Time that the flight took on the computer, without building images.
    pub wall: Duration,
    /// All events in chronological order.
    pub records: Vec<Occurrence>,
    /// The lines of the narrator.
    pub story: Vec<Line>,
    /// The observer after the end of the flight.
    pub observer: Observer,
    /// Counters of the boards, master first.
    pub boards: Vec<BoardCount>,
    /// Planned faults that could not be caused, with the reason.
    pub refused: Vec<String>,
    /// Errors of the stamps of SYNC.
    pub stamp_errors: StampErrors,
    /// Errors of the slaves' clocks against the master's, by Node-ID.
    pub clocks: Vec<Clock>,
    /// Slaves without an entry in `clocks`, with the cause.
    pub uncompared: BTreeMap<Node, Unjudged>,
    /// Time that frames and error frames took on each bus, nominal first.
    pub busy: [Time; 2],
}

/// Heartbeats of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heartbeats {
    /// Number of heartbeats that completed.
    pub count: u64,
    /// Longest time without a heartbeat: between two of them, or from the last one to the end of the flight while the
    /// node has power. `None` without heartbeats, or with only one of a node that lost its power.
    pub longest_gap: Option<Time>,
}

/// Reason why a flight ended before its planned end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interruption {
    /// Ctrl-C or SIGTERM.
    Asked,
    /// The output can no longer be written.
    Unread,
}

/// Counters of one board.
#[derive(Clone, Debug, Default)]
pub struct BoardCount {
    /// Node-ID.
    pub node: Node,
    /// Instructions that the emulated CPU executed.
    pub instructions: u64,
    /// Cycles in which the emulated CPU was awake, since its first power-on.
    pub cycles_awake: u64,
    /// Frames that its controllers admitted and its node did not handle.
    pub lost_frames: u64,
    /// Transmissions that were aborted in a mailbox.
    pub aborted: Vec<AbortedFrame>,
    /// Lock-ups of the CPU.
    pub lockups: u64,
    /// Panics of the firmware.
    pub panics: u64,
    /// Resets requested by the firmware, and resets by the watchdog.
    pub resets: u64,
    /// Reason why the twin stopped it: an access to hardware that is not modelled.
    pub stopped: Option<String>,
    /// Bit rate of its controller on each bus, nominal first, kbit/s; `None` on a bus that it never took part in.
    pub bit_rates: [Option<u32>; 2],
    /// Mismatches of image and board, such as the pins of a controller.
    pub warnings: Vec<String>,
    /// Deepest stack since power-on, bytes.
    pub stack: u32,
    /// Counters of the firmware.
    pub diagnostics: Diagnostics,
    /// Counters of the application; `None` for an application that is not of the mission.
    pub counters: Option<Counters>,
}

/// A frame that a board aborted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AbortedFrame {
    /// Time of the abort.
    pub at: Time,
    /// Bus on which the frame waited.
    pub bus: Bus,
    /// COB-ID.
    pub id: WireId,
    /// Result of the latest attempt to send the frame; `None` if there was none.
    pub last: Option<Attempt>,
}

impl BoardCount {
    /// Returns a counter of the application as text; a dash for an application without counters.
    pub fn counted(&self, which: impl Fn(&Counters) -> u32) -> String {
        self.counters.as_ref().map_or("-".into(), |counters| which(counters).to_string())
    }
}

impl Flight {
    /// Returns all frames, in order of completion.
    pub fn frames(&self) -> impl Iterator<Item = (Time, &Seen)> {
        frames(&self.records)
    }

    /// Returns all emergency messages, in order of completion.
    pub fn emergencies(&self) -> impl Iterator<Item = (Time, &Seen)> {
        self.frames().filter(|(_, seen)| matches!(seen.meaning, Some(Meaning::Emergency { .. })))
    }

    /// Returns the slaves whose clock is not judged, with the cause.
    pub fn unjudged_clocks(&self) -> BTreeMap<Node, Unjudged> {
        let unsettled = self.clocks.iter().filter(|clock| clock.settled().is_none());
        let short = unsettled.map(|clock| (clock.node, Unjudged::TooShort { set: clock.set, end: self.end }));
        self.uncompared.iter().map(|(node, cause)| (*node, *cause)).chain(short).collect()
    }

    /// The last error in the log of a node.
    pub fn last_error(&self, of: Node) -> Option<&str> {
        self.records.iter().rev().find_map(|record| match &record.what {
            FlightEvent::Log { node, level: Level::Error, text } if *node == of => Some(&**text),
            _ => None,
        })
    }

    /// Load of a bus over the whole flight, 0 to 1. The pieces of a cut bus are busy at the same time, and so are nodes
    /// with different bit rates: their sum is limited to 1.
    pub fn load(&self, bus: Bus) -> f64 {
        (self.busy[bus as usize].as_secs_f64() / self.end.as_secs_f64().max(f64::MIN_POSITIVE)).min(1.0)
    }

    /// The heartbeats of a node on both buses.
    pub fn heartbeats(&self, node: Node) -> Heartbeats {
        let is_own = |seen: &Seen| matches!(seen.meaning, Some(Meaning::Heartbeat { node: of, .. }) if seen.board(of) == node);
        let (mut heartbeats, mut last) = (Heartbeats::default(), None::<Time>);
        for (at, _) in self.frames().filter(|(_, seen)| is_own(seen)) {
            let gap = last.map(|last| at.since(last));
            heartbeats =
                Heartbeats { count: heartbeats.count + 1, longest_gap: heartbeats.longest_gap.max(gap) };
            last = Some(at);
        }
        let has_power = self.observer.nodes.get(&node).is_some_and(|track| track.now().phase.is_powered());
        let silence = last.filter(|_| has_power).map(|last| self.end.since(last));
        heartbeats.longest_gap = heartbeats.longest_gap.max(silence);
        heartbeats
    }

    /// Number of changes of bus of the first master.
    pub fn bus_changes(&self) -> usize {
        let spans = &self.observer.nodes[&MASTER].spans;
        spans.windows(2).filter(|pair| pair[0].bus != pair[1].bus).count()
    }

    /// Time and bus of the cut.
    pub fn cut(&self) -> Option<(Time, Bus)> {
        self.records.iter().find_map(|record| match record.what {
            FlightEvent::Cut(cut) => Some((record.at, cut.bus)),
            _ => None,
        })
    }

    /// Time of the reset of the standby, and that board.
    pub fn standby_reset(&self) -> Option<(Time, Node)> {
        self.records.iter().find_map(|record| match record.what {
            FlightEvent::Reset(board) if self.plan.standby_reset() == Some(record.at) => {
                Some((record.at, board))
            }
            _ => None,
        })
    }

    /// Time at which the first master lost its power, and that board.
    pub fn loss(&self) -> Option<(Time, Node)> {
        self.records.iter().find_map(|record| match record.what {
            FlightEvent::PowerOff(board) if is_master(board) => Some((record.at, board)),
            _ => None,
        })
    }

    /// The takeover by the standby, if there was one.
    pub fn takeover(&self) -> Option<Takeover> {
        self.observer.takeover()
    }

    /// Returns the faults of the plan, in chronological order: name in the pictures, and instant.
    pub fn faults(&self) -> Vec<(&'static str, Time)> {
        let fault = |record: &Occurrence| match record.what {
            FlightEvent::Reset(_) => Some(("reset", record.at)),
            FlightEvent::Cut(_) => Some(("cut", record.at)),
            FlightEvent::PowerOff(_) => Some(("power off", record.at)),
            FlightEvent::Other { name, .. } => Some((name, record.at)),
            _ => None,
        };
        self.records.iter().filter_map(fault).collect()
    }

    /// Number of master boards.
    pub fn masters(&self) -> usize {
        self.boards.iter().filter(|board| is_master(board.node)).count()
    }

    /// Returns the first change of bus of the active master before its loss of power. A standby changes with it.
    pub fn switch(&self) -> Option<Time> {
        let spans = &self.observer.nodes[&MASTER].spans;
        let switch = spans.windows(2).find(|pair| pair[0].bus != pair[1].bus).map(|pair| pair[1].from)?;
        self.loss().is_none_or(|(loss, _)| switch < loss).then_some(switch)
    }
}
