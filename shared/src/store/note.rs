//! Note of a slave beside its parameters: the bus where it last found the master.
//!
//! ```text
//! bits 7 to 1   Node-ID
//! bit 0         Bdefault
//! ```
//!
//! A note holds for the node that wrote it, as a set does.

use super::{ParameterStore, StoreError};
use crate::redundancy::{Redundancy, RedundancyObjects};
use crate::types::{Address, Bus, NodeId};

/// The parameter that a note stands for.
pub(super) const BDEFAULT: Address = RedundancyObjects::PARAMETERS.field(Redundancy::BDEFAULT).address();

/// Returns the Bdefault that `node` noted, if no newer set replaced it.
pub fn noted_bdefault(store: &dyn ParameterStore, node: NodeId) -> Option<Bus> {
    let note = store.note().filter(|note| note >> 1 == node.get().into())?;
    Bus::from_bdefault((note & 1) as u8)
}

/// Writes Bdefault as a note. From now on it has priority over the stored one.
///
/// # Errors
/// [`StoreError::Full`], [`StoreError::Hardware`]. Then the note before stays.
pub fn note_bdefault(store: &mut dyn ParameterStore, node: NodeId, bus: Bus) -> Result<(), StoreError> {
    store.write_note(u16::from(node.get()) << 1 | u16::from(bus.bdefault()))
}
