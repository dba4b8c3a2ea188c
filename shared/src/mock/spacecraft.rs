//! Spacecraft of mock boards: several nodes on two buses in one process, in virtual time.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::future::Future;

use super::{LoopbackPort, ManualClock, MockBoard, Tasks};
use crate::node::Node;
use crate::runner::{Clock, Connection, Diagnostics, Events, Handle, Resources};
use crate::types::{Bus, Frame, Instant, PerBus};

/// Several nodes on two buses. All have the same clock.
///
/// A frame reaches every other node on its bus whose filters admit it, in no time. A bus is whole or
/// [cut](MockSpacecraft::cut).
///
/// A master finds a slave, loses the nominal bus, and goes on with the redundant one:
///
/// ```
/// use ecss_can::mock::MockSpacecraft;
/// use ecss_can::prelude::*;
///
/// # /// A device without objects and PDOs of its own.
/// # #[derive(Objects)]
/// # #[objects(device)]
/// # struct Bare {}
/// # impl Device for Bare {
/// #     type Pdos = PdoObjects<0, 0>;
/// #     type Consumers = HeartbeatConsumers<1>;
/// #     const PDOS: PdoSet = PdoSet::NONE;
/// # }
/// let mut spacecraft = MockSpacecraft::new();
/// let (master, _) = spacecraft.power_on(|| Master::builder(&Profile::DEFAULT, Bare::default()).build());
/// let slave = Slave::builder(NodeId::of::<3>(), &Profile::DEFAULT, Bare::default());
/// let (slave, _) = spacecraft.power_on(|| slave.build());
///
/// spacecraft.run_until(Instant::from_micros(2_000_000));
/// assert!(master.may_command(NodeId::of::<3>()));
///
/// spacecraft.cut(Bus::Nominal);
/// let sent = spacecraft.run_until(Instant::from_micros(3_000_000));
/// assert!(sent.iter().any(|one| one.bus == Bus::Redundant && one.frame.id().raw() == 0x701));
/// assert_eq!(slave.status().active, Bus::Redundant);
/// ```
///
/// # Limits
///
/// - There is no arbitration: frames of one instant pass in the order of the nodes.
/// - The storage of a node is never freed.
#[derive(Default)]
pub struct MockSpacecraft {
    clock: ManualClock,
    nodes: Vec<PerBus<LoopbackPort>>,
    is_cut: PerBus<bool>,
    tasks: Tasks,
}

/// Steps at one instant, of which a long transfer by SDO needs one for each frame.
const MOST_STEPS: u32 = 100_000;

/// Frame that a node sent and another one acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SentFrame {
    /// End of the frame.
    pub at: Instant,
    /// Bus of the frame.
    pub bus: Bus,
    /// The frame, with its data.
    pub frame: Frame,
}

impl MockSpacecraft {
    /// Makes a spacecraft without nodes.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the present instant of all nodes.
    pub fn now(&self) -> Instant {
        self.clock.now()
    }

    /// Makes a node on both buses and powers it on.
    pub fn power_on<N: Node>(
        &mut self,
        node: impl FnOnce() -> N,
    ) -> (Handle<MockBoard, N>, Events<MockBoard, N>) {
        let ports = PerBus::from_fn(|_| LoopbackPort::new(&self.clock));
        for bus in Bus::ALL.into_iter().filter(|bus| self.is_cut[*bus]) {
            ports[bus].cut();
        }
        self.nodes.push(ports.clone());
        let resources: &'static Resources<MockBoard, N> = Box::leak(Box::new(Resources::new()));
        let diagnostics: &'static Diagnostics = Box::leak(Box::new(Diagnostics::new()));
        let (handle, events, runners) =
            resources.start(node, Connection { ports, clock: self.clock.clone() }, diagnostics);
        self.tasks.spawn_node(runners);
        (handle, events)
    }

    /// Adds a task, for example the application of a node.
    pub fn spawn<F: Future + 'static>(&mut self, task: F) {
        self.tasks.spawn(task);
    }

    /// Cuts a bus between all nodes: none of their frames is acknowledged.
    pub fn cut(&mut self, bus: Bus) {
        self.is_cut[bus] = true;
        self.nodes.iter().for_each(|ports| ports[bus].cut());
    }

    /// Mends a bus. Frames that still wait in mailboxes go out with the next step.
    pub fn mend(&mut self, bus: Bus) {
        self.is_cut[bus] = false;
        self.nodes.iter().for_each(|ports| ports[bus].mend());
    }

    /// Runs all tasks until they wait, and delivers the frames that they sent. If there are none, time advances to the
    /// next deadline of a task, at most to `end`. Returns the frames; the tasks of their receivers have not run yet.
    pub fn step(&mut self, end: Instant) -> Vec<SentFrame> {
        self.tasks.run();
        let sent = self.deliver();
        if sent.is_empty() {
            let next = self.clock.deadline().map_or(end, |deadline| deadline.min(end));
            self.clock.advance(next.since(self.now()));
        }
        sent
    }

    /// Runs until `end`. Returns the frames that were sent, the first one first.
    ///
    /// # Panics
    /// When time stands still, for example because applications answer each other without end: frames take no time.
    pub fn run_until(&mut self, end: Instant) -> Vec<SentFrame> {
        let (mut all, mut steps) = (Vec::new(), 0);
        while self.now() < end {
            let before = self.now();
            all.extend(self.step(end));
            steps = if self.now() == before { steps + 1 } else { 0 };
            assert!(
                steps < MOST_STEPS,
                "time stands still at {before:?}: frames answer each other without end"
            );
        }
        all
    }

    fn deliver(&self) -> Vec<SentFrame> {
        let mut delivered = Vec::new();
        for (sender, ports) in self.nodes.iter().enumerate() {
            for bus in Bus::ALL {
                for frame in ports[bus].sent() {
                    let others = self.nodes.iter().enumerate().filter(|(other, _)| *other != sender);
                    others.for_each(|(_, ports)| {
                        ports[bus].receive(frame);
                    });
                    delivered.push(SentFrame { at: self.now(), bus, frame });
                }
            }
        }
        delivered
    }
}
