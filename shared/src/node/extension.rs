//! Parts of a node beyond CANopen: the objects of ECSS-E-ST-50-15C and a parameter store, or none.

use core::fmt::Debug;

use super::Spacecraft;
use super::stored::{NoStore, Storage, Stored};
use crate::od::Objects;
use crate::profile::Profile;
use crate::time::TimeService;

/// Parts of a node beyond CANopen. The image of a node has no code for parts that the node does not have.
pub trait Extension: Objects + Debug + Default {
    /// Type of the parameter store.
    type Storage: Storage;

    /// Type of the time service.
    type Time: Debug;

    /// `true`: the node has a clock and its objects.
    const HAS_TIME: bool;

    /// `true`: the node looks for flipped bits in its Node-ID, its COB-IDs and its filters (ECSS 6.10d, k).
    const IS_GUARDED: bool;

    /// Returns the objects of a node of a spacecraft, if the node has them.
    fn spacecraft(&mut self) -> Option<&mut Spacecraft>;

    /// Makes the time service. The clock is not set.
    fn new_time(profile: &Profile) -> Self::Time;

    /// Returns the time service, if the node has one.
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

/// Extension of a node that has CANopen only.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct CanopenOnly {}

impl Extension for CanopenOnly {
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
