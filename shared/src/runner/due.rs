//! What is due by time.

use core::convert::Infallible;
use core::future::poll_fn;
use core::pin::pin;
use core::task::Poll;

use super::alarm::Alarm;
use super::resources::{Core, Platform};
use super::shared::register;
use crate::node::Node;
use crate::time::Clock;
use crate::types::Instant;

/// Runs what is due by time. For a task of its own.
pub struct DueRunner<B: Platform, N: Node> {
    core: &'static Core<B, N>,
}

impl<B: Platform, N: Node> DueRunner<B, N> {
    pub(super) const fn new(core: &'static Core<B, N>) -> Self {
        DueRunner { core }
    }

    /// Runs for ever.
    pub async fn run(self) -> ! {
        let core = self.core;
        let timer = pin!(None);
        let mut alarm = Alarm::new(timer);
        let mut step = Step::Poll;
        match poll_fn(|context| {
            let now = core.clock.now();
            core.lock(|shared| {
                let due = shared.node.deadline().unwrap_or(Instant::NEVER);
                match step {
                    Step::Poll if due <= now => {
                        // First of all: a bus that is woken during this step has its turn before the next one.
                        context.waker().wake_by_ref();
                        shared.node.poll(now, &mut shared.out);
                        step = Step::Deliver;
                    }
                    Step::Deliver => {
                        context.waker().wake_by_ref();
                        // A bus alone obeys other commands than frames.
                        shared.deliver(None, now);
                        shared.tell_application();
                        step = Step::Arm;
                    }
                    Step::Poll | Step::Arm => {
                        if register(&mut shared.timekeeper, context) {
                            alarm.arm(due, context, || core.clock.at(due));
                        } else {
                            alarm.set(due, now, context, || core.clock.at(due));
                        }
                        shared.armed = alarm.at();
                        step = Step::Poll;
                    }
                }
            });
            Poll::<Infallible>::Pending
        })
        .await {}
    }
}

/// What is done in one turn. A frame that is received meanwhile waits for the end of one step, not for all that is due.
enum Step {
    /// The node does what is due.
    Poll,
    /// Frames go into the queues of their buses, events to the application.
    Deliver,
    /// The task is woken when something is due next.
    Arm,
}
