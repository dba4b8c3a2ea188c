//! Narrates a flight line by line: changes, not every frame.

use std::collections::{BTreeMap, BTreeSet};

use can_twin::wire::time::Time;

use super::change::{Change, Since};
use super::emergency;
use super::line::{Line, Tone, Topic};
use super::meaning::{Meaning, NmtState, Scope};
use super::phase::Phase;
use super::plan::Plan;
use super::record::{Bus, FlightEvent, Level, MASTER, Node, Occurrence, SECOND_MASTER, Seen, is_master};
use super::repeats::Repeats;
use super::telemetry;

/// Interval of the lines that sum up the traffic.
const SUMMARY_EVERY: Time = Time::from_ms(5000);

/// Traffic since the last summary.
#[derive(Clone, Debug, Default)]
struct Traffic {
    commands: u32,
    requests: u32,
    replies: u32,
    pdos: u32,
    sdos: u32,
    heartbeats: u32,
    /// The latest reply to each request.
    latest: BTreeMap<u16, (Node, u64)>,
}

/// Turns records and the observer's changes into lines.
#[derive(Debug)]
pub struct Narrator {
    plan: Plan,
    traffic: Traffic,
    next_summary: Time,
    summaries: usize,
    master_bus: Option<Bus>,
    /// Boards whose claims were seen, and on which bus.
    claims: BTreeSet<(Node, Bus)>,
    /// Emergency messages that are repeated.
    emergencies: Repeats,
    /// The last fault of the demo, and its instant.
    fault: Option<(Since, Time)>,
}

/// Returns a node's name in the story.
pub fn name(node: Node) -> String {
    match node {
        MASTER => "master".into(),
        SECOND_MASTER => "master 2".into(),
        slave => format!("node {slave}"),
    }
}

impl Narrator {
    /// Makes the narrator at the begin of a flight.
    pub fn new(plan: &Plan) -> Self {
        Narrator {
            plan: plan.clone(),
            traffic: Traffic::default(),
            next_summary: SUMMARY_EVERY,
            summaries: 0,
            master_bus: None,
            claims: BTreeSet::new(),
            emergencies: Repeats::default(),
            fault: None,
        }
    }

    /// Returns the lines for one record and the observer's changes.
    pub fn narrate(&mut self, record: &Occurrence, changes: &[Change]) -> Vec<Line> {
        let mut lines = Vec::new();
        if record.at >= self.next_summary {
            let repeats = self.emergencies.take().into_iter();
            lines.extend(repeats.map(|(node, code, count)| {
                let text = format!(
                    "emergency {code:04X}h again: {count} times in the last {} s",
                    SUMMARY_EVERY.as_secs_f64()
                );
                let line = line(self.next_summary, None, node, text, Tone::Warning);
                Line { topic: Topic::Emergency, ..line }
            }));
            lines.extend(self.sum_up());
        }
        match &record.what {
            FlightEvent::PowerOn(node) => lines.push(line(record.at, None, *node, "power on", Tone::Quiet)),
            FlightEvent::PowerOff(node) => {
                if is_master(*node) {
                    self.fault = Some((Since::Loss, record.at));
                }
                lines.push(fault(record.at, None, &format!("{} loses its power", name(*node))));
            }
            FlightEvent::Reset(node) => {
                let standby =
                    if self.plan.standby_reset() == Some(record.at) { ", the standby," } else { "" };
                lines.push(fault(record.at, None, &format!("{}{standby} is reset", name(*node))));
            }
            FlightEvent::Other { bus, text, .. } => lines.push(fault(record.at, Some(*bus), text)),
            FlightEvent::Cut(cut) => {
                self.fault = Some((Since::Cut, record.at));
                let text = format!("the {} bus is cut {}", cut.bus.name(), self.plan.place(cut));
                lines.push(fault(record.at, Some(cut.bus), &text));
            }
            FlightEvent::Log { node, level, text } => {
                let tone = match level {
                    Level::Trace | Level::Debug | Level::Info => Tone::Quiet,
                    Level::Warn => Tone::Warning,
                    Level::Error => Tone::Bad,
                };
                let line = line(record.at, None, *node, format!("log: {text}"), tone);
                lines.push(Line { topic: Topic::Log, ..line });
            }
            FlightEvent::Frame(seen) => self.on_frame(record.at, seen, &mut lines),
        }
        lines.extend(changes.iter().filter_map(|change| self.on_change(record.at, change)));
        lines
    }

