//! The properties, as counters of how long they have not held since the last fault.

use ecss_can::redundancy::Broken;
use ecss_can::types::{Bus, Instant, NmtState, Rebase};

use crate::profile::PARAMETERS;
use crate::station::Station;
use crate::world::{Crew, Fault, MASTERS, World};

/// A spacecraft at [`Rebase::ORIGIN`], under watch.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Watched {
    /// The spacecraft.
    pub world: World,
    /// The properties.
    pub watch: Watch,
}

impl Watched {
    /// All nodes powered at the same instant. `broken`: a rule that does not hold.
    pub fn new(crew: Crew, faults: u8, broken: Option<Broken>) -> Watched {
        Watched { world: World::new(crew, faults, broken), watch: Watch::default() }
    }

    /// A fault happens, and what follows from it at once.
    pub fn suffer(&mut self, fault: Fault) {
        self.suffer_at(fault, Rebase::ORIGIN);
        self.world.rebase(Rebase::ORIGIN);
    }

    /// The same at any time, without the shift to [`Rebase::ORIGIN`].
    pub fn suffer_at(&mut self, fault: Fault, now: Instant) {
        self.world.suffer_at(fault, now, &mut |world| self.watch.restart(world));
        self.watch.restart(&self.world);
    }

    /// Ticks until something is due.
    pub fn ticks(&self) -> u32 {
        self.world.ticks_from(Rebase::ORIGIN)
    }

    /// Time goes on to the next tick at which something is due.
    pub fn tick(&mut self) {
        let now = self.tick_from(Rebase::ORIGIN);
        self.world.rebase(now);
    }

    /// The same from any time, without the shift to [`Rebase::ORIGIN`]. Returns the time then.
    pub fn tick_from(&mut self, now: Instant) -> Instant {
        let ticks = self.world.ticks_from(now);
        let now = self.world.tick_from(now, &mut |world| self.watch.restart(world));
        self.watch.look(&self.world, ticks);
        now
    }
}

/// Ticks and events since the last fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Watch {
    /// Ticks without all slaves operational that one bus can serve.
    pub unserved: u8,
    /// Ticks in which a slave that is on the master's bus has not selected it.
    pub disagreeing: u8,
    /// Changes of the bus while all slaves were served.
    pub needless: u8,
    /// Changes of role of the masters.
    pub handed_over: u8,
    /// Ticks in which two active masters were on a bus on which one of them sends.
    pub rivalling: u8,
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
        *self = Watch { unserved: 0, disagreeing: 0, needless: 0, handed_over: 0, rivalling: 0, ..*self };
        self.note_split(world);
    }

    fn note_split(&mut self, world: &World) {
        let Command::One(master) = command(world) else { return };
        if !Bus::ALL.into_iter().any(|bus| serves_all(world, master, bus)) {
            self.was_split = true;
        } else if slaves()
            .all(|slave| !is_in_reach(world, master, slave) || is_operational(world, master, slave))
        {
            self.was_split = false;
        }
    }

    /// Whether the slaves in reach are operational: all of them if one bus serves all, and always did, else one.
    fn is_served(&self, world: &World) -> bool {
        match command(world) {
            Command::Nobody => !slaves().any(|slave| masters(world).any(|it| can_reach(world, it, slave))),
            Command::Two => slaves().any(|slave| masters(world).any(|it| is_operational(world, it, slave))),
            Command::One(master) => {
                let mut in_reach = slaves().filter(|slave| is_in_reach(world, master, *slave)).peekable();
                if self.was_split {
                    in_reach.peek().is_none() || in_reach.any(|slave| is_operational(world, master, slave))
                } else {
                    in_reach.all(|slave| is_operational(world, master, slave))
                }
            }
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
        if was_served
            && let Command::One(master) = command(world)
            && world.masters[master].switched.is_some()
            && slaves().any(|slave| is_in_reach(world, master, slave))
        {
            self.needless = self.needless.saturating_add(1);
        }
        let changes = masters(world).filter(|it| world.masters[*it].role_changed.is_some()).count();
        self.handed_over = self.handed_over.saturating_add(changes as u8);
        self.rivalling = if are_rivals(world) { self.rivalling.saturating_add(ticks) } else { 0 };
        self.unserved = if self.is_served(world) { 0 } else { self.unserved.saturating_add(ticks) };
        self.disagreeing = if is_agreed(world) { 0 } else { self.disagreeing.saturating_add(ticks) };
    }
}

