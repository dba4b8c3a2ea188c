//! Narrates a flight for people, line by line: what changed, not every frame.

use std::collections::BTreeMap;

use can_wire::time::Time;
use console::{Style, style};

use super::meaning::{Meaning, NmtState, Scope};
use super::observer::Change;
use super::record::{Bus, Happening, Level, MASTER, Node, Occurrence, SECOND_MASTER, Seen, is_master};
use super::telemetry;
use super::track::Phase;

/// How often the traffic in between is summed up.
const SUMMARY_EVERY: Time = Time::from_ms(5000);

/// A line of the story.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// When.
    pub at: Time,
    /// The bus it happened on, if it did.
    pub bus: Option<Bus>,
    /// Who, for people: "master", "node 3", or empty.
    pub who: String,
    /// What.
    pub text: String,
    /// How it should look.
    pub tone: Tone,
}

/// How a line should look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// As it is.
    Plain,
    /// In the background.
    Quiet,
    /// Good news.
    Good,
    /// Look here.
    Warning,
    /// Bad news.
    Bad,
}

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
    scope: Scope,
    traffic: Traffic,
    next_summary: Time,
    summaries: usize,
    master_bus: Option<Bus>,
    /// When the cut was made, or the master lost its power.
    cut: Option<Time>,
    lost_master: bool,
}

/// A node's name in the story.
pub fn name(node: Node) -> String {
    match node {
        MASTER => "master".into(),
        SECOND_MASTER => "master 2".into(),
        slave => format!("node {slave}"),
    }
}

impl Narrator {
    /// At the start of a flight.
    pub fn new(scope: Scope) -> Self {
        Narrator {
            scope,
            traffic: Traffic::default(),
            next_summary: SUMMARY_EVERY,
            summaries: 0,
            master_bus: None,
            cut: None,
            lost_master: false,
        }
    }

    /// The lines for one record and what the observer made of it.
    pub fn narrate(&mut self, record: &Occurrence, changes: &[Change]) -> Vec<Line> {
        let mut lines = Vec::new();
        if record.at >= self.next_summary {
            lines.extend(self.sum_up());
        }
        match &record.what {
            Happening::PowerOn(node) => lines.push(line(record.at, None, *node, "power on", Tone::Quiet)),
            Happening::PowerOff(node) => {
                (self.cut, self.lost_master) = (Some(record.at), true);
                let text = format!("===== {} loses its power =====", name(*node));
                lines.push(Line { who: String::new(), ..line(record.at, None, *node, text, Tone::Bad) });
            }
            Happening::Cut(bus) => {
                self.cut = Some(record.at);
                lines.push(Line {
                    at: record.at,
                    bus: Some(*bus),
                    who: String::new(),
                    text: format!("===== the {} bus is cut next to the master =====", bus.name()),
                    tone: Tone::Bad,
                });
            }
            Happening::Log { node, level, text } => {
                let tone = match level {
                    Level::Info => Tone::Quiet,
                    Level::Warn => Tone::Warning,
                    Level::Error => Tone::Bad,
                };
                lines.push(line(record.at, None, *node, format!("log: {text}"), tone));
            }
            Happening::Frame(seen) => self.on_frame(record.at, seen, &mut lines),
        }
        lines.extend(changes.iter().filter_map(|change| self.on_change(record.at, change)));
        lines
    }

