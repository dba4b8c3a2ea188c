//! A trace as a table.

use std::fmt;

use ecss_can::types::{Bus, NmtState};
use model::master::Master;
use model::profile::TICK;
use model::station::Station;
use model::watch::Watched;
use model::world::{Fault, Kind, Message, Report, STATIONS, World};
use stateright::Path;

use super::step::Step;

/// Names of the nodes.
const NAMES: [&str; STATIONS] = ["master", "slave 2", "slave 3", "second master"];

/// The path to a state, with a row for each step that changed something.
pub struct Table(pub Vec<(Watched, Option<Step>)>);

impl Table {
    /// Makes the table of a path that the checker found.
    pub fn new(path: Path<Watched, Step>) -> Table {
        Table(path.into_vec())
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let second = if self.0.first().is_some_and(|(state, _)| state.world.masters.len() > 1) {
            NAMES[3]
        } else {
            ""
        };
        let gap = if second.is_empty() { 0 } else { 20 };
        writeln!(
            f,
            "    ms  step                                master              {second:gap$}slave 2, parallel   slave 3, selective  not served"
        )?;
        let (mut at, mut told) = (0, String::new());
        let mut step = String::from("power-on of all nodes");
        for (place, (state, next)) in self.0.iter().enumerate() {
            let now = nodes(&state.world);
            let is_last = place + 1 == self.0.len();
            if now != told || !step.is_empty() || is_last {
                let unserved = u64::from(state.watch.unserved) * TICK.as_millis();
                writeln!(f, "{at:6}  {step:34}  {now}  {unserved:7} ms")?;
            }
            told = now;
            step = match next {
                Some(Step::Tick) => {
                    at += u64::from(state.ticks()) * TICK.as_millis();
                    String::new()
                }
                Some(Step::Fault(fault)) => words(*fault),
                Some(Step::Report(Report::Wrong)) => String::from("error appears"),
                Some(Step::Report(Report::Right)) => String::from("error is gone"),
                Some(Step::Report(Report::Changed)) => String::from("value changes"),
                Some(Step::Calm) => String::from("no more faults"),
                None => String::new(),
            };
        }
        Ok(())
    }
}

fn nodes(world: &World) -> String {
    let masters: Vec<String> = world.masters.iter().map(|it| format!("{:18}", master(it))).collect();
    let slaves = world.slaves.iter().enumerate().map(|(nth, slave)| {
        if !world.is_there(nth + 1) {
            return String::from("not there");
        }
        let given_up = if slave.has_given_up() { " gave up" } else { "" };
        format!("{} {}{given_up}", letter(slave.active()), state(slave.state()))
    });
    let slaves: Vec<String> = slaves.map(|text| format!("{text:18}")).collect();
    format!("{}  {}", masters.join("  "), slaves.join("  "))
}

fn master(master: &Master) -> String {
    let cause = master.switched.map_or(String::new(), |cause| format!(" {cause:?}"));
    let role = if master.is_active() { "" } else { " silent" };
    format!("{}{role}{cause}", letter(master.active()))
}

fn words(fault: Fault) -> String {
    match fault {
        Fault::Cut(bus, place) => format!("{} cut from {}", NAMES[place], letter(bus)),
        Fault::Restore(bus, place) => format!("{} back on {}", NAMES[place], letter(bus)),
        Fault::BusOff(bus) => format!("{} bus-off on {}", NAMES[0], letter(bus)),
        Fault::Request(bus) => format!("master asks for {}", letter(bus)),
        Fault::Hold(place) => format!("master stops {}", NAMES[place]),
        Fault::Choose(bus, place) => format!("{} chooses {}", NAMES[place], letter(bus)),
        Fault::Save(place) => format!("{} saves", NAMES[place]),
        Fault::Silence(place) => format!("{} silenced", NAMES[place]),
        Fault::Reset(place) => format!("{} reset", NAMES[place]),
        Fault::Off(place) => format!("{} without power", NAMES[place]),
        Fault::On(place) => format!("{} has power again", NAMES[place]),
        Fault::Lose(place, Kind::Heartbeat) => format!("{} will lose a heartbeat", NAMES[place]),
        Fault::Lose(place, Kind::Command) => format!("{} will lose a command", NAMES[place]),
        Fault::Foreign(bus, Message::Heartbeat) => format!("foreign master's heartbeat on {}", letter(bus)),
        Fault::Foreign(bus, Message::OfSlave) => format!("foreign slave's heartbeat on {}", letter(bus)),
        Fault::Foreign(bus, Message::OfSlaveLater) => {
            format!("foreign slave's heartbeat on {}, later", letter(bus))
        }
        Fault::Foreign(bus, Message::Command(command)) => format!("foreign {command:?} on {}", letter(bus)),
    }
}

fn letter(bus: Bus) -> &'static str {
    match bus {
        Bus::Nominal => "N",
        Bus::Redundant => "R",
    }
}

fn state(state: NmtState) -> &'static str {
    match state {
        NmtState::Initialising => "initialising",
        NmtState::PreOperational => "pre-op",
        NmtState::Operational => "operational",
        NmtState::Stopped => "stopped",
    }
}
