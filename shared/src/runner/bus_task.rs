//! The task of one bus: priority queue, mailboxes, lifetimes, leaving.

use core::future::pending;

use embassy_futures::select::{Either3, select3};
use embassy_sync::blocking_mutex::raw::RawMutex;

use super::{BusCommand, COMMAND_DEPTH, FailCause, LinkEvent, Links};
use crate::link::port::{CanPort, Health, MAILBOXES, Mailbox, PortEvent};
use crate::link::queue::{Outgoing, TxQueue, is_expired};
use crate::link::{Bus, Frame};
use crate::time::{Clock, Instant};

/// Runs one controller for ever. The port comes off the bus, its filters set.
pub async fn bus_task<M: RawMutex>(bus: Bus, port: impl CanPort, clock: impl Clock, links: &Links<M>) -> ! {
    let (queue, mailboxes, told) = (TxQueue::new(), [None; MAILBOXES], Health::default());
    // Borrowed, not moved: a future keeps a second copy of what is moved into the one that it waits for.
    let mut task = BusTask { bus, port, clock, links, queue, mailboxes, told };
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
    queue: TxQueue<COMMAND_DEPTH>,
    mailboxes: [Option<Pending>; MAILBOXES],
    /// What the node knows of the controller.
    told: Health,
}

impl<M: RawMutex, P: CanPort, C: Clock> BusTask<'_, M, P, C> {
    async fn run(&mut self) -> ! {
        loop {
            self.expire().await;
            self.fill_mailboxes();
            let deadline = self.next_expiry();
            let expiry = async {
                match deadline {
                    Some(at) => self.clock.at(at).await,
                    None => pending().await,
                }
            };
            match select3(self.port.event(), self.links.commands[self.bus].receive(), expiry).await {
                Either3::First(event) => self.on_port(event).await,
                Either3::Second(command) => self.on_command(command).await,
                Either3::Third(()) => {}
            }
        }
    }

    async fn on_command(&mut self, command: BusCommand) {
        match command {
            BusCommand::Send(outgoing) => {
                if let Some(lost) = self.queue.push(outgoing).unwrap_or(Some(outgoing)) {
                    self.fail(lost.frame, FailCause::QueueFull).await;
                }
            }
            BusCommand::Abandon => self.abandon().await,
            BusCommand::Join => self.port.join(),
            BusCommand::Leave => {
                self.abandon().await;
                self.port.leave();
            }
            BusCommand::Recover => self.port.recover(),
        }
    }

    async fn on_port(&mut self, event: PortEvent) {
        self.tell_counters(&event).await;
        let event = match event {
            PortEvent::Received { frame, stamp } => LinkEvent::Received { frame, stamp },
            PortEvent::Transmitted { mailbox, stamp } => match self.release(mailbox) {
                Some(pending) => LinkEvent::Transmitted { frame: pending.outgoing.frame, stamp },
                None => return,
            },
            PortEvent::Failed { mailbox } => match self.release(mailbox) {
                Some(pending) => LinkEvent::Failed {
                    frame: pending.outgoing.frame,
                    cause: pending.aborting.unwrap_or(FailCause::Aborted),
                },
                None => return,
            },
            PortEvent::Overrun { lost } => LinkEvent::Overrun { lost },
            PortEvent::Health(health) => LinkEvent::Health(health),
        };
        self.report(event).await;
    }

    /// The port tells of changed states only; a node that answers for its counters needs them as they are.
    async fn tell_counters(&mut self, event: &PortEvent) {
        if let PortEvent::Health(health) = event {
            self.told = *health;
            return;
        }
        let health = self.port.health();
        if health != self.told {
            self.told = health;
            self.report(LinkEvent::Counters(health)).await;
        }
    }

    fn release(&mut self, mailbox: Mailbox) -> Option<Pending> {
        self.mailboxes.get_mut(usize::from(mailbox.0))?.take()
    }

    /// ECSS 8.3.3b: nothing meant for a bus that was left may go out on it later.
    async fn abandon(&mut self) {
        while let Some(outgoing) = self.queue.pop() {
            self.fail(outgoing.frame, FailCause::BusLeft).await;
        }
        self.abort_where(|_| true, FailCause::BusLeft);
    }

    /// Ends the lifetimes that are over, in the queue and in the mailboxes.
    async fn expire(&mut self) {
        let now = self.clock.now();
        while let Some(outgoing) = self.queue.pop_expired(now) {
            self.fail(outgoing.frame, FailCause::Expired).await;
        }
        self.abort_where(|outgoing| is_expired(outgoing.expires, now), FailCause::Expired);
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
        in_mailboxes.filter_map(|pending| pending.outgoing.expires).chain(self.queue.next_expiry()).min()
    }

    async fn fail(&self, frame: Frame, cause: FailCause) {
        self.report(LinkEvent::Failed { frame, cause }).await;
    }

    /// Waits when the node is behind: the port's receive queue is the bounded place where a loss is counted.
    async fn report(&self, event: LinkEvent) {
        self.links.events.send((self.bus, event)).await;
    }
}
