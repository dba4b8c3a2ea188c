//! Responses of a server, and frames that do not belong to the transfer.

use super::{Client, Error, Mode, Protocol, State};
use crate::sdo::wire;
use crate::sdo::wire::{Payload, Response};
use crate::types::{AbortCode, Address, Instant};

impl Client {
    /// Handles a response. Returns whether it was of use. Frames without a transfer, segments out of order,
    /// repeated frames and late answers of other transfers are ignored.
    pub fn on_response(&mut self, payload: &Payload, now: Instant, send: &mut impl FnMut(Payload)) -> bool {
        let [command, data @ ..] = payload;
        if !self.is_on_the_way() || self.strays.claim(*command, now) {
            return false;
        }
        let used = match &self.state {
            State::BlockUpload { .. } if *command != wire::ABORT => {
                self.on_sub_block(*command, data, now, send)
            }
            State::BlockUploadEnd { receiver, .. }
                if receiver.is_repeat(*command)
                    && self.staging.ends_with(data)
                    && !wire::is_block_end(*command) =>
            {
                Ok(false)
            }
            _ => self.on_answer(payload, now, send),
        };
        match used {
            Ok(was_used) => {
                self.drive(now, send);
                was_used
            }
            Err(error) => {
                self.fail(error, send);
                true
            }
        }
    }

    /// Everything but segments of sub-blocks.
    fn on_answer(
        &mut self,
        payload: &Payload,
        now: Instant,
        send: &mut impl FnMut(Payload),
    ) -> Result<bool, Error> {
        let response = Response::parse(payload);
        let is_first = matches!(self.state, State::Initiated(_));
        let used = match (&mut self.state, response) {
            (_, Response::Abort(at, code)) => return Ok(self.on_abort(at, code)),
            // Late: of a transfer before this one. The first answer of each transfer names its object.
            _ if (is_first || response.is_initiate()) && wire::address(payload) != self.at => {
                return Ok(false);
            }
            (State::Initiated(Protocol::Download), Response::Download) => {
                self.on_download();
                Ok(())
            }
            (State::Download { toggle, asked: true }, Response::DownloadSegment { toggle: answered }) => {
                let toggle = *toggle;
                self.on_download_segment(toggle, answered)
            }
            (State::Initiated(Protocol::BlockDownload), Response::BlockDownload { crc, block_size }) => {
                self.on_block_download(crc, block_size)
            }
            (State::BlockDownload { sender, .. }, Response::BlockDownload { .. }) if sender.is_first() => {
                return Ok(false);
            }
            (State::BlockDownload { .. }, Response::BlockDownloadAck { ackseq, block_size }) => {
                return self.on_ack(ackseq, block_size, now, send);
            }
            (State::BlockDownloadEnd, Response::BlockDownloadAck { .. }) => return Ok(false),
            (State::BlockDownloadEnd, Response::BlockDownloadEnd) => {
                self.done(Ok(self.size as usize));
                Ok(())
            }
            (State::Initiated(Protocol::Upload | Protocol::BlockUpload), Response::Upload(content)) => {
                self.on_upload(content)
            }
            (State::Upload { toggle, asked: true }, Response::UploadSegment(segment)) => {
                let toggle = *toggle;
                self.on_upload_segment(toggle, &segment)
            }
            (State::Initiated(Protocol::BlockUpload), Response::BlockUpload { crc, size }) => {
                self.on_block_upload(crc, size, now, send)
            }
            (State::BlockUploadEnd { crc, .. }, Response::BlockUploadEnd { unused, crc: sum }) => {
                let sum = crc.then_some(sum);
                self.on_block_upload_end(usize::from(unused), sum, send)
            }
            _ => Err(Error::Protocol(AbortCode::CommandSpecifier)),
        };
        used.map(|()| true)
    }

    /// The server aborts. Whether it means this transfer: the abort of an earlier one may be late. A server that
    /// does not know what it aborts says 0000h.
    fn on_abort(&mut self, at: Address, code: u32) -> bool {
        if at != self.at && at != Address::new(0, 0) {
            return false;
        }
        let known = AbortCode::from_code(code);
        if self.mode == Mode::Auto && known == Some(AbortCode::CommandSpecifier) {
            // A server that knows no blocks (CiA 301 7.2.4.2.8: optional).
            let protocol = match self.state {
                State::Initiated(Protocol::BlockDownload) => Some(Protocol::Download),
                State::Initiated(Protocol::BlockUpload) => Some(Protocol::Upload),
                _ => None,
            };
            if let Some(protocol) = protocol {
                self.state = State::Initiate(protocol);
                return true;
            }
        }
        self.done(Err(known.map_or(Error::UnknownAbort(code), Error::Abort)));
        true
    }
}
