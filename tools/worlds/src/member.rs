//! A node of any device: interface for its application and for a world.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::rc::Rc;

use can_twin::wire::time::Time;
use ecss_can::node::minimal::{MinimalDevice, MinimalEvent, MinimalSlave};
use ecss_can::node::{
    Master, MasterEvent, MasterRequest, Node, NodeObjects, Slave, SlaveEvent, SpacecraftDevice, Status,
};
use ecss_can::redundancy::MasterBoards;
use ecss_can::runner::extend::WholeNode;
use ecss_can::runner::{self, EventSource};
use ecss_can::types::{AbortCode, Address, Instant};
use ecss_can_eds::pdos;

use crate::board::MockBoard;
use crate::key::NodeKey;
use crate::log::{Entry, NodeEvent};
use crate::timeline::Timeline;

/// A node, for its application and for a test.
pub type Handle<N> = runner::Handle<MockBoard, N>;

/// A master, a slave or a minimal slave, of any device.
pub trait Member: Node + Sized {
    /// Converts an event for the log of a world.
    fn node_event(event: &Self::Event) -> NodeEvent;

    /// Returns whether an event requests a reset of the chip.
    fn is_reset(_: &Self::Event) -> bool {
        false
    }

    /// Converts a request to a master; `None` for a slave.
    fn request(_: MasterRequest) -> Option<Self::Request> {
        None
    }

    /// Returns the status of the node at `now`; `None` for a minimal slave.
    fn status(&self, _now: Instant) -> Option<Status> {
        None
    }

    /// Returns the present PDOs of its dictionary; `None` for a minimal slave, which has no mappings.
    fn pdos(&self, _name: &str) -> Option<pdos::Node> {
        None
    }

    /// Returns whether it is a master that manages the network now.
    fn is_active_master(&self) -> bool {
        false
    }

    /// Writes an object as the application does.
    ///
    /// # Errors
    /// [`AbortCode`], as for a client of the SDO server. A minimal slave has no objects.
    fn write(_: &Handle<Self>, _at: Address, _value: &[u8]) -> Result<(), AbortCode> {
        Err(AbortCode::NoObject)
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> Member for Master<D, B> {
    fn node_event(event: &MasterEvent) -> NodeEvent {
        NodeEvent::Master(*event)
    }

    fn request(request: MasterRequest) -> Option<MasterRequest> {
        Some(request)
    }

    fn status(&self, now: Instant) -> Option<Status> {
        Some(self.status(now))
    }

    fn pdos(&self, name: &str) -> Option<pdos::Node> {
        mapped(name, self.objects())
    }

    fn is_active_master(&self) -> bool {
        self.is_active()
    }

    fn write(handle: &Handle<Self>, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        handle.write(at, value)
    }
}

impl<D: SpacecraftDevice> Member for Slave<D> {
    fn node_event(event: &SlaveEvent) -> NodeEvent {
        NodeEvent::Slave(*event)
    }

    fn is_reset(event: &SlaveEvent) -> bool {
        *event == SlaveEvent::ResetNode
    }

    fn status(&self, now: Instant) -> Option<Status> {
        Some(self.status(now))
    }

    fn pdos(&self, name: &str) -> Option<pdos::Node> {
        mapped(name, self.objects())
    }

    fn write(handle: &Handle<Self>, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        handle.write(at, value)
    }
}

impl<D: MinimalDevice> Member for MinimalSlave<D> {
    fn node_event(event: &MinimalEvent) -> NodeEvent {
        NodeEvent::Minimal(*event)
    }
}

/// Returns the present PDOs of a dictionary.
fn mapped<D: SpacecraftDevice>(name: &str, objects: &NodeObjects<D>) -> Option<pdos::Node> {
    pdos::Node::of::<NodeObjects<D>, _>(name, &mut objects.pdos.clone()).ok()
}

/// Events of a node for its application. Each event that is taken is added to the log of the world.
pub struct Events<N: Member> {
    events: runner::Events<MockBoard, N>,
    diary: Diary,
    reset: Rc<Cell<bool>>,
}

impl<N: Member> Events<N> {
    pub(crate) fn new(events: runner::Events<MockBoard, N>, diary: Diary, reset: Rc<Cell<bool>>) -> Self {
        Events { events, diary, reset }
    }

    /// Waits for the next event. Cancel-safe: a dropped future loses no event.
    pub async fn next(&mut self) -> N::Event {
        let event = self.events.next().await;
        self.diary.note(N::node_event(&event));
        event
    }

    /// Resets the chip, as `ecss_can_stm32f4::reset` does, once all its tasks wait.
    pub fn reset(&self) {
        self.reset_line().reset();
    }

    /// Returns the reset of the chip, for an application that owns its events.
    pub fn reset_line(&self) -> ResetLine {
        ResetLine(self.reset.clone())
    }

    /// Returns the present of the world, which is not known to nodes.
    pub fn world_time(&self) -> Time {
        self.diary.timeline.now()
    }
}

impl<N: Member> EventSource for Events<N> {
    type Event = N::Event;

    fn next(&mut self) -> impl Future<Output = N::Event> {
        Events::next(self)
    }
}

/// The reset of a chip.
#[derive(Clone, Debug)]
pub struct ResetLine(Rc<Cell<bool>>);

impl ResetLine {
    /// Resets the chip, once all its tasks wait.
    pub fn reset(&self) {
        self.0.set(true);
    }
}

/// An application that takes all events, executes resets, and does nothing else.
pub async fn idle<N: Member>(_: Handle<N>, mut events: Events<N>) {
    loop {
        if N::is_reset(&events.next().await) {
            events.reset();
        }
    }
}

/// Access of a node to the log of the world.
#[derive(Clone)]
pub(crate) struct Diary {
    pub key: NodeKey,
    pub timeline: Rc<Timeline>,
    pub entries: Rc<RefCell<Vec<Entry>>>,
}

impl Diary {
    pub fn note(&self, what: NodeEvent) {
        self.entries.borrow_mut().push(Entry {
            at: self.timeline.now(),
            node: self.key.node(),
            key: self.key,
            what,
        });
    }
}

/// A node with power, of any device.
pub(crate) trait Running {
    /// `None` for a minimal slave.
    fn status(&self) -> Option<Status>;
    fn pdos(&self, name: &str) -> Option<pdos::Node>;
    fn is_active_master(&self) -> bool;
    fn write(&self, at: Address, value: &[u8]) -> Result<(), AbortCode>;
    /// Makes a request. Returns `false` for a slave, which accepts none.
    fn request(&self, request: MasterRequest) -> bool;
    fn handle(&self) -> &dyn Any;
}

impl<N: Member> Running for Handle<N> {
    fn status(&self) -> Option<Status> {
        self.with(|node, now| Member::status(node, now))
    }

    fn pdos(&self, name: &str) -> Option<pdos::Node> {
        self.with(|node, _| Member::pdos(node, name))
    }

    fn is_active_master(&self) -> bool {
        self.with(|node, _| node.is_active_master())
    }

    fn write(&self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        N::write(self, at, value)
    }

    fn request(&self, request: MasterRequest) -> bool {
        N::request(request).map(|request| WholeNode::request(self, request)).is_some()
    }

    fn handle(&self) -> &dyn Any {
        self
    }
}
