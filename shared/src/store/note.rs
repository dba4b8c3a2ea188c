//! Note of a slave beside its parameters: the bus where it last found the master.
//!
//! ```text
//! bits 7 to 1   Node-ID
//! bit 0         Bdefault
//! ```
//!
//! A note holds for the node that wrote it, as a set does.

use async_canopen::store;

use super::{Apply, Loaded, ParameterStore, StoreError};
use crate::redundancy::{Redundancy, RedundancyObjects};
use crate::types::{Address, Bus, NodeId};

/// Notes of the Bdefault of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BdefaultNotes;

impl store::machine::Notes for BdefaultNotes {
    const PARAMETER: Address = RedundancyObjects::PARAMETERS.field(Redundancy::BDEFAULT).address();

    fn noted(store: &dyn ParameterStore, node: NodeId) -> Option<u8> {
        noted_bdefault(store, node).map(Bus::bdefault)
    }
}

/// A save that is running, which keeps the noted Bdefault: [`async_canopen::store::machine::Save`].
pub type Save = store::machine::Save<BdefaultNotes>;

/// Applies the stored parameters before communication starts. The noted Bdefault comes last.
///
/// # Errors
/// [`StoreError::Hardware`]. Parameters that were applied before stay.
pub fn load(store: &mut dyn ParameterStore, node: NodeId, apply: &mut Apply) -> Result<Loaded, StoreError> {
    store::machine::load::<BdefaultNotes>(store, node, apply)
}

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
