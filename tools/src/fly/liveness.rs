//! Whether a node is alive, judged by its own heartbeats.
//!
//! The *period* of a node is the median of its last gaps between two heartbeats. A node that sends none for three
//! periods is silent. No knowledge of its image is needed.
//!
//! A node may also send an immediate heartbeat when its state or its bus changes. So only a gap between two heartbeats
//! with the same state on the same bus counts. A node without such a gap has no period and is not judged.

use std::collections::VecDeque;

use can_twin::wire::time::Time;

use super::meaning::NmtState;
use super::record::Bus;

/// Periods without a heartbeat after which a node is silent: one may be lost, and one may wait for the bus.
const MISSED: u64 = 3;

/// Gaps of which the median is taken.
const GAPS: usize = 5;

/// The heartbeats of a node.
#[derive(Clone, Debug, Default)]
pub struct Liveness {
    /// End of the last heartbeat or boot-up message.
    last: Option<Time>,
    /// State and bus of the last heartbeat; `None` after a boot-up message.
    reported: Option<(NmtState, Bus)>,
    gaps: VecDeque<Time>,
}

impl Liveness {
    /// Handles the end of a heartbeat with this state on `bus`.
    pub fn on_heartbeat(&mut self, state: NmtState, bus: Bus, at: Time) {
        let (last, reported) = (self.last.replace(at), self.reported.replace((state, bus)));
        if let Some(last) = last.filter(|_| reported == self.reported) {
            if self.gaps.len() == GAPS {
                self.gaps.pop_front();
            }
            self.gaps.push_back(at.since(last));
        }
    }

    /// Handles the end of a boot-up message: the gap before it does not count.
    pub fn on_boot_up(&mut self, at: Time) {
        (self.last, self.reported) = (Some(at), None);
    }

    /// Handles a loss of power: silence is no fault then.
    pub fn on_power_off(&mut self) {
        self.last = None;
    }

    /// Returns when the node counts as silent if it sends nothing more; `None` while its period is unknown.
    pub fn silent_at(&self) -> Option<Time> {
        let mut gaps: Vec<Time> = self.gaps.iter().copied().collect();
        gaps.sort_unstable();
        let period = gaps.get(gaps.len() / 2)?;
        Some(self.last? + Time(MISSED * period.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Time {
        Time::from_ms(ms)
    }

    fn after(heartbeats: &[u64]) -> Liveness {
        let mut liveness = Liveness::default();
        let state = NmtState::Operational;
        heartbeats.iter().for_each(|at| liveness.on_heartbeat(state, Bus::Nominal, ms(*at)));
        liveness
    }

    #[test]
    fn node_is_silent_three_periods_after_its_last_heartbeat() {
        for (what, heartbeats, silent) in [
            ("equal gaps", &[100, 200, 300][..], 600),
            ("one long gap does not change the period", &[100, 200, 300, 2_300, 2_400], 2_700),
            ("the period is that of the last gaps", &[0, 100, 200, 1_200, 2_200, 3_200, 4_200], 7_200),
        ] {
            assert_eq!(after(heartbeats).silent_at(), Some(ms(silent)), "{what}");
        }
    }

    #[test]
    fn node_without_a_period_or_power_is_not_judged() {
        assert_eq!(after(&[100]).silent_at(), None);
        let mut off = after(&[100, 200, 300]);
        off.on_power_off();
        assert_eq!(off.silent_at(), None);
    }

    /// Given immediate heartbeats after boot-up, at a change of the state and at a change of the bus, then none of
    /// their gaps counts.
    #[test]
    fn heartbeat_at_a_change_is_no_period() {
        let mut liveness = Liveness::default();
        liveness.on_boot_up(ms(0));
        liveness.on_heartbeat(NmtState::PreOperational, Bus::Nominal, ms(1));
        liveness.on_heartbeat(NmtState::Operational, Bus::Nominal, ms(11));
        liveness.on_heartbeat(NmtState::Operational, Bus::Redundant, ms(20));
        assert_eq!(liveness.silent_at(), None);
        liveness.on_heartbeat(NmtState::Operational, Bus::Redundant, ms(120));
        assert_eq!(liveness.silent_at(), Some(ms(420)));
    }

    #[test]
    fn time_of_a_reset_is_no_period() {
        let mut reset = after(&[100, 200, 300]);
        reset.on_boot_up(ms(9_000));
        assert_eq!(reset.silent_at(), Some(ms(9_300)));
    }
}
