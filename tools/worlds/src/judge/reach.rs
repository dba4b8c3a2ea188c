//! Which slaves a master can reach, and on which bus.

use ecss_can::types::Bus;

use crate::judge::view::View;

impl View<'_> {
    /// Returns whether master and slave have power, and the cable of this bus joins them.
    fn is_wired(&self, master: usize, slave: usize, bus: Bus) -> bool {
        let node = &self.slaves[slave];
        self.masters[master].is_powered && node.is_powered && node.wired[master][bus]
    }

    /// Returns whether a master hears this slave on a bus, at the latest when the slave searches there. A slave that
    /// gave up its search stays on its bus (ECSS 8.3.3j): if it is cut off there, no master hears it.
    pub fn is_heard(&self, master: usize, slave: usize, bus: Bus) -> bool {
        let node = &self.slaves[slave];
        self.is_wired(master, slave, bus) && (!node.has_given_up || node.bus == Some(bus))
    }

    /// Returns whether a master that takes over hears this slave on one of the buses.
    pub(crate) fn is_heard_at_all(&self, master: usize, slave: usize) -> bool {
        Bus::ALL.into_iter().any(|bus| self.is_heard(master, slave, bus))
    }

    /// Returns whether a master reaches this slave on a bus: it hears the slave there. A master that hears no slave at
    /// all alternates (docs/decisions/master-bus-choice.md), so it also reaches a slave that gave up and still listens
    /// to that bus.
    pub fn is_reachable(&self, master: usize, slave: usize, bus: Bus) -> bool {
        let hears_one = || self.all_slaves().any(|slave| self.is_heard_at_all(master, slave));
        self.is_heard(master, slave, bus)
            || self.is_wired(master, slave, bus) && self.slaves[slave].listens(bus) && !hears_one()
    }

    /// Returns whether a master reaches this slave on one of the buses, so that it has to serve the slave.
    pub fn is_in_reach(&self, master: usize, slave: usize) -> bool {
        Bus::ALL.into_iter().any(|bus| self.is_reachable(master, slave, bus))
    }

    /// Returns whether a master has a slave in reach.
    pub fn has_slaves(&self, master: usize) -> bool {
        self.all_slaves().any(|slave| self.is_in_reach(master, slave))
    }

    /// Returns whether a master reaches on this bus all slaves that it reaches on any.
    pub fn serves_all(&self, master: usize, bus: Bus) -> bool {
        self.all_slaves()
            .all(|slave| !self.is_in_reach(master, slave) || self.is_reachable(master, slave, bus))
    }

    /// Returns whether no bus serves all slaves in reach of a master. A master may later stay on a bus that serves a
    /// part of them (docs/decisions/master-bus-choice.md).
    pub fn is_split(&self, master: usize) -> bool {
        !Bus::ALL.into_iter().any(|bus| self.serves_all(master, bus))
    }

    /// Returns whether another active master reaches this slave on the bus that it manages. A slave between two masters
    /// that do not hear each other cannot know which one to follow.
    pub fn is_contested(&self, master: usize, slave: usize) -> bool {
        self.active().any(|(other, bus)| other != master && self.is_reachable(other, slave, bus))
    }
}

#[cfg(test)]
mod tests {
    use ecss_can::link::access::BusAccess;
    use ecss_can::types::PerBus;

    use super::*;
    use crate::judge::view::tests::{BOTH, NEITHER, NOMINAL, REDUNDANT, view};
    use crate::judge::view::{Master, Slave};

    fn active(bus: Bus) -> Master {
        Master { is_powered: true, bus: Some(bus), ..Master::default() }
    }

    fn wired(to_first: PerBus<bool>, to_second: PerBus<bool>) -> Slave {
        Slave { wired: [to_first, to_second], ..Slave::default() }
    }

    /// Given a slave with this cable, power of both nodes. Then it is reached on these buses.
    #[test]
    fn a_slave_is_reached_where_a_cable_joins_powered_nodes() {
        for cable in [NEITHER, NOMINAL, REDUNDANT, BOTH] {
            for (master_on, slave_on) in [(true, true), (true, false), (false, true)] {
                let masters = [Master { is_powered: master_on, ..active(Bus::Nominal) }];
                let slaves = [Slave { is_powered: slave_on, ..wired(cable, NEITHER) }];
                let view = view(&masters, &slaves);
                let reached = PerBus::from_fn(|bus| view.is_reachable(0, 0, bus));
                let expected = if master_on && slave_on { cable } else { NEITHER };
                assert_eq!(reached, expected, "{cable:?}, {master_on}, {slave_on}");
                assert_eq!(view.is_in_reach(0, 0), expected != NEITHER);
            }
        }
    }

    /// Given a slave that gave up on the nominal bus, whose stub is cut there. Then a master reaches it only if it hears nobody
    /// else, and the slave has a controller on the other bus.
    #[test]
    fn a_slave_that_gave_up_is_reached_by_a_lonely_master_only() {
        let gave_up = Slave { has_given_up: true, bus: Some(Bus::Nominal), ..wired(REDUNDANT, NEITHER) };
        let selective = Slave { access: BusAccess::Selective, ..gave_up };
        let other = wired(NOMINAL, NEITHER);
        let masters = [active(Bus::Nominal)];
        for (slaves, expected) in [
            (vec![gave_up], true),
            (vec![selective], false),
            (vec![gave_up, other], false),
            (vec![Slave { has_given_up: false, ..gave_up }, other], true),
            (vec![Slave { bus: Some(Bus::Redundant), ..gave_up }, other], true),
        ] {
            assert_eq!(view(&masters, &slaves).is_in_reach(0, 0), expected, "{slaves:?}");
        }
    }

    /// Given the cables of two slaves. Then these buses serve all slaves in reach, and none of them means a split.
    #[test]
    fn a_network_is_split_when_no_bus_serves_all() {
        for (cables, serving) in [
            ([BOTH, BOTH], BOTH),
            ([NOMINAL, BOTH], NOMINAL),
            ([REDUNDANT, REDUNDANT], REDUNDANT),
            ([NOMINAL, REDUNDANT], NEITHER),
            // No bus can serve the second slave.
            ([NOMINAL, NEITHER], NOMINAL),
            ([NEITHER, NEITHER], BOTH),
        ] {
            let masters = [active(Bus::Nominal)];
            let slaves = cables.map(|cable| wired(cable, NEITHER));
            let view = view(&masters, &slaves);
            assert_eq!(PerBus::from_fn(|bus| view.serves_all(0, bus)), serving, "{cables:?}");
            assert_eq!(view.is_split(0), serving == NEITHER, "{cables:?}");
        }
    }

    /// Given two masters on different buses. Then a slave that each reaches on its own bus is contested, and no other one.
    #[test]
    fn a_slave_is_contested_when_two_active_masters_reach_it() {
        let masters = [active(Bus::Nominal), active(Bus::Redundant)];
        let standby = [masters[0], Master { bus: None, ..masters[1] }];
        for (to_first, to_second, contested) in [
            (NOMINAL, REDUNDANT, [true, true]),
            (BOTH, NOMINAL, [false, true]),
            (NOMINAL, NOMINAL, [false, true]),
            (NEITHER, REDUNDANT, [true, false]),
        ] {
            let slaves = [wired(to_first, to_second)];
            let found = [0, 1].map(|master| view(&masters, &slaves).is_contested(master, 0));
            assert_eq!(found, contested, "{to_first:?}, {to_second:?}");
            assert!(!view(&standby, &slaves).is_contested(0, 0), "by a standby");
        }
    }
}
