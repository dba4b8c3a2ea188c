//! Master boards of a mission: one, or two of which one is the standby of the other.

use core::fmt::Debug;

use crate::redundancy::{Pair, Standby, Strap};
use crate::types::Canonical;

/// Master boards of a mission. The image of a mission with one board has no code for a standby.
pub trait MasterBoards: Debug + Canonical<Context = ()> + 'static {
    /// Returns the role of this board. `None`: the mission has one master board.
    fn standby(&self) -> Option<&Standby>;

    /// Returns the role of this board, to be changed. `None`: the mission has one master board.
    fn standby_mut(&mut self) -> Option<&mut Standby>;
}

/// One master board, which is active at power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Canonical)]
pub struct OneBoard;

/// Two master boards (ECSS 8.1a, Figure 4-2), if the profile has numbers for them.
#[doc(alias("standby master", "redundant master"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct TwoBoards(Option<Standby>);

impl TwoBoards {
    /// Makes the board with this strap, before power-on. Without a `pair` it is as [`OneBoard`].
    pub fn new(pair: Option<Pair>, strap: Strap) -> TwoBoards {
        TwoBoards(pair.map(|pair| Standby::new(pair, strap)))
    }
}

impl MasterBoards for OneBoard {
    fn standby(&self) -> Option<&Standby> {
        None
    }

    fn standby_mut(&mut self) -> Option<&mut Standby> {
        None
    }
}

impl MasterBoards for TwoBoards {
    fn standby(&self) -> Option<&Standby> {
        self.0.as_ref()
    }

    fn standby_mut(&mut self) -> Option<&mut Standby> {
        self.0.as_mut()
    }
}
