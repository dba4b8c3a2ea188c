//! A machine under replay: its inputs, its deadline and what it produces.

use ecss_can::link::port::Health;
use ecss_can::types::{Bus, Duration, Frame, Instant, NmtState};

use crate::output::Output;

/// Output of a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Produced {
    /// Instant by the clock of the node.
    pub at: Instant,
    /// The output.
    pub output: Output,
}

impl Produced {
    /// The node sends a frame.
    pub fn frame(at: Instant, bus: Bus, frame: Frame) -> Produced {
        Produced { at, output: Output::Frame(bus, frame) }
    }

    /// The node logs a line.
    pub fn line(at: Instant, line: String) -> Produced {
        Produced { at, output: Output::Line(line) }
    }

    /// The node reports an error.
    pub fn emergency(at: Instant, (code, source): (u16, u8)) -> Produced {
        Produced { at, output: Output::Emergency(code, source) }
    }
}

/// A machine of redundancy, and the parts of the node that its inputs come from.
pub trait Machine {
    /// Loses what does not outlive power.
    fn lose_power(&mut self);
    /// Returns the time from the first line of the program to the start of its node, as measured on the twin: the program
    /// makes the node.
    fn start_delay(&self) -> Duration;
    /// Starts after power-on or a reset of the chip.
    fn start(&mut self, now: Instant);
    /// Does what is due.
    fn poll(&mut self, now: Instant);
    /// Returns when to poll next.
    fn deadline(&self) -> Option<Instant>;
    /// The program took a frame of another node.
    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant);
    /// A frame of the node was acknowledged.
    fn on_sent(&mut self, bus: Bus, frame: &Frame, now: Instant);
    /// The program aborted a frame of the node.
    fn on_aborted(&mut self, bus: Bus, frame: &Frame, now: Instant);
    /// The program requested the transmission of a frame.
    fn on_requested(&mut self, bus: Bus, frame: &Frame, now: Instant);
    /// The program read another state of a controller.
    fn on_health(&mut self, bus: Bus, health: Health, now: Instant);
    /// Returns the bus that the node considers active. `None`: its log does not show it.
    fn bus(&self) -> Option<Bus>;
    /// Returns the NMT state of the node.
    fn state(&self) -> NmtState;
    /// Returns whether a line of the log shows a decision of the machine.
    fn is_of_machine(&self, line: &str) -> bool;
    /// Takes all outputs since the last call.
    fn take_produced(&mut self) -> Vec<Produced>;
}
