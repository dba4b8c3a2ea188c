//! Upsets of the CAN controllers: bits that hold state, and what follows when one of them is inverted.
//!
//! Not listed: INAK and SLAK, which follow the mode; FMP, the number of messages; TEC and REC, which belong to the engine of the wire;
//! TIME, which reads zero.

use super::controller::Registers;
use super::fifo::{Fifo, rir};
use super::filter::FilterBlock;
use super::mailbox::{Mailbox, Mailboxes, Request};
use super::regs::*;
use super::{BxcanPair, Side, locate};
use crate::wire::frame::{WireFrame, WireId};
use crate::wire::time::Time;

/// RQCP, TXOK, ALST, TERR and ABRQ of the three mailboxes.
const TSR_BITS: u32 = 0x008F_8F8F;
/// All bits of RIR but the reserved one.
const RIR_BITS: u32 = !1;
/// DLC and the filter match index.
const RDTR_BITS: u32 = 0xFF0F;
const WORDS: [u32; 4] = [u32::MAX, TDTR_STORED, u32::MAX, u32::MAX];
const RECEIVED: [u32; 4] = [RIR_BITS, RDTR_BITS, u32::MAX, u32::MAX];

impl BxcanPair {
    /// Returns the offsets from 4000 6400h of the registers of a controller, and their bits that hold state. The filters belong to
    /// CAN1. An empty FIFO has no message.
    pub fn stored(&self, side: Side) -> Vec<(u32, u32)> {
        let controller = &self.controllers[side as usize];
        let mut all = vec![
            (MCR, MCR_STORED),
            (MSR, MSR_ERRI | MSR_WKUI | MSR_SLAKI),
            (TSR, TSR_BITS),
            (RF0R, RFR_FULL | RFR_FOVR),
            (RF1R, RFR_FULL | RFR_FOVR),
            (IER, IER_STORED),
            (ESR, ESR_LEC),
            (BTR, BTR_STORED),
        ];
        let words = |base: u32, bits: [u32; 4]| (base..).step_by(4).zip(bits);
        all.extend((0..3).flat_map(|n| words(TX_MAILBOXES + 16 * n, WORDS)));
        let full = (0..2).zip(&controller.fifos).filter(|(_, fifo)| !fifo.messages.is_empty());
        all.extend(full.flat_map(|(n, _)| words(RX_MAILBOXES + 16 * n, RECEIVED)));
        match side {
            Side::Can1 => {
                all.push((FMR, FMR_FINIT | FMR_CAN2SB));
                all.extend([FM1R, FS1R, FFA1R, FA1R].map(|offset| (offset, BANK_BITS)));
                all.extend((BANKS..BANKS_END).step_by(4).map(|offset| (offset, u32::MAX)));
            }
            Side::Can2 => all.iter_mut().for_each(|(offset, _)| *offset += CONTROLLER_SIZE),
        }
        all
    }

    /// Inverts a bit of a register at `now`. Requests for a mode take effect as if the program had made them; filters and bit timing
    /// change at once, whatever protects them from the program.
    pub fn flip(&mut self, offset: u32, bit: u32, now: Time) {
        let Ok((side, within)) = locate(offset) else { return };
        match side {
            Side::Can1 if within >= FMR => self.filters.flip(within, bit, now),
            _ => self.controllers[side as usize].flip(within, bit, now),
        }
    }
}

impl Registers {
    fn flip(&mut self, offset: u32, bit: u32, now: Time) {
        let mask = 1 << bit;
        match offset {
            MCR => self.write_mcr(self.mcr ^ mask, now),
            MSR => self.msr_flags ^= mask,
            TSR => self.mailboxes.flip_status(bit, now),
            RF0R | RF1R => self.fifos[usize::from(offset == RF1R)].flags ^= mask,
            IER => self.ier ^= mask,
            ESR => self.errors.lec ^= (mask >> 4) as u8,
            BTR => self.set_btr(self.btr ^ mask),
            TX_MAILBOXES..RX_MAILBOXES => {
                let (n, word) = (((offset - TX_MAILBOXES) / 16) as usize, (offset / 4 % 4) as usize);
                self.mailboxes.flip(n, word, bit, now);
            }
            RX_MAILBOXES..RX_MAILBOXES_END => {
                let (n, word) =
                    (((offset - RX_MAILBOXES) / 16) as usize, ((offset - RX_MAILBOXES) / 4 % 4) as usize);
                self.fifos[n].flip(word, bit);
            }
            _ => {}
        }
    }
}

