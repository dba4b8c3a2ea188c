//! The tasks of a board, in a fixed order, with a flag for pending work.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};

use futures_util::StreamExt;
use futures_util::future::{FutureExt, LocalBoxFuture};
use futures_util::stream::FuturesUnordered;

use crate::timeline::MAX_STEPS_PER_INSTANT;

type Task = LocalBoxFuture<'static, ()>;

/// Tasks of one board. With many boards most have no work at most instants, which one flag shows.
pub(crate) struct Pool {
    tasks: FuturesUnordered<Task>,
    spawned: Rc<RefCell<Vec<Task>>>,
    alarm: Arc<Alarm>,
}

/// Spawns tasks.
#[derive(Clone)]
pub(crate) struct Spawner {
    spawned: Rc<RefCell<Vec<Task>>>,
    alarm: Arc<Alarm>,
}

#[derive(Default)]
struct Alarm(AtomicBool);

impl Wake for Alarm {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Alarm {
    fn take(&self) -> bool {
        self.0.swap(false, Ordering::Relaxed)
    }
}

impl Pool {
    pub fn new() -> Pool {
        Pool { tasks: FuturesUnordered::new(), spawned: Rc::default(), alarm: Arc::default() }
    }

    pub fn spawner(&self) -> Spawner {
        Spawner { spawned: self.spawned.clone(), alarm: self.alarm.clone() }
    }

    /// Polls all tasks until none can continue now.
    ///
    /// # Panics
    /// When they keep waking each other.
    pub fn run_until_stalled(&mut self) {
        if !self.alarm.take() {
            return;
        }
        let waker = Waker::from(self.alarm.clone());
        let mut context = Context::from_waker(&waker);
        for _ in 0..MAX_STEPS_PER_INSTANT {
            self.tasks.extend(self.spawned.borrow_mut().drain(..));
            let is_idle = !matches!(self.tasks.poll_next_unpin(&mut context), Poll::Ready(Some(())));
            if is_idle && self.spawned.borrow().is_empty() && !self.alarm.take() {
                return;
            }
        }
        panic!("tasks wake each other without end");
    }
}

impl Spawner {
    pub fn spawn(&self, task: impl Future<Output = ()> + 'static) {
        self.spawned.borrow_mut().push(task.boxed_local());
        self.alarm.clone().wake();
    }
}
