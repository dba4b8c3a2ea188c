//! A line of the story, and how a terminal shows it.

use can_wire::time::Time;
use console::{Style, style};

use super::record::Bus;

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
