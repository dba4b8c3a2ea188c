//! Trying the other bus for a few slaves that are heard only there.

use super::peers::NodeSet;
use crate::types::Instant;

/// One try at a time, and none again while the same slaves stay silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Trial {
    running: Option<Running>,
    /// Slaves that were silent on the bus where the last try ended.
    settled: Option<NodeSet>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Running {
    /// Slaves that were silent on the bus left, and how many were heard there.
    silent: NodeSet,
    heard: u32,
    verdict: Instant,
}

impl Trial {
    pub const fn new() -> Trial {
        Trial { running: None, settled: None }
    }

    /// Whether the other bus may be tried while these slaves are silent.
    pub fn is_allowed(&self, silent: NodeSet) -> bool {
        self.running.is_none() && self.settled != Some(silent)
    }

    /// The other bus becomes active; it is judged at `verdict`.
    pub fn begin(&mut self, silent: NodeSet, heard: u32, verdict: Instant) {
        self.running = Some(Running { silent, heard, verdict });
    }

    /// The bus changes for another reason.
    pub fn abandon(&mut self) {
        if let Some(running) = self.running.take() {
            self.settled = Some(running.silent);
        }
    }

    /// Ends a try that is due, given what is heard and silent on the bus tried. `true`: fewer slaves than before, go
    /// back. A tie stays.
    pub fn judge(&mut self, now: Instant, silent: NodeSet, heard: u32) -> Option<bool> {
        let running = self.running.take_if(|running| running.verdict <= now)?;
        let is_worse = heard < running.heard;
        self.settled = Some(if is_worse { running.silent } else { silent });
        Some(is_worse)
    }
}
