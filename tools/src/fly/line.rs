//! A line of the story, and its format on a terminal.

use can_twin::wire::time::Time;
use console::{Style, style};

use super::record::Bus;

/// A line of the story.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Virtual time.
    pub at: Time,
    /// Bus to which the line refers, if any.
    pub bus: Option<Bus>,
    /// Name of the board, for example "master" or "node 3"; empty for a line about all of them.
    pub who: String,
    /// Text without time, bus and board.
    pub text: String,
    /// Emphasis of the text.
    pub tone: Tone,
    /// Kind of the line.
    pub topic: Topic,
}

/// Kind of a line, by which the report picks lines for its tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// A change of a node or a bus: power, reset, cut, boot-up, NMT command, state, bus.
    Event,
    /// An emergency message.
    Emergency,
    /// A line that a firmware logged.
    Log,
    /// Routine traffic: spacecraft time, summaries.
    Traffic,
}

/// Emphasis of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// No emphasis.
    Plain,
    /// Dimmed: routine.
    Quiet,
    /// A node works correctly.
    Good,
    /// Unusual.
    Warning,
    /// A fault.
    Bad,
}

impl Line {
    /// Formats the line for a terminal, with colours where it has them.
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
