//! Runner of one bus: events of its controller, mailboxes, lifetimes, leaving the bus.

#[cfg(test)]
mod tests;

use core::convert::Infallible;
use core::future::poll_fn;
use core::pin::pin;
use core::task::{Context, Poll};

use super::Clock;
use super::Platform;
use super::TURN;
use super::alarm::Alarm;
use super::filters::{self, Refresh};
use super::shared::{Shared, register};
use super::storage::{BusStates, Core};
use crate::link::Stamp;
use crate::link::port::{CanPort, ErrorState, Health, LastError, Mailbox, PortEvent, is_urgent};
use crate::link::queue::{Full, Outgoing};
use crate::node::{BusCommand, FailCause, Filters, LinkEvent, Node, Turn};
use crate::types::{Bus, Duration, Frame, Instant, PerBus};

/// Polls health: the controller raises no event when only its counters or the cause of its last error change. Each poll also
/// sets a filter again. Frames do not delay it.
const POLL: Duration = Duration::from_millis(100);

/// Polls health at this rate while transmitting in error-passive, until the last error indicates isolation: a cut wire
/// raises no event.
const CLOSE_LOOK: Duration = Duration::from_millis(2);

/// Runs the controller of one bus, in a task of its own.
pub struct BusRunner<B: Platform, N: Node> {
    core: &'static Core<B, N>,
    // In the storage: the future of a task would hold a port twice, as an argument and in this future.
    state: &'static mut BusState<B::Port>,
}

impl<B: Platform, N: Node> BusRunner<B, N> {
    pub(super) const fn new(core: &'static Core<B, N>, state: &'static mut BusState<B::Port>) -> Self {
        BusRunner { core, state }
    }

    /// Runs without end.
    ///
    /// # Cancel safety
    /// The future must not be dropped: the frames in the mailboxes of the port would no longer be followed.
    pub async fn run(self) -> ! {
        let BusRunner { core, state } = self;
        state.poll_from(core.clock.now());
        let timer = pin!(None);
        let mut alarm = Alarm::new(timer);
        match poll_fn(|context| {
            // Work that is due by time takes longer than a frame. One that came meanwhile is handled before the other tasks have
            // their turn (row `rx.inside_look`).
            for _ in 0..2 {
                state.take_events(core, context);
                let now = core.clock.now();
                let is_due = state.is_due(now);
                let is_new = core.lock(|shared| state.end_turn(shared, now, context));
                let due = state.due;
                if is_new {
                    alarm.arm(due, context, || core.clock.at(due));
                } else {
                    alarm.set(due, now, context, || core.clock.at(due));
                }
                if !is_due {
                    break;
                }
            }
            Poll::<Infallible>::Pending
        })
        .await {}
    }
}

/// A frame in a mailbox, and why it is being aborted, if it is.
#[derive(Clone, Copy)]
struct Pending {
    outgoing: Outgoing,
    aborting: Option<Abort>,
}

/// Why a mailbox is being aborted.
#[derive(Clone, Copy)]
enum Abort {
    /// The frame is lost.
    Lost(FailCause),
    /// An urgent frame needs the mailbox: this one goes back into the queue.
    Preempted,
}

/// State of a bus: its controller, and the frames of the node in it.
pub(super) struct BusState<P: CanPort> {
    bus: Bus,
    /// Whether it is the redundant bus: copies of `bus`, which a flipped bit must not change.
    copies: [bool; 2],
    port: P,
    mailboxes: P::PerMailbox<Option<Pending>>,
    /// As the node knows it.
    health: Health,
    /// Instant at which it was read last.
    looked: Instant,
    /// Instant of the next poll.
    poll: Instant,
    /// Sets its filters again, one at a time.
    refresh: Refresh,
    /// Instant at which this task has to run without an event: a poll of the health, or the end of a lifetime.
    due: Instant,
}

impl<P: CanPort> BusStates for PerBus<BusState<P>> {
    fn set_filters(&mut self, filters: &Filters) {
        self.nominal.set_filters(filters);
        self.redundant.set_filters(filters);
    }
}

impl<P: CanPort> BusStates for BusState<P> {
    fn set_filters(&mut self, filters: &Filters) {
        self.port.set_filters(filters);
    }
}

