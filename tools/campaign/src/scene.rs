//! What a campaign sees of a spacecraft and does to it, in every world alike.

use can_wire::fault::Fault;
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use ecss_can::redundancy::{Parameters, SwitchCause};
use ecss_can::types::{Bus, NmtState, NodeId, PerBus, Scet};
use host_worlds::NodeKey;

/// A spacecraft of a master, or two, and some slaves on two buses.
pub trait Scene {
    /// The present.
    fn now(&self) -> Time;

    /// Flies to `end`.
    fn run_until(&mut self, end: Time);

    /// Changes of nodes since the last call, in the order of time.
    fn take_news(&mut self) -> Vec<Noted>;

    /// Frames that completed since the last call, on each bus in the order of time.
    fn take_frames(&mut self) -> PerBus<Vec<Sent>>;

    /// Clocks of slaves since the last call, in the order of time.
    fn take_clocks(&mut self) -> Vec<Reading>;

    /// Violations since the last call that only this world sees: commands that slaves executed, panics.
    fn take_wrongs(&mut self) -> Vec<String>;

    /// Slaves that do not have the configuration that the master gave them.
    fn unconfigured(&self) -> Vec<NodeId> {
        Vec::new()
    }

    /// Errors of slaves with power that an active master does not know, or that it takes for active though they are over: the
    /// slave, the master, and what is wrong.
    fn unknown_errors(&self) -> Vec<(NodeId, NodeKey, String)> {
        Vec::new()
    }

    /// Object 2000h of a slave with power; `None` where it cannot be seen.
    fn parameters(&self, _node: NodeId) -> Option<Parameters> {
        None
    }

    /// Frames of a bus so far that were destroyed or that nobody acknowledged.
    fn disturbance(&self, bus: Bus) -> u64;

    /// Whether the master, the first of two, sends or receives a frame on a bus.
    fn is_busy(&self, bus: Bus) -> bool;

    /// Whether a node has power.
    fn is_powered(&self, key: NodeKey) -> bool;

    /// Switches the power of a node.
    fn power(&mut self, key: NodeKey, on: bool);

    /// Resets the chip of a node.
    fn reset(&mut self, key: NodeKey);

    /// Number of nodes, which have the lowest indices on both wires.
    fn nodes(&self) -> usize;

    /// Index of a node on both wires.
    fn index(&self, key: NodeKey) -> usize;

    /// Lets something go wrong on a bus now, or heals it.
    fn strike(&mut self, bus: Bus, fault: Fault);

    /// A foreign node sends a frame as soon as the bus lets it.
    fn inject(&mut self, bus: Bus, frame: WireFrame);
}

/// A change of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Noted {
    /// When.
    pub at: Time,
    /// On which node.
    pub key: NodeKey,
    /// What.
    pub news: News,
}

/// What changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// Power came, or the chip was reset.
    PowerOn,
    /// Power went.
    PowerOff,
    /// One of two masters became active on this bus, or the standby.
    Role(Option<Bus>),
    /// The master changed the bus.
    Switched {
        /// The bus that it left.
        from: Bus,
        /// The bus where it is now.
        to: Bus,
        /// Why.
        cause: SwitchCause,
    },
    /// A controller of a master is bus-off, and hears nothing, or is on its bus again.
    Hearing {
        /// Its bus.
        bus: Bus,
        /// Whether it hears.
        is_on: bool,
    },
    /// NMT state of a slave.
    State(NmtState),
    /// The bus that a slave considers active.
    ActiveBus(Bus),
    /// The clock of a slave was set.
    ClockSet,
    /// A node heard its own Node-ID, the master its own heartbeat, from somebody else: EMCY 8150h.
    Collision,
    /// Another change of state.
    Other,
}

/// A frame that completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sent {
    /// Falling edge of SOF.
    pub start: Time,
    /// End of EOF.
    pub end: Time,
    /// Who sent it; `None` is a foreign node.
    pub key: Option<NodeKey>,
    /// Its 11-bit identifier; `None` for a 29-bit one.
    pub id: Option<u16>,
    /// Number of controllers that received it.
    pub receivers: usize,
}

/// The clock of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// When it was read.
    pub at: Time,
    /// Whose.
    pub node: NodeId,
    /// The spacecraft time that it showed.
    pub scet: Scet,
}

/// All that was seen of a run so far.
#[derive(Default)]
pub struct Seen {
    /// Changes of nodes, in the order of time.
    pub news: Vec<Noted>,
    /// Frames of each bus, in the order of time.
    pub frames: PerBus<Vec<Sent>>,
}

impl Seen {
    /// Adds what is new.
    pub fn read(&mut self, scene: &mut impl Scene) {
        self.news.extend(scene.take_news());
        let mut frames = scene.take_frames();
        Bus::ALL.into_iter().for_each(|bus| self.frames[bus].append(&mut frames[bus]));
    }
}
