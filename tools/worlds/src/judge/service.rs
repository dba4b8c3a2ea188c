//! Service of slaves, and agreement of nodes on the bus (ECSS 8.3.3).

use ecss_can::types::{Bus, NmtState};

use crate::judge::command::Command;
use crate::judge::view::View;

impl View<'_> {
    /// Returns whether a slave is Operational on the bus that the master manages, and the master reaches it there.
    pub fn serves(&self, master: usize, slave: usize) -> bool {
        let node = &self.slaves[slave];
        self.masters[master].bus.is_some_and(|bus| {
            node.state == NmtState::Operational
                && node.bus == Some(bus)
                && self.is_reachable(master, slave, bus)
        })
    }

    /// Returns whether a master serves all slaves in its reach.
    pub fn serves_all_in_reach(&self, master: usize) -> bool {
        self.all_slaves().all(|slave| !self.is_in_reach(master, slave) || self.serves(master, slave))
    }

    /// Returns the slaves that a master has to serve on the bus that it manages: those that it reaches there and that no other
    /// active master contests.
    pub fn to_serve(&self, master: usize) -> impl Iterator<Item = usize> {
        let bus = self.masters[master].bus;
        self.all_slaves().filter(move |slave| {
            bus.is_some_and(|bus| self.is_reachable(master, *slave, bus))
                && !self.is_contested(master, *slave)
        })
    }

    /// Returns whether the network is served. `was_split`: no bus served all slaves at some time, so one served slave
    /// is enough. The same holds for two masters that do not hear each other. Without an active master there must be no
    /// slave that a board hears.
    pub fn is_served(&self, was_split: bool) -> bool {
        match self.command() {
            Command::Nobody => !self
                .powered()
                .any(|master| self.all_slaves().any(|slave| self.is_heard_at_all(master, slave))),
            Command::Two => {
                self.powered().any(|master| self.all_slaves().any(|slave| self.serves(master, slave)))
            }
            Command::One(master) if was_split => {
                !self.has_slaves(master) || self.all_slaves().any(|slave| self.serves(master, slave))
            }
            Command::One(master) => self.serves_all_in_reach(master),
        }
    }

    /// Returns whether the slaves that hear the master have selected its bus (ECSS 8.3.3). Two masters that do not hear
    /// each other may share them.
    pub fn is_agreed(&self) -> bool {
        let Command::One(master) = self.command() else { return true };
        let Some(bus) = self.masters[master].bus else { return true };
        self.all_slaves()
            .all(|slave| !self.is_heard(master, slave, bus) || self.slaves[slave].bus == Some(bus))
    }

    /// Returns whether a master with slaves in reach changed the bus since the view before. Such a change needs an
    /// unserved slave.
    pub fn has_moved(&self, master: usize) -> bool {
        self.masters[master].has_switched && self.has_slaves(master)
    }

    /// Returns Bdefault of a served slave if it is known and is not the bus of its master: Bdefault becomes the bus on
    /// which the master is found (ECSS 8.3.3k).
    pub fn wrong_bdefault(&self, master: usize, slave: usize) -> Option<Bus> {
        let bdefault = self.slaves[slave].parameters?.bdefault;
        (self.serves(master, slave) && self.masters[master].bus != Some(bdefault)).then_some(bdefault)
    }
}

#[cfg(test)]
mod tests {
    use ecss_can::profile::Profile;
    use ecss_can::redundancy::Parameters;
    use ecss_can::types::PerBus;

    use super::*;
    use crate::judge::view::tests::{BOTH, MASTER, NEITHER, NOMINAL, REDUNDANT, view};
    use crate::judge::view::{Master, Slave};

    const STANDBY: Master = Master { bus: None, ..MASTER };

    /// Operational on the nominal bus.
    fn slave(cable: PerBus<bool>) -> Slave {
        let (state, bus) = (NmtState::Operational, Some(Bus::Nominal));
        Slave { state, bus, wired: [cable; 2], ..Slave::default() }
    }

    fn waiting(cable: PerBus<bool>) -> Slave {
        Slave { state: NmtState::PreOperational, ..slave(cable) }
    }

    #[test]
    fn a_slave_is_served_when_operational_on_its_masters_bus() {
        for (master, slave, expected) in [
            (MASTER, slave(NOMINAL), true),
            (MASTER, slave(REDUNDANT), false),
            (MASTER, waiting(BOTH), false),
            (MASTER, Slave { state: NmtState::Stopped, ..slave(BOTH) }, false),
            (MASTER, Slave { bus: Some(Bus::Redundant), ..slave(BOTH) }, false),
            (MASTER, Slave { bus: None, ..slave(BOTH) }, false),
            (MASTER, Slave { is_powered: false, ..slave(BOTH) }, false),
            (STANDBY, slave(BOTH), false),
        ] {
            assert_eq!(view(&[master], &[slave]).serves(0, 0), expected, "{master:?}, {slave:?}");
        }
    }

