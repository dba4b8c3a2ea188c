//! Requests that begin a transfer. An expedited request completes it at once.

use super::{BLOCK_SIZE, Server, State, Turn};
use crate::od::{ObjectAccess, Transfer};
use crate::sdo::block::{Receiver, Sender, check_size};
use crate::sdo::wire;
use crate::sdo::wire::{Content, Payload, Request};
use crate::types::{AbortCode, Address, Instant};

/// Most bytes of an expedited transfer.
const EXPEDITED: usize = 4;

impl Server {
    /// A request without a transfer.
    pub(super) fn initiate(
        &mut self,
        payload: &Payload,
        request: Request,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> bool {
        let mut at = wire::address(payload);
        let begun = match request {
            Request::Download(content) => self.download(at, content, turn),
            Request::Upload => self.upload(at, turn),
            Request::BlockDownload { crc, size } => self.block_download(at, crc, size, turn),
            Request::BlockUpload { crc, block_size, threshold } => {
                self.block_upload(at, crc, block_size, threshold, turn)
            }
            Request::Abort => return false,
            _ => {
                at = Address::new(0, 0);
                Err(AbortCode::CommandSpecifier)
            }
        };
        if let Err(code) = begun {
            self.value.close(turn.objects);
            turn.abort(at, code);
        }
        true
    }

    #[inline(never)] // smaller than in its callers
    fn download<O: ObjectAccess>(
        &mut self,
        at: Address,
        content: Content,
        turn: &mut Turn<O, impl FnMut(Payload)>,
    ) -> Result<(), AbortCode> {
        let (data, told) = match content {
            Content::Expedited(data, len) => (data, Some(usize::from(len))),
            Content::Unsized(data) => (data, None),
            Content::Segmented(size) => {
                self.value.open_download(at, size, false, turn.objects)?;
                self.begin(State::Download { toggle: false }, turn.now);
                turn.send(wire::download_response(at));
                return Ok(());
            }
        };
        let transfer = turn.objects.download(at, told)?;
        let (Transfer::Whole(most) | Transfer::Stream(most)) = transfer;
        let value = data.get(..told.unwrap_or(most)).unwrap_or(&data);
        let is_too_long = value.len() > most;
        let is_stream = O::TAKES_PARTS && matches!(transfer, Transfer::Stream(_));
        if is_too_long {
            if is_stream {
                turn.objects.cancel(at);
            }
            return Err(AbortCode::TooLong);
        }
        if is_stream {
            turn.objects.write_part(at, 0, value)?;
            turn.objects.finish(at, value.len())?;
        } else {
            turn.objects.write(at, value)?;
        }
        turn.send(wire::download_response(at));
        Ok(())
    }

    fn upload(
        &mut self,
        at: Address,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> Result<(), AbortCode> {
        let transfer = turn.objects.upload(at)?;
        self.answer_upload(at, transfer, turn)
    }

    #[inline(never)]
    fn answer_upload(
        &mut self,
        at: Address,
        transfer: Transfer,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> Result<(), AbortCode> {
        let (Transfer::Whole(size) | Transfer::Stream(size)) = transfer;
        let mut data = [0; EXPEDITED];
        match data.get_mut(..size) {
            Some(value) if size > 0 => {
                if turn.objects.read(at, 0, value)? != size {
                    return Err(AbortCode::CannotTransfer);
                }
                turn.send(wire::upload_expedited_response(at, data, size as u8));
            }
            _ => {
                self.value.open_upload(at, transfer, false, turn.objects)?;
                self.begin(State::Upload { toggle: false, offset: 0 }, turn.now);
                turn.send(wire::upload_response(at, self.value.size()));
            }
        }
        Ok(())
    }

    #[inline(never)]
    fn block_download(
        &mut self,
        at: Address,
        crc: bool,
        size: Option<u32>,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> Result<(), AbortCode> {
        self.value.open_download(at, size, crc, turn.objects)?;
        self.begin(State::BlockDownload { receiver: Receiver::new(BLOCK_SIZE), refused: None }, turn.now);
        turn.send(wire::block_download_response(at, crc, BLOCK_SIZE));
        Ok(())
    }

    #[inline(never)]
    fn block_upload(
        &mut self,
        at: Address,
        crc: bool,
        block_size: u8,
        threshold: u8,
        turn: &mut Turn<impl ObjectAccess, impl FnMut(Payload)>,
    ) -> Result<(), AbortCode> {
        check_size(block_size)?;
        let transfer = turn.objects.upload(at)?;
        let (Transfer::Whole(size) | Transfer::Stream(size)) = transfer;
        if size <= usize::from(threshold) && threshold > 0 {
            return self.answer_upload(at, transfer, turn);
        }
        self.value.open_upload(at, transfer, crc, turn.objects)?;
        self.begin(State::BlockUploadStart(Sender::new(block_size)), turn.now);
        turn.send(wire::block_upload_response(at, crc, self.value.size()));
        Ok(())
    }

    fn begin(&mut self, state: State, now: Instant) {
        self.state = state;
        self.deadline = now + self.timeout;
    }
}

/// The response to an expedited transfer of a number. `None` for all other requests, and for what is no number.
#[inline(always)] // called from one place
pub(super) fn number(
    payload: &Payload,
    objects: &mut impl ObjectAccess,
) -> Result<Option<Payload>, AbortCode> {
    let at = wire::address(payload);
    if wire::is_upload(payload) {
        let value = objects.fetch(at)?;
        return Ok(value.map(|(bytes, count)| wire::upload_expedited_response(at, bytes, count)));
    }
    match wire::expedited_download(payload) {
        Some((bytes, count)) if objects.store(at, bytes, count)? => Ok(Some(wire::download_response(at))),
        _ => Ok(None),
    }
}
