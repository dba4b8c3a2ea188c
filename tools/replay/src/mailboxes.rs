//! Mailboxes of a board, by the journals of its controllers.

use can_wire::time::Time;
use ecss_can::types::{Bus, Frame, PerBus};

/// Mailboxes that a frame without urgency may have: one of three is kept free.
const MAILBOXES: usize = 2;
/// A frame that was aborted for an urgent one is requested again within its lifetime, 100 ms. A request at the end of the
/// lifetime is that of the next frame. The lifetime begins up to 2 ms before the first request.
const RETURN: Time = Time::from_ms(98);

/// Requests that have not ended, and spans in which frames had to wait.
#[derive(Debug, Default)]
pub struct Mailboxes {
    /// First request of each frame.
    pending: PerBus<Vec<(Time, Frame)>>,
    aborted: PerBus<Vec<(Time, Frame)>>,
    /// Since then frames wait.
    full_since: PerBus<Option<Time>>,
    full: PerBus<Vec<(Time, Time)>>,
}

impl Mailboxes {
    /// Takes a request. Returns `false` if the frame was aborted for an urgent one before, and is requested again.
    pub fn request(&mut self, at: Time, bus: Bus, frame: Frame) -> bool {
        let place = self.aborted[bus].iter().position(|(_, aborted)| *aborted == frame);
        let first = place.map(|place| self.aborted[bus].remove(place).0);
        let again = first.filter(|first| at < *first + RETURN);
        self.pending[bus].push((again.unwrap_or(at), frame));
        self.follow(at, bus);
        again.is_none()
    }

    /// Takes the end of a request.
    pub fn end(&mut self, at: Time, bus: Bus, frame: &Frame, is_aborted: bool) {
        let Some(place) = self.pending[bus].iter().position(|(_, pending)| pending == frame) else { return };
        let ended = self.pending[bus].remove(place);
        if is_aborted {
            self.aborted[bus].push(ended);
        }
        self.follow(at, bus);
    }

    /// Forgets all requests: the chip was reset, or the run ended.
    pub fn reset(&mut self, at: Time) {
        (self.pending, self.aborted) = Default::default();
        Bus::ALL.into_iter().for_each(|bus| self.follow(at, bus));
    }

    fn follow(&mut self, at: Time, bus: Bus) {
        let is_full = self.pending[bus].len() >= MAILBOXES;
        if is_full {
            self.full_since[bus].get_or_insert(at);
        } else if let Some(since) = self.full_since[bus].take() {
            self.full[bus].push((since, at));
        }
    }

    /// Returns whether frames had to wait at some instant of a span.
    pub fn is_full(&self, bus: Bus, from: Time, to: Time) -> bool {
        self.full[bus].iter().any(|(since, until)| *since <= to && *until >= from)
    }
}

#[cfg(test)]
mod tests {
    use ecss_can::heartbeat;
    use ecss_can::types::{NmtState, NodeId};

    use super::*;

    const BUS: Bus = Bus::Nominal;

    fn frame() -> Frame {
        heartbeat::encode(NodeId::of::<2>(), NmtState::Operational)
    }

    /// Given an aborted frame, when it is requested again within its lifetime, then that is no other frame. At the end of the
    /// lifetime it is.
    #[test]
    fn an_aborted_frame_returns_within_its_lifetime() {
        let mut mailboxes = Mailboxes::default();
        assert!(mailboxes.request(Time::ZERO, BUS, frame()));
        mailboxes.end(Time::from_ms(10), BUS, &frame(), true);
        assert!(!mailboxes.request(Time::from_ms(20), BUS, frame()));
        mailboxes.end(Time::from_ms(100), BUS, &frame(), true);
        assert!(mailboxes.request(Time::from_ms(100), BUS, frame()));
    }

    #[test]
    fn a_frame_that_was_sent_does_not_return() {
        let mut mailboxes = Mailboxes::default();
        mailboxes.request(Time::ZERO, BUS, frame());
        mailboxes.end(Time::from_ms(10), BUS, &frame(), false);
        assert!(mailboxes.request(Time::from_ms(20), BUS, frame()));
    }

    #[test]
    fn frames_wait_while_two_of_their_bus_are_pending() {
        let mut mailboxes = Mailboxes::default();
        mailboxes.request(Time::from_ms(1), BUS, frame());
        mailboxes.request(Time::from_ms(2), BUS, frame());
        mailboxes.end(Time::from_ms(4), BUS, &frame(), false);
        let is_full = |bus, from, to| mailboxes.is_full(bus, Time::from_ms(from), Time::from_ms(to));
        assert!(is_full(BUS, 0, 2) && is_full(BUS, 3, 9));
        assert!(!is_full(BUS, 0, 1) && !is_full(BUS, 5, 9));
        assert!(!is_full(BUS.other(), 0, 9));
    }
}
