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

/// Does what is due; when to come again.
fn turn<N: Node>(shared: &mut Shared<N>, now: Instant) -> Instant {
    if shared.is_due(now) {
        shared.run_due(now);
    }
    shared.tell_application();
    shared.node.deadline().unwrap_or(Instant::NEVER)
}
