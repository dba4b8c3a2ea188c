//! Runner of everything that is due by time.

use core::convert::Infallible;
use core::future::poll_fn;
use core::pin::pin;
use core::task::Poll;

use super::Clock;
use super::Platform;
use super::alarm::Alarm;
use super::shared::{Shared, register};
use super::storage::Core;
use crate::node::Node;
use crate::types::Instant;

/// Runs everything that is due by time, in a task of its own.
pub struct DueRunner<B: Platform, N: Node> {
    core: &'static Core<B, N>,
}

impl<B: Platform, N: Node> DueRunner<B, N> {
    pub(super) const fn new(core: &'static Core<B, N>) -> Self {
        DueRunner { core }
    }

    /// Runs without end.
    ///
    /// # Cancel safety
    /// The future must not be dropped: nothing would be done when it is due.
    pub async fn run(self) -> ! {
        let core = self.core;
        let timer = pin!(None);
        let mut alarm = Alarm::new(timer);
        let mut has_given_way = false;
        match poll_fn(|context| {
            // An executor may poll the task first that was woken last. A frame that came before has precedence (row
            // `rx.inside_look`).
            has_given_way = !has_given_way;
            if has_given_way {
                context.waker().wake_by_ref();
                return Poll::Pending;
            }
            let now = core.clock.now();
            core.lock(|shared| {
                let due = turn(shared, now);
                if shared.node.is_on_schedule(now) {
                    core.clock.on_schedule();
                }
                if register(&mut shared.timekeeper, context) {
                    alarm.arm(due, context, || core.clock.at(due));
                } else {
                    alarm.set(due, now, context, || core.clock.at(due));
                }
                shared.armed = alarm.at();
            });
            Poll::<Infallible>::Pending
        })
        .await {}
    }
}

/// Does what is due; when to come again. The node runs at the instant that it asked for, whatever its memory says since. If it has
/// run meanwhile, with a frame, nothing is left to do (row `rx.interrupt_to_application`).
fn turn<N: Node>(shared: &mut Shared<N>, now: Instant) -> Instant {
    if shared.is_due(now) || shared.is_missed(now) {
        shared.run_due(now);
    }
    shared.tell_application();
    shared.node.deadline().unwrap_or(Instant::NEVER)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::probe::Probe;
    use crate::node::{CanopenSlave, Settings};
    use crate::runner::Diagnostics;
    use crate::types::{Bus, Duration, NodeId};

    extern crate alloc;

    use alloc::boxed::Box;

    fn shared() -> Shared<CanopenSlave<Probe>> {
        static DIAGNOSTICS: Diagnostics = Diagnostics::new();
        let slave = CanopenSlave::new(NodeId::of::<5>(), &Settings::DEFAULT, Probe::default());
        let mut shared = Shared::new(Box::leak(Box::new(slave)), &DIAGNOSTICS);
        shared.power_on(Instant::ZERO);
        shared
    }

    /// Given a slave that has run with a frame at the instant of its alarm, then it does not run again, unless something is due.
    #[test]
    fn a_node_that_has_run_at_its_alarm_does_not_run_again() {
        let mut shared = shared();
        let due = turn(&mut shared, Instant::ZERO);
        shared.armed = due;
        shared.run_due(due);
        // A run would compute the deadline anew.
        shared.node.wakes_mut().set(None);
        assert_eq!(turn(&mut shared, due), Instant::NEVER);
        shared.armed = due + Duration::from_micros(1);
        assert_ne!(turn(&mut shared, due + Duration::from_micros(1)), Instant::NEVER);
    }

    /// Given a slave whose alarm is set to its next heartbeat, when any bit of the instant at which the node runs next flips, then
    /// the heartbeat is sent when the alarm fires.
    #[test]
    fn the_node_runs_at_its_alarm_whatever_bit_has_flipped() {
        for bit in 0..64 {
            let mut shared = shared();
            let (period, mut due) = (Settings::DEFAULT.heartbeats.producer, Instant::ZERO);
            // Filters go first, one after the other.
            while due < Instant::ZERO + period {
                due = turn(&mut shared, due);
                while shared.out.pop_command().is_some() {}
            }
            while shared.queues[Bus::Nominal].pop().is_some() {}
            shared.armed = due;
            let wakes = shared.node.wakes_mut();
            wakes.set(Some(Instant::from_micros(due.as_micros() ^ 1 << bit)));
            let next = turn(&mut shared, due);
            assert!(shared.queues[Bus::Nominal].pop().is_some(), "bit {bit}");
            assert!(due < next && next <= due + period, "bit {bit}");
        }
    }
}