    /// Given masters and slaves. Then the network is served before a split, and after one.
    #[test]
    fn a_network_is_served_when_all_or_after_a_split_one_is() {
        let unheard = Slave { has_given_up: true, bus: Some(Bus::Redundant), ..waiting(NOMINAL) };
        let second = Master { bus: Some(Bus::Redundant), ..MASTER };
        let to_second = |slave: Slave| Slave { wired: [NEITHER, REDUNDANT], ..slave };
        for (masters, slaves, expected) in [
            (vec![MASTER], vec![slave(BOTH), slave(NOMINAL)], [true, true]),
            (vec![MASTER], vec![slave(BOTH), waiting(REDUNDANT)], [false, true]),
            (vec![MASTER], vec![waiting(BOTH), waiting(BOTH)], [false, false]),
            (vec![MASTER], vec![slave(BOTH), waiting(NEITHER)], [true, true]),
            (vec![MASTER], vec![waiting(NEITHER), waiting(NEITHER)], [true, true]),
            (vec![STANDBY], vec![slave(BOTH)], [false, false]),
            (vec![STANDBY], vec![unheard], [true, true]),
            (vec![MASTER, second], vec![slave(NOMINAL), to_second(waiting(BOTH))], [true, true]),
            (vec![MASTER, second], vec![waiting(NOMINAL), to_second(waiting(BOTH))], [false, false]),
        ] {
            let found = [false, true].map(|was_split| view(&masters, &slaves).is_served(was_split));
            assert_eq!(found, expected, "{masters:?}, {slaves:?}");
        }
    }

    /// Given a second master that is active on the redundant bus. Then the first one has to serve the slaves that only
    /// it reaches.
    #[test]
    fn a_master_has_to_serve_uncontested_slaves_on_its_bus() {
        let cables = [[BOTH, NEITHER], [NOMINAL, REDUNDANT], [REDUNDANT, NEITHER], [NOMINAL, NOMINAL]];
        let slaves = cables.map(|wired| Slave { wired, ..waiting(NEITHER) });
        let masters = [MASTER, Master { bus: Some(Bus::Redundant), ..MASTER }];
        let to_serve = |view: View, master| view.to_serve(master).collect::<Vec<_>>();
        assert_eq!(to_serve(view(&masters, &slaves), 0), [0, 3]);
        assert_eq!(to_serve(view(&masters, &slaves), 1), [0; 0]);
        assert_eq!(to_serve(view(&[MASTER, STANDBY], &slaves), 0), [0, 1, 3]);
        assert_eq!(to_serve(view(&[MASTER, STANDBY], &slaves), 1), [0; 0]);
    }

    #[test]
    fn nodes_agree_when_slaves_that_hear_the_master_are_on_its_bus() {
        let elsewhere = |cable| Slave { bus: Some(Bus::Redundant), ..waiting(cable) };
        for (slaves, expected) in [
            ([waiting(BOTH), waiting(BOTH)], true),
            ([waiting(BOTH), elsewhere(BOTH)], false),
            ([waiting(BOTH), elsewhere(REDUNDANT)], true),
            ([waiting(BOTH), Slave { has_given_up: true, ..elsewhere(BOTH) }], true),
        ] {
            assert_eq!(view(&[MASTER], &slaves).is_agreed(), expected, "{slaves:?}");
            assert!(view(&[STANDBY], &slaves).is_agreed(), "nobody to agree with");
        }
    }

    #[test]
    fn a_master_that_left_slaves_in_reach_has_moved() {
        let moved = Master { has_switched: true, ..MASTER };
        for (master, cable, expected) in
            [(moved, BOTH, true), (moved, REDUNDANT, true), (moved, NEITHER, false), (MASTER, BOTH, false)]
        {
            assert_eq!(view(&[master], &[slave(cable)]).has_moved(0), expected, "{master:?}, {cable:?}");
        }
    }

    /// Verifies: ECSS 8.3.3k
    #[test]
    fn bdefault_of_a_served_slave_is_the_masters_bus() {
        let with = |bdefault, slave| {
            let parameters = Some(Parameters { bdefault, ..Profile::DEFAULT.redundancy() });
            Slave { parameters, ..slave }
        };
        for (slave, expected) in [
            (with(Bus::Nominal, slave(BOTH)), None),
            (with(Bus::Redundant, slave(BOTH)), Some(Bus::Redundant)),
            (with(Bus::Redundant, waiting(BOTH)), None),
            (slave(BOTH), None),
        ] {
            assert_eq!(view(&[MASTER], &[slave]).wrong_bdefault(0, 0), expected, "{slave:?}");
        }
    }
}
