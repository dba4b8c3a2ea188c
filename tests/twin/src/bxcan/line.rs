//! A controller on its wire, and the internal wire of loopback.

use can_wire::controller::{Controller, WireEvent};
use can_wire::frame::{WireFrame, WireId};
use can_wire::time::Time;

use super::controller::{Mode, Registers};
use super::filter::FilterBlock;
use super::mailbox::Attempt;
use super::regs::{MCR_NART, MCR_TXFP};

/// Intermission between two frames, bits.
const INTERMISSION: u64 = 3;

/// One controller as a wire sees it; borrowed from the pair because the filters belong to both.
#[derive(Debug)]
pub struct Line<'a> {
    pub(super) registers: &'a mut Registers,
    pub(super) filters: &'a FilterBlock,
}

impl Controller for Line<'_> {
    fn bit_time(&self) -> Option<Time> {
        let registers = &self.registers;
        let live = registers.mode == Mode::Normal && !registers.errors.bus_off() && !registers.loopback();
        live.then(|| registers.bits(1))
    }

    fn acknowledges(&self) -> bool {
        !self.registers.silent()
    }

    fn error_passive(&self) -> bool {
        self.registers.errors.passive()
    }

    fn request_at(&self) -> Option<Time> {
        if self.bit_time().is_none() || self.registers.silent() {
            return None;
        }
        let at = self.registers.mailboxes.request_at()?.max(self.registers.on_bus_since);
        self.registers.may_send(at).then_some(at)
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        let allowed = self.bit_time().is_some() && !self.registers.silent() && self.registers.may_send(at);
        allowed.then(|| self.registers.mailboxes.contend(at, self.registers.mcr(MCR_TXFP))).flatten()
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        let registers = &mut *self.registers;
        if registers.mode != Mode::Normal || registers.errors.bus_off() {
            return;
        }
        let single_shot = registers.mcr(MCR_NART);
        match event {
            WireEvent::Started => {
                let by_request_order = registers.mcr(MCR_TXFP);
                registers.mailboxes.start(at, by_request_order);
                return;
            }
            WireEvent::ArbitrationLost => {
                registers.mailboxes.finish(at, Attempt::ArbitrationLost, single_shot);
                return;
            }
            WireEvent::Transmitted(_) => {
                registers.errors.transmitted();
                registers.mailboxes.finish(at, Attempt::Succeeded, single_shot);
            }
            WireEvent::Received(trace) => registers.receive(at, trace.frame, self.filters),
            WireEvent::TransmitError(kind) => {
                registers.mailboxes.finish(at, Attempt::Failed, single_shot);
                registers.fail(at, |errors| errors.transmit_error(*kind));
            }
            WireEvent::ReceiveError(kind) => registers.fail(at, |errors| errors.receive_error(*kind)),
        }
        registers.activity_ended(at);
    }
}

impl Line<'_> {
    /// Runs loopback up to `now`, RM0090 32.5.2: what is sent is received, acknowledge errors are ignored.
    ///
    /// The frames stay inside: that they also appear on CANTX without LBKM's silent companion is not modelled. Their
    /// length is that without stuff bits.
    pub(super) fn run_loopback(&mut self, now: Time) {
        let registers = &mut *self.registers;
        if registers.mode != Mode::Normal || !registers.loopback() {
            registers.loopback_end = None;
            return;
        }
        let by_request_order = registers.mcr(MCR_TXFP);
        loop {
            if let Some(end) = registers.loopback_end {
                if end > now {
                    return;
                }
                let frame = registers.mailboxes.finish(end, Attempt::Succeeded, false);
                registers.errors.transmitted();
                if let Some(frame) = frame {
                    registers.receive(end, frame, self.filters);
                }
                registers.loopback_end = None;
                registers.on_bus_since = end + registers.bits(INTERMISSION);
            }
            let Some(request) = registers.mailboxes.request_at() else { return };
            let start = request.max(registers.on_bus_since);
            if start > now || !registers.may_send(start) {
                return;
            }
            let Some(frame) = registers.mailboxes.start(start, by_request_order) else { return };
            registers.loopback_end = Some(start + registers.bits(unstuffed_bits(&frame)));
        }
    }
}

/// From SOF to the last bit of EOF.
fn unstuffed_bits(frame: &WireFrame) -> u64 {
    let around_data = match frame.id {
        WireId::Standard(_) => 44,
        WireId::Extended(_) => 64,
    };
    around_data + 8 * frame.len() as u64
}