    fn on_frame(&mut self, at: Time, seen: &Seen, lines: &mut Vec<Line>) {
        let topic = match seen.meaning {
            Some(Meaning::Emergency { .. }) => Topic::Emergency,
            Some(Meaning::SpacecraftTime(_)) => Topic::Traffic,
            _ => Topic::Event,
        };
        let mut say = |node, text: String, tone| {
            lines.push(Line { topic, ..line(at, Some(seen.bus), node, text, tone) });
        };
        self.traffic.count(seen.meaning);
        match seen.meaning {
            Some(Meaning::BootUp { node }) => say(seen.board(node), "boot-up".into(), Tone::Plain),
            Some(Meaning::Nmt { command, node }) => {
                let whom = if node == 0 { "all nodes".into() } else { name(node) };
                say(seen.board(MASTER), format!("NMT {command}: {whom}"), Tone::Plain);
            }
            Some(Meaning::Emergency { node, code, register, details }) => {
                if self.emergencies.is_repeat(seen.board(node), (code, register, details)) {
                    return;
                }
                let text = format!("emergency {code:04X}h: {}", emergency::meaning(code));
                say(seen.board(node), text, Tone::Warning);
            }
            Some(Meaning::SpacecraftTime(scet)) => {
                say(seen.board(MASTER), format!("distributes spacecraft time {scet}"), Tone::Quiet);
            }
            Some(Meaning::Heartbeat { node: MASTER, .. }) => {
                let before = self.master_bus.replace(seen.bus);
                if before != Some(seen.bus) {
                    let bus = seen.bus.name();
                    let (text, tone) = match (before, self.fault) {
                        (None, _) => {
                            (format!("heartbeat on the {bus} bus: it is the active one"), Tone::Plain)
                        }
                        (Some(_), None) => (format!("heartbeat moved to the {bus} bus"), Tone::Warning),
                        (Some(_), Some((since, fault))) => {
                            let (took, since) = (milliseconds(at.since(fault)), since.name());
                            (format!("heartbeat moved to the {bus} bus, {took} after {since}"), Tone::Warning)
                        }
                    };
                    say(seen.board(MASTER), text, tone);
                }
            }
            Some(Meaning::Claim { board, .. }) => {
                if self.claims.insert((board, seen.bus)) {
                    let text = format!("first claim on the {} bus: it is the active master", seen.bus.name());
                    say(board, text, Tone::Quiet);
                }
            }
            // Routine: only summed up.
            Some(_) => {}
            None => {
                let text = format!("frame without a known meaning: {:?}", seen.frame);
                say(seen.from, text, Tone::Warning);
            }
        }
    }

    fn sum_up(&mut self) -> Option<Line> {
        let at = self.next_summary;
        self.next_summary = at + SUMMARY_EVERY;
        let traffic = std::mem::take(&mut self.traffic);
        let counts = match self.plan.scope() {
            Scope::Mission => {
                let Traffic { commands, requests, replies, latest, .. } = traffic;
                // A different request each time, so that every kind of telemetry appears.
                let (&code, &(node, value)) = latest.iter().nth(self.summaries % latest.len().max(1))?;
                self.summaries += 1;
                format!(
                    "{commands} TC, {requests} TM requests, {replies} TM replies; {}: {}",
                    name(node),
                    telemetry::text(code, value)
                )
            }
            Scope::Protocol => {
                let Traffic { pdos, sdos, heartbeats, .. } = traffic;
                format!("{heartbeats} heartbeats, {pdos} PDOs, {sdos} frames of SDOs")
            }
        };
        Some(Line {
            at,
            bus: None,
            who: String::new(),
            text: format!("in the last {} s: {counts}", SUMMARY_EVERY.as_us() / 1_000_000),
            tone: Tone::Quiet,
            topic: Topic::Traffic,
        })
    }

