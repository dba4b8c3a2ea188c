//! Mock of a board, for tests and examples of an application (feature `mock`).
//!
//! A *mock board* has a clock that the test sets, [`ManualClock`], and a port for each bus, [`LoopbackPort`]. The port
//! acknowledges every frame of the node at once and keeps it for the test. [`Tasks`] runs the node without an executor.
//!
//! ```
//! use ecss_can::mock::{LoopbackPort, ManualClock, MockBoard, Tasks};
//! use ecss_can::prelude::*;
//!
//! /// A device without objects and PDOs of its own.
//! #[derive(Objects)]
//! #[objects(device)]
//! struct Bare {}
//!
//! impl Device for Bare {
//!     type Pdos = PdoObjects<0, 0>;
//!     type Consumers = HeartbeatConsumers<1>;
//!     const PDOS: PdoSet = PdoSet::NONE;
//! }
//!
//! static DIAGNOSTICS: Diagnostics = Diagnostics::new();
//! static RESOURCES: Resources<MockBoard, Slave<Bare>> = Resources::new();
//! let clock = ManualClock::new();
//! let ports = PerBus::from_fn(|_| LoopbackPort::new(&clock));
//! let slave = || Slave::new(NodeId::of::<3>(), &Profile::DEFAULT, Bare::default());
//! let (_, mut events, runners) = RESOURCES.start(slave, ports.clone(), clock.clone(), &DIAGNOSTICS);
//!
//! let mut tasks = Tasks::new(runners);
//! tasks.run();
//! clock.advance(Profile::DEFAULT.heartbeat);
//! tasks.run();
//! let sent = ports.nominal.sent();
//! assert_eq!(sent.len(), 2); // the boot-up message, and a heartbeat after its period
//! assert_eq!((sent[1].id().raw(), sent[1].data()), (0x703, &[0x7F][..]));
//! assert!(ecss_can::mock::poll_once(events.next()).is_some());
//! ```
//!
//! # Limits
//!
//! The module needs an allocator. A port sends in no time: there is no arbitration, no error and no bus-off. The packages
//! `twin/wire` and `tests/host` of the repository simulate these.

use alloc::boxed::Box;
use alloc::collections::VecDeque;
use alloc::rc::Rc;
use alloc::sync::Arc;
use alloc::task::Wake;
use alloc::vec::Vec;
use core::cell::{Cell, RefCell};
use core::future::{Future, poll_fn};
use core::pin::{Pin, pin};
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::{Context, Poll, Waker};

use crate::link::Stamp;
use crate::link::port::{Busy, CanPort, Filter, Health, Mailbox, PortEvent};
use crate::node::Node;
use crate::runner::{Platform, Runners};
use crate::time::Clock;
use crate::types::{Duration, Frame, Instant};

/// Mock board: a [`LoopbackPort`] for each bus and a [`ManualClock`].
pub struct MockBoard;

impl Platform for MockBoard {
    type Port = LoopbackPort;
    type Clock = ManualClock;
}

/// Clock that shows power-on until the test advances it. Clones show the same time.
#[derive(Clone, Debug, Default)]
pub struct ManualClock(Rc<Time>);

#[derive(Debug, Default)]
struct Time {
    now: Cell<Instant>,
    waiting: RefCell<Vec<Waker>>,
}

impl ManualClock {
    /// Makes a clock that shows power-on.
    pub fn new() -> Self {
        Self::default()
    }

    /// Advances the clock by `span` and wakes the tasks that wait for it.
    pub fn advance(&self, span: Duration) {
        self.0.now.set(self.0.now.get() + span);
        self.0.waiting.take().into_iter().for_each(Waker::wake);
    }
}

impl Clock for ManualClock {
    fn now(&self) -> Instant {
        self.0.now.get()
    }

    async fn at(&self, deadline: Instant) {
        poll_fn(|context| {
            if self.now() >= deadline {
                return Poll::Ready(());
            }
            self.0.waiting.borrow_mut().push(context.waker().clone());
            Poll::Pending
        })
        .await;
    }
}

/// Port that acknowledges every frame at once and keeps it. Clones are the same port.
#[derive(Clone, Debug)]
pub struct LoopbackPort {
    controller: Rc<RefCell<Controller>>,
    clock: ManualClock,
}

