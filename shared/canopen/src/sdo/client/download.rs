//! Writing to a server: expedited, in segments, in blocks.

use super::staging::Staging;
use super::{Client, Error, State};
use crate::sdo::block::{Ack, Sender};
use crate::sdo::wire::{Payload, Segment};
use crate::sdo::{block, wire};
use crate::types::{AbortCode, Address, Instant};

/// Bytes of a segment.
const SEGMENT: u32 = block::SEGMENT as u32;

/// The request of a download without blocks; none while a value that it carries itself is not there yet.
pub(super) fn request(staging: &Staging, at: Address, size: u32) -> Option<Payload> {
    let mut data = [0; 4];
    match data.get_mut(..size as usize) {
        Some(value) if size > 0 => {
            let is_there = staging.peek(0, value) == value.len();
            is_there.then(|| wire::download_expedited(at, data, size as u8))
        }
        _ => Some(wire::download(at, size)),
    }
}

/// The next segment, when its bytes are there; `rest` bytes are not acknowledged.
pub(super) fn segment(staging: &Staging, toggle: bool, rest: u32) -> Option<Payload> {
    let (data, len) = bytes(staging, 0, rest)?;
    Some(Segment { toggle, last: rest <= SEGMENT, len, data }.payload())
}

/// The bytes of a segment, from the `at`th of those staged on, and how many count.
fn bytes(staging: &Staging, at: u32, rest: u32) -> Option<([u8; 7], u8)> {
    let mut data = [0; SEGMENT as usize];
    let value = data.get_mut(..rest.min(SEGMENT) as usize)?;
    let len = value.len();
    (staging.peek(at as usize, value) == len).then_some((data, len as u8))
}

impl Client {
    pub(super) fn on_download(&mut self) {
        if (1..=4).contains(&self.size) {
            self.done(Ok(self.size as usize));
        } else {
            self.state = State::Download { toggle: false, asked: false };
        }
    }

    pub(super) fn on_download_segment(&mut self, toggle: bool, answered: bool) -> Result<(), Error> {
        if answered != toggle {
            return Err(Error::Protocol(AbortCode::Toggle));
        }
        self.acknowledge(self.moved.saturating_add(SEGMENT).min(self.size));
        if self.moved == self.size {
            self.done(Ok(self.size as usize));
        } else {
            self.state = State::Download { toggle: !toggle, asked: false };
        }
        Ok(())
    }

    pub(super) fn on_block_download(&mut self, crc: bool, block_size: u8) -> Result<(), Error> {
        block::check_size(block_size).map_err(Error::Protocol)?;
        self.state = State::BlockDownload { sender: Sender::new(block_size), crc };
        Ok(())
    }

    /// Sends the segments of a sub-block for which the bus has room and whose bytes are available.
    pub(super) fn send_sub_block(&mut self, now: Instant, send: &mut impl FnMut(Payload)) {
        let State::BlockDownload { sender, .. } = &mut self.state else { return };
        while let Some(next) = sender.next(self.size) {
            let at = next.offset.saturating_sub(self.moved);
            let rest = self.size.saturating_sub(next.offset);
            let Some((data, _)) = bytes(&self.staging, at, rest) else { return };
            sender.on_send();
            send(wire::sub_block_segment(next.seqno, next.last, data));
            self.deadline = now + self.timeout;
        }
    }

    pub(super) fn on_ack(
        &mut self,
        ackseq: u8,
        block_size: u8,
        now: Instant,
        send: &mut impl FnMut(Payload),
    ) -> Result<bool, Error> {
        let State::BlockDownload { sender, crc } = &mut self.state else { return Ok(false) };
        match sender.on_ack(ackseq, block_size, self.size).map_err(Error::Protocol)? {
            Ack::Repeat => return Ok(false),
            Ack::More(offset) => self.acknowledge(offset),
            Ack::Complete => {
                let crc = if *crc { self.crc.value() } else { 0 };
                self.acknowledge(self.size);
                self.state = State::BlockDownloadEnd;
                send(wire::block_end(block::unused(self.size), crc));
            }
        }
        self.deadline = now + self.timeout;
        Ok(true)
    }

    /// The server has all bytes up to this one.
    fn acknowledge(&mut self, offset: u32) {
        self.staging.consume(offset.saturating_sub(self.moved) as usize);
        self.moved = offset;
    }
}
