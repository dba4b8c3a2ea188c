//! Outcomes of upsets, and how a flight is judged.
//!
//! A *service* is a COB-ID that a node sends regularly, its heartbeats in Operational, or the commands that a slave executes. A service
//! is *healthy* in a span if its count differs from that of the reference by at most 2 or 15 %. A service with a long period is also
//! unhealthy if it is absent in the last 10 s, in which the reference has it at least twice. The spacecraft time of a slave is healthy if
//! it differs from that of the reference by at most 5 ms; it is not compared after the master was reset or replaced.

use std::collections::BTreeSet;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::record::{Record, Service};

/// Span before an end in which services must be healthy, microseconds.
pub const HEALTHY_US: u64 = 4_000_000;
/// The same at the end of a probe.
pub const PROBED_US: u64 = 3_000_000;
/// Span in which services with a long period are expected, microseconds.
const LONG_US: u64 = 10_000_000;
/// Tolerance of a count.
const FEW: usize = 2;
const PERCENT: usize = 15;
/// Greatest difference of the spacecraft time, microseconds.
const CLOCK_US: i64 = 5_000;
/// Time in which a watchdog expires, microseconds: a reset by it costs more than one by a pin.
const WATCHDOG_US: u64 = 2_000_000;

/// Outcome of an upset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The flight without upset shows that the byte is not read after the upset, or is written first. It was not flown.
    NotUsed,
    /// No count differs from the reference by more than 2; no further emergency, no reset. The probe succeeds.
    None,
    /// Something differed, and all services are healthy at the end. No board was reset. The probe succeeds.
    Repaired,
    /// As before, and a board was reset by its program or watchdog.
    Reset,
    /// All services are healthy at the end, but another node than that of the upset lost more commands or heartbeats than a reset of the
    /// board by its pin costs, plus those of 2 s, in which a watchdog expires.
    OthersLose,
    /// A service is unhealthy at the end. All heartbeats are healthy, no further emergency was sent and no board was reset.
    WrongSilent,
    /// A service is unhealthy at the end, and a missing heartbeat, an emergency or a reset shows it.
    NotRecovered,
    /// All services are healthy until the probe. After it a service is unhealthy.
    Latent,
    /// The emulator refused an access or a state, for which the manuals define no result.
    Unjudged,
}

impl Outcome {
    /// All outcomes, in the order of the table.
    pub const ALL: [Outcome; 9] = [
        Outcome::NotUsed,
        Outcome::None,
        Outcome::Repaired,
        Outcome::Reset,
        Outcome::OthersLose,
        Outcome::WrongSilent,
        Outcome::NotRecovered,
        Outcome::Latent,
        Outcome::Unjudged,
    ];

    /// Returns the name in tables and lists.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::NotUsed => "not used",
            Outcome::None => "none",
            Outcome::Repaired => "repaired",
            Outcome::Reset => "reset",
            Outcome::OthersLose => "others lose",
            Outcome::WrongSilent => "wrong, silent",
            Outcome::NotRecovered => "not recovered",
            Outcome::Latent => "latent",
            Outcome::Unjudged => "unjudged",
        }
    }

    /// Returns whether the spacecraft lost something for good, or more than a reset costs.
    pub fn is_bad(self) -> bool {
        use Outcome::{Latent, NotRecovered, OthersLose, WrongSilent};
        matches!(self, OthersLose | WrongSilent | NotRecovered | Latent)
    }
}

/// Flights that belong to one upset.
pub struct Case<'a> {
    /// The flight with the upset.
    pub run: &'a Record,
    /// The flight that it is compared with.
    pub reference: &'a Record,
    /// The flight in which the board was reset by its pin instead, and the instant of that reset in microseconds.
    pub reset: (&'a Record, u64),
    /// Node-ID of the board.
    pub node: u8,
    /// Instant of the upset, and end of the judged time, microseconds.
    pub judged: Range<u64>,
}

/// A record, and the spans of it that are compared, microseconds.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// The record.
    pub record: &'a Record,
    /// End of the spans.
    pub end: u64,
    /// Length of the span in which services must be healthy.
    pub length: u64,
}

