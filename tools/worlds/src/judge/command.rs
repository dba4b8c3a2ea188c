//! Management of the network (ECSS 8.1a, docs/decisions/standby-master.md).

use ecss_can::types::Bus;

use crate::judge::view::View;

/// Masters that manage the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// No master is active.
    Nobody,
    /// This master. Another active master, if any, has no slave in reach.
    One(usize),
    /// Two masters that both have slaves in reach.
    Two,
}

impl View<'_> {
    /// Returns the masters that manage the network. If no active master has a slave in reach, the first one.
    pub fn command(&self) -> Command {
        let (mut first, mut reaching) = (None, None);
        for (master, _) in self.active() {
            first = first.or(Some(master));
            if self.has_slaves(master) && reaching.replace(master).is_some() {
                return Command::Two;
            }
        }
        reaching.or(first).map_or(Command::Nobody, Command::One)
    }

    /// Returns how many masters have to be active in the steady state: one if a bus joins the boards (ECSS 8.1a),
    /// otherwise each board with power, because it hears no other master.
    pub fn managers_expected(&self) -> usize {
        let powered = self.powered().count();
        let are_joined = Bus::ALL.into_iter().any(|bus| self.joins_masters[bus]);
        if are_joined { powered.min(1) } else { powered }
    }

    /// Returns whether two masters are active, and each receives the other one's frames on this bus. An active master
    /// sends its heartbeat on its bus and its claims on both, so one of the two has to yield.
    pub fn are_rivals_on(&self, bus: Bus) -> bool {
        self.joins_masters[bus] && self.active().count() > 1
    }

    /// Returns the number of masters that changed their role since the view before.
    pub fn role_changes(&self) -> usize {
        self.powered().filter(|master| self.masters[*master].has_changed_role).count()
    }
}

#[cfg(test)]
mod tests {
    use ecss_can::types::PerBus;

    use super::*;
    use crate::judge::view::{Master, Slave};

    const ON: Option<Bus> = Some(Bus::Nominal);

    fn masters(boards: &[(bool, Option<Bus>)]) -> Vec<Master> {
        let board =
            |(is_powered, bus): &_| Master { is_powered: *is_powered, bus: *bus, ..Master::default() };
        boards.iter().map(board).collect()
    }

    /// Given boards with power and role, and whether each has the slave in reach. Then this one manages the network.
    ///
    /// Verifies: ECSS 8.1a
    #[test]
    fn a_master_with_slaves_in_reach_manages_the_network() {
        for (boards, reaches, command) in [
            (vec![], [false, false], Command::Nobody),
            (vec![(true, None)], [true, false], Command::Nobody),
            (vec![(false, ON)], [true, false], Command::Nobody),
            (vec![(true, ON)], [false, false], Command::One(0)),
            (vec![(true, None), (true, ON)], [true, true], Command::One(1)),
            (vec![(true, ON), (true, ON)], [false, true], Command::One(1)),
            (vec![(true, ON), (true, ON)], [true, false], Command::One(0)),
            (vec![(true, ON), (true, ON)], [false, false], Command::One(0)),
            (vec![(true, ON), (true, ON)], [true, true], Command::Two),
            (vec![(true, ON), (false, ON)], [true, true], Command::One(0)),
        ] {
            let masters = masters(&boards);
            let wired = reaches.map(|reaches| PerBus { nominal: false, redundant: reaches });
            let slaves = [Slave { wired, ..Slave::default() }];
            let view = View { masters: &masters, slaves: &slaves, joins_masters: PerBus::default() };
            assert_eq!(view.command(), command, "{boards:?}, {reaches:?}");
        }
    }

    /// Given the power of two boards, and whether a bus joins them, then this number of boards has to be active.
    ///
    /// Verifies: ECSS 8.1a
    #[test]
    fn of_joined_boards_one_has_to_be_active() {
        for (powered, redundant, expected) in [
            ([true, true], true, 1),
            ([true, true], false, 2),
            ([true, false], true, 1),
            ([false, true], false, 1),
            ([false, false], true, 0),
        ] {
            let masters = masters(&powered.map(|is_powered| (is_powered, None)));
            let joins_masters = PerBus { nominal: false, redundant };
            let view = View { masters: &masters, slaves: &[], joins_masters };
            assert_eq!(view.managers_expected(), expected, "{powered:?}, joined: {redundant}");
        }
    }

    /// Given two boards that only the redundant bus joins. Then they are rivals there if both are active.
    ///
    /// Verifies: ECSS 8.1a
    #[test]
    fn two_active_masters_are_rivals_where_a_bus_joins_them() {
        let joins_masters = PerBus { nominal: false, redundant: true };
        for (boards, expected) in [
            ([(true, ON), (true, ON)], true),
            ([(true, ON), (true, None)], false),
            ([(true, ON), (false, ON)], false),
        ] {
            let masters = masters(&boards);
            let view = View { masters: &masters, slaves: &[], joins_masters };
            assert_eq!(Bus::ALL.map(|bus| view.are_rivals_on(bus)), [false, expected], "{boards:?}");
        }
    }

    #[test]
    fn changes_of_role_of_boards_with_power_count() {
        let changed = Master { is_powered: true, has_changed_role: true, ..Master::default() };
        for (masters, count) in [
            ([changed, changed], 2),
            ([changed, Master { has_changed_role: false, ..changed }], 1),
            ([Master { is_powered: false, ..changed }, changed], 1),
        ] {
            let view = View { masters: &masters, slaves: &[], joins_masters: PerBus::default() };
            assert_eq!(view.role_changes(), count, "{masters:?}");
        }
    }
}
