//! Faults of a flight, each at its time: the commands of `ecss-can twin`, and two faults of the demonstration that depend on
//! which master is active.

use std::str::FromStr;

use can_twin::wire::time::Time;

use super::command::{Command, NoCommand, Switch};
use super::record::{CutPlan, FlightEvent};

/// A fault, or the end of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Time after the start of the flight.
    pub at: Time,
    /// What is done to the spacecraft.
    pub cause: Cause,
    /// Option, or line and key of the mission file, that plans it: for messages.
    pub origin: String,
}

/// What is done to the spacecraft.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// A command of `ecss-can twin`.
    Command(Command),
    /// Resets the standby of two masters.
    ResetStandby,
    /// Takes the power from the active one of two masters.
    LoseActive,
}

impl Fault {
    /// Makes a fault of the demonstration.
    pub fn new(at: Time, cause: Cause) -> Fault {
        Fault { at, cause, origin: "--cut-at".into() }
    }

    /// Makes the cut of a bus.
    pub fn cut(CutPlan { bus, at, position_m }: CutPlan) -> Fault {
        Fault::new(at, Cause::Command(Command::Cut { bus, metres: position_m }))
    }

    /// Returns the cut, if it is one.
    pub fn as_cut(&self) -> Option<CutPlan> {
        match self.cause {
            Cause::Command(Command::Cut { bus, metres }) => {
                Some(CutPlan { bus, at: self.at, position_m: metres })
            }
            _ => None,
        }
    }
}

/// The value of `--fault`: seconds, a blank, and a command.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedCommand {
    /// Virtual seconds after the start.
    pub second: f64,
    /// The command.
    pub command: Command,
    /// Where it was given: for messages.
    pub origin: String,
}

impl FromStr for TimedCommand {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let allowed =
            "give a second of the run and a command of `ecss-can twin`, for example \"5 cut nominal 0.5\"";
        let (second, line) = text.trim().split_once(char::is_whitespace).ok_or(allowed)?;
        let second = second.parse().ok().filter(|second: &f64| second.is_finite() && *second >= 0.0);
        let second = second.ok_or(allowed)?;
        Ok(TimedCommand { second, command: command(line)?, origin: format!("--fault \"{text}\"") })
    }
}

/// Reads a command that may be planned.
///
/// # Errors
/// When it is none: the reason, and what is allowed.
pub fn command(line: &str) -> Result<Command, String> {
    const ALLOWED: &str = "allowed are cut, heal, short, clear, power, reset, flip, babble, quiet";
    match line.parse() {
        Ok(Command::Status | Command::Quit) | Err(NoCommand::Help(_)) => {
            Err(format!("'{line}' is no fault; {ALLOWED}"))
        }
        Ok(command) => Ok(command),
        Err(NoCommand::Mistake(text)) => {
            // Without the usage of a typed line.
            let text = text.split("\n\nUsage").next().unwrap_or_default().trim_start_matches("error: ");
            let text =
                text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ");
            Err(format!("{text}; {ALLOWED}"))
        }
    }
}

/// Returns the event of a command that was executed at `at`; `None` for a command that is no fault.
pub fn event(command: &Command, at: Time) -> Option<FlightEvent> {
    let other = |bus, name, text| FlightEvent::Other { bus, name, text };
    Some(match command {
        Command::Cut { bus, metres } => FlightEvent::Cut(CutPlan { bus: *bus, at, position_m: *metres }),
        Command::Power { node, to: Switch::On } => FlightEvent::PowerOn(*node),
        Command::Power { node, to: Switch::Off } => FlightEvent::PowerOff(*node),
        Command::Reset { node } => FlightEvent::Reset(*node),
        Command::Heal { bus, metres: Some(metres) } => {
            other(*bus, "heal", format!("the {bus} bus is mended at {metres} m"))
        }
        Command::Heal { bus, metres: None } => other(*bus, "heal", format!("the {bus} bus is mended")),
        Command::Short { bus, metres, level } => {
            other(*bus, "short", format!("the {bus} bus is shorted at {metres} m, {level}"))
        }
        Command::Clear { bus } => other(*bus, "clear", format!("the shorts of the {bus} bus end")),
        Command::Flip { bus, bit, nodes } => {
            let of = if nodes.is_empty() { String::new() } else { format!(" for {}", list(nodes)) };
            other(*bus, "flip", format!("bit {bit} of the next frame on the {bus} bus is inverted{of}"))
        }
        Command::Babble { node, bus, frame } => {
            other(*bus, "babble", format!("node {node} babbles {frame} on the {bus} bus"))
        }
        Command::Quiet { node, bus } => {
            other(*bus, "quiet", format!("node {node} ends to babble on the {bus} bus"))
        }
        Command::Status | Command::Quit => return None,
    })
}

fn list(nodes: &[u8]) -> String {
    let nodes: Vec<String> = nodes.iter().map(|node| format!("node {node}")).collect();
    nodes.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::record::Bus;

    #[test]
    fn fault_is_a_second_and_a_command() {
        let fault: TimedCommand = "5.5 heal redundant".parse().unwrap();
        let command = Command::Heal { bus: Bus::Redundant, metres: None };
        assert_eq!((fault.second, fault.command), (5.5, command));
        for (text, said) in [
            ("5", "for example"),
            ("soon cut nominal 1", "for example"),
            ("-1 reset 3", "for example"),
            ("5 quit", "'quit' is no fault"),
            ("5 help", "is no fault"),
            ("5 jump", "allowed are cut, heal"),
            ("5 cut third 3", "nominal, redundant"),
            ("5 cut nominal 2000", "0 to 1000"),
        ] {
            let error = text.parse::<TimedCommand>().unwrap_err();
            assert!(error.contains(said) && !error.contains("Usage"), "{text}: {error}");
        }
    }
}
