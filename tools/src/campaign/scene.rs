//! Interface of a campaign to a spacecraft, the same in every world.

use can_twin::wire::fault::Fault;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use ecss_can::redundancy::{Parameters, SwitchCause};
use ecss_can::types::{Bus, NmtState, NodeId, PerBus, Scet};
use ecss_can_worlds::NodeKey;

/// A spacecraft of a master, or two, and some slaves on two buses.
pub trait Scene {
    /// Returns the present.
    fn now(&self) -> Time;

    /// Runs to `end`.
    fn run_until(&mut self, end: Time);

    /// Takes the changes of nodes since the last call, in chronological order.
    fn take_news(&mut self) -> Vec<Noted>;

    /// Takes the frames that completed since the last call, for each bus in chronological order.
    fn take_frames(&mut self) -> PerBus<Vec<Sent>>;

    /// Takes the readings of slaves' clocks since the last call, in chronological order.
    fn take_clocks(&mut self) -> Vec<Reading>;

    /// Takes the violations since the last call that only this world detects: commands that slaves executed, panics.
    fn take_wrongs(&mut self) -> Vec<String>;

    /// Returns the slaves without the configuration written by the master.
    fn unconfigured(&self) -> Vec<NodeId> {
        Vec::new()
    }

    /// Returns errors of slaves with power that an active master does not know, or that it considers active although
    /// they have ended: the slave, the master, and the difference.
    fn unknown_errors(&self) -> Vec<(NodeId, NodeKey, String)> {
        Vec::new()
    }

    /// Returns object 2000h of a slave with power; `None` if it is not known.
    fn parameters(&self, _node: NodeId) -> Option<Parameters> {
        None
    }

    /// Returns the number of frames of a bus that were destroyed or not acknowledged so far.
    fn disturbance(&self, bus: Bus) -> u64;

    /// Returns whether the master, the first of two, sends or receives a frame on a bus.
    fn is_busy(&self, bus: Bus) -> bool;

    /// Returns whether a node has power.
    fn is_powered(&self, key: NodeKey) -> bool;

    /// Switches the power of a node.
    fn power(&mut self, key: NodeKey, on: bool);

    /// Resets the chip of a node.
    fn reset(&mut self, key: NodeKey);

    /// Returns the number of nodes, which have the lowest indices on both wires.
    fn nodes(&self) -> usize;

    /// Returns the index of a node on both wires.
    fn index(&self, key: NodeKey) -> usize;

    /// Applies a fault to a bus now, or its end.
    fn strike(&mut self, bus: Bus, fault: Fault);

    /// Makes a foreign node send a frame as soon as possible.
    fn inject(&mut self, bus: Bus, frame: WireFrame);
}

/// A change of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Noted {
    /// Instant of the change.
    pub at: Time,
    /// Node that changed.
    pub key: NodeKey,
    /// The change.
    pub news: News,
}

/// Change of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// Power was switched on, or the chip was reset.
    PowerOn,
    /// Power was switched off.
    PowerOff,
    /// One of two masters became active on this bus, or the standby.
    Role(Option<Bus>),
    /// The master changed the bus.
    Switched {
        /// The bus that it left.
        from: Bus,
        /// The new bus.
        to: Bus,
        /// Cause of the change.
        cause: SwitchCause,
    },
    /// A controller of a master became bus-off, or is on its bus again.
    Hearing {
        /// Its bus.
        bus: Bus,
        /// Whether it is on its bus.
        is_on: bool,
    },
    /// NMT state of a slave.
    State(NmtState),
    /// The bus that a slave considers active.
    ActiveBus(Bus),
    /// The clock of a slave was set.
    ClockSet,
    /// A node received its own Node-ID, or the master its own heartbeat, from another node: EMCY 8150h.
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
    /// Node that sent it; `None` is a foreign node.
    pub key: Option<NodeKey>,
    /// Its 11-bit identifier; `None` for a 29-bit one.
    pub id: Option<u16>,
    /// Number of controllers that received it.
    pub receivers: usize,
}

/// The clock of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Instant of the reading.
    pub at: Time,
    /// Slave of the clock.
    pub node: NodeId,
    /// The spacecraft time that it showed.
    pub scet: Scet,
}

/// Observations of a run so far.
#[derive(Default)]
pub struct Seen {
    /// Changes of nodes, in chronological order.
    pub news: Vec<Noted>,
    /// Frames of each bus, in chronological order.
    pub frames: PerBus<Vec<Sent>>,
}

impl Seen {
    /// Adds the new observations.
    pub fn read(&mut self, scene: &mut impl Scene) {
        self.news.extend(scene.take_news());
        let mut frames = scene.take_frames();
        Bus::ALL.into_iter().for_each(|bus| self.frames[bus].append(&mut frames[bus]));
    }
}
