//! The port as the wire sees it.

use can_wire::controller::{Controller, WireEvent};
use can_wire::frame::{WireFrame, WireId};
use can_wire::time::Time;
use ecss_can::link::port::{ErrorState, MAILBOXES, Mailbox, PortEvent};
use ecss_can::link::{CobId, Frame};

use super::{BIT, Chip, MockPort, RECEIVE_DEPTH};

impl Controller for MockPort {
    fn bit_time(&self) -> Option<Time> {
        self.chip().takes_part().then_some(BIT)
    }

    fn error_passive(&self) -> bool {
        self.chip().confinement.state() != ErrorState::Active
    }

    fn request_at(&self) -> Option<Time> {
        let chip = self.chip();
        if chip.leaving || chip.confinement.state() == ErrorState::BusOff {
            return None;
        }
        Some(chip.mailboxes.waiting_since()?.max(chip.joined?))
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        let chip = self.chip();
        if chip.leaving || !chip.takes_part() {
            return None;
        }
        let (mailbox, frame) = chip.mailboxes.best(at)?;
        chip.contending.set(Some(mailbox));
        Some(WireFrame::standard(frame.id().raw(), frame.data()))
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        let mut chip = self.0.borrow_mut();
        match event {
            WireEvent::Started => chip.on_started(),
            WireEvent::ArbitrationLost => chip.on_retry(),
            WireEvent::Transmitted(_) => chip.on_transmitted(at),
            WireEvent::Received(trace) => chip.on_received(at, &trace.frame),
            WireEvent::TransmitError(kind) => {
                chip.confinement.transmit_error(*kind);
                chip.on_retry();
                chip.on_counters();
            }
            WireEvent::ReceiveError(kind) => {
                chip.confinement.receive_error(*kind);
                chip.on_counters();
            }
        }
        chip.finish_leaving();
    }
}

impl Chip {
    fn on_started(&mut self) {
        if let Some(mailbox) = self.contending.take() {
            self.mailboxes.start(mailbox);
        }
    }

    /// Automatic retransmission, unless the frame is to be aborted.
    fn on_retry(&mut self) {
        if let Some(mailbox) = self.mailboxes.retry() {
            self.fail(mailbox);
        }
    }

    fn on_transmitted(&mut self, at: Time) {
        let Some(mailbox) = self.mailboxes.on_wire() else { return };
        self.mailboxes.end(mailbox);
        self.confinement.transmitted();
        let stamp = self.stamp(at);
        self.push(PortEvent::Transmitted { mailbox: Mailbox(mailbox as u8), stamp });
        self.on_counters();
    }

    fn on_received(&mut self, at: Time, frame: &WireFrame) {
        if self.leaving {
            return;
        }
        self.confinement.received();
        self.on_counters();
        let Some(frame) = self.admit(frame) else { return };
        if self.received == RECEIVE_DEPTH {
            self.lost = self.lost.saturating_add(1);
            return self.wake();
        }
        self.received += 1;
        let stamp = self.stamp(at);
        self.push(PortEvent::Received { frame, stamp });
    }

    /// Only 11-bit data frames that a filter admits; all others were acknowledged and are of no concern.
    fn admit(&self, frame: &WireFrame) -> Option<Frame> {
        let WireId::Standard(raw) = frame.id else { return None };
        let id = CobId::new(raw).filter(|_| !frame.remote)?;
        self.filters
            .iter()
            .any(|filter| filter.admits(id))
            .then(|| Frame::from_dlc(id, frame.dlc, frame.data))
    }

    fn on_counters(&mut self) {
        if self.confinement.state() == ErrorState::BusOff {
            (0..MAILBOXES)
                .filter(|&mailbox| self.mailboxes.is_pending(mailbox))
                .collect::<Vec<_>>()
                .into_iter()
                .for_each(|mailbox| self.fail(mailbox));
        }
        if self.confinement.flags() != self.told {
            self.wake();
        }
    }
}
