//! Slots: the mailboxes of an adapter, in front of those of its driver.

use core::task::Context;

use heapless::{Deque, Vec};

use super::driver::{Accepted, Driver, Refused};
use crate::link::Stamp;
use crate::link::port::{Busy, LastError, Mailbox, PortEvent, is_urgent};
use crate::types::{CobId, Frame};

/// Number of mailboxes of an adapter.
pub const SLOTS: usize = 3;

/// Frames that wait for the driver or are in it, and ends of mailboxes that were not handed out yet.
#[derive(Default)]
pub struct Slots {
    slots: [Slot; SLOTS],
    /// Ends in the order of time. Each mailbox has at most one.
    ends: Deque<PortEvent, SLOTS>,
    /// Order of the frame that was sent last; counts up from zero.
    sent: i64,
    /// Order of the frame that was given back last; counts down from zero.
    returned: i64,
}

#[derive(Clone, Copy, Default)]
struct Slot {
    held: Option<Held>,
    /// The end of the mailbox is in `ends`.
    is_ending: bool,
}

impl Slot {
    fn is_in(&self, place: u8) -> bool {
        self.held.is_some_and(|held| held.place == Some(place))
    }
}

/// A frame that has not left.
#[derive(Clone, Copy)]
struct Held {
    frame: Frame,
    /// Frames of one COB-ID are handed over in this order.
    order: i64,
    /// Place in the driver; `None` while the frame waits for the driver.
    place: Option<u8>,
    /// The end of its mailbox was reported when the driver accepted it. The driver gave it back later.
    is_reported: bool,
}

impl Held {
    fn waits(&self) -> bool {
        self.place.is_none()
    }
}

impl Slots {
    /// Puts a frame into a free slot. The last free slot is for urgent frames.
    pub fn put(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        let mut free = (0..).zip(&mut self.slots).filter(|(_, slot)| slot.held.is_none() && !slot.is_ending);
        let (number, slot) = free.next().ok_or(Busy)?;
        if !is_urgent(frame.id()) && free.next().is_none() {
            return Err(Busy);
        }
        self.sent += 1;
        slot.held = Some(Held { frame: *frame, order: self.sent, place: None, is_reported: false });
        Ok(Mailbox(number))
    }

    /// Returns the next end of a mailbox, which is free from now on.
    pub fn next_end(&mut self) -> Option<PortEvent> {
        let end = self.ends.pop_front()?;
        if let PortEvent::Transmitted { mailbox, .. } | PortEvent::Failed { mailbox } = end
            && let Some(slot) = self.slots.get_mut(usize::from(mailbox.0))
        {
            slot.is_ending = false;
        }
        Some(end)
    }

    /// Returns whether the task has something to do without an event of the driver.
    pub fn has_work(&self) -> bool {
        !self.ends.is_empty() || self.slots.iter().flat_map(|slot| slot.held).any(|held| held.waits())
    }

    /// Hands waiting frames to the driver, the lowest COB-ID first. Returns the error of the driver that ended this.
    pub fn hand_over<D: Driver>(&mut self, driver: &mut D, context: &mut Context<'_>) -> Option<LastError> {
        let mut refused = Vec::<CobId, SLOTS>::new();
        // Bounded: a driver that gives up a frame for a less urgent one would go on without end.
        for _ in 0..2 * SLOTS {
            let (number, held) = self.next_waiting(&refused)?;
            match driver.transmit(&held.frame, context) {
                Ok(accepted) => self.on_accepted(number, held, accepted, driver),
                // Not tried again, and not overtaken by a later one.
                Err(Refused::Full) => refused.push(held.frame.id()).ok()?,
                Err(Refused::Error(error)) => return Some(error),
            }
        }
        None
    }

    /// Returns the waiting frame that goes first, of those with other COB-IDs than these.
    fn next_waiting(&self, refused: &[CobId]) -> Option<(usize, Held)> {
        let held = self.slots.iter().enumerate().filter_map(|(number, slot)| Some((number, slot.held?)));
        held.filter(|(_, held)| held.waits() && !refused.contains(&held.frame.id()))
            .min_by_key(|(_, held)| (held.frame.id(), held.order))
    }

    fn on_accepted<D: Driver>(&mut self, number: usize, held: Held, accepted: Accepted, driver: &D) {
        match accepted {
            Accepted::Unfollowed { replaced } => {
                self.returned -= i64::from(replaced.is_some());
                let order = self.returned;
                let given_back = |frame| Held { frame, order, place: None, is_reported: true };
                self.hold(number, replaced.map(given_back));
                if !held.is_reported {
                    self.end(number, true, driver);
                }
            }
            Accepted::Followed { place, replaced } => {
                let earlier = self.slots.iter().position(|slot| slot.is_in(place));
                self.hold(number, Some(Held { place: Some(place), ..held }));
                let Some(earlier) = earlier else { return };
                if replaced {
                    self.give_back(earlier);
                } else {
                    self.hold(earlier, None);
                    self.end(earlier, true, driver);
                }
            }
        }
    }

    fn hold(&mut self, number: usize, held: Option<Held>) {
        if let Some(slot) = self.slots.get_mut(number) {
            slot.held = held;
        }
    }

    /// The frame in this slot waits again.
    fn give_back(&mut self, number: usize) {
        if let Some(held) = self.slots.get_mut(number).and_then(|slot| slot.held.as_mut()) {
            held.place = None;
        }
    }

    /// Notes which frames have left. Returns whether there was one.
    pub fn take_sent<D: Driver>(&mut self, driver: &mut D, context: &mut Context<'_>) -> bool {
        let mut any = false;
        for number in 0..SLOTS {
            let place = self.held(number).and_then(|held| held.place);
            if place.is_some_and(|place| driver.poll_sent(place, context).is_ready()) {
                self.hold(number, None);
                self.end(number, true, driver);
                any = true;
            }
        }
        any
    }

    fn held(&self, number: usize) -> Option<Held> {
        self.slots.get(number)?.held
    }

    /// Aborts a mailbox. A frame that has left ends as transmitted. One that the driver does not follow has ended.
    pub fn abort<D: Driver>(&mut self, mailbox: Mailbox, driver: &mut D) {
        let number = usize::from(mailbox.0);
        let Some(held) = self.held(number) else { return };
        if !held.is_reported && held.place.is_none_or(|place| driver.abort(place)) {
            self.hold(number, None);
            self.end(number, false, driver);
        }
    }

    /// Aborts all mailboxes, and drops the frames that the driver gave back.
    pub fn abort_all<D: Driver>(&mut self, driver: &mut D) {
        for number in 0..SLOTS {
            self.abort(Mailbox(number as u8), driver);
            self.hold(number, self.held(number).filter(|held| !held.is_reported));
        }
    }

    fn end<D: Driver>(&mut self, number: usize, was_sent: bool, driver: &D) {
        let mailbox = Mailbox(number as u8);
        let end = if was_sent {
            PortEvent::Transmitted { mailbox, stamp: Stamp::interrupt(driver.now()) }
        } else {
            PortEvent::Failed { mailbox }
        };
        // There is room: a mailbox is not used again before its end was handed out.
        if self.ends.push_back(end).is_ok()
            && let Some(slot) = self.slots.get_mut(number)
        {
            slot.is_ending = true;
        }
    }
}
