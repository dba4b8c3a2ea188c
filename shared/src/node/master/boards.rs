//! One master board, or two of which one is the standby of the other.

use core::fmt::Debug;

use super::Master;
use crate::node::Device;
use crate::profile::Profile;
use crate::redundancy::{Standby, Strap};
use crate::store::ParameterStore;

/// Master boards of a mission. What a mission does not have costs it nothing: its image holds no code for it.
pub trait MasterBoards: Debug + 'static {
    /// Which of two boards is active; `None` where there is one.
    fn standby(&self) -> Option<&Standby>;

    /// As [`MasterBoards::standby`], to change it.
    fn standby_mut(&mut self) -> Option<&mut Standby>;
}

/// One master board: active at power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct OneBoard;

/// Two master boards (ECSS 8.1a, Figure 4-2), if the profile has numbers for them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TwoBoards(Option<Standby>);

impl MasterBoards for OneBoard {
    #[inline(always)]
    fn standby(&self) -> Option<&Standby> {
        None
    }

    #[inline(always)]
    fn standby_mut(&mut self) -> Option<&mut Standby> {
        None
    }
}

impl MasterBoards for TwoBoards {
    #[inline(always)]
    fn standby(&self) -> Option<&Standby> {
        self.0.as_ref()
    }

    #[inline(always)]
    fn standby_mut(&mut self) -> Option<&mut Standby> {
        self.0.as_mut()
    }
}

impl<D: Device> Master<D, TwoBoards> {
    /// One of two masters before power-on, `strap` says which one (ECSS 8.1a, Figure 4-2). It listens before it becomes active,
    /// or the standby. In a profile without numbers for two boards ([`Profile::standby`]) it is as [`Master::new`] makes it.
    #[inline(always)] // a copy of a master is 20 kB of stack
    pub fn of_two(
        profile: &Profile,
        strap: Strap,
        device: D,
        store: Option<&'static mut (dyn ParameterStore + Send)>,
    ) -> Self {
        let standby = profile.standby.map(|pair| Standby::new(pair, strap));
        Master::with(TwoBoards(standby), profile, device, store)
    }
}
