//! Sub-blocks of block downloads and block uploads.

use super::{BLOCK_SIZE, Server, State, Turn};
use crate::od::ObjectAccess;
use crate::sdo::block::{Ack, SegmentOutcome, unused};
use crate::sdo::crc::Crc;
use crate::sdo::wire;
use crate::sdo::wire::Payload;
use crate::types::{AbortCode, Instant};

impl Server {
    /// Returns whether a frame is a segment like nearly all: the next one, neither first nor last of its sub-block, and
    /// the buffer has room for it. Then [take it](Server::take_plain_segment). If not, call [`Server::on_request`].
    #[inline]
    pub(crate) fn is_plain_segment(&self, payload: &Payload) -> bool {
        let [command, ..] = payload;
        matches!(&self.state, State::BlockDownload { receiver, refused: None } if receiver.is_plain(*command))
            && self.value.has_room()
    }

    /// Takes a segment that is [plain](Server::is_plain_segment). The deadline only becomes later.
    #[inline]
    pub(crate) fn take_plain_segment(&mut self, payload: &Payload, now: Instant) {
        let [_, data @ ..] = payload;
        self.deadline = now + self.pause();
        if let State::BlockDownload { receiver, .. } = &mut self.state {
            receiver.take_plain();
        }
        self.value.push_full(data);
    }

    /// A frame in a sub-block of a download: a segment, whatever its first byte, or an abort.
    #[inline(never)]
    pub(super) fn on_sub_block(
        &mut self,
        payload: &Payload,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> bool {
        let [command, data @ ..] = payload;
        let deadline = turn.now + self.pause();
        let State::BlockDownload { receiver, refused } = &mut self.state else { return false };
        let heard = receiver.on_segment(*command);
        if *command == wire::ABORT {
            self.value.close(turn.objects);
            self.state = State::Idle;
            return true;
        }
        if receiver.is_heard() {
            self.deadline = deadline;
        }
        let pushed = match heard {
            _ if refused.is_some() => Ok(()),
            SegmentOutcome::TakenLast => self.value.push_last(data, turn.objects),
            SegmentOutcome::Taken | SegmentOutcome::TakenAtEnd => {
                self.value.push(data, data.len(), turn.objects)
            }
            SegmentOutcome::Ends | SegmentOutcome::Ignored => Ok(()),
        };
        if let Err(code) = pushed {
            self.refuse(code, turn.objects);
        }
        if matches!(heard, SegmentOutcome::TakenLast | SegmentOutcome::TakenAtEnd | SegmentOutcome::Ends) {
            self.end_sub_block(heard == SegmentOutcome::TakenLast, turn);
        }
        !matches!(heard, SegmentOutcome::Ends | SegmentOutcome::Ignored)
    }

    /// The download fails. The client gets the abort at the end of the sub-block.
    fn refuse(&mut self, code: AbortCode, objects: &mut impl ObjectAccess) {
        self.value.close(objects);
        if let State::BlockDownload { refused, .. } = &mut self.state {
            *refused = Some(code);
        }
    }

    pub(super) fn is_sub_block_heard(&self) -> bool {
        matches!(&self.state, State::BlockDownload { receiver, .. } if receiver.is_heard())
    }

    /// Acknowledges a sub-block, or aborts a download that is refused.
    pub(super) fn end_sub_block(
        &mut self,
        is_complete: bool,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) {
        let State::BlockDownload { receiver, refused } = &mut self.state else { return };
        match refused.map_or_else(|| receiver.acknowledge(BLOCK_SIZE), Err) {
            Ok(ackseq) => turn.send(wire::block_ack(ackseq, BLOCK_SIZE)),
            Err(code) => {
                // Nothing of the sub-block is left on the way.
                self.state = State::Idle;
                self.value.close(turn.objects);
                turn.abort(self.value.at, code);
                return;
            }
        }
        if is_complete {
            self.state = State::BlockDownloadEnd(receiver.clone());
        }
        self.deadline = turn.now + self.timeout;
    }

    /// Sends what the bus has room for of a sub-block of an upload.
    pub(super) fn send_sub_block(
        &mut self,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> Result<(), AbortCode> {
        let State::BlockUpload(sender) = &mut self.state else { return Ok(()) };
        while let Some(next) = sender.next(self.value.size()) {
            let (data, _) = self.value.segment(next.offset, turn.objects)?;
            sender.on_send();
            turn.send(wire::sub_block_segment(next.seqno, next.last, data));
            self.deadline = turn.now + self.timeout;
        }
        Ok(())
    }

    /// The client ends a sub-block of an upload. Whether that is news.
    pub(super) fn on_ack(
        &mut self,
        ackseq: u8,
        block_size: u8,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> Result<bool, AbortCode> {
        let State::BlockUpload(sender) = &mut self.state else { return Ok(false) };
        match sender.on_ack(ackseq, block_size, self.value.size())? {
            Ack::Repeat => return Ok(false),
            Ack::More(_) => self.send_sub_block(turn)?,
            Ack::Complete => {
                self.state = State::BlockUploadEnd;
                let crc = self.value.crc.map_or(0, Crc::value);
                turn.send(wire::block_end(unused(self.value.size()), crc));
            }
        }
        Ok(true)
    }
}
