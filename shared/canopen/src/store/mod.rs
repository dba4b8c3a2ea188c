//! Parameters that outlive a reset: objects 1010h and 1011h (CiA 301 7.5.2.13, 7.5.2.14).
//!
//! A *set* is the stored parameters of all groups. A *save* writes a whole new set: the present values of one
//! group, and the stored values of the others. So a save is stored whole or not at all. To restore the defaults of
//! a group is to write a set without it. Both take effect at the next reset, when [`load`](machine::load) runs before
//! communication starts.
//!
//! ```
//! use async_canopen::store::{Content, Group, Loaded, ParameterStore, StoreRequest};
//! use async_canopen::store::machine::{NoNotes, Save, load};
//! use async_canopen::types::{Address, NodeId};
//! # use async_canopen::store::{Parameters, Row, StoreError};
//! # #[derive(Default)]
//! # struct Memory { stored: Vec<u8>, begun: Vec<u8> }
//! # impl ParameterStore for Memory {
//! #     fn stored_len(&self) -> usize { self.stored.len() }
//! #     fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<(), StoreError> {
//! #         into.copy_from_slice(&self.stored[offset..][..into.len()]);
//! #         Ok(())
//! #     }
//! #     fn begin(&mut self, _: usize) -> Result<(), StoreError> { self.begun.clear(); Ok(()) }
//! #     fn append(&mut self, bytes: &[u8]) -> Result<(), StoreError> { self.begun.extend(bytes); Ok(()) }
//! #     fn commit(&mut self) -> Result<(), StoreError> { self.stored = std::mem::take(&mut self.begun); Ok(()) }
//! #     fn note(&self) -> Option<u16> { None }
//! #     fn write_note(&mut self, _: u16) -> Result<(), StoreError> { Ok(()) }
//! # }
//! # /// Object 1017h.
//! # struct Values([u8; 2]);
//! # impl Parameters for Values {
//! #     fn find(&mut self, from: Address) -> Option<Row> {
//! #         let at = Address::new(0x1017, 0);
//! #         (from <= at).then_some(Row { at, count: 1, len: 2 })
//! #     }
//! #     fn read(&mut self, _: Address, offset: usize, into: &mut [u8]) -> usize {
//! #         into.copy_from_slice(&self.0[offset..][..into.len()]);
//! #         into.len()
//! #     }
//! # }
//!
//! const NODE: NodeId = NodeId::of::<3>();
//! let (mut store, mut values) = (Memory::default(), Values([100, 0]));
//! let mut save = Save::<NoNotes>::begin(&mut store, NODE, Group::All, StoreRequest::Save)?;
//! while !save.advance(&mut store, &mut values)? {
//!     // The node does its other work between two steps.
//! }
//!
//! let apply = &mut |at: Address, content: Content| {
//!     assert_eq!((at, content), (Address::new(0x1017, 0), Content::Whole(&[100, 0])));
//!     Ok(())
//! };
//! assert_eq!(load::<NoNotes>(&mut store, NODE, apply)?, Loaded::Set { applied: 1, skipped: 0 });
//! # Ok::<(), StoreError>(())
//! ```
//!
//! Three things are kept:
//!
//! | kept | where | ends with |
//! | --- | --- | --- |
//! | set of parameters | [`ParameterStore`] | the next set |
//! | *note*: the newest value of one parameter, see [`Notes`]; none with [`NoNotes`](machine::NoNotes) | one word beside the set | the next set |
//! | Node-ID in three copies | beside both | another Node-ID |
//!
//! # Limits
//!
//! - Each value is stored as it is when its turn comes. A value of more than eight bytes takes several steps. If it
//!   changes between them, it may be stored with bytes of both. If it becomes shorter, the save fails.
//! - A set of another Node-ID is not applied.
//! - [`SaveLimit`](machine::SaveLimit) allows ten saves in a row, then one every six minutes.

mod limit;
pub mod machine;
mod notes;
mod objects;
mod save;
mod set;
pub(crate) mod storage;

pub(crate) use notes::Notes;
pub use objects::{StoreObjects, StoreRequest};
pub use save::{Parameters, Row};
pub use set::{Content, Loaded};

use thiserror::Error;

use crate::types::{AbortCode, NodeId};

/// Signature that a client writes to 1010h to save: "save".
pub const SAVE: u32 = u32::from_le_bytes(*b"save");
/// Signature that a client writes to 1011h to restore defaults: "load".
pub const LOAD: u32 = u32::from_le_bytes(*b"load");

/// Group of parameters: a sub-index of 1010h and 1011h.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Group {
    /// All parameters (sub-index 1).
    All,
    /// Communication profile, 1000h to 1FFFh (sub-index 2).
    Communication,
    /// Device profiles and above, from 6000h on (sub-index 3).
    Application,
    /// Manufacturer-specific objects, 2000h to 5FFFh, and objects below 1000h (sub-index 4).
    Manufacturer,
}

