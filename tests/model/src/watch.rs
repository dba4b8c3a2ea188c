//! The properties, as counters of how long they have not held since the last fault.

use ecss_can::types::{Bus, NmtState};

use crate::profile::PARAMETERS;
use crate::station::Station;
use crate::world::{MASTER, World};

/// Ticks and events since the last fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Watch {
    /// Ticks without all slaves operational that one bus can serve.
    pub unserved: u8,
    /// Ticks in which a slave that is on the master's bus has not selected it.
    pub disagreeing: u8,
    /// Changes of the bus while all slaves were served.
    pub needless: u8,
    /// No bus served all slaves in reach, and not all were served since.
    pub was_split: bool,
    /// Ctoggle exceeded Ntoggle.
    pub is_toggled_too_often: bool,
    /// Bdefault changed without a find or a follow.
    pub has_wrong_bdefault: bool,
}

impl Watch {
    /// A fault happened.
    pub fn restart(&mut self, world: &World) {
        (self.unserved, self.disagreeing, self.needless) = (0, 0, 0);
        self.note_split(world);
    }

    fn note_split(&mut self, world: &World) {
        if !Bus::ALL.into_iter().any(|bus| serves_all(world, bus)) {
            self.was_split = true;
        } else if slaves().all(|slave| !is_in_reach(world, slave) || is_operational(world, slave)) {
            self.was_split = false;
        }
    }

    /// Whether the slaves in reach are operational: all of them if one bus serves all, and always did, else one.
    fn is_served(&self, world: &World) -> bool {
        let mut in_reach = slaves().filter(|slave| is_in_reach(world, *slave)).peekable();
        if self.was_split {
            in_reach.peek().is_none() || in_reach.any(|slave| is_operational(world, slave))
        } else {
            in_reach.all(|slave| is_operational(world, slave))
        }
    }

    /// Looks at the world after `ticks`.
    pub fn look(&mut self, world: &World, ticks: u32) {
        let ticks = ticks as u8;
        for slave in &world.slaves {
            let parameters = slave.selector.parameters();
            self.is_toggled_too_often |= parameters.ctoggle > PARAMETERS.ntoggle;
            self.has_wrong_bdefault |= slave.has_wrong_bdefault;
        }
        self.note_split(world);
        if world.left > 0 || world.is_losing() {
            return;
        }
        let was_served = self.unserved == 0;
        if was_served && world.master.switched.is_some() && slaves().any(|slave| is_in_reach(world, slave)) {
            self.needless = self.needless.saturating_add(1);
        }
        self.unserved = if self.is_served(world) { 0 } else { self.unserved.saturating_add(ticks) };
        self.disagreeing = if is_agreed(world) { 0 } else { self.disagreeing.saturating_add(ticks) };
    }
}

/// Whether the master finds this slave on `bus`, where it hears others as well. A slave that gave up its search stays where it is
/// (ECSS 8.3.3j): if it is cut off there, no master hears it.
fn is_heard(world: &World, slave: usize, bus: Bus) -> bool {
    let node = &world.slaves[slave];
    is_wired(world, slave, bus) && (!node.has_given_up || node.active() == bus)
}

/// Whether master and slave have power, and no cut on this bus.
fn is_wired(world: &World, slave: usize, bus: Bus) -> bool {
    [MASTER, slave + 1].into_iter().all(|place| world.is_powered(place) && world.is_connected(bus, place))
}

/// Whether the master is to serve this slave where it is on `bus`. A master that hears no slave comes to both buses, and a slave
/// with parallel access hears it there, also when it gave up.
fn is_reachable(world: &World, slave: usize, bus: Bus) -> bool {
    let is_any_heard = || slaves().any(|slave| Bus::ALL.into_iter().any(|bus| is_heard(world, slave, bus)));
    is_heard(world, slave, bus)
        || is_wired(world, slave, bus) && world.slaves[slave].is_joined(bus) && !is_any_heard()
}

fn is_in_reach(world: &World, slave: usize) -> bool {
    Bus::ALL.into_iter().any(|bus| is_reachable(world, slave, bus))
}

fn is_operational(world: &World, slave: usize) -> bool {
    let (node, active) = (&world.slaves[slave], world.master.active());
    node.state() == NmtState::Operational && node.active() == active && is_reachable(world, slave, active)
}

fn serves_all(world: &World, bus: Bus) -> bool {
    slaves().all(|slave| !is_in_reach(world, slave) || is_reachable(world, slave, bus))
}

fn slaves() -> core::ops::Range<usize> {
    0..2
}

/// Whether the slaves that hear the master have selected its bus.
fn is_agreed(world: &World) -> bool {
    let active = world.master.active();
    slaves().all(|slave| !is_heard(world, slave, active) || world.slaves[slave].active() == active)
}
