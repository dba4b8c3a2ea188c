//! Events of a controller that its task has not taken yet. Their number is bounded, and losses are counted.
//!
//! This ring buffer checks each index. `heapless::Deque` does not: one flipped bit in an index would cause an access
//! out of bounds. A test compares the two. An index that is out of range loses the events that wait, and counts as an
//! overrun.

use ecss_can::link::Stamp;
use ecss_can::link::port::{Mailbox, PortEvent};
use ecss_can::types::{CobId, Frame, Instant};

use super::MAILBOXES;
use super::status::ErrorLog;

/// Received frames that may wait for the task: 1.5 ms of the shortest frames, 3.5 ms of those with 8 bytes. A minimal
/// slave receives only its own commands, SYNC and the heartbeat of the master.
const FRAMES: usize = if cfg!(feature = "full") { 32 } else { 8 };

/// Capacity: the frames and one result per mailbox.
const PLACES: usize = FRAMES + MAILBOXES;

/// An empty place. Zero, so that the statics of the events stay in `.bss`.
const EMPTY: PortEvent = PortEvent::Received {
    frame: Frame::from_dlc(CobId::NMT, 0, [0; 8]),
    stamp: Stamp::interrupt(Instant::ZERO),
};

/// Events of a controller that were not taken yet.
pub(super) struct Waiting {
    /// Ring of `len` events in chronological order, beginning at `first`.
    events: [PortEvent; PLACES],
    first: usize,
    len: usize,
    lost: u16,
    pub errors: ErrorLog,
}

impl Waiting {
    pub const fn new() -> Self {
        Waiting { events: [EMPTY; PLACES], first: 0, len: 0, lost: 0, errors: ErrorLog::new() }
    }

    /// Adds a received frame, or counts it as lost if too many are pending.
    #[inline]
    pub fn received(&mut self, frame: Frame, stamp: Stamp) {
        if self.len >= FRAMES {
            return self.lose();
        }
        self.put(PortEvent::Received { frame, stamp });
    }

    /// Adds an event. The caller has checked that there is room.
    #[inline(always)] // the receive interrupt makes the event in its place
    fn put(&mut self, event: PortEvent) {
        if let Some(place) = self.events.get_mut(place(self.first + self.len)) {
            *place = event;
            self.len += 1;
        } else {
            self.lose();
        }
    }

    /// Counts an overrun: at least one frame was lost before it could be read. FOVR gives no number.
    pub fn lose(&mut self) {
        self.lost = self.lost.saturating_add(1);
    }

    /// Adds the result of a mailbox. A mailbox is reused only after its result was taken. If it ends twice
    /// nevertheless, the later result replaces the earlier one, which is counted as lost.
    pub fn finished(&mut self, result: PortEvent) {
        for n in 0..self.len.min(PLACES) {
            if let Some(earlier) = self.events.get_mut(place(self.first + n))
                && mailbox(earlier) == mailbox(&result)
            {
                *earlier = result;
                return self.lose();
            }
        }
        if self.len < PLACES { self.put(result) } else { self.lose() }
    }

    /// Returns whether an event matches `such`.
    pub fn holds(&self, such: impl Fn(&PortEvent) -> bool) -> bool {
        (0..self.len.min(PLACES)).filter_map(|n| self.events.get(place(self.first + n))).any(such)
    }

    /// The next event.
    #[inline]
    pub fn take(&mut self) -> Option<PortEvent> {
        if let Some(health) = self.errors.take() {
            return Some(PortEvent::Health(health));
        }
        if self.first >= PLACES || self.len > PLACES {
            (self.first, self.len) = (0, 0);
            self.lose();
        }
        if self.lost > 0 {
            return Some(PortEvent::Overrun { lost: core::mem::take(&mut self.lost) });
        }
        if self.len == 0 {
            return None;
        }
        let event = self.events.get(self.first).copied();
        self.len -= 1;
        self.first = place(self.first + 1);
        event
    }
}

/// Index of an element in the ring, modulo its capacity. Out of range if an index is.
fn place(number: usize) -> usize {
    if number < PLACES { number } else { number - PLACES }
}