impl View<'_> {
    fn span(&self) -> Range<u64> {
        self.end - self.length..self.end
    }

    fn count(&self, key: (u8, Service)) -> usize {
        self.record.count(key, &self.span())
    }

    /// Counts a service with a long period. After a probe there is no longer span.
    fn count_long(&self, key: (u8, Service)) -> usize {
        let length = if self.length == PROBED_US { PROBED_US } else { LONG_US };
        self.record.count(key, &(self.end - length..self.end))
    }
}

/// Returns the services of a flight that are not healthy.
pub fn unhealthy(run: View, reference: View) -> Vec<String> {
    let keys = run.record.services.keys().chain(reference.record.services.keys());
    let keys: BTreeSet<(u8, Service)> = keys.copied().collect();
    let regular = keys.into_iter().filter(|(_, service)| service.is_regular());
    let wrong = regular.filter_map(|key| {
        let (here, there) = (run.count(key), reference.count(key));
        let is_off = here.abs_diff(there) > FEW.max(there * PERCENT / 100);
        let is_absent = reference.count_long(key) >= FEW && run.count_long(key) == 0;
        (is_off || is_absent).then(|| format!("node {}: {}: {here}, expected {there}", key.0, shown(key.1)))
    });
    wrong.chain(wrong_clocks(run, reference)).collect()
}

fn shown(service: Service) -> String {
    match service {
        Service::Frames(id) => format!("{id:03X}h"),
        Service::Commands => "commands".to_owned(),
        Service::Heartbeats(state) => format!("heartbeats of state {state}"),
    }
}

fn wrong_clocks(run: View, reference: View) -> Vec<String> {
    if !run.record.resets.is_empty() || run.record.active != reference.record.active {
        return Vec::new();
    }
    let last = |view: View, node: u8| {
        let here = view.record.clocks.iter().filter(|(of, at, _)| *of == node && view.span().contains(at));
        here.map(|(.., ahead)| *ahead).next_back()
    };
    let nodes: BTreeSet<u8> = reference.record.clocks.iter().map(|(node, ..)| *node).collect();
    let wrong = nodes.into_iter().filter_map(|node| {
        let ahead = last(run, node)? - last(reference, node)?;
        (ahead.abs() > CLOCK_US).then(|| format!("node {node}: its time differs by {ahead} us"))
    });
    wrong.collect()
}

