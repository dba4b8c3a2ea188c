//! Access of a slave to the two buses (ECSS 4.8.1), found by its behaviour.
//!
//! A slave with *parallel access* follows the first message of the master on the other bus at once. A slave with *selective access*
//! stays until it has missed the heartbeats of the master for a consumer time. So the slave's first heartbeat after the master has
//! moved shows its access, if the slave was operational up to then.
//!
//! Without such a change of bus the access stays unknown.

use can_twin::wire::time::Time;

use super::plan::BusAccess;
use super::record::Bus;

/// Longest time that a heartbeat may have waited for the bus: longer than all frames that may be sent before it.
pub const SETTLING: Time = Time::from_ms(5);

/// Evidence about the access of a slave.
#[derive(Clone, Copy, Debug, Default)]
pub struct Follow {
    /// Bus to which the master moved while the slave was operational on the other one, and the time of its first message there.
    moved: Option<(Bus, Time)>,
    found: Option<BusAccess>,
}

impl Follow {
    /// Handles a message of the master. `operational_on`: bus on which the slave is operational by its own heartbeats.
    pub fn on_master(&mut self, bus: Bus, at: Time, operational_on: Option<Bus>) {
        if operational_on.is_some_and(|own| own != bus) && self.moved.is_none() {
            self.moved = Some((bus, at));
        }
    }

    /// Handles a heartbeat of the slave. One that may have waited in a mailbox since before the move is no evidence.
    pub fn on_heartbeat(&mut self, bus: Bus, at: Time) {
        if let Some((to, _)) = self.moved.take_if(|(to, moved)| bus == *to || at >= *moved + SETTLING) {
            self.found = Some(if bus == to { BusAccess::Parallel } else { BusAccess::Selective });
        }
    }

    /// Returns the access; `None` while there is no evidence.
    pub fn found(&self) -> Option<BusAccess> {
        self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feeds heartbeats of the slave after the master has moved to the redundant bus at 1 s.
    fn found(operational_on: Option<Bus>, heartbeats: &[(u64, Bus)]) -> Option<BusAccess> {
        let mut follow = Follow::default();
        follow.on_heartbeat(Bus::Nominal, Time::from_ms(900));
        follow.on_master(Bus::Redundant, Time::from_ms(1000), operational_on);
        heartbeats.iter().for_each(|(ms, bus)| follow.on_heartbeat(*bus, Time::from_ms(*ms)));
        follow.found()
    }

    #[test]
    fn first_heartbeat_after_the_move_shows_the_access() {
        let on = Some(Bus::Nominal);
        for (heartbeats, expected) in [
            (&[(1002, Bus::Redundant)][..], Some(BusAccess::Parallel)),
            (&[(1002, Bus::Nominal), (1100, Bus::Redundant)], Some(BusAccess::Parallel)),
            (&[(1100, Bus::Nominal), (2000, Bus::Redundant)], Some(BusAccess::Selective)),
            (&[(1002, Bus::Nominal)], None),
            (&[], None),
        ] {
            assert_eq!(found(on, heartbeats), expected, "{heartbeats:?}");
        }
    }

    #[test]
    fn slave_that_was_not_operational_shows_nothing() {
        assert_eq!(found(None, &[(1100, Bus::Redundant)]), None);
        assert_eq!(found(Some(Bus::Redundant), &[(1100, Bus::Redundant)]), None);
    }
}
