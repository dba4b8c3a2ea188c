//! Compares what a machine did in the replay with what its board did in flight.

use std::collections::BTreeMap;

use can_wire::time::Time;
use ecss_can::redundancy::Pair;
use ecss_can::types::{Bus, NmtState, NodeId};

use crate::difference::Difference;
use crate::flown::Flown;
use crate::output::{Output, Stream};
use crate::run::{After, Replayed};

/// Latest output of a board after that of its machine. A machine decides in no time. The program of a board wakes up, handles the
/// frames before, and writes a mailbox or the log: some 50 us as a rule. The longest is the first step of a master, 1.7 ms.
pub const LATE: Time = Time::from_ms(2);
/// Earliest output of a board before that of its machine.
pub const EARLY: Time = LATE;
/// Lifetime of a heartbeat that waits for a mailbox.
const LIFETIME: Time = Time::from_ms(100);
/// EMCYs that may wait.
const WAITING: usize = 8;
/// An EMCY waits for those before it, with an inhibit time of 100 ms (1015h).
const INHIBITED: Time = Time::from_ms(100 * (WAITING as u64 + 1));

/// Result of a comparison.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Comparison {
    /// Frames after which bus and state were compared.
    pub frames: u64,
    /// Outputs that agreed, of each stream.
    pub outputs: BTreeMap<Stream, u64>,
    /// Lines among them that name the active bus.
    pub changes: u64,
    /// Frames that waited for a mailbox or for an inhibit time, and agreed.
    pub waited: u64,
    /// Heartbeats and claims whose lifetime ended before there was a mailbox for them, and EMCYs that found the queue full.
    pub given_up: u64,
    /// Boards that agree if frames come before deadlines that were up to 10 us earlier.
    pub reordered: u64,
    /// Longest time from an output of the machine to that of the board, without those that waited for a mailbox.
    pub latest: Time,
    /// First difference of each stream of each board.
    pub differences: Vec<Difference>,
}

/// Board whose outputs are compared.
pub struct Compared<'a> {
    pub name: &'a str,
    pub id: NodeId,
    pub pair: Option<&'a Pair>,
    pub flown: &'a Flown,
}

impl Comparison {
    /// Adds another comparison.
    pub fn add(&mut self, other: Comparison) {
        self.frames += other.frames;
        for (stream, count) in other.outputs {
            *self.outputs.entry(stream).or_default() += count;
        }
        self.changes += other.changes;
        self.waited += other.waited;
        self.given_up += other.given_up;
        self.reordered += other.reordered;
        self.latest = self.latest.max(other.latest);
        self.differences.extend(other.differences);
    }

    /// Compares a board.
    pub fn board(compared: &Compared<'_>, replayed: &Replayed) -> Comparison {
        let mut comparison = Comparison::default();
        for stream in Stream::ALL {
            comparison.compare(stream, compared, replayed);
        }
        comparison.compare_after(compared, &replayed.after);
        comparison
    }

    fn compare(&mut self, stream: Stream, compared: &Compared<'_>, replayed: &Replayed) {
        let of = |all: &[(Time, Output)]| -> Vec<(Time, Output)> {
            let is_of = |output: &Output| output.stream(compared.id, compared.pair) == Some(stream);
            all.iter().filter(|(_, output)| is_of(output)).cloned().collect()
        };
        let (expected, flown) = (of(&replayed.outputs), of(&compared.flown.outputs));
        let mut flown = flown.into_iter().peekable();
        for (nth, (at, output)) in expected.iter().enumerate() {
            let mut take = |latest: Time| {
                let is_same = |(found, same): &(Time, Output)| {
                    same == output && *found + EARLY >= *at && *found <= latest
                };
                flown.next_if(is_same)
            };
            if let Some((found, _)) = take(*at + LATE) {
                self.agree(stream, output);
                self.latest = self.latest.max(found.since(*at));
                continue;
            }
            let next = expected.iter().skip(nth + 1).find(|(_, other)| other == output);
            let next = next.map_or(Time::NEVER, |(at, _)| *at);
            let wait = compared.wait(*at, output);
            if wait.is_some_and(|wait| take((*at + wait).min(next)).is_some()) {
                self.agree(stream, output);
                self.waited += 1;
            } else if wait.is_some() && compared.may_be_lost(*at, stream) {
                self.given_up += 1;
            } else if !compared.is_cut_off(*at, wait.unwrap_or(LATE)) {
                let instead = flown.peek().map_or("nothing more".into(), |(at, output)| {
                    format!("{} at {:.6} s", output, at.as_secs_f64())
                });
                let expected = output.to_string();
                return self.differ(compared, *at, format!("{stream:?}"), expected, instead);
            }
        }
        if let Some((at, output)) = flown.next() {
            self.differ(compared, at, format!("{stream:?}"), "nothing more".into(), output.to_string());
        }
    }

