//! A node with its queues, shared by the tasks of its buses, the task of everything that is due, and its
//! application.

use core::task::{Context, Waker};

use super::Diagnostics;
use crate::link::depth::Depth as _;
use crate::link::queue::{Full, Outgoing, TxQueue};
use crate::node::{BusCommand, FailCause, LinkEvent, Node, Outbox, Turn};
use crate::types::{Bus, Frame, Instant, PerBus};

/// Number of tasks that can wait for a signal of the node.
pub(super) const WAITERS: usize = 4;

/// A node and what it wants sent.
pub(super) struct Shared<N: Node> {
    pub node: &'static mut N,
    pub out: Outbox<N::Event, N::Depth>,
    pub queues: PerBus<TxQueue<N::Depth>>,
    /// The tasks of both buses.
    pub buses: PerBus<Option<Waker>>,
    /// The task of what is due.
    pub timekeeper: Option<Waker>,
    /// Instant at which that task runs by itself.
    pub armed: Instant,
    /// The task of the application, while it waits for events. With `WakerRegistration` of embassy-sync the row
    /// `rx.interrupt_to_application_accelerated` is 2.7 % higher and the master is 224 bytes larger.
    pub listener: Option<Waker>,
    /// Tasks that wait for a signal of the node. When a `MultiWakerRegistration` of embassy-sync is full, it wakes all
    /// tasks: five of them would wake each other without end.
    pub waiters: [Option<Waker>; WAITERS],
    pub diagnostics: &'static Diagnostics,
}

impl<N: Node> Shared<N> {
    #[inline]
    pub fn new(node: &'static mut N, diagnostics: &'static Diagnostics) -> Self {
        Shared {
            node,
            out: Outbox::new(),
            queues: PerBus { nominal: TxQueue::new(), redundant: TxQueue::new() },
            buses: PerBus { nominal: None, redundant: None },
            timekeeper: None,
            armed: Instant::NEVER,
            listener: None,
            waiters: [const { None }; WAITERS],
            diagnostics,
        }
    }

    /// Starts the node. Its commands wait for the tasks.
    pub fn power_on(&mut self, now: Instant) {
        self.node.start(&mut Turn::new(now, &mut self.out));
    }