    fn on_change(&self, now: Time, change: &Change) -> Option<Line> {
        match *change {
            Change::Now(_, span) if matches!(span.phase, Phase::Off | Phase::Starting) => None,
            // The state and bus of the master are shown by its messages.
            Change::Now(node, span) if is_master(node) => (span.phase == Phase::Standby).then(|| {
                let text =
                    format!("standby on the {} bus: silent, the other master is active", span.bus.name());
                line(span.from, Some(span.bus), node, text, Tone::Plain)
            }),
            Change::Now(node, span) => {
                let tone = match span.phase {
                    Phase::Nmt(NmtState::Operational) => Tone::Good,
                    Phase::Silent => Tone::Warning,
                    _ => Tone::Plain,
                };
                let text = format!("{} on the {} bus", span.phase.name(), span.bus.name());
                Some(line(span.from, Some(span.bus), node, text, tone))
            }
            Change::Recovered(node, since, took) => {
                let what = match (self.plan.scope(), since) {
                    (Scope::Mission, _) => "commands and telemetry flow again",
                    (Scope::Protocol, Since::Loss) => "operational",
                    (Scope::Protocol, Since::Cut) => "operational on the other bus",
                };
                let text = format!("{what}, {} after {}", milliseconds(took), since.name());
                Some(line(now, None, node, text, Tone::Good))
            }
            Change::TookOver(takeover) => {
                let (took, from) = (milliseconds(takeover.took()), name(takeover.from));
                let text = format!("takes over, {took} after the last heartbeat of {from}");
                Some(line(now, None, takeover.to, text, Tone::Warning))
            }
        }
    }
}

impl Traffic {
    fn count(&mut self, message: Option<Meaning>) {
        match message {
            Some(Meaning::Telecommand { .. }) => self.commands += 1,
            Some(Meaning::TelemetryRequest { .. }) => self.requests += 1,
            Some(Meaning::Telemetry { node, code, value }) => {
                self.replies += 1;
                self.latest.insert(code, (node, value));
            }
            Some(Meaning::Pdo) => self.pdos += 1,
            Some(Meaning::Sdo { .. }) => self.sdos += 1,
            Some(Meaning::Heartbeat { .. }) => self.heartbeats += 1,
            _ => {}
        }
    }
}

/// Formats a time span.
pub fn milliseconds(span: Time) -> String {
    format!("{:.1} ms", span.as_secs_f64() * 1e3)
}

/// Makes a line about a fault of the demo.
fn fault(at: Time, bus: Option<Bus>, text: &str) -> Line {
    let text = format!("===== {text} =====");
    Line { at, bus, who: String::new(), text, tone: Tone::Bad, topic: Topic::Event }
}

fn line(at: Time, bus: Option<Bus>, node: Node, text: impl Into<String>, tone: Tone) -> Line {
    Line { at, bus, who: name(node), text: text.into(), tone, topic: Topic::Event }
}

#[cfg(test)]
mod tests {
    use can_twin::wire::frame::WireFrame;

    use super::*;
    use crate::fly::record::Nodes;
    use crate::fly::sample;

    /// Narrates a frame of the master. Each line begins with its board.
    fn on(narrator: &mut Narrator, ms: u64, bus: Bus, id: u16, data: &[u8]) -> Vec<String> {
        texts(narrator, &sample::frame(ms, bus, MASTER, id, data, &[]))
    }

    fn texts(narrator: &mut Narrator, record: &Occurrence) -> Vec<String> {
        narrator.narrate(record, &[]).into_iter().map(|line| format!("{}: {}", line.who, line.text)).collect()
    }

    #[test]
    fn the_switch_is_told_once_with_its_delay() {
        let mut narrator = Narrator::new(&sample::plan());
        let beat = |narrator: &mut Narrator, ms, bus| on(narrator, ms, bus, 0x701, &[0x05]);
        let first = beat(&mut narrator, 100, Bus::Nominal);
        assert_eq!(first, ["master: heartbeat on the nominal bus: it is the active one"]);
        assert_eq!(beat(&mut narrator, 350, Bus::Nominal), [""; 0]);
        let cut = sample::at(500, FlightEvent::Cut(sample::plan().cut().expect("a cut")));
        assert_eq!(texts(&mut narrator, &cut), [": ===== the nominal bus is cut next to the master ====="]);
        let moved = beat(&mut narrator, 612, Bus::Redundant);
        assert_eq!(moved, ["master: heartbeat moved to the redundant bus, 112.0 ms after the cut"]);
        assert_eq!(beat(&mut narrator, 862, Bus::Redundant), [""; 0]);
    }

