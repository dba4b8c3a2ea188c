//! Trial of the other bus for a few slaves that are heard only there.

use super::peers::NodeSet;
use crate::types::{Bus, Canonical, Instant, PerBus};

/// One try at a time, and from each bus none again while the same slaves stay silent there. Exceptions: the try was a
/// success, or another node sent the heartbeat of the master during it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
pub(super) struct Trial {
    running: Option<Running>,
    /// Slaves that were silent on this bus when it was left for the last try.
    tried: PerBus<Option<NodeSet>>,
    /// Another node sent the heartbeat of the master during the last try from this bus.
    disturbed: PerBus<bool>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
struct Running {
    /// The bus left.
    from: Bus,
    /// Number of slaves that were heard on the bus that was left.
    heard: u32,
    #[canonical(due)]
    verdict: Instant,
}

impl Trial {
    pub const fn new() -> Trial {
        Trial {
            running: None,
            tried: PerBus { nominal: None, redundant: None },
            disturbed: PerBus { nominal: false, redundant: false },
        }
    }

    /// Returns whether the other bus may be tried while these slaves are silent on `bus`.
    pub fn is_allowed(&self, bus: Bus, silent: NodeSet) -> bool {
        self.running.is_none() && self.tried[bus] != Some(silent)
    }

    /// Begins a trial: `bus` is left because of these slaves. The other bus is judged at `verdict`.
    pub fn begin(&mut self, bus: Bus, silent: NodeSet, heard: u32, verdict: Instant) {
        self.running = Some(Running { from: bus, heard, verdict });
        self.tried[bus] = Some(silent);
        self.disturbed[bus] = false;
    }

    /// Notes a heartbeat of the master from another node: it may keep slaves on the bus that was left.
    pub fn on_rival(&mut self) {
        if let Some(running) = self.running {
            self.disturbed[running.from] = true;
        }
    }

    /// Notes that no other node sends the heartbeat of the master any more: a disturbed try may be repeated.
    pub fn on_rivals_silent(&mut self) {
        for bus in Bus::ALL {
            if core::mem::take(&mut self.disturbed[bus]) {
                self.tried[bus] = None;
            }
        }
    }

    /// Ends the trial: the bus changes for another reason.
    pub fn abandon(&mut self) {
        self.running = None;
    }

    /// Ends a trial that is due, with the slaves that are `heard` on the bus that is tried. `true`: they are
    /// fewer than before, so return. A tie stays. More slaves allow another trial if that bus is lost and
    /// returns.
    pub fn judge(&mut self, now: Instant, heard: u32) -> Option<bool> {
        let running = self.running.take_if(|running| running.verdict <= now)?;
        if heard > running.heard {
            self.tried[running.from] = None;
        }
        Some(heard < running.heard)
    }
}
