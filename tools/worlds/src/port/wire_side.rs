//! Interface of the port to the wire.

use can_twin::wire::controller::{Attachment, Controller, ErrorCounters, WireEvent};
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::time::Time;
use ecss_can::link::port::{LastError, Mailbox, PortEvent};
use ecss_can::types::{CobId, Frame};

use super::faults::last_error;
use super::mailbox::MAILBOXES;
use super::{Chip, MockPort, RECEIVE_DEPTH};

impl Controller for MockPort {
    fn attachment(&self) -> Option<Attachment> {
        let chip = self.chip();
        if chip.gone.take() {
            // Leaving and rejoining at the same instant are two changes: the wire has to query again.
            chip.changed.set(true);
            chip.clock.timeline().interrupt();
            return None;
        }
        chip.attachment()
    }

    fn request_at(&self) -> Option<Time> {
        self.chip().waits_since()
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        let chip = self.chip();
        if !chip.may_send() {
            return None;
        }
        let (mailbox, frame) = chip.mailboxes.best(at)?;
        chip.contending.set(Some(mailbox));
        Some(WireFrame::standard(frame.id().raw(), frame.data()))
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        let mut chip = self.chip_mut();
        match event {
            WireEvent::Joined => chip.joined = true,
            WireEvent::Started => chip.on_started(),
            WireEvent::ArbitrationLost => chip.on_retry(),
            WireEvent::Transmitted => chip.on_transmitted(at),
            WireEvent::Received(frame) => chip.on_received(at, frame),
            WireEvent::TransmitError(kind) => {
                chip.faults.last_error = last_error(*kind);
                chip.on_retry();
            }
            WireEvent::ReceiveError(kind) => chip.faults.last_error = last_error(*kind),
            WireEvent::Counters(counters) => chip.on_counters(*counters),
        }
        if chip.faults.flags() != chip.told {
            chip.wake();
        }
        chip.finish_leaving();
    }
}

impl Chip {
    pub(super) fn attachment(&self) -> Option<Attachment> {
        let since = self.on_bus?;
        let (recovers, power_cycle, silent) = (self.recovers, self.power_cycle, self.listens);
        Some(Attachment { recovers, power_cycle, silent, since, ..Attachment::new(self.timing) })
    }

    /// Returns since when a frame that may be sent waits.
    pub(super) fn waits_since(&self) -> Option<Time> {
        if self.may_send() { self.mailboxes.waiting_since() } else { None }
    }

    fn on_started(&mut self) {
        if let Some(mailbox) = self.contending.take() {
            self.mailboxes.start(mailbox);
        }
    }

    /// Handles automatic retransmission, unless the frame is to be aborted.
    fn on_retry(&mut self) {
        if let Some(mailbox) = self.mailboxes.retry() {
            self.fail(mailbox);
        }
    }

    fn on_transmitted(&mut self, at: Time) {
        let Some(mailbox) = self.mailboxes.on_wire() else { return };
        self.mailboxes.end(mailbox);
        self.faults.last_error = LastError::None;
        let stamp = self.stamp(at);
        self.push(PortEvent::Transmitted { mailbox: Mailbox(mailbox as u8), stamp });
    }

    fn on_received(&mut self, at: Time, frame: &WireFrame) {
        if self.leaving {
            return;
        }
        self.faults.last_error = LastError::None;
        let Some(frame) = self.admit(frame) else { return };
        if self.received == RECEIVE_DEPTH {
            self.lost = self.lost.saturating_add(1);
            return self.wake();
        }
        self.received += 1;
        let stamp = self.stamp(at);
        self.push(PortEvent::Received { frame, stamp });
    }

    /// Returns the frame if it is an 11-bit data frame that a filter admits. All others are only acknowledged.
    fn admit(&self, frame: &WireFrame) -> Option<Frame> {
        let WireId::Standard(raw) = frame.id else { return None };
        let id = CobId::new(raw).filter(|_| !frame.remote)?;
        let is_admitted = self.filters.iter().any(|filter| filter.admits(id));
        let frame = is_admitted.then(|| Frame::from_dlc(id, frame.dlc, frame.data));
        frame.filter(|frame| !self.missed.contains(frame))
    }

    fn on_counters(&mut self, counters: ErrorCounters) {
        self.faults.counters = counters;
        if counters.bus_off() {
            (0..MAILBOXES)
                .filter(|&mailbox| self.mailboxes.is_pending(mailbox))
                .collect::<Vec<_>>()
                .into_iter()
                .for_each(|mailbox| self.fail(mailbox));
        } else if counters == ErrorCounters::default() {
            // A recovery ends with both counters at zero.
            self.recovers = false;
        }
    }
}
