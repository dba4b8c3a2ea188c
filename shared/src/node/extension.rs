//! What a node has beyond CANopen: the objects of ECSS-E-ST-50-15C and a parameter store, or nothing.

use core::fmt::Debug;

use super::Spacecraft;
use super::services::{NoStore, Storage, Stored};
use crate::od::Objects;
use crate::profile::Profile;
use crate::time::TimeService;

/// Objects beside those of CANopen, and where parameters are kept. What a node does not have costs it nothing: its image holds
/// no code for it.
pub trait Extension: Objects + Debug + Default {
    /// Its parameter store.
    type Storage: Storage;

    /// Its clock and what belongs to it.
    type Time: Debug;

    /// Whether it has a clock with its objects.
    const HAS_TIME: bool;

    /// Whether it looks for flipped bits in its Node-ID, its COB-IDs and its filters (ECSS 6.10d, k).
    const IS_GUARDED: bool;

    /// The objects of a node of a spacecraft, if it has them.
    fn spacecraft(&mut self) -> Option<&mut Spacecraft>;

    /// Its clock, never set.
    fn new_time(profile: &Profile) -> Self::Time;

    /// The time service, if it has one.
    fn time(time: &mut Self::Time) -> Option<&mut TimeService>;
}

impl Extension for Spacecraft {
    type Storage = Stored;

    type Time = TimeService;

    const HAS_TIME: bool = true;

    const IS_GUARDED: bool = true;

    #[inline(always)]
    fn spacecraft(&mut self) -> Option<&mut Spacecraft> {
        Some(self)
    }

    fn new_time(profile: &Profile) -> TimeService {
        TimeService::new(&profile.clocks, profile.network.longest_delay())
    }

    #[inline(always)]
    fn time(time: &mut TimeService) -> Option<&mut TimeService> {
        Some(time)
    }
}

/// Nothing beyond CANopen.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct Nothing {}

impl Extension for Nothing {
    type Storage = NoStore;

    type Time = ();

    const HAS_TIME: bool = false;

    const IS_GUARDED: bool = false;

    #[inline(always)]
    fn spacecraft(&mut self) -> Option<&mut Spacecraft> {
        None
    }

    fn new_time(_: &Profile) {}

    #[inline(always)]
    fn time((): &mut ()) -> Option<&mut TimeService> {
        None
    }
}
