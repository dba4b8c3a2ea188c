//! State of a controller that changes while a frame waits to be handled: the event of the change comes behind that frame.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use ecss_can::link::Stamp;
use ecss_can::link::port::{Busy, CanPort, ErrorState, Filter, Health, LastError, Mailbox, PortEvent};
use ecss_can::node::extend::LinkEvent;
use ecss_can::runner::{Connection, Platform, Resources, Runners};
use ecss_can::types::{FineInstant, Frame, PerBus};
use ecss_can_worlds::clock::MockClock;
use ecss_can_worlds::timeline::Timeline;
use futures_executor::LocalPool;
use futures_util::task::LocalSpawnExt;

use crate::bench::{Probe, frame};

/// Port with health and events from the test.
#[derive(Clone, Default)]
struct Scripted(Rc<RefCell<Script>>);

#[derive(Default)]
struct Script {
    health: Health,
    events: VecDeque<PortEvent>,
    waiting: Option<Waker>,
}

impl Scripted {
    /// The controller has received a frame, and then its state has changed, before the node takes an event.
    fn receive_and_become(&self, health: Health) {
        let mut script = self.0.borrow_mut();
        script.health = health;
        script
            .events
            .extend([PortEvent::Received { frame: heartbeat(), stamp: stamp() }, PortEvent::Health(health)]);
        if let Some(waiting) = script.waiting.take() {
            waiting.wake();
        }
    }
}

impl CanPort for Scripted {
    type PerMailbox<T: Default> = [T; 1];

    const FILTERS: usize = 28;

    fn set_filters(&mut self, _: &[Filter]) {}

    fn set_filter(&mut self, _: u8, _: Filter) {}

    fn join(&mut self) {}

    fn listen(&mut self) {}

    fn leave(&mut self) {}

    fn send(&mut self, _: &Frame) -> Result<Mailbox, Busy> {
        Err(Busy)
    }

    fn abort(&mut self, _: Mailbox) {}

    fn health(&self) -> Health {
        self.0.borrow().health
    }

    fn recover(&mut self) {}

    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        let mut script = self.0.borrow_mut();
        match script.events.pop_front() {
            Some(event) => Poll::Ready(event),
            None => {
                script.waiting = Some(context.waker().clone());
                Poll::Pending
            }
        }
    }
}

struct Board;

impl Platform for Board {
    type Port = Scripted;
    type Clock = MockClock;
}

fn heartbeat() -> Frame {
    frame(0x70A, 5)
}

fn stamp() -> Stamp {
    Stamp::captured(FineInstant::from_units(0))
}

/// Given a frame that waits for the node, when the controller becomes error passive or error active before the node handles the frame,
/// then the runner reports the new state once, with that frame. The later event of the controller adds no report.
///
/// Verifies: ECSS 5.6.2b, 5.6.2a
/// Notices: ECSS 5.6.2b: a change of the state that is seen before its event counts as a change of the counters alone.
/// Notices: ECSS 5.6.2a: error passive that is seen before its event is no state.
#[test]
fn state_seen_before_its_event_is_reported_once() {
    let clock = MockClock::power_on(Timeline::new(), 0);
    let ports = PerBus::from_fn(|_| Scripted::default());
    let port = ports.nominal.clone();
    let resources: &Resources<Board, Probe> = Box::leak(Box::default());
    let probe = Probe::default();
    let (_, _, runners) =
        resources.start(|| probe.clone(), Connection { ports, clock }, Box::leak(Box::default()));
    let Runners { nominal, .. } = runners;
    let mut pool = LocalPool::new();
    pool.spawner().spawn_local(async { nominal.run().await }).expect("the pool lives");
    pool.run_until_stalled();

    let passive = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Form };
    let active = Health { state: ErrorState::Active, tec: 127, ..passive };
    for health in [passive, active] {
        port.receive_and_become(health);
        pool.run_until_stalled();
        let told = std::mem::take(&mut *probe.told.borrow_mut());
        let received = LinkEvent::Received { frame: heartbeat(), stamp: stamp() };
        assert_eq!(told, [LinkEvent::Health(health), received]);
    }
}
