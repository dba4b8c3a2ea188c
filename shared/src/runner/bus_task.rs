//! The task of one bus: priority queue, mailboxes, lifetimes, leaving.

use embassy_futures::select::{Either3, select3};
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_sync::channel::TrySendError;

use super::Links;
use crate::link::Stamp;
use crate::link::port::{CanPort, ErrorState, Health, LastError, MAILBOXES, Mailbox, PortEvent};
use crate::link::queue::{Outgoing, TxQueue};
use crate::node::{BusCommand, FailCause, LinkEvent, QUEUE_DEPTH};
use crate::time::Clock;
use crate::types::{Bus, CobId, Duration, Frame, Instant};

/// Counters move and causes of errors change without an event of the controller: so often they are looked at.
const LOOK: Duration = Duration::from_millis(100);

/// As often while an error passive controller sends and its last error is none that tells of isolation: the wire may be
/// cut at any moment, and nothing else would say so.
const CLOSE_LOOK: Duration = Duration::from_millis(2);

/// Runs one controller for ever. The port comes off the bus, its filters set. Frames with COB-IDs in `stamped` get the
/// best stamps that the port has.
pub async fn bus_task<M: RawMutex>(
    bus: Bus,
    port: impl CanPort,
    clock: impl Clock,
    links: &Links<M>,
    stamped: &'static [CobId],
) -> ! {
    let (queue, mailboxes, told) = (TxQueue::new(), [None; MAILBOXES], Health::default());
    let looked = clock.now();
    // Borrowed, not moved: a future keeps a second copy of what is moved into the one that it waits for.
    let mut task =
        BusTask { bus, port, clock, links, stamped, queue, mailboxes, told, looked, held: None, left: false };
    task.run().await
}

/// A frame in a mailbox, and why it is being aborted, if it is.
#[derive(Clone, Copy)]
struct Pending {
    outgoing: Outgoing,
    aborting: Option<FailCause>,
}

struct BusTask<'a, M: RawMutex, P, C> {
    bus: Bus,
    port: P,
    clock: C,
    links: &'a Links<M>,
    stamped: &'static [CobId],
    queue: TxQueue<QUEUE_DEPTH>,
    mailboxes: [Option<Pending>; MAILBOXES],
    /// What the node knows of the controller.
    told: Health,
    /// When it looked at the controller last.
    looked: Instant,
    /// What comes after news of the controller.
    held: Option<LinkEvent>,
    /// The bus was left: what is in the queue goes back.
    left: bool,
}

