//! Properties that must hold at all times.

use ecss_can_worlds::judge::Bounds;

use crate::profile::{bounds, ticks, with_round, without_round};
use crate::watch::Watched;

/// A property that must hold in each state.
#[derive(Clone, Copy, Debug)]
pub struct Property {
    /// Name in reports.
    pub name: &'static str,
    /// Returns whether it holds.
    pub holds: fn(&Watched) -> bool,
}

impl PartialEq for Property {
    fn eq(&self, other: &Property) -> bool {
        self.name == other.name
    }
}

/// Each reachable slave is operational on the master's bus.
pub const SERVED: Property = Property {
    name: "slaves in reach are operational within the bound",
    holds: |it| it.watch.unserved <= ticks(bounds().service),
};
/// Slaves that hear the master agree with it on the bus.
pub const AGREED: Property = Property {
    name: "nodes that hear each other agree on the bus within the bound",
    holds: |it| it.watch.disagreeing <= ticks(bounds().agreement),
};
/// The bus stops changing.
pub const SETTLED: Property =
    Property { name: "the bus does not change for ever", holds: |it| it.watch.needless <= Bounds::NEEDLESS };
/// No two masters stay active.
pub const ONE_ACTIVE: Property = Property {
    name: "of two active masters that hear each other one yields within the bound",
    holds: |it| it.watch.rivalling <= ticks(bounds().rivalry),
};
/// The role of a master stops changing.
pub const ROLES: Property = Property {
    name: "masters do not take turns for ever",
    holds: |it| it.watch.handed_over <= Bounds::HANDED_OVER,
};
/// The value of Ctoggle.
pub const CTOGGLE: Property =
    Property { name: "Ctoggle is at most Ntoggle", holds: |it| !it.watch.is_toggled_too_often };
/// The value of Bdefault.
pub const BDEFAULT: Property = Property {
    name: "Bdefault changes with a find, a follow and their return only",
    holds: |it| !it.watch.has_wrong_bdefault,
};
/// The master knows errors and values of a slave.
pub const KNOWN: Property = Property {
    name: "what a slave in reach has reported is known to its master within the bound",
    holds: |it| it.unknown <= if it.world.has_rounds() { with_round() } else { without_round() },
};

/// All properties.
pub const ALL: [Property; 8] = [SERVED, AGREED, SETTLED, ONE_ACTIVE, ROLES, CTOGGLE, BDEFAULT, KNOWN];
