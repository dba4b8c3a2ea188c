//! Parameters that outlive a reset, as a node uses them: objects 1010h and 1011h (CiA 301 7.5.2.13, 7.5.2.14).

use super::{Group, Loaded, Loss, StoreError};
use crate::od::Objects;
use crate::types::{AbortCode, Address, Instant, NodeId};

/// End of a save or a restore.
pub struct SaveEnd {
    /// Object and sub-index that were written.
    pub at: Address,
    /// Abort code for the client if it failed. Then the set that was stored before stays.
    pub result: Result<(), AbortCode>,
    /// Answer for the client that waits, if it succeeded.
    pub answer: Option<[u8; 8]>,
}

/// Parameter store as a node uses it.
pub trait Storage: core::fmt::Debug + Default {
    /// `false`: the node has no objects 1010h and 1011h.
    const HAS_OBJECTS: bool = true;

    /// Returns whether there is a store.
    fn is_there(&self) -> bool;

    /// Checks the stored set. Returns the loss since the last save, if there is one.
    fn check(&mut self) -> Option<Loss>;

    /// Applies the stored parameters of a group. Numbers are checked by the `rules` of their objects. Returns
    /// `Ok(None)` without a store.
    ///
    /// # Errors
    /// [`StoreError::Hardware`]. Parameters that were applied before stay.
    fn load<D: Objects>(
        &mut self,
        id: NodeId,
        group: Group,
        objects: &mut D,
        rules: impl Fn(&D, Address, u32) -> Result<(), AbortCode>,
    ) -> Result<Option<Loaded>, StoreError>;

    /// Begins to save a group, or to restore its defaults at the next reset. `at` is the object and sub-index of
    /// 1010h or 1011h that was written.
    ///
    /// # Errors
    /// The abort code to answer. Then the set that was stored before stays.
    fn begin(&mut self, id: NodeId, at: Address, now: Instant) -> Result<(), AbortCode>;

    /// Keeps the answer to a client until its save or restore ends. Returns `false` for the answer to another request.
    fn hold(&mut self, answer: &[u8; 8]) -> bool;

    /// Notes that no client waits for the answer of the running save.
    fn drop_answer(&mut self);

    /// Returns when a running save continues.
    fn deadline(&self) -> Option<Instant>;

    /// Continues a running save if that is due. Returns its end.
    fn advance<D: Objects>(&mut self, objects: &mut D, now: Instant) -> Option<SaveEnd>;

    /// Aborts a running save. The set that was stored before stays, and its client gets no answer.
    fn give_up(&mut self);
}

/// Storage of a device that has no parameter store.
#[derive(Debug, Default)]
pub struct NoStore;

impl Storage for NoStore {
    const HAS_OBJECTS: bool = false;

    fn is_there(&self) -> bool {
        false
    }

    fn check(&mut self) -> Option<Loss> {
        None
    }

    fn load<D: Objects>(
        &mut self,
        _: NodeId,
        _: Group,
        _: &mut D,
        _: impl Fn(&D, Address, u32) -> Result<(), AbortCode>,
    ) -> Result<Option<Loaded>, StoreError> {
        Ok(None)
    }

    fn begin(&mut self, _: NodeId, _: Address, _: Instant) -> Result<(), AbortCode> {
        Err(AbortCode::NoObject)
    }

    fn hold(&mut self, _: &[u8; 8]) -> bool {
        false
    }

    fn drop_answer(&mut self) {}

    fn deadline(&self) -> Option<Instant> {
        None
    }

    fn advance<D: Objects>(&mut self, _: &mut D, _: Instant) -> Option<SaveEnd> {
        None
    }

    fn give_up(&mut self) {}
}