impl Group {
    /// Returns the group of a sub-index. `None` if it has no group.
    pub const fn from_sub(sub: u8) -> Option<Group> {
        Some(match sub {
            1 => Group::All,
            2 => Group::Communication,
            3 => Group::Application,
            4 => Group::Manufacturer,
            _ => return None,
        })
    }

    /// Returns whether the object `index` belongs to the group. Every object belongs to [`Group::All`] and to one
    /// other group.
    pub const fn contains(self, index: u16) -> bool {
        match self {
            Group::All => true,
            Group::Communication => index >> 12 == 1,
            Group::Application => index >= 0x6000,
            Group::Manufacturer => index < 0x6000 && index >> 12 != 1,
        }
    }
}

/// Reason why parameters were not stored, or not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StoreError {
    /// There is no room before the next start, which makes room.
    #[error("the parameter store has no room before the next start")]
    Full,
    /// A value or a set is too long, or a set has another length than announced.
    #[error("a value or a set of parameters is too long, or has another length than announced")]
    Size,
    /// The memory does not hold the bytes that were written, or does not answer.
    #[error("the memory of the parameter store does not hold what was written, or does not answer")]
    Hardware,
}

impl StoreError {
    /// Returns the abort code for the client of the SDO server.
    pub const fn abort_code(self) -> AbortCode {
        match self {
            StoreError::Full => AbortCode::DeviceState,
            StoreError::Size => AbortCode::CannotTransfer,
            StoreError::Hardware => AbortCode::Hardware,
        }
    }
}

/// Reason why parameters that a client saved are not in the store.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Loss {
    /// The last save did not end: power failed, or the memory refused a word. The set before it is stored.
    Interrupted = 1,
    /// A saved set has more flipped bits than can be corrected. The set before it is stored, or none.
    Damaged = 2,
}

/// Store for one set of parameters. A new set replaces the old one when it is committed, or not at all, even if
/// power fails.
#[doc(alias("1010h", "1011h", "store parameters", "restore default parameters", "non-volatile memory"))]
pub trait ParameterStore {
    /// Returns the number of bytes of the stored set, 0 without one.
    fn stored_len(&self) -> usize;

    /// Copies from the stored set, also while another one is being written. `into` must end within the set.
    ///
    /// # Errors
    /// [`StoreError::Size`] beyond the end of the set, [`StoreError::Hardware`].
    fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<(), StoreError>;

    /// Checks the stored set before it is applied. Returns the loss since the last save, if there is one. It was
    /// found at start-up or now. The default implementation reports no loss.
    fn check(&mut self) -> Option<Loss> {
        None
    }

    /// Begins a set of `len` bytes. A set that was begun before and not committed is dropped.
    ///
    /// # Errors
    /// [`StoreError::Full`], [`StoreError::Size`], [`StoreError::Hardware`].
    fn begin(&mut self, len: usize) -> Result<(), StoreError>;

    /// Writes the next bytes of the set that was begun.
    ///
    /// # Errors
    /// [`StoreError::Size`] beyond its length, [`StoreError::Hardware`].
    fn append(&mut self, bytes: &[u8]) -> Result<(), StoreError>;

    /// Commits the set that was begun: from now on it is the stored one.
    ///
    /// # Errors
    /// [`StoreError::Size`] if it is shorter than announced, [`StoreError::Hardware`].
    fn commit(&mut self) -> Result<(), StoreError>;

    /// Returns the last note since the stored set was committed, 0 to FFFh.
    fn note(&self) -> Option<u16>;

    /// Writes a note of 12 bits, which replaces the one before. It is stored at once or not at all, even if power
    /// fails. A set that was begun and not committed is dropped.
    ///
    /// # Errors
    /// [`StoreError::Full`] in the last quarter of the room, which is reserved for sets. [`StoreError::Size`] above
    /// FFFh. [`StoreError::Hardware`].
    fn write_note(&mut self, note: u16) -> Result<(), StoreError>;

    /// Returns the Node-ID that two of three stored copies agree on. `None` for a store without
    /// Node-IDs.
    fn node_id(&mut self) -> Option<NodeId> {
        None
    }

    /// Stores three copies of a Node-ID, or of none, and reads each of them back. The old or the new Node-ID is
    /// stored, even if power fails. A set that was begun and not committed is dropped.
    ///
    /// # Errors
    /// [`StoreError::Full`], [`StoreError::Hardware`]. [`StoreError::Size`] if the store keeps no Node-ID.
    fn store_node_id(&mut self, _id: Option<NodeId>) -> Result<(), StoreError> {
        Err(StoreError::Size)
    }
}
