//! What a node has beyond CANopen: the objects of ECSS-E-ST-50-15C and a parameter store, or nothing.

use core::fmt::Debug;

use super::Spacecraft;
use super::services::{NoStore, Storage, Stored};
use crate::od::Objects;

/// Objects beside those of CANopen, and where parameters are kept. What a node does not have costs it nothing: its image holds
/// no code for it.
pub trait Extension: Objects + Debug + Default {
    /// Its parameter store.
    type Storage: Storage;

    /// Whether it has a clock with its objects.
    const HAS_TIME: bool;

    /// The objects of a node of a spacecraft, if it has them.
    fn spacecraft(&mut self) -> Option<&mut Spacecraft>;
}

impl Extension for Spacecraft {
    type Storage = Stored;

    const HAS_TIME: bool = true;

    #[inline(always)]
    fn spacecraft(&mut self) -> Option<&mut Spacecraft> {
        Some(self)
    }
}

/// Nothing beyond CANopen.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct Nothing {}

impl Extension for Nothing {
    type Storage = NoStore;

    const HAS_TIME: bool = false;

    #[inline(always)]
    fn spacecraft(&mut self) -> Option<&mut Spacecraft> {
        None
    }
}