impl Case<'_> {
    /// Judges the flight up to the probe. Returns the outcome and the reasons.
    pub fn judge(&self) -> (Outcome, Vec<String>) {
        let Range { start, end } = self.judged;
        let last = end - HEALTHY_US..end;
        let view = |record| View { record, end, length: HEALTHY_US };
        let wrong = unhealthy(view(self.run), view(self.reference));
        if !wrong.is_empty() {
            let outcome = if self.is_shown(&last) { Outcome::NotRecovered } else { Outcome::WrongSilent };
            return (outcome, wrong);
        }
        let losses = self.losses_of_others();
        if !losses.is_empty() {
            return (Outcome::OthersLose, losses);
        }
        if !self.run.resets.is_empty() {
            return (Outcome::Reset, Vec::new());
        }
        let outcome = if self.differs(&(start..end)) { Outcome::Repaired } else { Outcome::None };
        (outcome, Vec::new())
    }

    /// Returns whether the network shows the failure: by a reset, an emergency or heartbeats.
    fn is_shown(&self, last: &Range<u64>) -> bool {
        let (run, reference) = (self.run, self.reference);
        let is_heartbeat = |service: Service| match service {
            Service::Frames(id) => (0x701..=0x77F).contains(&id),
            Service::Heartbeats(_) => true,
            Service::Commands => false,
        };
        let keys = run.services.keys().chain(reference.services.keys());
        let is_off = |key: &(u8, Service)| run.count(*key, last).abs_diff(reference.count(*key, last)) > FEW;
        !run.resets.is_empty()
            || run.emergencies(&self.judged) > reference.emergencies(&self.judged)
            || keys.filter(|key| is_heartbeat(key.1)).any(is_off)
    }

    /// Returns the losses of other nodes that exceed those by a reset.
    fn losses_of_others(&self) -> Vec<String> {
        let (reset, reset_at) = self.reset;
        let span = &self.judged;
        let others = self.reference.services.keys().filter(|(node, service)| {
            let counts =
                *service == Service::Commands || *service == Service::Frames(0x700 + u16::from(*node));
            *node != self.node && counts
        });
        let lost = others.filter_map(|key| {
            let expected = self.reference.count(*key, span);
            let lost = expected.saturating_sub(self.run.count(*key, span));
            let since_reset = reset_at..span.end;
            let cost =
                self.reference.count(*key, &since_reset).saturating_sub(reset.count(*key, &since_reset));
            let margin = expected * WATCHDOG_US as usize / (span.end - span.start) as usize;
            let (node, service) = (key.0, shown(key.1));
            (lost > cost + margin + FEW)
                .then(|| format!("node {node} lost {lost} {service}, a reset costs {cost}"))
        });
        lost.collect()
    }

    fn differs(&self, span: &Range<u64>) -> bool {
        let (run, reference) = (self.run, self.reference);
        let mut keys = run.services.keys().chain(reference.services.keys());
        let is_rare = |service: Service| !service.is_regular();
        keys.any(|key| {
            let difference = run.count(*key, span).abs_diff(reference.count(*key, span));
            difference > if is_rare(key.1) { 0 } else { FEW }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: u64 = 5_000_000;
    const END: u64 = 18_000_000;
    const HEARTBEAT: (u8, Service) = (2, Service::Frames(0x702));
    const COMMANDS: (u8, Service) = (2, Service::Commands);
    const OTHER: (u8, Service) = (3, Service::Commands);

    /// A flight in which each service is there each 100 ms, but not in a span.
    fn without(gaps: &[((u8, Service), Range<u64>)]) -> Record {
        let mut record = Record::default();
        for key in [HEARTBEAT, COMMANDS, OTHER] {
            let is_there = |at: &u64| !gaps.iter().any(|(of, span)| *of == key && span.contains(at));
            record.services.insert(key, (START..END).step_by(100_000).filter(is_there).collect());
        }
        record
    }

    fn view(record: &Record) -> View<'_> {
        View { record, end: END, length: HEALTHY_US }
    }

    fn judged(run: &Record) -> Outcome {
        let (reference, reset) = (without(&[]), without(&[(HEARTBEAT, START..6_000_000)]));
        let case = Case { run, reference: &reference, reset: (&reset, START), node: 2, judged: START..END };
        case.judge().0
    }

    #[test]
    fn outcomes_of_flights_are_as_defined() {
        let (gap, rest) = (START..7_000_000, START..END);
        let mut reset = without(&[(HEARTBEAT, gap.clone())]);
        reset.resets.push((1, 6_000_000));
        let mut reported = without(&[(COMMANDS, rest.clone())]);
        reported.services.insert((2, Service::Frames(0x082)), vec![6_000_000]);
        for (run, expected) in [
            (without(&[]), Outcome::None),
            (without(&[(HEARTBEAT, START..START + 200_000)]), Outcome::None),
            (without(&[(HEARTBEAT, gap)]), Outcome::Repaired),
            (reset, Outcome::Reset),
            (without(&[(OTHER, START..10_000_000)]), Outcome::OthersLose),
            (without(&[(COMMANDS, rest.clone())]), Outcome::WrongSilent),
            (reported, Outcome::NotRecovered),
            (without(&[(HEARTBEAT, rest)]), Outcome::NotRecovered),
        ] {
            assert_eq!(judged(&run), expected);
        }
    }

    #[test]
    fn rare_service_that_ends_is_unhealthy() {
        let rare = (1, Service::Frames(0x080));
        let mut reference = without(&[]);
        reference.services.insert(rare, vec![9_000_000, 14_500_000]);
        let wrong = unhealthy(view(&without(&[])), view(&reference));
        assert_eq!(wrong, ["node 1: 080h: 0, expected 1"]);
    }

    #[test]
    fn time_of_a_slave_that_jumps_is_unhealthy_unless_a_board_was_reset() {
        let (mut run, mut reference) = (without(&[]), without(&[]));
        reference.clocks.push((2, 17_000_000, 100));
        run.clocks.push((2, 17_100_000, 100 + CLOCK_US + 1));
        let wrong = |run: &Record| unhealthy(view(run), view(&reference)).len();
        assert_eq!(wrong(&run), 1);
        run.resets.push((0, 6_000_000));
        assert_eq!(wrong(&run), 0);
    }
}