    /// Makes a step for the application.
    pub fn step<R>(
        &mut self,
        now: Instant,
        step: impl FnOnce(&mut N, &mut Turn<'_, N::Event, N::Depth>) -> R,
    ) -> R {
        let result = step(self.node, &mut Turn::new(now, &mut self.out));
        self.finish(now);
        result
    }

    /// Reports an event of a bus to the node.
    pub fn tell(&mut self, bus: Bus, event: &LinkEvent, now: Instant) {
        self.node.on_link(bus, event, &mut Turn::new(now, &mut self.out));
    }

    /// Returns whether there is a frame to send on a bus, or a command to deliver.
    #[inline]
    pub fn is_asked(&self, bus: Bus) -> bool {
        !(self.out.is_settled() && self.queues[bus].is_empty())
    }

    /// Delivers the commands of a step of the node. Frames go into the queues of their buses. Other commands for
    /// `here` are returned one by one. Other commands for the other bus wait for its task.
    ///
    /// Call it until `None`.
    #[inline]
    pub fn deliver(&mut self, here: Option<Bus>, now: Instant) -> Option<BusCommand> {
        if self.out.is_settled() { None } else { self.empty_outbox(here, now) }
    }

    #[inline(never)] // most frames leave nothing in it
    fn empty_outbox(&mut self, here: Option<Bus>, now: Instant) -> Option<BusCommand> {
        let mut found = None;
        // A loss may make the node send again. What is left then has its turn at the next step.
        for _ in 0..2 {
            self.diagnostics.app_overflows().add(self.out.take_overflows());
            for &bus in &Bus::ALL {
                let frames = self.out.take_unsent(bus);
                if frames > 0 {
                    self.tell(bus, &LinkEvent::Unsent { frames }, now);
                }
            }
            found = self.take_commands(here, now);
            if self.out.is_settled() || found.is_some() {
                break;
            }
        }
        found
    }

    /// Looks at every command once. One that has to wait goes behind the others, and so do all after it for the
    /// same bus: each bus has its own in order.
    fn take_commands(&mut self, here: Option<Bus>, now: Instant) -> Option<BusCommand> {
        let mut waits = PerBus { nominal: false, redundant: false };
        let (mut found, mut losses) = (None, 0);
        let mut ahead = self.out.commands();
        while ahead > 0
            && let Some((bus, command)) = self.out.pop_command()
        {
            ahead -= 1;
            match command {
                BusCommand::Send(outgoing) if !waits[bus] && losses < N::Depth::PLACES => {
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
        let mut lost = (outgoing.frame, FailCause::OverBudget);
        if self.node.charge(&outgoing.frame, &mut Turn::new(now, &mut self.out)) {
            match self.push(bus, outgoing, here) {
                Some(frame) => lost = (frame, FailCause::QueueFull),
                None => return false,
            }
        }
        let (frame, cause) = lost;
        self.tell(bus, &LinkEvent::Failed { frame, cause }, now);
        true
    }

    /// Returns the frame for which there is no place.
    #[inline(always)] // called from one place
    fn push(&mut self, bus: Bus, outgoing: Outgoing, here: Option<Bus>) -> Option<Frame> {
        let queue = &mut self.queues[bus];
        // A task that has frames waits for a mailbox, or for the first end of a lifetime. There may be a mailbox already for
        // a frame that goes before the others.
        let is_next = queue.peek().is_none_or(|next| outgoing.frame.id() < next.frame.id());
        let is_first = queue.next_expiry().is_none_or(|first| outgoing.expires < first);
        if (is_next || is_first) && Some(bus) != here {
            wake(&self.buses[bus]);
        }
        match queue.push(outgoing) {
            Ok(displaced) => displaced.map(|displaced| displaced.frame),
            Err(Full) => Some(outgoing.frame),
        }
    }

    /// Frees the place of a task that waited for a signal.
    pub fn free(&mut self, place: usize) {
        if let Some(waiter) = self.waiters.get_mut(place) {
            *waiter = None;
        }
    }

    /// Returns whether something is due. An alarm may be early.
    pub fn is_due(&self, now: Instant) -> bool {
        self.node.deadline().is_some_and(|due| due <= now)
    }

    /// Returns whether the node has not run since the instant for which the alarm was set, though that is past.
    pub fn is_missed(&self, now: Instant) -> bool {
        self.armed <= now && self.out.done_until() < self.armed
    }

    /// Does what is due.
    #[inline(never)] // row `size.pyboard-v11.slave.flash`: once for its task and for calls of the application
    pub fn run_due(&mut self, now: Instant) {
        self.node.poll(&mut Turn::new(now, &mut self.out));
        // A bus alone obeys other commands than frames.
        self.deliver(None, now);
    }

    /// Does what a call of the application has made due, and ends its step.
    #[inline(never)] // row `size.pyboard-v11.master.flash`: once for all calls
    pub fn finish(&mut self, now: Instant) {
        if self.is_due(now) {
            self.run_due(now);
        } else {
            self.deliver(None, now);
        }
        self.end_step(now);
    }

    /// Ends a step of the node: wakes the application for its events, and the task of everything that is due if
    /// it would run too late, or missed its instant: a bit of its alarm flipped.
    #[inline]
    pub fn end_step(&mut self, now: Instant) {
        self.tell_application();
        if let Some(due) = self.node.deadline()
            && (due < self.armed || self.armed < now)
        {
            wake(&self.timekeeper);
        }
    }

    /// Wakes the application, once until it waits again, and after a signal the tasks that wait for one.
    #[inline]
    pub fn tell_application(&mut self) {
        if !self.out.has_events() {
            return;
        }
        if let Some(listener) = self.listener.take() {
            listener.wake();
        }
        if self.out.take_signal() {
            self.waiters.iter().for_each(wake);
        }
    }
}

/// Wakes a task that is there.
pub(super) fn wake(task: &Option<Waker>) {
    if let Some(task) = task {
        task.wake_by_ref();
    }
}

/// Keeps the task to wake. Returns whether it is another one than before, which `WakerRegistration` of embassy-sync does not
/// report.
#[inline]
pub(super) fn register(task: &mut Option<Waker>, context: &Context<'_>) -> bool {
    let is_new = !task.as_ref().is_some_and(|task| task.will_wake(context.waker()));
    if is_new {
        *task = Some(context.waker().clone());
    }
    is_new
}

#[cfg(test)]
mod tests {
    use super::Shared;
    use crate::node::CanopenSlave;
    use crate::node::probe::Probe;

    const fn assert_send<T: Send>() {}

    /// A node may run at another priority than its application.
    const _: () = assert_send::<Shared<CanopenSlave<Probe>>>();
}
