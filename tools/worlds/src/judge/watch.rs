//! Duration of violations of the rules.

use crate::judge::command::Command;
use crate::judge::selector::is_toggled_too_often;
use crate::judge::view::View;

/// Counts ticks and events since the last fault. The search defines the length of a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Watch {
    /// Consecutive ticks in which a slave that one bus can serve was not served.
    pub unserved: u8,
    /// Consecutive ticks in which a slave that hears the master had not selected its bus.
    pub disagreeing: u8,
    /// Number of changes of the bus while all slaves were served.
    pub needless: u8,
    /// Number of changes of role of the masters.
    pub handed_over: u8,
    /// Consecutive ticks in which two active masters heard each other.
    pub rivalling: u8,
    /// No bus served all slaves in reach, and not all were served since.
    pub was_split: bool,
    /// Ctoggle exceeded Ntoggle.
    pub is_toggled_too_often: bool,
    /// Bdefault changed without a find or a follow.
    pub has_wrong_bdefault: bool,
}

impl Watch {
    /// Handles a fault: counters restart at zero.
    pub fn restart(&mut self, view: &View) {
        *self = Watch { unserved: 0, disagreeing: 0, needless: 0, handed_over: 0, rivalling: 0, ..*self };
        self.note(view);
    }

    /// Records violations that are never allowed, and splits.
    pub fn note(&mut self, view: &View) {
        let mut parameters = view.slaves.iter().filter_map(|slave| slave.parameters.as_ref());
        self.is_toggled_too_often |= parameters.any(is_toggled_too_often);
        let Command::One(master) = view.command() else { return };
        if view.is_split(master) {
            self.was_split = true;
        } else if view.serves_all_in_reach(master) {
            self.was_split = false;
        }
    }

    /// Counts `ticks` of a network without a fault, after [`note`](Watch::note). `are_rivals`: two active masters hear
    /// each other.
    pub fn count(&mut self, view: &View, are_rivals: bool, ticks: u8) {
        let run = |ticks_so_far: u8, holds: bool| if holds { 0 } else { ticks_so_far.saturating_add(ticks) };
        if let Command::One(master) = view.command()
            && self.unserved == 0
            && view.has_moved(master)
        {
            self.needless = self.needless.saturating_add(1);
        }
        self.handed_over = self.handed_over.saturating_add(view.role_changes() as u8);
        self.rivalling = run(self.rivalling, !are_rivals);
        self.unserved = run(self.unserved, view.is_served(self.was_split));
        self.disagreeing = run(self.disagreeing, view.is_agreed());
    }
}

#[cfg(test)]
mod tests {
    use ecss_can::profile::Profile;
    use ecss_can::redundancy::Parameters;
    use ecss_can::types::{Bus, NmtState, PerBus};

    use super::*;
    use crate::judge::view::tests::{BOTH, MASTER};
    use crate::judge::view::{Master, Slave};

    fn look(watch: &mut Watch, master: Master, slaves: &[Slave], are_rivals: bool) {
        let view = View { masters: &[master], slaves, joins_masters: PerBus::default() };
        watch.note(&view);
        watch.count(&view, are_rivals, 3);
    }

    fn served() -> Slave {
        let (state, bus) = (NmtState::Operational, Some(Bus::Nominal));
        Slave { state, bus, wired: [BOTH; 2], ..Slave::default() }
    }

    #[test]
    fn ticks_count_while_a_rule_does_not_hold() {
        let mut watch = Watch::default();
        let lost = Slave { bus: Some(Bus::Redundant), ..served() };
        look(&mut watch, MASTER, &[lost], true);
        look(&mut watch, MASTER, &[lost], true);
        let both = Watch { unserved: 6, disagreeing: 6, rivalling: 6, ..Watch::default() };
        assert_eq!(watch, both);
        look(&mut watch, MASTER, &[served()], false);
        assert_eq!(watch, Watch::default());
        (0..100).for_each(|_| look(&mut watch, MASTER, &[lost], false));
        assert_eq!(watch.unserved, 255, "no overflow");
    }

    #[test]
    fn changes_count_until_the_next_fault() {
        let mut watch = Watch::default();
        let restless = Master { has_switched: true, has_changed_role: true, ..MASTER };
        look(&mut watch, restless, &[served()], false);
        look(&mut watch, restless, &[served()], false);
        look(&mut watch, MASTER, &[served()], false);
        assert_eq!(watch, Watch { needless: 2, handed_over: 2, ..Watch::default() });
        watch.restart(&View { masters: &[], slaves: &[], joins_masters: PerBus::default() });
        assert_eq!(watch, Watch::default());
    }

    #[test]
    fn a_change_of_the_bus_for_an_unserved_slave_has_a_reason() {
        let mut watch = Watch::default();
        let moved = Master { has_switched: true, ..MASTER };
        let waiting = Slave { state: NmtState::PreOperational, ..served() };
        look(&mut watch, MASTER, &[waiting], false);
        look(&mut watch, moved, &[served()], false);
        assert_eq!(watch.needless, 0);
        look(&mut watch, moved, &[served()], false);
        assert_eq!(watch.needless, 1);
    }

    /// Given a network in which each bus serves one of two slaves. Then one served slave is enough, until all are served.
    #[test]
    fn a_split_is_forgotten_when_all_are_served() {
        let mut watch = Watch::default();
        let on = |nominal, redundant| Slave { wired: [PerBus { nominal, redundant }; 2], ..served() };
        let waiting = |slave| Slave { state: NmtState::PreOperational, ..slave };
        look(&mut watch, MASTER, &[on(true, false), waiting(on(false, true))], false);
        assert_eq!((watch.was_split, watch.unserved), (true, 0));
        look(&mut watch, MASTER, &[served(), waiting(served())], false);
        assert_eq!((watch.was_split, watch.unserved), (true, 0));
        look(&mut watch, MASTER, &[served(), served()], false);
        assert!(!watch.was_split);
        look(&mut watch, MASTER, &[served(), waiting(served())], false);
        assert_eq!((watch.was_split, watch.unserved), (false, 3));
    }

    /// Each state of the model keeps a watch.
    #[test]
    fn a_watch_is_eight_bytes() {
        assert_eq!(size_of::<Watch>(), 8);
    }

    /// Verifies: ECSS 8.3.3h
    #[test]
    fn one_switch_too_many_is_never_forgotten() {
        let mut watch = Watch::default();
        let parameters = Some(Parameters { ctoggle: 5, ntoggle: 4, ..Profile::DEFAULT.redundancy() });
        look(&mut watch, MASTER, &[Slave { parameters, ..served() }], false);
        watch.restart(&View { masters: &[], slaves: &[], joins_masters: PerBus::default() });
        assert!(watch.is_toggled_too_often);
    }
}
