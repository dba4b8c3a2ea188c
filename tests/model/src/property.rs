//! What holds at any time.

use ecss_can::types::Duration;
use host_worlds::judge::{Bounds, Watch};

use crate::profile::{DWELL, PAIR, PARAMETERS, TICK};

/// Something that holds in every state.
#[derive(Clone, Copy, Debug)]
pub struct Property {
    /// What a report calls it.
    pub name: &'static str,
    /// Whether it holds.
    pub holds: fn(&Watch) -> bool,
}

impl PartialEq for Property {
    fn eq(&self, other: &Property) -> bool {
        self.name == other.name
    }
}

/// Every slave in reach is operational on the master's bus.
pub const SERVED: Property = Property {
    name: "slaves in reach are operational within the bound",
    holds: |watch| watch.unserved <= ticks(bounds().service),
};
/// Slaves that hear the master agree with it on the bus.
pub const AGREED: Property = Property {
    name: "nodes that hear each other agree on the bus within the bound",
    holds: |watch| watch.disagreeing <= ticks(bounds().agreement),
};
/// The bus does not change for ever.
pub const SETTLED: Property =
    Property { name: "the bus does not change for ever", holds: |watch| watch.needless <= Bounds::NEEDLESS };
/// Two active masters.
pub const ONE_ACTIVE: Property = Property {
    name: "of two active masters that hear each other one yields within the bound",
    holds: |watch| watch.rivalling <= ticks(bounds().rivalry),
};
/// The role of a master does not change for ever.
pub const ROLES: Property = Property {
    name: "masters do not take turns for ever",
    holds: |watch| watch.handed_over <= Bounds::HANDED_OVER,
};
/// Ctoggle.
pub const CTOGGLE: Property =
    Property { name: "Ctoggle is at most Ntoggle", holds: |watch| !watch.is_toggled_too_often };
/// Bdefault.
pub const BDEFAULT: Property = Property {
    name: "Bdefault changes with a find, a follow and their return only",
    holds: |watch| !watch.has_wrong_bdefault,
};

/// All of them.
pub const ALL: [Property; 7] = [SERVED, AGREED, SETTLED, ONE_ACTIVE, ROLES, CTOGGLE, BDEFAULT];

fn bounds() -> Bounds {
    Bounds::new(&PARAMETERS, DWELL, &PAIR)
}

fn ticks(span: Duration) -> u8 {
    u8::try_from(span.as_micros() / TICK.as_micros()).unwrap_or(u8::MAX)
}
