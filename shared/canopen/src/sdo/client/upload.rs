//! Reading from a server: expedited, in segments, in blocks.

use super::staging::Staging;
use super::{Client, Error, State};
use crate::sdo::block::{MOST, Receiver, SegmentOutcome};
use crate::sdo::wire::{Content, Payload, Segment};
use crate::sdo::{block, wire};
use crate::types::{AbortCode, Instant};

/// Bytes of a segment.
pub(super) const SEGMENT: usize = block::SEGMENT as usize;

/// Returns the number of segments for which there is room.
pub(super) fn block_size(staging: &Staging) -> u8 {
    (staging.room() / SEGMENT).min(usize::from(MOST)) as u8
}

impl Client {
    pub(super) fn on_upload(&mut self, content: Content) -> Result<(), Error> {
        match content {
            Content::Expedited(data, len) => self.on_expedited(data.get(..usize::from(len)).unwrap_or(&data)),
            Content::Unsized(data) => self.on_expedited(data.get(..self.size as usize).unwrap_or(&data)),
            Content::Segmented(size) => {
                self.on_size(size)?;
                self.state = State::Upload { toggle: false, asked: false };
            }
        }
        Ok(())
    }

    fn on_expedited(&mut self, value: &[u8]) {
        let outcome = if value.len() > self.size as usize {
            Err(Error::TooLarge)
        } else {
            (self.size, self.is_size_told) = (value.len() as u32, true);
            Ok(self.staging.push(value))
        };
        self.done(outcome);
    }

    fn on_size(&mut self, told: Option<u32>) -> Result<(), Error> {
        if let Some(size) = told {
            if size > self.size {
                return Err(Error::TooLarge);
            }
            (self.size, self.is_size_told) = (size, true);
        }
        Ok(())
    }

    /// So many bytes more. An error if that is too much, or too little at the end.
    fn on_bytes(&mut self, count: usize, is_end: bool) -> Result<(), Error> {
        self.moved = self.moved.saturating_add(count as u32);
        if self.moved > self.size {
            Err(if self.is_size_told { Error::Protocol(AbortCode::TooLong) } else { Error::TooLarge })
        } else if is_end && self.is_size_told && self.moved < self.size {
            Err(Error::Protocol(AbortCode::TooShort))
        } else {
            Ok(())
        }
    }

    pub(super) fn on_upload_segment(&mut self, toggle: bool, segment: &Segment) -> Result<(), Error> {
        if segment.toggle != toggle {
            return Err(Error::Protocol(AbortCode::Toggle));
        }
        if segment.is_vain() {
            return Err(Error::Protocol(AbortCode::TooShort));
        }
        self.on_bytes(segment.bytes().len(), segment.last)?;
        self.staging.push(segment.bytes());
        if segment.last {
            self.done(Ok(self.moved as usize));
        } else {
            self.state = State::Upload { toggle: !toggle, asked: false };
        }
        Ok(())
    }

    pub(super) fn on_block_upload(
        &mut self,
        crc: bool,
        size: Option<u32>,
        now: Instant,
        send: &mut impl FnMut(Payload),
    ) -> Result<(), Error> {
        self.on_size(size)?;
        self.state =
            State::BlockUpload { receiver: Receiver::new(block_size(&self.staging)), crc, due: false };
        self.deadline = now + self.timeout;
        send(wire::block_upload_start());
        Ok(())
    }

    /// A segment of a sub-block. Whether it counts.
    pub(super) fn on_sub_block(
        &mut self,
        command: u8,
        data: &[u8; SEGMENT],
        now: Instant,
        send: &mut impl FnMut(Payload),
    ) -> Result<bool, Error> {
        let pause = self.pause();
        let State::BlockUpload { receiver, crc, due } = &mut self.state else { return Ok(false) };
        if *due {
            // The sub-block has ended; there was no room to ask for the next.
            return Ok(false);
        }
        let heard = receiver.on_segment(command);
        *due = matches!(heard, SegmentOutcome::TakenAtEnd | SegmentOutcome::Ends);
        if *due {
            // The acknowledgement waits for room, as long as the application takes anything.
            self.deadline = now + self.timeout;
        } else if receiver.is_heard() {
            self.deadline = now + pause;
        }
        match heard {
            SegmentOutcome::Taken | SegmentOutcome::TakenAtEnd => {
                if *crc {
                    self.crc.update(data);
                }
                self.staging.push(data);
                self.on_bytes(data.len(), false)?;
            }
            SegmentOutcome::TakenLast => {
                // Nothing more is to come, so that room does not matter.
                let ackseq = receiver.acknowledge(MOST).map_err(Error::Protocol)?;
                send(wire::block_ack(ackseq, MOST));
                self.state = State::BlockUploadEnd { receiver: receiver.clone(), crc: *crc };
                self.staging.push(data);
                self.deadline = now + self.timeout;
            }
            SegmentOutcome::Ends | SegmentOutcome::Ignored => return Ok(false),
        }
        Ok(true)
    }

    pub(super) fn on_block_upload_end(
        &mut self,
        unused: usize,
        crc: Option<u16>,
        send: &mut impl FnMut(Payload),
    ) -> Result<(), Error> {
        let count = SEGMENT.saturating_sub(unused);
        let mut data = [0; SEGMENT];
        self.staging.peek(self.staging.len().saturating_sub(SEGMENT), &mut data);
        self.staging.truncate(unused);
        self.on_bytes(count, true)?;
        self.crc.update(data.get(..count).unwrap_or_default());
        if crc.is_some_and(|crc| crc != self.crc.value()) {
            return Err(Error::Protocol(AbortCode::Crc));
        }
        send(wire::block_end_answer());
        self.done(Ok(self.moved as usize));
        Ok(())
    }

    /// Bytes that may be pulled. The number of bytes of the last segment that count is known at the end.
    pub(super) fn ready(&self) -> usize {
        match self.state {
            _ if self.is_downloading() => 0,
            State::BlockUploadEnd { .. } => self.staging.len().saturating_sub(SEGMENT),
            _ => self.staging.len(),
        }
    }
}
