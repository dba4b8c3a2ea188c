//! Compares what a machine did in the replay with what its board did in flight.

use std::collections::BTreeMap;
use std::fmt;

use can_wire::time::Time;
use ecss_can::redundancy::Pair;
use ecss_can::types::{Bus, NodeId};

use crate::flown::Flown;
use crate::output::{Output, Stream};
use crate::run::{After, Replayed};

/// Latest output in flight after its instant in the replay: the way from the interrupt to the mailbox or the log, while the
/// program handles a burst of frames.
pub const LATE: Time = Time::from_ms(2);
/// Earliest output in flight before its instant in the replay. The replay hears of some inputs by the log, which is late.
pub const EARLY: Time = Time::from_us(500);
/// Lifetime of a heartbeat that waits for a mailbox.
const LIFETIME: Time = Time::from_ms(100);

/// First difference of a stream of outputs, or of bus and state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Name of the board.
    pub board: String,
    /// Instant on the time axis of the run.
    pub at: Time,
    /// What was compared.
    pub what: String,
    /// What the machine did.
    pub expected: String,
    /// What the board did.
    pub flown: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Difference { board, at, what, expected, flown } = self;
        write!(f, "{board}, {:.6} s, {what}: the machine {expected}, the board {flown}", at.as_secs_f64())
    }
}

/// Result of a comparison.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Comparison {
    /// Frames after which bus and state were compared.
    pub frames: u64,
    /// Outputs that agreed, of each stream.
    pub outputs: BTreeMap<Stream, u64>,
    /// Changes of the active bus that agreed.
    pub changes: u64,
    /// Heartbeats that waited for a mailbox or never had one.
    pub waited: u64,
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
        self.latest = self.latest.max(other.latest);
        self.differences.extend(other.differences);
    }

    /// Compares a board.
    pub fn board(compared: &Compared<'_>, replayed: &Replayed) -> Comparison {
        let mut comparison = Comparison::default();
        let streams = [
            Stream::Heartbeat,
            Stream::Command,
            Stream::Claim,
            Stream::Question,
            Stream::Emergency,
            Stream::Line,
        ];
        for stream in streams {
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
            let next = expected.get(nth + 1).map_or(Time::NEVER, |(at, _)| *at);
            let latest = self.latest_of(compared, *at, output, next);
            let found = flown.next_if(|(found, same)| {
                same == output && *found + EARLY >= *at && *found <= latest.unwrap_or(*at + LATE)
            });
            match found {
                Some((found, _)) => {
                    *self.outputs.entry(stream).or_default() += 1;
                    let is_change = matches!(output, Output::Line(line) if line.starts_with("active bus"));
                    self.changes += u64::from(is_change);
                    if latest.is_some() {
                        self.waited += 1;
                    } else {
                        self.latest = self.latest.max(found.since(*at));
                    }
                }
                None if latest.is_some() || compared.is_cut_off(*at) => {
                    self.waited += u64::from(latest.is_some());
                }
                None => {
                    let instead = flown.peek().map_or("nothing more".into(), |(at, output)| {
                        format!("{} at {:.6} s", output, at.as_secs_f64())
                    });
                    let expected = output.to_string();
                    return self.differ(compared, *at, format!("{stream:?}"), expected, instead);
                }
            }
        }
        if let Some((at, output)) = flown.next() {
            self.differ(compared, at, format!("{stream:?}"), "nothing more".into(), output.to_string());
        }
    }

    /// Returns the latest instant of a frame that had to wait for a mailbox. It may also be missing. `None`: it need not wait.
    fn latest_of(&self, compared: &Compared<'_>, at: Time, output: &Output, next: Time) -> Option<Time> {
        let Output::Frame(bus, _) = output else { return None };
        compared.flown.is_full(*bus, at, at + LATE).then(|| (at + LIFETIME).min(next))
    }

    fn compare_after(&mut self, compared: &Compared<'_>, after: &[After]) {
        let Flown { buses, states, .. } = compared.flown;
        for After { at, bus, state } in after {
            self.frames += 1;
            let (from, to) = (at.since(LATE), *at + LATE);
            let is_bus = bus.is_none_or(|bus| is_among(buses, bus, from, to));
            if !(is_bus && is_among(states, *state, from, to)) {
                let expected = format!("{:?}, {state:?}", bus.unwrap_or(Bus::Nominal));
                let shown = format!("{:?}, {:?}", last(buses, *at), last(states, *at));
                return self.differ(compared, *at, "bus and state".into(), expected, shown);
            }
        }
    }

    fn differ(&mut self, compared: &Compared<'_>, at: Time, what: String, expected: String, flown: String) {
        self.differences.push(Difference { board: compared.name.into(), at, what, expected, flown });
    }
}

impl Compared<'_> {
    /// Returns whether the chip was reset, or the run ended, before an output of `at` was sure to come.
    fn is_cut_off(&self, at: Time) -> bool {
        self.flown.ends.iter().any(|end| *end + EARLY >= at && *end <= at + LATE)
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