#[derive(Debug, Default)]
struct Controller {
    /// On the bus: receives frames.
    receives: bool,
    /// On the bus and not only listening: sends frames.
    sends: bool,
    filters: Vec<Filter>,
    /// Events that the node did not take yet.
    events: VecDeque<PortEvent>,
    /// Frames of the node that the test did not take yet.
    sent: Vec<Frame>,
    waiting: Option<Waker>,
}

impl LoopbackPort {
    /// Makes a port that is off its bus. `clock` gives the stamps of its frames.
    pub fn new(clock: &ManualClock) -> Self {
        LoopbackPort { controller: Rc::default(), clock: clock.clone() }
    }

    /// Returns the frames that the node sent since the last call.
    pub fn sent(&self) -> Vec<Frame> {
        core::mem::take(&mut self.controller.borrow_mut().sent)
    }

    /// Sends a frame to the node, which ended now. Returns whether the node received it: it is on the bus, and one of its
    /// filters admits the frame.
    pub fn receive(&self, frame: Frame) -> bool {
        let controller = &mut *self.controller.borrow_mut();
        let is_received = controller.receives && controller.filters.iter().any(|one| one.admits(frame.id()));
        if is_received {
            controller.report(PortEvent::Received { frame, stamp: Stamp::interrupt(self.clock.now()) });
        }
        is_received
    }
}

impl Controller {
    fn report(&mut self, event: PortEvent) {
        self.events.push_back(event);
        if let Some(waiting) = self.waiting.take() {
            waiting.wake();
        }
    }
}

impl CanPort for LoopbackPort {
    type PerMailbox<T: Default> = [T; 3];

    const FILTERS: usize = 28;

    fn set_filters(&mut self, filters: &[Filter]) {
        self.controller.borrow_mut().filters = filters.to_vec();
    }

    fn set_filter(&mut self, number: u8, filter: Filter) {
        if let Some(place) = self.controller.borrow_mut().filters.get_mut(usize::from(number)) {
            *place = filter;
        }
    }

    fn join(&mut self) {
        let mut controller = self.controller.borrow_mut();
        (controller.receives, controller.sends) = (true, true);
    }

    fn listen(&mut self) {
        let mut controller = self.controller.borrow_mut();
        (controller.receives, controller.sends) = (true, false);
    }

    fn leave(&mut self) {
        let mut controller = self.controller.borrow_mut();
        (controller.receives, controller.sends) = (false, false);
    }

    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        let controller = &mut *self.controller.borrow_mut();
        if !controller.sends {
            return Err(Busy);
        }
        controller.sent.push(*frame);
        let stamp = Stamp::interrupt(self.clock.now());
        controller.report(PortEvent::Transmitted { mailbox: Mailbox(0), stamp });
        Ok(Mailbox(0))
    }

    fn abort(&mut self, _: Mailbox) {}

    fn health(&self) -> Health {
        Health::default()
    }

    fn recover(&mut self) {}

    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        let controller = &mut *self.controller.borrow_mut();
        controller.events.pop_front().map_or_else(
            || {
                controller.waiting = Some(context.waker().clone());
                Poll::Pending
            },
            Poll::Ready,
        )
    }
}

/// Tasks of a node on a mock board. On a board an executor runs them.
pub struct Tasks {
    futures: [Pin<Box<dyn Future<Output = ()>>>; 3],
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
        let Runners { nominal, redundant, due } = runners;
        Tasks {
            futures: [
                Box::pin(async { nominal.run().await }),
                Box::pin(async { redundant.run().await }),
                Box::pin(async { due.run().await }),
            ],
            is_woken: Arc::new(Woken(AtomicBool::new(false))),
        }
    }

    /// Runs the tasks until all of them wait.
    pub fn run(&mut self) {
        let waker = Waker::from(self.is_woken.clone());
        loop {
            self.is_woken.0.store(false, Ordering::Relaxed);
            for future in &mut self.futures {
                let _ = future.as_mut().poll(&mut Context::from_waker(&waker));
            }
            if !self.is_woken.0.load(Ordering::Relaxed) {
                return;
            }
        }
    }
}

/// Polls a future once. Returns its result, `None` if it has to wait.
pub fn poll_once<F: Future>(future: F) -> Option<F::Output> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => Some(result),
        Poll::Pending => None,
    }
}
