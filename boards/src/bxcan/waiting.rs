//! Events of a controller that its task has not taken yet: bounded, nothing dropped silently.

use ecss_can::link::Stamp;
use ecss_can::link::port::{Mailbox, PortEvent};
use ecss_can::types::Frame;
use heapless::Deque;

use super::MAILBOXES;
use super::status::ErrorLog;

/// Received frames that may wait for the task: 1.5 ms of the shortest frames, 3.5 ms of those with 8 bytes.
const FRAMES: usize = 32;

/// What happened on a controller and was not taken yet.
pub(super) struct Waiting {
    /// In the order of time. Frames and one result per mailbox always find a place.
    events: Deque<PortEvent, { FRAMES + MAILBOXES }>,
    lost: u16,
    pub errors: ErrorLog,
}

impl Waiting {
    pub const fn new() -> Self {
        Waiting { events: Deque::new(), lost: 0, errors: ErrorLog::new() }
    }

    /// A frame was received; when there are too many it is counted as lost.
    pub fn received(&mut self, frame: Frame, stamp: Stamp) {
        if self.events.len() >= FRAMES || self.events.push_back(PortEvent::Received { frame, stamp }).is_err()
        {
            self.lose();
        }
    }

    /// At least one frame was lost before it could be read: FOVR does not count them.
    pub fn lose(&mut self) {
        self.lost = self.lost.saturating_add(1);
    }

    /// The result of a mailbox. It is used again only after its result was taken; should it end once more before, the
    /// later result takes the place of the earlier one, which is counted.
    pub fn finished(&mut self, result: PortEvent) {
        let same = self.events.iter_mut().find(|event| mailbox(event) == mailbox(&result));
        match same {
            Some(earlier) => {
                *earlier = result;
                self.lose();
            }
            None => {
                if self.events.push_back(result).is_err() {
                    self.lose();
                }
            }
        }
    }

    /// Whether such an event waits.
    pub fn holds(&self, such: impl Fn(&PortEvent) -> bool) -> bool {
        self.events.iter().any(such)
    }

    /// The next event.
    pub fn take(&mut self) -> Option<PortEvent> {
        if let Some(health) = self.errors.take() {
            return Some(PortEvent::Health(health));
        }
        if self.lost > 0 {
            return Some(PortEvent::Overrun { lost: core::mem::take(&mut self.lost) });
        }
        self.events.pop_front()
    }
}

/// Mailbox of a result.
fn mailbox(event: &PortEvent) -> Option<Mailbox> {
    match event {
        PortEvent::Transmitted { mailbox, .. } | PortEvent::Failed { mailbox } => Some(*mailbox),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ecss_can::types::{CobId, Instant};

    fn receive(waiting: &mut Waiting) {
        let stamp = Stamp::interrupt(Instant::from_micros(1));
        waiting.received(Frame::from_dlc(CobId::SYNC, 0, [0; 8]), stamp);
    }

    fn failed(mailbox: u8) -> PortEvent {
        PortEvent::Failed { mailbox: Mailbox(mailbox) }
    }

    fn taken(waiting: &mut Waiting) -> Vec<PortEvent> {
        std::iter::from_fn(|| waiting.take()).collect()
    }

    #[test]
    fn full_queue_keeps_a_result_of_every_mailbox() {
        let mut waiting = Waiting::new();
        (0..FRAMES + 2).for_each(|_| receive(&mut waiting));
        (0..MAILBOXES as u8).for_each(|mailbox| waiting.finished(failed(mailbox)));
        let events = taken(&mut waiting);
        assert_eq!(events[0], PortEvent::Overrun { lost: 2 });
        assert_eq!(events[1 + FRAMES..], [failed(0), failed(1), failed(2)]);
    }

    #[test]
    fn second_result_of_a_mailbox_replaces_the_first_and_counts() {
        let mut waiting = Waiting::new();
        (0..FRAMES).for_each(|_| receive(&mut waiting));
        (0..MAILBOXES as u8).for_each(|mailbox| waiting.finished(failed(mailbox)));
        let stamp = Stamp::interrupt(Instant::from_micros(2));
        let sent = PortEvent::Transmitted { mailbox: Mailbox(1), stamp };
        waiting.finished(sent);
        assert!(waiting.holds(|event| *event == sent) && !waiting.holds(|event| *event == failed(1)));
        let events = taken(&mut waiting);
        assert_eq!(events[0], PortEvent::Overrun { lost: 1 });
        assert_eq!(events[1 + FRAMES..], [failed(0), sent, failed(2)]);
    }
}
