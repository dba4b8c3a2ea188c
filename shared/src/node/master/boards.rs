//! Master boards of a mission: one, or two of which one is the standby of the other.

use core::fmt::Debug;

use super::Master;
use crate::node::Device;
use crate::profile::Profile;
use crate::redundancy::{Standby, Strap};
use crate::store::ParameterStore;

/// Master boards of a mission. The image of a mission with one board has no code for a standby.
pub trait MasterBoards: Debug + 'static {
    /// Returns the role of this board. `None`: the mission has one master board.
    fn standby(&self) -> Option<&Standby>;

    /// Returns the role of this board, to be changed. `None`: the mission has one master board.
    fn standby_mut(&mut self) -> Option<&mut Standby>;
}

/// One master board, which is active at power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct OneBoard;

/// Two master boards (ECSS 8.1a, Figure 4-2), if the profile has numbers for them.
#[doc(alias("standby master", "redundant master"))]
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
    /// Makes one of two masters before power-on. `strap` is the number of the board (ECSS 8.1a, Figure 4-2). The
    /// board listens first, and then becomes active or the standby. With a profile that has no numbers for two
    /// boards ([`Profile::standby`]) it is the same as [`Master::new`].
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
