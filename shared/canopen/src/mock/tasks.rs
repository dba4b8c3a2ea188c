//! Tasks of mock boards, without an executor.

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::task::Wake;
use alloc::vec::Vec;
use core::future::Future;
use core::pin::{Pin, pin};
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::{Context, Poll, Waker};

use super::MockBoard;
use crate::node::Node;
use crate::runner::{Runners, SingleRunners};

/// Rounds in which tasks come to rest, unless they wake each other without end.
const MOST_ROUNDS: u32 = 10_000;

/// Tasks of nodes and applications on mock boards. On a board an executor runs them.
#[derive(Default)]
pub struct Tasks {
    tasks: Vec<Task>,
}

struct Task {
    future: Pin<Box<dyn Future<Output = ()>>>,
    is_woken: Arc<Woken>,
}

struct Woken(AtomicBool);

impl Wake for Woken {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Tasks {
    /// Makes a task of each runner.
    pub fn new<N: Node>(runners: Runners<MockBoard, N>) -> Self {
        let mut tasks = Tasks::default();
        tasks.spawn_node(runners);
        tasks
    }

    /// Adds a task for each runner of one more node, which is on two buses.
    pub fn spawn_node<N: Node>(&mut self, runners: Runners<MockBoard, N>) {
        let Runners { nominal, redundant, due } = runners;
        self.spawn(nominal.run());
        self.spawn(redundant.run());
        self.spawn(due.run());
    }

    /// Adds a task for each runner of one more node, which is on one bus.
    pub fn spawn_single<N: Node>(&mut self, runners: SingleRunners<MockBoard, N>) {
        let SingleRunners { bus, due } = runners;
        self.spawn(bus.run());
        self.spawn(due.run());
    }

    /// Adds a task, for example an application.
    pub fn spawn<F: Future + 'static>(&mut self, task: F) {
        let future = Box::pin(async {
            task.await;
        });
        self.tasks.push(Task { future, is_woken: Arc::new(Woken(AtomicBool::new(true))) });
    }

    /// Runs the tasks until each of them waits or has ended.
    ///
    /// # Panics
    /// When tasks wake each other, or themselves, without end.
    pub fn run(&mut self) {
        for _ in 0..MOST_ROUNDS {
            let mut is_at_rest = true;
            self.tasks.retain_mut(|Task { future, is_woken }| {
                if !is_woken.0.swap(false, Ordering::Relaxed) {
                    return true;
                }
                is_at_rest = false;
                let waker = Waker::from(is_woken.clone());
                future.as_mut().poll(&mut Context::from_waker(&waker)).is_pending()
            });
            if is_at_rest {
                return;
            }
        }
        panic!("tasks wake each other without end: let them wait for an event or for the clock");
    }
}

/// Polls a future once. Returns its result, `None` if it has to wait.
pub fn poll_once<F: Future>(future: F) -> Option<F::Output> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => Some(result),
        Poll::Pending => None,
    }
}