/// Returns the mailbox if the event is a result.
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
    use heapless::Deque;
    use proptest::prelude::*;

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

    /// Given frames that wait, when any bit of an index flips, then the queue is empty after at most all its places and an
    /// overrun, and the next frames arrive in order.
    #[test]
    fn a_flipped_bit_of_an_index_loses_frames_alone() {
        let frames = |waiting: &mut Waiting| {
            let events = taken(waiting).into_iter();
            events.filter(|event| matches!(event, PortEvent::Received { .. })).count()
        };
        for bit in 0..2 * usize::BITS {
            for number in 0..FRAMES {
                let mut waiting = Waiting::new();
                (0..number).for_each(|_| receive(&mut waiting));
                let index = if bit < usize::BITS { &mut waiting.first } else { &mut waiting.len };
                *index ^= 1 << (bit % usize::BITS);
                receive(&mut waiting);
                waiting.finished(failed(0));
                assert!(frames(&mut waiting) <= PLACES, "bit {bit}");
                (0..5).for_each(|_| receive(&mut waiting));
                assert_eq!(frames(&mut waiting), 5, "bit {bit} with {number}");
            }
        }
    }

    #[test]
    fn events_keep_their_order_round_and_round() {
        let mut waiting = Waiting::new();
        (0..FRAMES / 2).for_each(|_| receive(&mut waiting));
        for round in 0..3 * PLACES {
            let frame = Frame::from_dlc(CobId::SYNC, 1, [round as u8; 8]);
            waiting.received(frame, Stamp::interrupt(Instant::from_micros(2)));
            let result = failed((round % MAILBOXES) as u8);
            waiting.finished(result);
            assert!(waiting.holds(|event| *event == result));
            let events = taken(&mut waiting);
            let last_two = &events[events.len() - 2..];
            assert!(
                matches!(last_two[0], PortEvent::Received { frame, .. } if frame.data() == [round as u8])
            );
            assert_eq!(last_two[1], result);
            assert_eq!(events.len(), if round == 0 { FRAMES / 2 + 2 } else { 2 });
        }
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

    #[derive(Clone, Copy, Debug)]
    enum Step {
        Receive,
        Finish { mailbox: u8, is_sent: bool },
        Take,
    }

    fn step() -> impl Strategy<Value = Step> {
        prop_oneof![
            Just(Step::Receive),
            (0..MAILBOXES as u8, any::<bool>())
                .prop_map(|(mailbox, is_sent)| Step::Finish { mailbox, is_sent }),
            Just(Step::Take),
        ]
    }

    /// Model of `Waiting` for frames and results, on a ring of `heapless`.
    #[derive(Default)]
    struct Model {
        events: Deque<PortEvent, PLACES>,
        lost: u16,
    }

    impl Model {
        fn received(&mut self, event: PortEvent) {
            if self.events.len() < FRAMES {
                self.events.push_back(event).unwrap();
            } else {
                self.lost += 1;
            }
        }

        fn finished(&mut self, result: PortEvent) {
            if let Some(earlier) = self.events.iter_mut().find(|event| mailbox(event) == mailbox(&result)) {
                *earlier = result;
                self.lost += 1;
            } else {
                self.events.push_back(result).unwrap();
            }
        }

        fn take(&mut self) -> Option<PortEvent> {
            match core::mem::take(&mut self.lost) {
                0 => self.events.pop_front(),
                lost => Some(PortEvent::Overrun { lost }),
            }
        }
    }

    proptest! {
        /// Given random runs of frames, results and takes, from empty to full and back, when both rings do the same, then each take
        /// gives the same event or the same count of losses.
        #[test]
        fn ring_gives_the_events_of_a_ring_of_heapless(
            runs in proptest::collection::vec((step(), 1..=PLACES + 1), 0..60),
        ) {
            let (mut waiting, mut model) = (Waiting::new(), Model::default());
            let steps = runs.into_iter().flat_map(|(step, times)| core::iter::repeat_n(step, times));
            for (number, step) in (0..).zip(steps) {
                let stamp = Stamp::interrupt(Instant::from_micros(number));
                match step {
                    Step::Receive => {
                        let frame = Frame::from_dlc(CobId::SYNC, 8, number.to_le_bytes());
                        waiting.received(frame, stamp);
                        model.received(PortEvent::Received { frame, stamp });
                    }
                    Step::Finish { mailbox, is_sent } => {
                        let mailbox = Mailbox(mailbox);
                        let result = if is_sent {
                            PortEvent::Transmitted { mailbox, stamp }
                        } else {
                            PortEvent::Failed { mailbox }
                        };
                        waiting.finished(result);
                        model.finished(result);
                    }
                    Step::Take => prop_assert_eq!(waiting.take(), model.take()),
                }
            }
            let rest: Vec<_> = core::iter::from_fn(|| model.take()).collect();
            prop_assert_eq!(taken(&mut waiting), rest);
        }
    }
}
