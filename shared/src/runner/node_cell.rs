//! A node with its queues, shared by the tasks of its buses, the task of what is due, and its application.

use core::cell::RefCell;
use core::task::{Context, Waker};

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::RawMutex;

use super::Surroundings;
use crate::link::queue::{Outgoing, TxQueue};
use crate::node::{BusCommand, FailCause, LinkEvent, Node, Outbox, QUEUE_DEPTH};
use crate::types::{Bus, Instant, PerBus};

/// Holds a node. Its tasks work on it in place, and the application has access between two steps of the protocol.
pub struct NodeCell<M: RawMutex, N: Node> {
    shared: Mutex<M, RefCell<Shared<N>>>,
}

impl<M: RawMutex, N: Node> NodeCell<M, N> {
    /// Takes a node before power-on.
    pub const fn new(node: N) -> Self {
        NodeCell { shared: Mutex::new(RefCell::new(Shared::new(node))) }
    }

    /// Reads or changes the node, its objects above all. [`node_task`](super::node_task) then does at once what has become
    /// due, such as sending a PDO.
    ///
    /// # Panics
    /// When called from within itself.
    pub fn with<R>(&self, f: impl FnOnce(&mut N) -> R) -> R {
        self.lock(|shared| {
            let result = f(&mut shared.node);
            wake(&shared.timekeeper);
            result
        })
    }

    /// As [`NodeCell::with`], but nothing has become due.
    pub(super) fn step<R>(&self, f: impl FnOnce(&mut N) -> R) -> R {
        self.lock(|shared| f(&mut shared.node))
    }

    #[inline]
    pub(super) fn lock<R>(&self, f: impl FnOnce(&mut Shared<N>) -> R) -> R {
        self.shared.lock(|shared| f(&mut shared.borrow_mut()))
    }
}

/// A node and what it wants sent.
pub(super) struct Shared<N: Node> {
    pub node: N,
    pub out: Outbox<N::Event>,
    pub queues: PerBus<TxQueue<QUEUE_DEPTH>>,
    /// The tasks of both buses.
    pub buses: PerBus<Option<Waker>>,
    /// The task of what is due.
    pub timekeeper: Option<Waker>,
    /// When that task looks at the node by itself; `None` before power-on.
    pub armed: Option<Instant>,
}

impl<N: Node> Shared<N> {
    const fn new(node: N) -> Self {
        Shared {
            node,
            out: Outbox::new(),
            queues: PerBus { nominal: TxQueue::new(), redundant: TxQueue::new() },
            buses: PerBus { nominal: None, redundant: None },
            timekeeper: None,
            armed: None,
        }
    }

    /// Whether there is something to send on a bus, or to deliver.
    #[inline]
    pub fn is_asked(&self, bus: Bus) -> bool {
        !(self.out.is_empty() && self.queues[bus].is_empty())
    }

    /// Ends a step of the node: events go to the application, frames into the queues of their buses. Other commands to
    /// `here` are returned one by one, those to the other bus wait for its task.
    ///
    /// Call until `None`.
    #[inline]
    pub fn deliver<M: RawMutex>(
        &mut self,
        here: Option<Bus>,
        now: Instant,
        around: &Surroundings<'_, M, N>,
    ) -> Option<BusCommand> {
        if self.out.is_empty() { None } else { self.empty_outbox(here, now, around) }
    }

    #[inline(never)] // most frames leave nothing in it
    fn empty_outbox<M: RawMutex>(
        &mut self,
        here: Option<Bus>,
        now: Instant,
        around: &Surroundings<'_, M, N>,
    ) -> Option<BusCommand> {
        let mut found = None;
        // A loss may make the node send again. What is left then has its turn at the next step.
        for _ in 0..2 {
            around.telltale.app_overflows().add(self.out.take_overflows());
            for bus in Bus::ALL {
                let frames = self.out.take_unsent(bus);
                if frames > 0 {
                    self.node.on_link(bus, &LinkEvent::Unsent { frames }, now, &mut self.out);
                }
            }
            found = self.take_commands(here, now);
            if self.out.is_empty() || found.is_some() {
                break;
            }
        }
        while let Some(event) = self.out.pop_event() {
            if around.app.events.try_send(event).is_err() {
                around.telltale.app_overflows().count();
            }
        }
        found
    }

    /// Looks at every command once. One that has to wait goes behind the others, and so do all after it for the same bus:
    /// each bus has its own in order.
    fn take_commands(&mut self, here: Option<Bus>, now: Instant) -> Option<BusCommand> {
        let mut waits = PerBus { nominal: false, redundant: false };
        let (mut found, mut losses) = (None, 0);
        let mut ahead = self.out.commands();
        while ahead > 0
            && let Some((bus, command)) = self.out.pop_command()
        {
            ahead -= 1;
            match command {
                BusCommand::Send(outgoing) if !waits[bus] && losses < QUEUE_DEPTH => {
                    let before = self.out.commands();
                    losses += usize::from(self.queue(bus, outgoing, here, now));
                    ahead += self.out.commands() - before;
                }
                command if Some(bus) == here && !waits[bus] => {
                    found = Some(command);
                    waits[bus] = true;
                }
                command => {
                    self.out.put_back(bus, command);
                    waits[bus] = true;
                    wake(&self.buses[bus]);
                }
            }
        }
        found
    }

    /// Queues a frame; whether another one or this is lost.
    fn queue(&mut self, bus: Bus, outgoing: Outgoing, here: Option<Bus>, now: Instant) -> bool {
        let queue = &mut self.queues[bus];
        // A task that has frames waits for a mailbox, or for the first end of a lifetime. There may be a mailbox already for
        // a frame that goes before the others.
        let is_next = queue.peek().is_none_or(|next| outgoing.frame.id() < next.frame.id());
        let is_first = queue.next_expiry().is_none_or(|first| outgoing.expires < first);
        if (is_next || is_first) && Some(bus) != here {
            wake(&self.buses[bus]);
        }
        let Some(lost) = queue.push(outgoing).unwrap_or(Some(outgoing)) else { return false };
        let event = LinkEvent::Failed { frame: lost.frame, cause: FailCause::QueueFull };
        self.node.on_link(bus, &event, now, &mut self.out);
        true
    }

    /// Wakes the task of what is due when it would look too late.
    #[inline]
    pub fn keep_time(&self) {
        if let Some(due) = self.node.deadline()
            && self.armed.is_some_and(|armed| due < armed)
        {
            wake(&self.timekeeper);
        }
    }
}

/// Wakes a task that is there.
pub(super) fn wake(task: &Option<Waker>) {
    if let Some(task) = task {
        task.wake_by_ref();
    }
}

/// Keeps the task to wake; whether it is another one than before.
#[inline]
pub(super) fn register(task: &mut Option<Waker>, context: &Context<'_>) -> bool {
    let is_new = !task.as_ref().is_some_and(|task| task.will_wake(context.waker()));
    if is_new {
        *task = Some(context.waker().clone());
    }
    is_new
}
