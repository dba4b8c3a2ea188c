//! Commands to a running spacecraft: typed, over the control port, or planned as faults of a flight.

mod act;
mod damage;
pub mod load;
mod status;

use std::fmt;
use std::str::FromStr;

pub use act::Operator;
use can_twin::spacecraft::Bus;
use can_twin::wire::frame::{WireFrame, WireId};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Parser, Subcommand, ValueEnum};

use crate::images::support::node::Node;

/// One line.
#[derive(Debug, Parser)]
#[command(multicall = true, disable_help_flag = true)]
struct Line {
    #[command(subcommand)]
    command: Command,
}

/// What to do to the spacecraft.
#[derive(Clone, Debug, PartialEq, Subcommand)]
pub enum Command {
    /// Break the cable of a bus
    Cut {
        #[arg(value_parser = bus())]
        bus: Bus,
        /// Metres from the master's end; a board at this place is behind the break
        #[arg(value_parser = metres, allow_negative_numbers = true)]
        metres: f64,
    },
    /// Mend the cable of a bus: the break at this place, or every one
    Heal {
        #[arg(value_parser = bus())]
        bus: Bus,
        /// Metres from the master's end, as they were given for the cut
        #[arg(value_parser = metres, allow_negative_numbers = true)]
        metres: Option<f64>,
    },
    /// Hold a bus at one level
    Short {
        #[arg(value_parser = bus())]
        bus: Bus,
        /// Metres from the master's end: where the cable is broken, the piece here is meant
        #[arg(value_parser = metres, allow_negative_numbers = true)]
        metres: f64,
        #[arg(value_enum, default_value_t = Level::Dominant)]
        level: Level,
    },
    /// End every short of a bus
    Clear {
        #[arg(value_parser = bus())]
        bus: Bus,
    },
    /// Give a board power, or take it away
    Power {
        node: Node,
        #[arg(value_enum)]
        to: Switch,
    },
    /// Pull the reset pin of a board
    Reset { node: Node },
    /// Invert a bit of the next frame
    Flip {
        #[arg(value_parser = bus())]
        bus: Bus,
        /// Counted from the start of the frame, which is 0; stuff bits count
        #[arg(value_parser = clap::value_parser!(u8).range(0..=159))]
        bit: u8,
        /// Boards that see it inverted; none: all
        nodes: Vec<Node>,
    },
    /// Let a board send a frame whenever the bus is free, in place of its own
    Babble {
        node: Node,
        #[arg(value_parser = bus())]
        bus: Bus,
        /// As candump writes it: 080#, 701#05
        frame: Payload,
    },
    /// End the babbling of a board
    Quiet {
        node: Node,
        #[arg(value_parser = bus())]
        bus: Bus,
    },
    /// Show boards and buses
    Status,
    /// End the run
    #[command(visible_alias = "exit")]
    Quit,
}

impl Command {
    /// Returns the boards that it names.
    pub fn nodes(&self) -> Vec<Node> {
        match self {
            Command::Power { node, .. }
            | Command::Reset { node }
            | Command::Babble { node, .. }
            | Command::Quiet { node, .. } => vec![*node],
            Command::Flip { nodes, .. } => nodes.clone(),
            _ => Vec::new(),
        }
    }
}

/// Reason why a line is no command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoCommand {
    /// It requests help: this text.
    Help(String),
    /// The error, and the allowed values.
    Mistake(String),
}

impl FromStr for Command {
    type Err = NoCommand;

    fn from_str(line: &str) -> Result<Command, NoCommand> {
        let parsed = Line::try_parse_from(line.split_whitespace());
        parsed.map(|line| line.command).map_err(|error| {
            let text = error.render().to_string().trim_end().to_owned();
            match error.kind() {
                ErrorKind::DisplayHelp => NoCommand::Help(text),
                _ => NoCommand::Mistake(text),
            }
        })
    }
}