    fn on_frame(&mut self, at: Time, seen: &Seen, lines: &mut Vec<Line>) {
        let mut say = |node, text: String, tone| lines.push(line(at, Some(seen.bus), node, text, tone));
        self.traffic.count(seen.meaning);
        match seen.meaning {
            Some(Meaning::BootUp { node }) => say(seen.board(node), "boot-up".into(), Tone::Plain),
            Some(Meaning::Nmt { command, node }) => {
                let whom = if node == 0 { "all nodes".into() } else { name(node) };
                say(seen.board(MASTER), format!("NMT {command}: {whom}"), Tone::Plain);
            }
            Some(Meaning::Emergency { node, code }) => {
                say(seen.board(node), format!("emergency {code:04X}h"), Tone::Warning)
            }
            Some(Meaning::SpacecraftTime(scet)) => {
                say(seen.board(MASTER), format!("distributes spacecraft time {scet}"), Tone::Quiet);
            }
            Some(Meaning::Heartbeat { node: MASTER, .. }) => {
                let before = self.master_bus.replace(seen.bus);
                if before != Some(seen.bus) {
                    let text = match (before, self.cut) {
                        (None, _) => {
                            format!("heartbeat on the {} bus: it is the active one", seen.bus.name())
                        }
                        (Some(_), None) => format!("heartbeat moved to the {} bus", seen.bus.name()),
                        (Some(_), Some(cut)) => format!(
                            "heartbeat moved to the {} bus, {} after the cut",
                            seen.bus.name(),
                            milliseconds(at.since(cut))
                        ),
                    };
                    say(seen.board(MASTER), text, if before.is_none() { Tone::Plain } else { Tone::Warning });
                }
            }
            Some(
                Meaning::Sync
                | Meaning::LocalTime { .. }
                | Meaning::Heartbeat { .. }
                | Meaning::Telecommand { .. }
                | Meaning::TelemetryRequest { .. }
                | Meaning::Telemetry { .. }
                | Meaning::CyclicState { .. }
                | Meaning::Pdo
                | Meaning::Sdo { .. },
            ) => {}
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
        let counts = match self.scope {
            Scope::Mission => {
                let Traffic { commands, requests, replies, latest, .. } = traffic;
                // Another request each time, so that every kind of telemetry appears.
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
        })
    }

    fn on_change(&self, now: Time, change: &Change) -> Option<Line> {
        match *change {
            Change::Now(_, span) if matches!(span.phase, Phase::Off | Phase::Starting) => None,
            // The master's own state and bus show in its messages.
            Change::Now(node, span) if is_master(node) => {
                (span.phase == Phase::Standby && self.cut.is_none()).then(|| {
                    let text =
                        format!("standby on the {} bus: silent, the other master is active", span.bus.name());
                    line(span.from, Some(span.bus), node, text, Tone::Plain)
                })
            }
            Change::Now(node, span) => {
                let tone = match span.phase {
                    Phase::Nmt(NmtState::Operational) => Tone::Good,
                    Phase::Silent => Tone::Warning,
                    _ => Tone::Plain,
                };
                let text = format!("{} on the {} bus", span.phase.name(), span.bus.name());
                Some(line(span.from, Some(span.bus), node, text, tone))
            }
            Change::Recovered(node, took) => {
                let what = match self.scope {
                    Scope::Mission => "commands and telemetry flow again",
                    Scope::Protocol if self.lost_master => "operational",
                    Scope::Protocol => "operational on the other bus",
                };
                let since = if self.lost_master { "the loss of the master" } else { "the cut" };
                let text = format!("{what}, {} after {since}", milliseconds(took));
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

fn milliseconds(span: Time) -> String {
    format!("{:.1} ms", span.as_secs_f64() * 1e3)
}

fn line(at: Time, bus: Option<Bus>, node: Node, text: impl Into<String>, tone: Tone) -> Line {
    Line { at, bus, who: name(node), text: text.into(), tone }
}

impl Line {
    /// For a terminal, with colours where it has them.
    pub fn styled(&self) -> String {
        let seconds = format!("{:>10.4} s", self.at.as_secs_f64());
        let bus = match self.bus {
            Some(bus) => style(format!("{:<9}", bus.name())).fg(match bus {
                Bus::Nominal => console::Color::Blue,
                _ => console::Color::Magenta,
            }),
            None => style(" ".repeat(9)),
        };
        let tone = match self.tone {
            Tone::Plain => Style::new(),
            Tone::Quiet => Style::new().dim(),
            Tone::Good => Style::new().green(),
            Tone::Warning => Style::new().yellow(),
            Tone::Bad => Style::new().red().bold(),
        };
        format!("{}  {bus}  {:<8}  {}", style(seconds).dim(), self.who, tone.apply_to(&self.text))
    }
}

#[cfg(test)]
mod tests {
    use can_wire::frame::WireFrame;

    use super::*;
    use crate::record::Nodes;

    fn frame(ms: u64, bus: Bus, id: u16, data: &[u8]) -> Occurrence {
        let frame = WireFrame::standard(id, data);
        record(ms, Seen::new(bus, frame, Scope::Mission, 1, Nodes::default()))
    }

    fn record(ms: u64, seen: Seen) -> Occurrence {
        Occurrence { at: Time::from_ms(ms), what: Happening::Frame(seen) }
    }

    fn texts(narrator: &mut Narrator, record: &Occurrence) -> Vec<String> {
        narrator.narrate(record, &[]).into_iter().map(|line| format!("{}: {}", line.who, line.text)).collect()
    }

    #[test]
    fn the_switch_is_told_once_with_its_delay() {
        let mut narrator = Narrator::new(Scope::Mission);
        let beat = |ms, bus| frame(ms, bus, 0x701, &[0x05]);
        let first = texts(&mut narrator, &beat(100, Bus::Nominal));
        assert_eq!(first, ["master: heartbeat on the nominal bus: it is the active one"]);
        assert!(texts(&mut narrator, &beat(350, Bus::Nominal)).is_empty());
        narrator.narrate(&Occurrence { at: Time::from_ms(500), what: Happening::Cut(Bus::Nominal) }, &[]);
        assert_eq!(
            texts(&mut narrator, &beat(612, Bus::Redundant)),
            ["master: heartbeat moved to the redundant bus, 112.0 ms after the cut"]
        );
        assert!(texts(&mut narrator, &beat(862, Bus::Redundant)).is_empty());
    }

    #[test]
    fn traffic_is_summed_up_every_five_seconds() {
        let mut narrator = Narrator::new(Scope::Mission);
        assert!(texts(&mut narrator, &frame(10, Bus::Nominal, 0x302, &[1, 0])).is_empty());
        assert!(texts(&mut narrator, &frame(20, Bus::Nominal, 0x402, &[3, 1])).is_empty());
        assert!(texts(&mut narrator, &frame(21, Bus::Nominal, 0x382, &[3, 1, 99])).is_empty());
        assert_eq!(
            texts(&mut narrator, &frame(5001, Bus::Nominal, 0x080, &[])),
            [": in the last 5 s: 1 TC, 1 TM requests, 1 TM replies; node 2: 99 commands executed"]
        );
    }

    #[test]
    fn traffic_of_unknown_images_is_counted_not_read() {
        let mut narrator = Narrator::new(Scope::Protocol);
        let mut on = |ms, id, data: &[u8]| {
            let frame = WireFrame::standard(id, data);
            let seen = Seen::new(Bus::Nominal, frame, Scope::Protocol, 1, Nodes::default());
            texts(&mut narrator, &record(ms, seen))
        };
        for id in [0x302, 0x382, 0x283] {
            assert_eq!(on(10, id, &[1, 0, 0]), [""; 0]);
        }
        assert_eq!(on(20, 0x603, &[0; 8]), [""; 0]);
        assert_eq!(on(30, 0x703, &[5]), [""; 0]);
        let expected = [": in the last 5 s: 1 heartbeats, 3 PDOs, 1 frames of SDOs"];
        assert_eq!(on(5001, 0x080, &[]), expected);
    }

    #[test]
    fn network_management_is_told_in_words() {
        let mut narrator = Narrator::new(Scope::Mission);
        assert_eq!(
            texts(&mut narrator, &frame(1, Bus::Redundant, 0x000, &[0x80, 3])),
            ["master: NMT enter pre-operational: node 3"]
        );
        assert_eq!(texts(&mut narrator, &frame(2, Bus::Nominal, 0x703, &[0])), ["node 3: boot-up"]);
    }
}