impl Mailboxes {
    /// Inverts a bit of TSR. ABRQ has an effect while its mailbox has a request.
    fn flip_status(&mut self, bit: u32, now: Time) {
        let Mailbox { status, request, .. } = &mut self.boxes[bit as usize / 8];
        match (1 << (bit % 8), request) {
            (TSR_ABRQ, Some(request)) => {
                request.abort = if request.abort.is_some() { None } else { Some(now) };
            }
            (TSR_ABRQ, None) => {}
            (flag, _) => *status ^= flag,
        }
    }

    /// Inverts a bit of a mailbox. TXRQ requests the content that is there, or withdraws a request whose frame is not on the wire.
    fn flip(&mut self, n: usize, word: usize, bit: u32, now: Time) {
        let order = self.requests;
        let mailbox = &mut self.boxes[n];
        if (word, 1 << bit) != (0, TIR_TXRQ) {
            mailbox.words[word] ^= 1 << bit;
            return;
        }
        match mailbox.request {
            None => {
                mailbox.request = Some(Request { at: now, order, abort: None, on_wire: false });
                self.requests += 1;
            }
            Some(request) if !request.on_wire => mailbox.request = None,
            Some(_) => {}
        }
    }
}

impl Fifo {
    /// Inverts a bit of the oldest message.
    fn flip(&mut self, word: usize, bit: u32) {
        let Some(message) = self.messages.front_mut() else { return };
        let frame = &mut message.frame;
        match word {
            0 => *frame = identified(rir(frame) ^ 1 << bit, frame),
            1 if bit < 4 => frame.dlc ^= 1 << bit,
            1 => message.filter ^= 1 << (bit - 8),
            _ => frame.data[4 * (word - 2) + bit as usize / 8] ^= 1 << (bit % 8),
        }
    }
}

/// Returns a frame with another identifier word.
fn identified(rir: u32, frame: &WireFrame) -> WireFrame {
    let id =
        if rir & TIR_IDE == 0 { WireId::Standard((rir >> 21) as u16) } else { WireId::Extended(rir >> 3) };
    WireFrame { id, remote: rir & TIR_RTR != 0, ..*frame }
}

impl FilterBlock {
    fn flip(&mut self, offset: u32, bit: u32, now: Time) {
        let mask = 1 << bit;
        match offset {
            FMR => {
                self.write(FMR, self.fmr ^ mask, now);
            }
            FM1R => self.fm1r ^= mask,
            FS1R => self.fs1r ^= mask,
            FFA1R => self.ffa1r ^= mask,
            FA1R => self.fa1r ^= mask,
            _ => {
                let word = ((offset - BANKS) / 4) as usize;
                self.banks[word / 2][word % 2] ^= mask;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::PclkTick;
    use super::*;

    const NOW: Time = Time::from_us(10);

    fn pair() -> BxcanPair {
        let mut pair = BxcanPair::new(PclkTick::new(8, 1));
        let frame = WireFrame::standard(0x123, &[1, 2, 3]);
        pair.controllers[0].fifos[1].store(NOW, frame, 4, false);
        pair
    }

    /// Given a message and empty mailboxes, then each bit but those of requests reads inverted after an upset.
    #[test]
    fn each_bit_reads_inverted() {
        for (side, request) in [(Side::Can1, TX_MAILBOXES), (Side::Can2, TX_MAILBOXES + CONTROLLER_SIZE)] {
            for (offset, bits) in pair().stored(side) {
                for bit in (0..32).filter(|bit| bits >> bit & 1 == 1) {
                    let mut pair = pair();
                    let before = pair.read(offset).unwrap();
                    pair.flip(offset, bit, NOW);
                    let is_abort = offset & 0x3FF == TSR && bit % 8 == 7;
                    // An extended identifier has other bits in use.
                    let is_ide = offset == RX_MAILBOXES + 16;
                    let changed = before ^ pair.read(offset).unwrap();
                    assert!(changed == 1 << bit || is_abort || is_ide, "{offset:03X}h.{bit}: {changed:08X}h");
                    assert!(offset != request || bit != 0 || pair.read(offset).unwrap() & TIR_TXRQ != 0);
                }
            }
        }
    }

    #[test]
    fn empty_fifo_has_no_message() {
        let stored = pair().stored(Side::Can1);
        assert!(stored.iter().all(|(offset, _)| !(RX_MAILBOXES..RX_MAILBOXES + 16).contains(offset)));
        assert!(stored.iter().any(|(offset, _)| *offset == RX_MAILBOXES + 16));
    }

    #[test]
    fn filters_and_bit_timing_change_although_they_are_protected() {
        let mut pair = pair();
        pair.write(FMR, FMR_AT_RESET & !FMR_FINIT, NOW).unwrap();
        pair.flip(FS1R, 6, NOW);
        pair.flip(BTR, 0, NOW);
        assert_eq!((pair.read(FS1R), pair.read(BTR)), (Ok(1 << 6), Ok(BTR_AT_RESET | 1)));
    }
}