impl<P: CanPort> BusState<P> {
    #[inline]
    pub fn new(bus: Bus, port: P) -> Self {
        BusState {
            bus,
            copies: [bus == Bus::Redundant; 2],
            port,
            mailboxes: Default::default(),
            health: Health::default(),
            looked: Instant::ZERO,
            poll: Instant::ZERO,
            refresh: Refresh::default(),
            due: Instant::ZERO,
        }
    }

    /// Counts polls from `now`, as if there had been one then.
    fn poll_from(&mut self, now: Instant) {
        self.poll = now + POLL;
        self.due = self.poll;
    }

    /// Returns whether the task has to run by time. An instant beyond the next poll has a flipped bit.
    fn is_due(&self, now: Instant) -> bool {
        now >= self.due || self.due.since(now) > POLL
    }

    /// Handles what the controller has, within bounds.
    #[inline]
    fn take_events<B: Platform<Port = P>, N: Node>(&mut self, core: &Core<B, N>, context: &mut Context<'_>) {
        for _ in 0..TURN {
            let Poll::Ready(event) = self.port.poll_event(context) else { return };
            core.lock(|shared| self.on_port(shared, &event, core.clock.now()));
        }
        context.waker().wake_by_ref();
    }

    /// Does what is due, obeys commands for this bus and fills its mailboxes. Returns whether another task is to be
    /// woken from now on.
    #[inline]
    fn end_turn<N: Node>(&mut self, shared: &mut Shared<N>, now: Instant, context: &Context<'_>) -> bool {
        let is_new = register(&mut shared.buses[self.bus], context);
        let is_due = self.is_due(now);
        if is_due {
            self.on_time(shared, now);
        }
        // Without either, the last step has ended already (row `rx.interrupt_to_application_median`).
        if is_due || shared.is_asked(self.bus) {
            self.settle(shared, now);
        }
        is_new
    }

    /// Ends a step of the node: obeys its commands and fills the mailboxes.
    #[inline]
    fn settle<N: Node>(&mut self, shared: &mut Shared<N>, now: Instant) {
        if shared.is_asked(self.bus) {
            self.send(shared, now);
        }
        shared.end_step(now);
    }

    #[inline(never)] // most frames ask for nothing
    fn send<N: Node>(&mut self, shared: &mut Shared<N>, now: Instant) {
        loop {
            while let Some(command) = shared.deliver(Some(self.bus), now) {
                self.obey(shared, command, now);
            }
            if !self.fill_mailboxes(shared, now) {
                break;
            }
        }
    }

    #[inline(never)] // few commands are not frames
    fn obey<N: Node>(&mut self, shared: &mut Shared<N>, command: BusCommand, now: Instant) {
        match command {
            // The outbox keeps these apart.
            BusCommand::Send(_) => {}
            BusCommand::Abandon => self.abandon(shared, now),
            BusCommand::Join => {
                self.port.join();
                // The node has forgotten this bus: a controller that is bus-off still is reported as if it were new.
                self.health = Health::default();
            }
            BusCommand::Listen => {
                self.abandon(shared, now);
                self.port.listen();
            }
            BusCommand::Leave => {
                self.abandon(shared, now);
                self.port.leave();
            }
            BusCommand::Recover => self.port.recover(),
            BusCommand::Filter { number, filter } => filters::set(&mut self.port, number, filter),
        }
    }

    #[inline]
    fn on_port<N: Node>(&mut self, shared: &mut Shared<N>, event: &PortEvent, now: Instant) {
        if let PortEvent::Received { frame, stamp } = event {
            let stamp = self.stamp(shared, frame, stamp);
            // A node that answers for its counters with the next frame needs them as they are.
            self.look(shared, now);
            shared.node.on_received(self.bus, frame, &stamp, &mut Turn::new(now, &mut shared.out));
            shared.diagnostics.handled(self.bus).count();
        } else {
            self.on_other(shared, event, now);
        }
        self.settle(shared, now);
    }