/// Returns the parser of a bus on the command line.
fn bus() -> impl TypedValueParser<Value = Bus> {
    let named = |name: String| Bus::ALL.into_iter().find(|bus| bus.name() == name).expect("a possible value");
    PossibleValuesParser::new(Bus::ALL.map(Bus::name)).map(named)
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.to_possible_value().expect("each level has a name").get_name())
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Level {
    Dominant,
    Recessive,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    On,
    Off,
}

/// A data frame with an 11-bit identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Payload(pub WireFrame);

impl fmt::Display for Payload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let WireId::Standard(id) = self.0.id {
            write!(f, "{id:03X}#")?;
        }
        self.0.payload().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

impl FromStr for Payload {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Payload, &'static str> {
        const ALLOWED: &str =
            "give an identifier of 000 to 7FF, # and up to 8 bytes, all hexadecimal: 701#05";
        let (id, data) = text.split_once('#').ok_or(ALLOWED)?;
        let id = u16::from_str_radix(id, 16).ok().filter(|id| *id <= 0x7FF).ok_or(ALLOWED)?;
        if !data.is_ascii() || data.len() > 16 || !data.len().is_multiple_of(2) {
            return Err(ALLOWED);
        }
        let byte = |nth| u8::from_str_radix(&data[nth..nth + 2], 16).map_err(|_| ALLOWED);
        let data = (0..data.len()).step_by(2).map(byte).collect::<Result<Vec<u8>, _>>()?;
        Ok(Payload(WireFrame::standard(id, &data)))
    }
}

fn metres(text: &str) -> Result<f64, &'static str> {
    let allowed = "give metres from the master's end, 0 to 1000";
    text.parse().ok().filter(|metres| (0.0..=1_000.0).contains(metres)).ok_or(allowed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Command, NoCommand> {
        line.parse()
    }

    #[test]
    fn a_line_is_a_command_with_its_words() {
        assert_eq!(parsed("cut nominal 3.5"), Ok(Command::Cut { bus: Bus::Nominal, metres: 3.5 }));
        assert_eq!(parsed("heal redundant"), Ok(Command::Heal { bus: Bus::Redundant, metres: None }));
        assert_eq!(parsed("power 3 off"), Ok(Command::Power { node: 3, to: Switch::Off }));
        let flip = Command::Flip { bus: Bus::Nominal, bit: 12, nodes: vec![2, 3] };
        assert_eq!(parsed(" flip  nominal 12 2 3"), Ok(flip));
        let frame = Payload(WireFrame::standard(0x701, &[5]));
        let babble = Command::Babble { node: 2, bus: Bus::Nominal, frame };
        assert_eq!(parsed("babble 2 nominal 701#05"), Ok(babble));
    }

    #[test]
    fn what_is_wrong_is_said_with_what_is_allowed() {
        for (line, said) in [
            ("cut", "<METRES>"),
            ("cut third 3", "nominal, redundant"),
            ("cut nominal -1", "0 to 1000"),
            ("cut nominal NaN", "0 to 1000"),
            ("power 3 maybe", "on, off"),
            ("flip nominal 160", "0..=159"),
            ("babble 2 nominal 800#", "000 to 7FF"),
            ("babble 2 nominal 080#1", "up to 8 bytes"),
            ("babble 2 nominal 080#\u{e9}\u{e9}", "hexadecimal"),
            ("jump", "unrecognized subcommand"),
            ("", "Usage"),
        ] {
            let NoCommand::Mistake(error) = parsed(line).expect_err(line) else { panic!("{line}: help") };
            assert!(error.contains(said), "{line}: {error}");
        }
    }

    #[test]
    fn help_is_no_mistake() {
        for (line, said) in [("help", "Break the cable of a bus"), ("help cut", "<METRES>")] {
            let NoCommand::Help(text) = parsed(line).expect_err(line) else { panic!("{line}: a mistake") };
            assert!(text.contains(said), "{line}: {text}");
        }
    }

    #[test]
    fn exit_ends_the_run_as_quit_does() {
        assert_eq!([parsed("exit"), parsed("quit")], [Ok(Command::Quit), Ok(Command::Quit)]);
    }
}