    fn agree(&mut self, stream: Stream, output: &Output) {
        *self.outputs.entry(stream).or_default() += 1;
        let is_change = matches!(output, Output::Line(line) if line.starts_with("active bus: "));
        self.changes += u64::from(is_change);
    }

    fn compare_after(&mut self, compared: &Compared<'_>, after: &[After]) {
        let Flown { buses, states, .. } = compared.flown;
        for After { at, bus, state } in after {
            self.frames += 1;
            let (from, to) = (at.since(LATE), *at + LATE);
            let is_bus = bus.is_none_or(|bus| is_among(buses, bus, from, to));
            if !(is_bus && is_among(states, *state, from, to)) {
                let shown = |bus: Option<Bus>, state: Option<NmtState>| {
                    let bus = bus.map_or("no bus".into(), |bus| format!("{bus:?}"));
                    let state = state.map_or("no state".into(), |state| format!("{state:?}"));
                    format!("{bus}, {state}")
                };
                let (expected, flown) =
                    (shown(*bus, Some(*state)), shown(last(buses, *at), last(states, *at)));
                return self.differ(compared, *at, "bus and state".into(), expected, flown);
            }
        }
    }

    fn differ(&mut self, compared: &Compared<'_>, at: Time, what: String, expected: String, flown: String) {
        self.differences.push(Difference { board: compared.name.into(), at, what, expected, flown });
    }
}

impl Compared<'_> {
    /// Returns how long an output may wait in a queue of the node. `None`: it need not wait.
    fn wait(&self, at: Time, output: &Output) -> Option<Time> {
        match output {
            Output::Frame(bus, _) => self.flown.mailboxes.is_full(*bus, at, at + LATE).then_some(LIFETIME),
            Output::Emergency(..) => Some(INHIBITED),
            Output::Line(_) => None,
        }
    }

    /// Returns whether an output that may wait may never have come.
    fn may_be_lost(&self, at: Time, stream: Stream) -> bool {
        match stream {
            Stream::Heartbeat | Stream::Claim(_) => true,
            // Those that waited before it have all been sent.
            Stream::Emergency => {
                let is_after = |sent: &&Time| **sent > at && **sent <= at + INHIBITED;
                self.flown.emergencies.iter().filter(is_after).count() >= WAITING
            }
            Stream::Command | Stream::Question | Stream::Line => false,
        }
    }

    /// Returns whether the chip was reset, or the run ended, before an output of `at` was sure to come.
    fn is_cut_off(&self, at: Time, wait: Time) -> bool {
        self.flown.ends.iter().any(|end| *end + EARLY >= at && *end <= at + wait)
    }
}

fn last<T: Copy>(changes: &[(Time, T)], at: Time) -> Option<T> {
    changes.iter().rfind(|(since, _)| *since <= at).map(|(_, value)| *value)
}

/// Returns whether the value was this at some instant of a span.
fn is_among<T: Copy + PartialEq>(changes: &[(Time, T)], value: T, from: Time, to: Time) -> bool {
    let until = changes.partition_point(|(at, _)| *at <= to);
    let Some(changes) = changes.get(..until) else { return false };
    let after = changes.iter().rev().take_while(|(at, _)| *at > from);
    after.clone().any(|(_, shown)| *shown == value)
        || changes.iter().rev().nth(after.count()).is_some_and(|(_, shown)| *shown == value)
}