    /// Handles an event other than a received frame.
    #[inline(never)]
    fn on_other<N: Node>(&mut self, shared: &mut Shared<N>, event: &PortEvent, now: Instant) {
        let event = match *event {
            PortEvent::Received { frame, stamp } => LinkEvent::Received { frame, stamp },
            PortEvent::Transmitted { mailbox, stamp } => {
                let Some(Pending { outgoing: Outgoing { frame, .. }, .. }) = self.release(mailbox) else {
                    return;
                };
                // The wire does not wait for the node.
                self.send(shared, now);
                LinkEvent::Transmitted { frame, stamp: self.stamp(shared, &frame, &stamp) }
            }
            PortEvent::Failed { mailbox } => {
                let Some(Pending { outgoing, aborting }) = self.release(mailbox) else { return };
                let cause = match aborting {
                    Some(Abort::Preempted) => match shared.queues[self.bus].put_back(outgoing) {
                        Ok(()) => return self.send(shared, now),
                        Err(Full) => FailCause::QueueFull,
                    },
                    Some(Abort::Lost(cause)) => cause,
                    None => FailCause::Aborted,
                };
                self.send(shared, now);
                LinkEvent::Failed { frame: outgoing.frame, cause }
            }
            PortEvent::Overrun { lost } => {
                shared.diagnostics.overruns().add(u32::from(lost));
                LinkEvent::Overrun { lost }
            }
            PortEvent::Stalled => LinkEvent::Stalled,
            PortEvent::Health(health) => {
                if core::mem::replace(&mut self.health, health) != health {
                    self.report(shared, &LinkEvent::Health(health), now);
                }
                return;
            }
        };
        self.look(shared, now);
        shared.tell(self.bus, &event, now);
    }

    /// Before anything else: what the port has measured does not last.
    #[inline(always)] // few frames need the port
    fn stamp<N: Node>(&mut self, shared: &Shared<N>, frame: &Frame, reported: &Stamp) -> Stamp {
        if shared.node.is_stamped(self.bus, frame) { self.port.stamp(frame, *reported) } else { *reported }
    }

    /// Reports what the controller raised no event for.
    #[inline]
    fn look<N: Node>(&mut self, shared: &mut Shared<N>, now: Instant) {
        self.looked = now;
        let health = self.port.health();
        if word(&health) != word(&self.health) {
            self.differs(shared, health, now);
        }
    }

    #[inline(never)] // row `rx.interrupt_to_dictionary_median`: most looks find nothing
    fn differs<N: Node>(&mut self, shared: &mut Shared<N>, health: Health, now: Instant) {
        let known = core::mem::replace(&mut self.health, health);
        let is_verdict = verdict(&health) != verdict(&known);
        let event = if is_verdict { LinkEvent::Health(health) } else { LinkEvent::Counters(health) };
        self.report(shared, &event, now);
    }

    /// Reports another health, by which the next look is due.
    fn report<N: Node>(&mut self, shared: &mut Shared<N>, event: &LinkEvent, now: Instant) {
        shared.tell(self.bus, event, now);
        self.update_due(shared);
    }

    /// Aborts frames whose lifetime has ended, polls the health of the controller, and sets one of its filters again.
    #[inline(never)] // ten times a second
    fn on_time<N: Node>(&mut self, shared: &mut Shared<N>, now: Instant) {
        self.give_up(shared, now, FailCause::Expired, now);
        if self.next_look() <= now {
            self.look(shared, now);
        }
        if self.poll <= now || self.poll > now + POLL {
            self.poll = now + POLL;
            if self.copies[0] == self.copies[1] {
                self.bus = if self.copies[0] { Bus::Redundant } else { Bus::Nominal };
            }
            self.refresh.step(&mut self.port, &*shared.node);
        }
        self.update_due(shared);
    }

    fn next_look(&self) -> Instant {
        let sends = self.mailboxes.as_ref().iter().any(Option::is_some);
        let may_be_isolated =
            self.health.state == ErrorState::Passive && self.health.last_error != LastError::Ack;
        if sends && may_be_isolated { self.poll.min(self.looked + CLOSE_LOOK) } else { self.poll }
    }

    fn release(&mut self, mailbox: Mailbox) -> Option<Pending> {
        self.mailboxes.as_mut().get_mut(usize::from(mailbox.0))?.take()
    }