/// Who manages the network.
enum Command {
    /// No master is active.
    Nobody,
    /// This one; another one that is active has no slave in reach.
    One(usize),
    /// Two that have slaves in reach.
    Two,
}

fn command(world: &World) -> Command {
    let active: Vec<usize> = masters(world).filter(|it| world.masters[*it].is_active()).collect();
    let reaches = |master: &usize| slaves().any(|slave| is_in_reach(world, *master, slave));
    let reaching: Vec<usize> = active.iter().copied().filter(reaches).collect();
    match (&active[..], &reaching[..]) {
        ([], _) => Command::Nobody,
        (_, [one]) | ([one, ..], []) => Command::One(*one),
        _ => Command::Two,
    }
}

/// The masters with power.
fn masters(world: &World) -> impl Iterator<Item = usize> {
    (0..world.masters.len()).filter(|master| world.is_powered(MASTERS[*master]))
}

/// Whether two masters are active and one hears the other: who is heard is told so by a claim.
fn are_rivals(world: &World) -> bool {
    let active: Vec<usize> = masters(world).filter(|it| world.masters[*it].is_active()).collect();
    let is_shared = |bus: Bus| active.iter().all(|master| world.is_connected(bus, MASTERS[*master]));
    active.len() > 1 && active.iter().any(|master| is_shared(world.masters[*master].active()))
}

/// Whether a master that takes over finds this slave.
fn can_reach(world: &World, master: usize, slave: usize) -> bool {
    Bus::ALL.into_iter().any(|bus| is_heard(world, master, slave, bus))
}

/// Whether a master finds this slave on `bus`, where it hears others as well. A slave that gave up its search stays where it is
/// (ECSS 8.3.3j): if it is cut off there, no master hears it.
fn is_heard(world: &World, master: usize, slave: usize, bus: Bus) -> bool {
    let node = &world.slaves[slave];
    is_wired(world, master, slave, bus) && (!node.has_given_up || node.active() == bus)
}

/// Whether master and slave have power, and no cut on this bus.
fn is_wired(world: &World, master: usize, slave: usize, bus: Bus) -> bool {
    [MASTERS[master], slave + 1]
        .into_iter()
        .all(|place| world.is_powered(place) && world.is_connected(bus, place))
}

/// Whether a master is to serve this slave where it is on `bus`. A master that hears no slave comes to both buses, and a slave
/// with parallel access hears it there, also when it gave up.
fn is_reachable(world: &World, master: usize, slave: usize, bus: Bus) -> bool {
    let is_any_heard = || slaves().any(|slave| can_reach(world, master, slave));
    is_heard(world, master, slave, bus)
        || is_wired(world, master, slave, bus) && world.slaves[slave].is_joined(bus) && !is_any_heard()
}

fn is_in_reach(world: &World, master: usize, slave: usize) -> bool {
    Bus::ALL.into_iter().any(|bus| is_reachable(world, master, slave, bus))
}

fn is_operational(world: &World, master: usize, slave: usize) -> bool {
    let (node, active) = (&world.slaves[slave], world.masters[master].active());
    node.state() == NmtState::Operational
        && node.active() == active
        && is_reachable(world, master, slave, active)
}

fn serves_all(world: &World, master: usize, bus: Bus) -> bool {
    slaves().all(|slave| !is_in_reach(world, master, slave) || is_reachable(world, master, slave, bus))
}

fn slaves() -> core::ops::Range<usize> {
    0..2
}

/// Whether the slaves that hear the master have selected its bus. Two masters that do not hear each other may share them.
fn is_agreed(world: &World) -> bool {
    let Command::One(master) = command(world) else { return true };
    let active = world.masters[master].active();
    slaves().all(|slave| !is_heard(world, master, slave, active) || world.slaves[slave].active() == active)
}
