//! One node of a wire: its engine, and the line at its position.

use crate::wire::controller::Attachment;
use crate::wire::fault::Effect;
use crate::wire::fine::Fine;
use crate::wire::frame::WireFrame;
use crate::wire::mac::{DOMINANT, Mac, RECESSIVE};
use crate::wire::time::Time;
use crate::wire::transceiver::Transceiver;

/// Drivers of a wire, one bit each.
pub(in crate::wire) type Drivers = u128;

/// Most nodes of one wire.
pub(in crate::wire) const MOST_NODES: usize = Drivers::BITS as usize;

#[derive(Clone, Debug)]
pub(in crate::wire) struct Node {
    pub(in crate::wire) mac: Mac,
    pub(in crate::wire) position_m: f64,
    /// Propagation delay from the left end.
    pub(in crate::wire) offset: Fine,
    /// Delay from its output to the line, and from the line to its input.
    pub(in crate::wire) driver: Fine,
    pub(in crate::wire) receiver: Fine,
    /// Dominant drivers that have arrived here.
    pub(in crate::wire) seen: Drivers,
    /// The level at its RX pin.
    pub(in crate::wire) level: bool,
    /// Its driver is dominant for the node itself.
    pub(in crate::wire) driving: bool,
    /// Its driver is dominant for other nodes. A silent node drives only itself.
    pub(in crate::wire) driving_others: bool,
    /// Instant of the last change of either.
    pub(in crate::wire) drove_at: Fine,
    /// Level of a shorted piece of cable.
    pub(in crate::wire) short: Option<bool>,
    /// Disturbances in progress.
    pub(in crate::wire) glitch: Glitching,
    pub(in crate::wire) condition: Condition,
    /// Records level changes for its controller.
    pub(in crate::wire) watches: bool,
    /// Level changes not yet reported, in chronological order.
    pub(in crate::wire) changes: Vec<(Time, bool)>,
}

/// Disturbances in progress at one node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::wire) struct Glitching {
    pub(in crate::wire) inverted: u32,
    pub(in crate::wire) dominant: u32,
    pub(in crate::wire) recessive: u32,
}

impl Glitching {
    /// Returns the number of active disturbances with this effect.
    pub(in crate::wire) fn of(&mut self, effect: Effect) -> &mut u32 {
        match effect {
            Effect::Invert => &mut self.inverted,
            Effect::Dominant => &mut self.dominant,
            Effect::Recessive => &mut self.recessive,
        }
    }
}

/// Lasting faults of one node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::wire) struct Condition {
    /// Its stub is open.
    pub(in crate::wire) disconnected: bool,
    pub(in crate::wire) unpowered: bool,
    /// Its driver is stuck dominant.
    pub(in crate::wire) stuck_dominant: bool,
    /// It sends this frame continuously instead of its controller's frames.
    pub(in crate::wire) babbles: Option<WireFrame>,
    /// Additional frequency error of its oscillator, in parts per billion; positive: fast.
    pub(in crate::wire) drift_ppb: i32,
}

impl Condition {
    /// Returns how a controller takes part that requests `asked`, with these faults.
    pub(in crate::wire) fn bends(&self, asked: Attachment) -> Option<Attachment> {
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
    pub(in crate::wire) fn new(position_m: f64, offset: Fine, transceiver: Transceiver) -> Self {
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
    pub(in crate::wire) fn wants_to_drive(&self) -> bool {
        let stuck = self.condition.stuck_dominant && !self.condition.unpowered;
        stuck || self.mac.drives()
    }

    /// Returns the level at its receiver.
    pub(in crate::wire) fn line(&self) -> bool {
        let bus = self.short.unwrap_or(self.seen == 0);
        let forced = match self.glitch {
            Glitching { dominant: 1.., .. } => DOMINANT,
            Glitching { recessive: 1.., .. } => RECESSIVE,
            _ => bus,
        };
        forced != (self.glitch.inverted % 2 == 1)
    }

    /// Returns whether neither a short nor a disturbance is active.
    pub(in crate::wire) fn is_undisturbed(&self) -> bool {
        self.short.is_none() && self.glitch == Glitching::default() && !self.condition.stuck_dominant
    }

    /// Delay from its output to the input of another node or of itself.
    pub(in crate::wire) fn path_to(&self, other: &Node) -> Fine {
        self.driver + Fine(self.offset.0.abs_diff(other.offset.0)) + other.receiver
    }

    pub(in crate::wire) fn record_change(&mut self, at: Fine, level: bool) {
        if self.watches {
            self.changes.push((at.floor(), level));
        }
    }
}
