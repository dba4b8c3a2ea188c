//! Values of the selector in its canonical form that are more than shifted instants.

use super::{Phase, Selector, Work};
use crate::redundancy::Parameters;
use crate::types::{Instant, PerBus};

impl Selector {
    /// Parameters without a Ctoggle that decides nothing: after a search it only shows the count of that search.
    pub(super) fn counting_parameters(&self) -> Parameters {
        let is_following = matches!(self.phase, Phase::Following { .. });
        Parameters { ctoggle: if is_following { 0 } else { self.parameters.ctoggle }, ..self.parameters }
    }

    /// Work on the buses up to now. Without a contradiction the next move looks only at work after it, so the observation
    /// may as well begin now.
    pub(super) fn observed_work(&self, frames: PerBus<u32>, now: Instant) -> Work {
        let mut work = self.work;
        work.frames = frames;
        if self.moved.is_none_or(|moved| !moved.has_effect(now, &self.parameters)) && self.hold_off.is_none()
        {
            work.restart(now);
        }
        work
    }
}