    /// Nothing meant for a bus that was left may go out on it later.
    fn abandon<N: Node>(&mut self, shared: &mut Shared<N>, now: Instant) {
        self.give_up(shared, Instant::NEVER, FailCause::BusLeft, now);
    }

    /// Aborts all frames that would expire by `end`, and drops those that wait.
    #[inline(never)] // from two places
    fn give_up<N: Node>(&mut self, shared: &mut Shared<N>, end: Instant, cause: FailCause, now: Instant) {
        for (number, slot) in self.mailboxes.as_mut().iter_mut().enumerate() {
            if let Some(pending) = slot
                && !matches!(pending.aborting, Some(Abort::Lost(_)))
                && pending.outgoing.is_expired(end)
                && pending.aborting.replace(Abort::Lost(cause)).is_none()
            {
                self.port.abort(Mailbox(number as u8));
            }
        }
        while let Some(lost) = shared.queues[self.bus].pop_expired(end) {
            self.lose(shared, &lost, cause, now);
        }
    }

    fn lose<N: Node>(&self, shared: &mut Shared<N>, lost: &Outgoing, cause: FailCause, now: Instant) {
        shared.tell(self.bus, &LinkEvent::Failed { frame: lost.frame, cause }, now);
    }

    /// Puts frames that wait into mailboxes. Returns whether it reported frames whose lifetime has ended.
    fn fill_mailboxes<N: Node>(&mut self, shared: &mut Shared<N>, now: Instant) -> bool {
        if shared.queues[self.bus].is_empty() {
            return false;
        }
        let mut told = false;
        while let Some(next) = shared.queues[self.bus].peek().copied() {
            if next.is_expired(now) {
                shared.queues[self.bus].pop();
                self.lose(shared, &next, FailCause::Expired, now);
                told = true;
                continue;
            }
            let Ok(mailbox) = self.port.send(&next.frame) else {
                self.preempt(&next.frame);
                break;
            };
            if let Some(slot) = self.mailboxes.as_mut().get_mut(usize::from(mailbox.0)) {
                *slot = Some(Pending { outgoing: next, aborting: None });
            }
            shared.queues[self.bus].pop();
        }
        self.update_due(shared);
        told
    }

    /// Makes room for an urgent frame when frames that go after it have all mailboxes: aborts the one of the lowest
    /// priority that is alone with its COB-ID. Other nodes may hold the bus against that one for any time.
    #[inline(never)] // few frames find all mailboxes taken
    fn preempt(&mut self, next: &Frame) {
        if !is_urgent(next.id()) {
            return;
        }
        let mailboxes = self.mailboxes.as_ref();
        let (mut last, mut id) = (None, next.id());
        for (number, slot) in mailboxes.iter().enumerate() {
            let Some(pending) = slot else { continue };
            if pending.aborting.is_some() {
                return;
            }
            let own = pending.outgoing.frame.id();
            let is_same = |other: &&Pending| other.outgoing.frame.id() == own;
            if own > id && mailboxes.iter().flatten().filter(is_same).count() == 1 {
                (last, id) = (Some(number), own);
            }
        }
        let Some(number) = last else { return };
        if let Some(Some(pending)) = self.mailboxes.as_mut().get_mut(number) {
            pending.aborting = Some(Abort::Preempted);
            self.port.abort(Mailbox(number as u8));
        }
    }

    fn update_due<N: Node>(&mut self, shared: &Shared<N>) {
        let mut due = self.next_look();
        for pending in self.mailboxes.as_ref().iter().flatten() {
            if pending.aborting.is_none() {
                due = due.min(pending.outgoing.expires);
            }
        }
        self.due = shared.queues[self.bus].next_expiry().map_or(due, |expiry| due.min(expiry));
    }
}

/// All of health, compared at once (row `rx.interrupt_to_dictionary_median`).
fn word(&Health { state, tec, rec, last_error }: &Health) -> u32 {
    u32::from_le_bytes([state as u8, last_error as u8, tec, rec])
}

/// The part of health that decisions depend on: the state, and whether frames stay without acknowledgement.
fn verdict(health: &Health) -> (ErrorState, bool) {
    (health.state, health.state == ErrorState::Passive && health.last_error == LastError::Ack)
}
