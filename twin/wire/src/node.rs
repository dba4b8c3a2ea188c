//! One node of a wire: its engine, and the line at its position.

use crate::controller::Attachment;
use crate::fault::Effect;
use crate::fine::Fine;
use crate::frame::WireFrame;
use crate::mac::{DOMINANT, Mac, RECESSIVE};
use crate::time::Time;
use crate::transceiver::Transceiver;

/// Drivers of a wire, one bit each.
pub(crate) type Drivers = u128;

/// Most nodes of one wire.
pub(crate) const MOST_NODES: usize = Drivers::BITS as usize;

#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) mac: Mac,
    pub(crate) position_m: f64,
    /// Propagation delay from the left end.
    pub(crate) offset: Fine,
    /// Delay from its output to the line, and from the line to its input.
    pub(crate) driver: Fine,
    pub(crate) receiver: Fine,
    /// Dominant drivers that have arrived here.
    pub(crate) seen: Drivers,
    /// The level at its RX pin.
    pub(crate) level: bool,
    /// Its driver is dominant for the node itself.
    pub(crate) driving: bool,
    /// Its driver is dominant for other nodes. A silent node drives only itself.
    pub(crate) driving_others: bool,
    /// Instant of the last change of either.
    pub(crate) drove_at: Fine,
    /// Level of a shorted piece of cable.
    pub(crate) short: Option<bool>,
    /// Disturbances in progress.
    pub(crate) glitch: Glitching,
    pub(crate) condition: Condition,
    /// Records level changes for its controller.
    pub(crate) watches: bool,
    /// Level changes not yet reported, in chronological order.
    pub(crate) changes: Vec<(Time, bool)>,
}

/// Disturbances in progress at one node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Glitching {
    pub(crate) inverted: u32,
    pub(crate) dominant: u32,
    pub(crate) recessive: u32,
}

impl Glitching {
    /// Returns the number of active disturbances with this effect.
    pub(crate) fn of(&mut self, effect: Effect) -> &mut u32 {
        match effect {
            Effect::Invert => &mut self.inverted,
            Effect::Dominant => &mut self.dominant,
            Effect::Recessive => &mut self.recessive,
        }
    }
}

/// Lasting faults of one node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Condition {
    /// Its stub is open.
    pub(crate) disconnected: bool,
    pub(crate) unpowered: bool,
    /// Its driver is stuck dominant.
    pub(crate) stuck_dominant: bool,
    /// It sends this frame continuously instead of its controller's frames.
    pub(crate) babbles: Option<WireFrame>,
    /// Additional frequency error of its oscillator, in parts per billion; positive: fast.
    pub(crate) drift_ppb: i32,
}

impl Condition {
    /// Returns how a controller takes part that requests `asked`, with these faults.
    pub(crate) fn bends(&self, asked: Attachment) -> Option<Attachment> {
        if self.unpowered {
            return None;
        }
        let timing = match self.drift_ppb {
            0 => asked.timing,
            ppb => asked.timing.fast_by(ppb),
        };
        Some(Attachment { timing, ..asked })
    }
}

impl Node {
    pub(crate) fn new(position_m: f64, offset: Fine, transceiver: Transceiver) -> Self {
        let [driver, receiver] = transceiver.delays();
        Node {
            mac: Mac::new(),
            position_m,
            offset,
            driver,
            receiver,
            seen: 0,
            level: RECESSIVE,
            driving: false,
            driving_others: false,
            drove_at: Fine(0),
            short: None,
            glitch: Glitching::default(),
            condition: Condition::default(),
            watches: false,
            changes: Vec::new(),
        }
    }

    /// Returns whether its driver is dominant.
    pub(crate) fn wants_to_drive(&self) -> bool {
        let stuck = self.condition.stuck_dominant && !self.condition.unpowered;
        stuck || self.mac.drives()
    }

    /// Returns the level at its receiver.
    pub(crate) fn line(&self) -> bool {
        let bus = self.short.unwrap_or(self.seen == 0);
        let forced = match self.glitch {
            Glitching { dominant: 1.., .. } => DOMINANT,
            Glitching { recessive: 1.., .. } => RECESSIVE,
            _ => bus,
        };
        forced != (self.glitch.inverted % 2 == 1)
    }

    /// Returns whether neither a short nor a disturbance is active.
    pub(crate) fn is_undisturbed(&self) -> bool {
        self.short.is_none() && self.glitch == Glitching::default() && !self.condition.stuck_dominant
    }

    /// Delay from its output to the input of another node or of itself.
    pub(crate) fn path_to(&self, other: &Node) -> Fine {
        self.driver + Fine(self.offset.0.abs_diff(other.offset.0)) + other.receiver
    }

    pub(crate) fn record_change(&mut self, at: Fine, level: bool) {
        if self.watches {
            self.changes.push((at.floor(), level));
        }
    }
}
