//! A controller on its wire, and internal loopback.

use super::controller::{Mode, Registers};
use super::filter::FilterBlock;
use super::mailbox::Attempt;
use super::regs::{MCR_NART, MCR_TXFP};
use crate::wire::controller::{Attachment, Controller, WireEvent};
use crate::wire::encode::encode;
use crate::wire::frame::{WireFrame, WireId};
use crate::wire::time::Time;

/// Intermission between two frames, bits.
const INTERMISSION: u64 = 3;

/// Access of a wire to one controller; borrows the pair because the controllers share the filters.
#[derive(Debug)]
pub struct BusTap<'a> {
    pub(super) registers: &'a mut Registers,
    pub(super) filters: &'a FilterBlock,
}

impl Controller for BusTap<'_> {
    fn attachment(&self) -> Option<Attachment> {
        self.registers.attachment()
    }

    fn request_at(&self) -> Option<Time> {
        self.registers.request_at()
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.registers.contend(at)
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        let registers = &mut *self.registers;
        let single_shot = registers.mcr(MCR_NART);
        match event {
            WireEvent::Joined => registers.joined(at),
            WireEvent::Counters(counters) => registers.count(at, *counters),
            _ if registers.mode != Mode::Normal => {}
            WireEvent::Started => {
                let by_request_order = registers.mcr(MCR_TXFP);
                registers.mailboxes.start(at, by_request_order);
            }
            WireEvent::ArbitrationLost => {
                registers.mailboxes.finish(at, Attempt::ArbitrationLost, single_shot);
            }
            WireEvent::Transmitted => {
                registers.mailboxes.finish(at, Attempt::Succeeded, single_shot);
                registers.errors.succeeded();
            }
            WireEvent::Received(frame) => {
                // A frame is valid with the last but one bit of EOF. Its start is derived from its length.
                let begun = registers.bits(encode(frame).bits().len() as u64 - 2);
                registers.receive(at.since(begun), at, *frame, self.filters);
            }
            WireEvent::TransmitError(kind) => {
                registers.mailboxes.finish(at, Attempt::Failed, single_shot);
                registers.fail(*kind);
            }
            WireEvent::ReceiveError(kind) => registers.fail(*kind),
        }
    }

    fn watches_line(&self) -> bool {
        true
    }

    fn on_line(&mut self, changes: &[(Time, bool)]) {
        changes.iter().filter(|(_, recessive)| !recessive).for_each(|&(at, _)| self.registers.dominant(at));
    }
}

impl BusTap<'_> {
    /// Runs loopback up to `now`, RM0090 32.5.2: sent frames are received, acknowledge errors are ignored.
    ///
    /// The frames stay inside the controller. It is not modelled that they also appear on CANTX unless silent mode is
    /// set. Their length is that without stuff bits.
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
                registers.errors.succeeded();
                if let Some(frame) = frame {
                    let start = end.since(registers.bits(unstuffed_bits(&frame)));
                    registers.receive(start, end, frame, self.filters);
                }
                registers.loopback_end = None;
                registers.on_bus_since = end + registers.bits(INTERMISSION);
            }
            let Some(start) = registers.loopback_start().filter(|&start| start <= now) else { return };
            let Some(frame) = registers.mailboxes.start(start, by_request_order) else { return };
            registers.loopback_end = Some(start + registers.bits(unstuffed_bits(&frame)));
        }
    }
}

/// Returns the number of bits from SOF to the last bit of EOF, without stuff bits.
fn unstuffed_bits(frame: &WireFrame) -> u64 {
    let around_data = match frame.id {
        WireId::Standard(_) => 44,
        WireId::Extended(_) => 64,
    };
    around_data + 8 * frame.len() as u64
}