impl<M: RawMutex, P: CanPort, C: Clock> BusTask<'_, M, P, C> {
    async fn run(&mut self) -> ! {
        let mut next = None;
        loop {
            // The one place where a node that is behind is waited for.
            if let Some(event) = next {
                self.report(event).await;
            }
            next = match self.returned() {
                Some(event) => Some(event),
                None => self.happened().await,
            };
        }
    }

    /// Waits for the controller, the node or the time; what the node is to be told of it.
    async fn happened(&mut self) -> Option<LinkEvent> {
        self.fill_mailboxes();
        let look = self.next_look();
        let timer = self.clock.at(self.next_expiry().map_or(look, |expiry| expiry.min(look)));
        // Commands first: a bus without a pause must not keep what is due from going out.
        match select3(self.links.commands[self.bus].receive(), self.port.event(), timer).await {
            Either3::First(command) => self.on_command(command),
            Either3::Second(PortEvent::Health(health)) if health != self.told => {
                self.told = health;
                Some(LinkEvent::Health(health))
            }
            Either3::Second(event) => {
                let event = self.on_port(&event)?;
                // A node that answers for its counters with the next frame needs them as they are.
                match self.look() {
                    None => Some(event),
                    news => {
                        self.held = Some(event);
                        news
                    }
                }
            }
            Either3::Third(()) if look <= self.clock.now() => self.look(),
            Either3::Third(()) => None,
        }
    }

    fn on_command(&mut self, command: BusCommand) -> Option<LinkEvent> {
        match command {
            BusCommand::Send(outgoing) => {
                let lost = self.queue.push(outgoing).unwrap_or(Some(outgoing))?;
                return Some(LinkEvent::Failed { frame: lost.frame, cause: FailCause::QueueFull });
            }
            BusCommand::Abandon => self.abandon(),
            BusCommand::Join => {
                self.port.join();
                // The node has forgotten this bus: a controller that is bus-off still is told as if it were new.
                self.told = Health::default();
            }
            BusCommand::Leave => {
                self.abandon();
                self.port.leave();
            }
            BusCommand::Recover => self.port.recover(),
            BusCommand::Filter { number, filter } => self.port.set_filter(number, filter),
        }
        None
    }

    /// What it means to the node; `None`: nothing new.
    fn on_port(&mut self, event: &PortEvent) -> Option<LinkEvent> {
        Some(match *event {
            PortEvent::Received { frame, stamp } => {
                LinkEvent::Received { frame, stamp: self.stamp(&frame, stamp) }
            }
            PortEvent::Transmitted { mailbox, stamp } => {
                let frame = self.release(mailbox)?.outgoing.frame;
                LinkEvent::Transmitted { frame, stamp: self.stamp(&frame, stamp) }
            }
            PortEvent::Failed { mailbox } => {
                let Pending { outgoing, aborting } = self.release(mailbox)?;
                LinkEvent::Failed { frame: outgoing.frame, cause: aborting.unwrap_or(FailCause::Aborted) }
            }
            PortEvent::Overrun { lost } => LinkEvent::Overrun { lost },
            PortEvent::Stalled => LinkEvent::Stalled,
            PortEvent::Health(_) => return None,
        })
    }

    /// Before anything else is waited for: what the port has measured does not last.
    fn stamp(&mut self, frame: &Frame, reported: Stamp) -> Stamp {
        if self.stamped.contains(&frame.id()) { self.port.stamp(frame, reported) } else { reported }
    }

    /// What the controller did not tell: it tells of a state when it has to, of its counters never.
    fn look(&mut self) -> Option<LinkEvent> {
        self.looked = self.clock.now();
        let health = self.port.health();
        let told = core::mem::replace(&mut self.told, health);
        if verdict(&health) != verdict(&told) {
            Some(LinkEvent::Health(health))
        } else if health != told {
            Some(LinkEvent::Counters(health))
        } else {
            None
        }
    }

    fn next_look(&self) -> Instant {
        let sends = self.mailboxes.iter().any(Option::is_some);
        let may_be_isolated =
            self.told.state == ErrorState::Passive && self.told.last_error != LastError::Ack;
        self.looked + if sends && may_be_isolated { CLOSE_LOOK } else { LOOK }
    }

    fn release(&mut self, mailbox: Mailbox) -> Option<Pending> {
        self.mailboxes.get_mut(usize::from(mailbox.0))?.take()
    }

    /// ECSS 8.3.3b: nothing meant for a bus that was left may go out on it later.
    fn abandon(&mut self) {
        self.abort_where(|_| true, FailCause::BusLeft);
        self.left = true;
    }

    /// What the node is told before anything else is waited for. Of a bus that was left what is nearest to the wire comes
    /// first: the node may be behind with what it is told. Then what has outlived its lifetime, in the queue; in the
    /// mailboxes it is aborted.
    fn returned(&mut self) -> Option<LinkEvent> {
        if let Some(event) = self.held.take() {
            return Some(event);
        }
        let (lost, cause) = if self.left
            && let Some(lost) = self.queue.pop()
        {
            (lost, FailCause::BusLeft)
        } else {
            self.left = false;
            let now = self.clock.now();
            self.abort_where(|outgoing| outgoing.is_expired(now), FailCause::Expired);
            (self.queue.pop_expired(now)?, FailCause::Expired)
        };
        Some(LinkEvent::Failed { frame: lost.frame, cause })
    }

    fn abort_where(&mut self, which: impl Fn(&Outgoing) -> bool, cause: FailCause) {
        for (number, slot) in self.mailboxes.iter_mut().enumerate() {
            if let Some(pending) = slot
                && pending.aborting.is_none()
                && which(&pending.outgoing)
            {
                pending.aborting = Some(cause);
                self.port.abort(Mailbox(number as u8));
            }
        }
    }

    fn fill_mailboxes(&mut self) {
        while let Some(next) = self.queue.peek().copied() {
            let Ok(mailbox) = self.port.send(&next.frame) else { return };
            if let Some(slot) = self.mailboxes.get_mut(usize::from(mailbox.0)) {
                *slot = Some(Pending { outgoing: next, aborting: None });
            }
            self.queue.pop();
        }
    }

    fn next_expiry(&self) -> Option<Instant> {
        let in_mailboxes = self.mailboxes.iter().flatten().filter(|pending| pending.aborting.is_none());
        in_mailboxes.map(|pending| pending.outgoing.expires).chain(self.queue.next_expiry()).min()
    }

    /// Waits when the node is behind: the port's receive queue is the bounded place where a loss is counted.
    async fn report(&self, event: LinkEvent) {
        if let Err(TrySendError::Full(event)) = self.links.events.try_send((self.bus, event)) {
            self.links.events.send(event).await;
        }
    }
}

/// What decisions are taken by: the state, and whether nobody acknowledges.
fn verdict(health: &Health) -> (ErrorState, bool) {
    (health.state, health.state == ErrorState::Passive && health.last_error == LastError::Ack)
}
