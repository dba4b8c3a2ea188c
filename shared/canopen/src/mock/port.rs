//! Port of mock boards: a CAN controller with three mailboxes on a bus without errors.

use alloc::collections::VecDeque;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::RefCell;
use core::task::{Context, Poll, Waker};

use super::ManualClock;
use crate::link::Stamp;
use crate::link::port::{
    Busy, CanPort, ErrorState, Filter, Health, LastError, Mailbox, PortEvent, is_urgent,
};
use crate::runner::Clock;
use crate::types::Frame;

const MAILBOXES: usize = 3;

/// Health of a controller whose frames no other node acknowledges. The transmit error counter stays at 128
/// (ISO 11898-1, fault confinement).
const ISOLATED: Health = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };

/// Port that acknowledges every frame at once and keeps it, unless its bus is cut. Clones are the same port.
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
    /// No other node is connected: no frame is acknowledged, and none arrives.
    is_cut: bool,
    health: Health,
    filters: Vec<Filter>,
    /// Events that the node did not take yet.
    events: VecDeque<PortEvent>,
    /// Frames of the node that the test did not take yet.
    sent: Vec<Frame>,
    /// Mailboxes whose end the node did not take yet.
    used: [bool; MAILBOXES],
    /// Frames that wait for an acknowledgement, the oldest first.
    pending: VecDeque<(Mailbox, Frame)>,
    waiting: Option<Waker>,
}

impl LoopbackPort {
    /// Makes a port that is off its bus. `clock` gives the stamps of its frames.
    pub fn new(clock: &ManualClock) -> Self {
        LoopbackPort { controller: Rc::default(), clock: clock.clone() }
    }

    /// Returns the frames that the node sent since the last call, and that were acknowledged.
    pub fn sent(&self) -> Vec<Frame> {
        core::mem::take(&mut self.controller.borrow_mut().sent)
    }

    /// Sends a frame to the node, which ended now. Returns whether the node received it: it is on the bus, the bus is not
    /// cut, and one of its filters admits the frame.
    pub fn receive(&self, frame: Frame) -> bool {
        let controller = &mut *self.controller.borrow_mut();
        let is_received = controller.receives
            && !controller.is_cut
            && controller.filters.iter().any(|one| one.admits(frame.id()));
        if is_received {
            controller.report(PortEvent::Received { frame, stamp: self.stamp_now() });
        }
        is_received
    }

    /// Cuts the bus beside this node. Frames of the node wait in their mailboxes without an acknowledgement, and the
    /// controller is error passive as soon as there is one.
    pub fn cut(&self) {
        self.controller.borrow_mut().is_cut = true;
    }

    /// Mends the bus. Frames that wait in mailboxes are acknowledged, in the order in which they were sent.
    pub fn mend(&self) {
        let controller = &mut *self.controller.borrow_mut();
        controller.is_cut = false;
        for (mailbox, frame) in core::mem::take(&mut controller.pending) {
            controller.transmit(mailbox, frame, self.stamp_now());
        }
        controller.set_health(Health::default());
    }

    /// Frames take no time: the present is as exact as a captured edge.
    fn stamp_now(&self) -> Stamp {
        Stamp::captured(self.clock.now().into())
    }
}

impl Controller {
    fn report(&mut self, event: PortEvent) {
        self.events.push_back(event);
        if let Some(waiting) = self.waiting.take() {
            waiting.wake();
        }
    }

    fn set_health(&mut self, health: Health) {
        if core::mem::replace(&mut self.health, health) != health {
            self.report(PortEvent::Health(health));
        }
    }

    fn transmit(&mut self, mailbox: Mailbox, frame: Frame, stamp: Stamp) {
        self.sent.push(frame);
        self.report(PortEvent::Transmitted { mailbox, stamp });
    }

    /// The mailbox for this frame. The last one that is free is for urgent frames.
    fn free_mailbox(&self, frame: &Frame) -> Option<Mailbox> {
        let mut free =
            (0..).zip(self.used).filter(|(_, is_used)| !is_used).map(|(number, _)| Mailbox(number));
        let first = free.next()?;
        (is_urgent(frame.id()) || free.next().is_some()).then_some(first)
    }

    fn abort_all(&mut self) {
        for (mailbox, _) in core::mem::take(&mut self.pending) {
            self.report(PortEvent::Failed { mailbox });
        }
    }
}

impl CanPort for LoopbackPort {
    type PerMailbox<T: Default> = [T; MAILBOXES];

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
        controller.abort_all();
    }

    fn leave(&mut self) {
        let mut controller = self.controller.borrow_mut();
        (controller.receives, controller.sends) = (false, false);
        controller.abort_all();
        controller.health = Health::default();
    }

    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        let controller = &mut *self.controller.borrow_mut();
        let mailbox = controller.free_mailbox(frame).filter(|_| controller.sends).ok_or(Busy)?;
        if let Some(used) = controller.used.get_mut(usize::from(mailbox.0)) {
            *used = true;
        }
        if controller.is_cut {
            controller.pending.push_back((mailbox, *frame));
            controller.set_health(ISOLATED);
        } else {
            controller.transmit(mailbox, *frame, self.stamp_now());
        }
        Ok(mailbox)
    }

    fn abort(&mut self, mailbox: Mailbox) {
        let mut controller = self.controller.borrow_mut();
        let before = controller.pending.len();
        controller.pending.retain(|(pending, _)| *pending != mailbox);
        if controller.pending.len() < before {
            controller.report(PortEvent::Failed { mailbox });
        }
    }

    fn health(&self) -> Health {
        self.controller.borrow().health
    }

    fn recover(&mut self) {}

    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        let controller = &mut *self.controller.borrow_mut();
        let Some(event) = controller.events.pop_front() else {
            controller.waiting = Some(context.waker().clone());
            return Poll::Pending;
        };
        if let PortEvent::Transmitted { mailbox, .. } | PortEvent::Failed { mailbox } = event
            && let Some(used) = controller.used.get_mut(usize::from(mailbox.0))
        {
            *used = false;
        }
        Poll::Ready(event)
    }
}
