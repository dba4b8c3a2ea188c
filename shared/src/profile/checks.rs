//! Checks that the values of a profile fit each other.

use super::Profile;
use crate::link::budget::BudgetPolicy;

impl Profile {
    /// Returns the profile if its values fit each other. End the declaration of a profile with it: the build stops at a
    /// profile that does not.
    ///
    /// | fields | rule |
    /// | --- | --- |
    /// | `heartbeat`, `consumer`, `settings` | whole milliseconds up to 65,535 ms, as 1017h and 1016h have them. Each consumer time is longer than the period that it watches; zero watches nothing, a period of zero sends nothing |
    /// | `slaves`, `settings`, `minimal`, `selective` | slaves are 2 to 126: 1 is the master, 127 a board in maintenance mode. `selective` may have the master |
    /// | `selective`, `ttoggle`, `ntoggle`, `dwell` | a slave with selective access searches until the master has tried both buses |
    /// | `budget` | it admits twice the frames of `heartbeat`, `sync` and `time`; no node has less than a COB-ID; the master hears as much of a slave as that may send |
    /// | `clocks` | clocks and bit timing can follow the crystals |
    /// | `standby` | the standby is slower than the active master, which may change the bus first, and faster than the slaves, which stay on their bus. A board that was reset listens until the other one has taken over. The claims have COB-IDs of their own |
    ///
    /// ```
    /// use ecss_can::profile::Profile;
    /// use ecss_can::types::NodeId;
    /// const MISSION: Profile = Profile { selective: &[NodeId::of::<4>()], ..Profile::DEFAULT }.checked();
    /// # assert_eq!(MISSION.selective.len(), 1);
    /// ```
    ///
    /// A slave that searches for 5.5 s ends before the master has tried both buses, and does not compile:
    ///
    /// ```compile_fail,E0080
    /// # use ecss_can::{profile::Profile, types::NodeId};
    /// const SHORT: Profile = Profile { selective: &[NodeId::of::<4>()], ntoggle: 10, ..Profile::DEFAULT }.checked();
    /// # assert_eq!(SHORT.ntoggle, 10);
    /// ```
    ///
    /// # Panics
    /// When called at run time with a profile that does not compile.
    #[track_caller]
    #[must_use]
    pub const fn checked(self) -> Profile {
        self.assert_heartbeats();
        self.assert_node_ids();
        assert!(
            self.is_search_long_enough(),
            "slaves with selective access give up before the master has tried both buses: raise `ntoggle` until ttoggle x \
             consumer x (ntoggle + 1) is at least two dwells, each the longer one of `dwell` and 2 x ttoggle x consumer + 2 x \
             heartbeat"
        );
        assert!(
            self.is_budget_sound(),
            "a node of this mission would silence itself: the rate of a COB-ID in `budget` admits at least twice the frames \
             that `heartbeat`, `sync` and `time` make, no node has less than a COB-ID, and the master hears as much of a slave \
             as that may send"
        );
        assert!(
            self.is_clock_sound(),
            "clocks cannot follow these crystals: `clocks.tolerance` is 1 to 900 ppm and at most \
             `network.oscillator_tolerance`, `clocks.drift` 1 to 3,500 ppb/s, `clocks.excursion` at most 1,000,000 ppb, \
             `clocks.agreeing` 2 to 40"
        );
        assert!(
            self.is_standby_sound(),
            "two master boards: their `consumer` is at least `consumer` + `heartbeat` of the profile, and shorter than ttoggle \
             x consumer; `prime_listens` is at least that time and two heartbeat periods, `second_listens` two heartbeat \
             periods more; claims have two COB-IDs that CANopen does not keep"
        );
        self
    }

    /// Returns whether slaves with selective access search long enough for a master that tries both buses. A slave that
    /// gives up earlier stays on its bus (ECSS 8.3.3j), even if that bus is dead.
    pub const fn is_search_long_enough(&self) -> bool {
        let redundancy = self.redundancy();
        let both_buses = redundancy.dwell(self.dwell).times(2);
        self.selective.is_empty() || redundancy.search_time().as_micros() >= both_buses.as_micros()
    }

    /// Returns whether the budget admits twice the frames that follow from the periods of the profile.
    pub const fn is_budget_sound(&self) -> bool {
        let BudgetPolicy { cob_id, slave, master, heard, .. } = self.budget;
        let admits =
            cob_id.is_twice(self.heartbeat) && cob_id.is_twice(self.sync) && cob_id.is_twice(self.time);
        admits && slave.is_at_least(cob_id) && master.is_at_least(cob_id) && heard.is_at_least(slave)
    }

    /// Returns whether every clock and the bit timing can follow the crystals that the profile admits.
    pub const fn is_clock_sound(&self) -> bool {
        self.clocks.is_sound() && self.clocks.tolerance.0 <= self.network.oscillator_tolerance.0
    }

    /// Returns whether the parameters of two master boards fit the others. `true` without a standby.
    pub const fn is_standby_sound(&self) -> bool {
        let Some(pair) = self.standby else { return true };
        let period = self.heartbeat.as_micros();
        let silence = pair.consumer.as_micros();
        let toggling = self.redundancy().toggling_time().as_micros();
        let are_claims_free = !pair.prime_claims.is_restricted()
            && !pair.second_claims.is_restricted()
            && pair.prime_claims.raw() != pair.second_claims.raw();
        let is_in_time =
            silence >= self.consumer.as_micros() + period && (toggling == 0 || silence < toggling);
        let waits = pair.prime_listens.as_micros() >= silence + 2 * period
            && pair.second_listens.as_micros() >= pair.prime_listens.as_micros() + 2 * period;
        are_claims_free && is_in_time && waits
    }
}