    #[test]
    fn traffic_is_summed_up_every_five_seconds() {
        let mut narrator = Narrator::new(&sample::plan());
        let frames: [(_, _, &[u8]); 3] =
            [(10, 0x302, &[1, 0]), (20, 0x402, &[3, 1]), (21, 0x382, &[3, 1, 99])];
        for (ms, id, data) in frames {
            assert_eq!(on(&mut narrator, ms, Bus::Nominal, id, data), [""; 0], "{id:03X}h");
        }
        let sum = [": in the last 5 s: 1 TC, 1 TM requests, 1 TM replies; node 2: 99 commands executed"];
        assert_eq!(on(&mut narrator, 5001, Bus::Nominal, 0x080, &[]), sum);
    }

    #[test]
    fn traffic_of_unknown_images_is_counted_not_read() {
        let mut plan = sample::plan();
        plan.boards[1].own_image = Some("own".into());
        let mut narrator = Narrator::new(&plan);
        let mut on = |ms, id, data: &[u8]| {
            let frame = WireFrame::standard(id, data);
            let seen = Seen::new(Bus::Nominal, frame, Scope::Protocol, 1, Nodes::default());
            texts(&mut narrator, &sample::at(ms, FlightEvent::Frame(seen)))
        };
        for id in [0x302, 0x382, 0x283] {
            assert_eq!(on(10, id, &[1, 0, 0]), [""; 0]);
        }
        assert_eq!(on(20, 0x603, &[0; 8]), [""; 0]);
        assert_eq!(on(30, 0x703, &[5]), [""; 0]);
        let expected = [": in the last 5 s: 1 heartbeats, 3 PDOs, 1 frames of SDOs"];
        assert_eq!(on(5001, 0x080, &[]), expected);
    }

    /// Given an emergency three times, then its end, then the emergency again, then the repeats are one line of the interval.
    #[test]
    fn repeated_emergencies_are_one_line() {
        let mut narrator = Narrator::new(&sample::plan());
        let message = [0x30, 0x81, 0x11, 1, 0, 0, 0, 0];
        let mut on =
            |ms, data: &[u8]| texts(&mut narrator, &sample::frame(ms, Bus::Nominal, 2, 0x082, data, &[1]));
        let first = ["node 2: emergency 8130h: heartbeat lost"];
        assert_eq!(on(100, &message), first);
        assert_eq!(on(200, &message), [""; 0]);
        assert_eq!(on(300, &message), [""; 0]);
        let again = "node 2: emergency 8130h again: 2 times in the last 5 s";
        assert_eq!(on(5_001, &[0; 8]), [again, "node 2: emergency 0000h: error ended, or no error"]);
        assert_eq!(on(5_100, &message), first);
        assert_eq!(on(10_001, &message), [""; 0], "no repeats before 10 s");
    }

    #[test]
    fn network_management_is_told_in_words() {
        let mut narrator = Narrator::new(&sample::plan());
        let command = on(&mut narrator, 1, Bus::Redundant, 0x000, &[0x80, 3]);
        assert_eq!(command, ["master: NMT enter pre-operational: node 3"]);
        assert_eq!(on(&mut narrator, 2, Bus::Nominal, 0x703, &[0]), ["node 3: boot-up"]);
    }

    #[test]
    fn first_claim_on_each_bus_is_reported() {
        let mut narrator = Narrator::new(&sample::plan());
        for (ms, bus) in [(100, Bus::Nominal), (300, Bus::Redundant)] {
            let expected = [format!("master: first claim on the {bus} bus: it is the active master")];
            assert_eq!(on(&mut narrator, ms, bus, 0x680, &[2, 0]), expected, "{bus}");
            assert_eq!(on(&mut narrator, ms + 100, bus, 0x680, &[2, 0]), [""; 0], "{bus}");
        }
    }

    /// Given a cut and then the loss of the master, then each recovery time is measured from its own fault.
    #[test]
    fn times_name_the_fault_that_they_are_measured_from() {
        let mut narrator = Narrator::new(&sample::plan());
        let loss = sample::at(900, FlightEvent::PowerOff(MASTER));
        let changes = [Since::Cut, Since::Loss].map(|since| Change::Recovered(2, since, Time::from_ms(400)));
        let lines = narrator.narrate(&loss, &changes);
        let texts: Vec<&str> = lines.iter().map(|line| line.text.as_str()).collect();
        let expected = [
            "===== master loses its power =====",
            "commands and telemetry flow again, 400.0 ms after the cut",
            "commands and telemetry flow again, 400.0 ms after the loss of the master",
        ];
        assert_eq!(texts, expected);
    }
}
