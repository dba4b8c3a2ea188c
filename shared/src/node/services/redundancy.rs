//! Redundancy parameters in the dictionary (2000h).

use super::{Device, Services};
use crate::redundancy::{Parameters, Redundancy, RedundancyObjects};
use crate::types::{Address, Instant};

const BDEFAULT: Address = RedundancyObjects::PARAMETERS.field(Redundancy::BDEFAULT).address();
const CTOGGLE: Address = RedundancyObjects::PARAMETERS.field(Redundancy::CTOGGLE).address();

impl<D: Device> Services<D> {
    /// Writes the present parameters into 2000h. PDOs that carry a changed Bdefault or Ctoggle become due.
    pub fn show_redundancy(&mut self, parameters: &Parameters, now: Instant) {
        let objects = &mut self.dictionary.objects;
        let before = objects.spacecraft.redundancy.parameters;
        objects.set_redundancy(parameters);
        let after = objects.spacecraft.redundancy.parameters;
        for (at, has_changed) in
            [(BDEFAULT, before.bdefault != after.bdefault), (CTOGGLE, before.ctoggle != after.ctoggle)]
        {
            if has_changed {
                self.dictionary.on_changed(at, now);
            }
        }
    }
}
