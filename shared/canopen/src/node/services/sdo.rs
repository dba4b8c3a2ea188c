//! SDO servers of a node: requests, answers, and the end of a save that a client waits for.

use super::Services;
use super::second_sdo::{DEFAULT, select};
use crate::node::Device;
use crate::node::services::extension::Extension;
use crate::sdo::abort;
use crate::store::storage::{SaveEnd, Storage};
use crate::types::{Address, CobId, Frame, Instant, earliest};

/// First byte of a request that aborts a transfer.
const ABORT: u8 = 0x80;

/// Task of the SDO servers.
pub enum SdoStep<'a> {
    /// Handle a frame for one of them.
    Request(&'a Frame),
    /// End their transfers: the bus of their clients was left.
    BusChanged,
    /// Do what was due at this instant, or continue after one of their frames was sent.
    Poll(Instant),
}

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Returns whether this is a COB-ID of SDO requests.
    pub fn is_sdo(&self, id: CobId) -> bool {
        self.sdo_id.is(id) || self.server_of(id) != DEFAULT
    }

    /// Returns the COB-ID of SDO requests by the Node-ID.
    pub(crate) fn sdo_id(&self) -> CobId {
        CobId::sdo_request(self.id)
    }

    /// Takes a segment of a block download like nearly all: see `is_plain_segment` of the server. Returns whether the
    /// frame was one.
    #[inline] // row `instructions.block_download_segment`
    pub fn on_plain_segment(&mut self, frame: &Frame, now: Instant) -> bool {
        let server = self.server_mut(self.server_of(frame.id()));
        let segment = frame.full().filter(|payload| server.is_plain_segment(payload));
        if let Some(payload) = segment {
            server.no_sooner().take_plain_segment(payload, now);
        }
        segment.is_some()
    }

    /// Runs the SDO servers. Returns whether a frame was of use. Call it from one place, so that an image has its
    /// code once.
    #[inline(always)] // row `instructions.sdo_upload`: 8 more without it
    pub fn serve(&mut self, step: SdoStep, now: Instant, send: &mut impl FnMut(Frame)) -> bool {
        let (mut nth, last) = match step {
            SdoStep::Request(frame) => {
                let nth = self.server_of(frame.id());
                (nth, nth)
            }
            SdoStep::BusChanged | SdoStep::Poll(_) => (DEFAULT, Self::LAST_SERVER),
        };
        loop {
            let was_saving = self.share(nth);
            let is_used = self.serve_one(nth, &step, now, send);
            self.note_begun(nth, was_saving);
            if nth == last {
                return is_used;
            }
            nth += 1;
        }
    }

    /// Runs the SDO server with this number.
    #[inline(always)] // row `instructions.sdo_upload`: 14 more without it
    fn serve_one(&mut self, nth: usize, step: &SdoStep, now: Instant, send: &mut impl FnMut(Frame)) -> bool {
        let Some(response) = self.answer_id(nth) else { return false };
        let has_saved = self.saving_server() == nth;
        let Self { dictionary, server, second_sdo, .. } = self;
        let server = select(server, second_sdo.as_mut(), nth);
        dictionary.set_now(now);
        let mut send = move |payload| send(Frame::of(response, payload));
        let is_used = match *step {
            SdoStep::Request(frame) => {
                let Some(payload) = frame.full() else { return false };
                if payload[0] == ABORT && has_saved {
                    dictionary.storage_mut().drop_answer();
                }
                server.no_sooner().on_request(payload, now, dictionary, &mut send)
            }
            SdoStep::BusChanged => {
                server.no_sooner().on_bus_changed(now, dictionary, &mut send);
                true
            }
            SdoStep::Poll(until) => {
                server.no_sooner().poll(until, dictionary, &mut send);
                true
            }
        };
        server.settle(dictionary.wakes_mut());
        is_used
    }

    /// Returns the earlier one of `deadline` and the next slice of a running save, which a received frame does not run.
    pub fn with_save(&self, deadline: Option<Instant>) -> Option<Instant> {
        match self.dictionary.storage().deadline() {
            // Nearly always.
            None => deadline,
            slice => earliest(&[slice, deadline]),
        }
    }

    /// Continues a running save if that is due. At its end, returns the frame for the client that waits for it, and
    /// the object that was written if the save succeeded.
    pub fn advance_save(&mut self, now: Instant) -> Option<(Option<Frame>, Option<Address>)> {
        let SaveEnd { at, result, answer } = self.dictionary.advance_save(now)?;
        let answer = answer.map(|answer| result.map_or_else(|code| abort(at, code), |()| answer));
        let id = self.answer_id(self.saving_server());
        let frame = id.zip(answer).map(|(id, answer)| Frame::of(id, answer));
        Some((frame, result.is_ok().then_some(at)))
    }

    /// Returns whether an SDO server has a transfer.
    pub fn is_sdo_busy(&self) -> bool {
        self.server.is_busy() || self.is_second_sdo_busy()
    }

    /// Notes that a response of the default server was sent, or failed.
    pub fn on_sdo_sent(&mut self) {
        self.server.change(self.dictionary.wakes_mut()).on_sent();
    }

    /// Notes that frames were dropped: each may have been a response of either server.
    pub(crate) fn on_sdo_unsent(&mut self, frames: u16) {
        for _ in 0..frames {
            self.on_sdo_sent();
            self.on_second_sdo_sent();
        }
    }

    /// Ends a running save, and the transfers of the SDO servers without an abort.
    pub(super) fn end_transfers(&mut self) {
        self.storage_mut().give_up();
        self.server.no_sooner().reset(&mut self.dictionary);
        self.reset_second_sdo();
    }
}
