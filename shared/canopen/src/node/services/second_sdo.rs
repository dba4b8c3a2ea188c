//! Second SDO server of a device that declares one: its channel, its transfers, and its part in saves. A device without it keeps nothing
//! and has no code for it.

#[cfg(test)]
mod tests;

use super::Services;
use crate::node::Device;
use crate::node::services::extension::Extension;
use crate::node::turn::Timed;
use crate::od::CobIdEntry;
use crate::od::copies::{Copied, Copies};
use crate::sdo::sharing::{Begun, Shared};
use crate::sdo::{SdoServers, Server};
use crate::types::{Address, CobId, Duration, Instant, Sealed};

/// Number of the default server among those of a device.
pub const DEFAULT: usize = 0;
/// Number of the second server.
const SECOND: usize = 1;

/// Second SDO server of a node.
#[derive(Debug)]
pub struct SecondServer {
    /// COB-IDs of requests and of answers, each while its entry is valid.
    ids: [Sealed; 2],
    /// Second copies of both entries.
    copies: [Copied; 2],
    server: Timed<Server>,
    /// `true`: the save that runs was requested by its client, `false`: by that of the default server.
    is_saving: bool,
    /// Transfers that both servers began last, by the number of the server.
    begun: [Option<Begun>; 2],
}

/// Returns the server with this number. `second` is empty without a second server.
#[inline] // rows `instructions.sdo_upload`, `instructions.sdo_download`
pub fn select<'a>(
    default: &'a mut Timed<Server>,
    second: &'a mut [SecondServer],
    nth: usize,
) -> &'a mut Timed<Server> {
    match second.first_mut() {
        Some(second) if nth == SECOND => &mut second.server,
        _ => default,
    }
}

impl SecondServer {
    /// Makes a server whose channel is not valid. A transfer without progress for `timeout` is aborted.
    pub fn new(timeout: Duration) -> Self {
        SecondServer {
            ids: [Sealed::NONE; 2],
            copies: [Copied::NONE; 2],
            server: Timed::new(Server::new(timeout)),
            is_saving: false,
            begun: [None; 2],
        }
    }

    /// Returns the COB-IDs of requests and of answers if both are valid.
    fn channel(&self) -> Option<[CobId; 2]> {
        let [request, answer] = self.ids;
        request.id().zip(answer.id()).map(<[CobId; 2]>::from)
    }

    fn answer(&self) -> Option<CobId> {
        self.channel().map(|[_, answer]| answer)
    }

    /// Returns whether this is the COB-ID of its requests, and its channel is valid.
    fn takes(&self, id: CobId) -> bool {
        let [request, _] = self.ids;
        request.is(id) && self.channel().is_some()
    }

    /// Returns the copies of the entry with this number: 0 for requests, 1 for answers.
    pub fn copies<'a>(&'a mut self, nth: usize, objects: [&'a mut u32; 2]) -> Option<Copies<'a>> {
        let object = objects.into_iter().nth(nth)?;
        let (second, in_use) = (self.copies.get_mut(nth)?, *self.ids.get(nth)?);
        Some(Copies::new(object, second, in_use))
    }
}

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Number of the last SDO server.
    pub(super) const LAST_SERVER: usize = if D::Sdo::SECOND_SERVER.is_some() { SECOND } else { DEFAULT };

    fn second(&self) -> Option<&SecondServer> {
        self.second_sdo.as_ref().first()
    }

    fn second_mut(&mut self) -> Option<&mut SecondServer> {
        self.second_sdo.as_mut().first_mut()
    }

    /// Returns the number of the SDO server that takes requests with this COB-ID. It is the default one for all others.
    #[inline] // rows `instructions.sdo_upload`, `instructions.sdo_download`
    pub fn server_of(&self, id: CobId) -> usize {
        if self.second().is_some_and(|second| second.takes(id)) { SECOND } else { DEFAULT }
    }

    /// Returns the SDO server with this number.
    #[inline] // rows `instructions.sdo_upload`, `instructions.sdo_download`
    pub(super) fn server_mut(&mut self, nth: usize) -> &mut Timed<Server> {
        select(&mut self.server, self.second_sdo.as_mut(), nth)
    }

    /// Returns the COB-ID of the answers of a server. `None`: it has none.
    #[inline(always)] // row `instructions.sdo_upload`
    pub(super) fn answer_id(&self, nth: usize) -> Option<CobId> {
        match self.second() {
            Some(second) if nth == SECOND => second.answer(),
            _ => self.sdo_id.id().map(CobId::sdo_answer),
        }
    }

    /// Returns the COB-ID of the requests of the second server as it was just written, if its channel is valid.
    pub(crate) fn second_sdo_id(&self) -> Option<CobId> {
        let [request, answer] =
            self.objects().sdo.cob_ids()?.map(|entry| CobIdEntry::from_raw(entry).cob_id());
        answer.and(request)
    }

    /// Returns whether this is the COB-ID of the answers of the second server.
    #[inline] // rows `instructions.sdo_upload`, `instructions.sdo_download`
    pub fn is_second_sdo_answer(&self, id: CobId) -> bool {
        self.second().is_some_and(|second| second.answer() == Some(id))
    }

    /// Notes that an answer of the second server was sent, or failed.
    pub(crate) fn on_second_sdo_sent(&mut self) {
        let Self { second_sdo, dictionary, .. } = self;
        if let Some(second) = second_sdo.as_mut().first_mut() {
            second.server.change(dictionary.wakes_mut()).on_sent();
        }
    }

    /// Returns whether the second server has a transfer and a channel.
    pub(super) fn is_second_sdo_busy(&self) -> bool {
        self.second().is_some_and(|second| second.server.is_busy() && second.channel().is_some())
    }

    /// Returns when the second server is due. It is not while a bit of its COB-IDs is wrong.
    #[inline] // rows `instructions.sdo_upload`, `instructions.sdo_download`
    pub(super) fn second_sdo_deadline(&self) -> Option<Instant> {
        let second = self.second()?;
        second.channel().and(second.server.deadline())
    }

    /// Shows the dictionary what the other server transfers, before a call of the server with this number. Returns
    /// whether a save is running.
    #[inline] // rows `instructions.sdo_upload`, `instructions.sdo_download`
    pub(super) fn share(&mut self, nth: usize) -> bool {
        let Self { dictionary, server, second_sdo, .. } = self;
        let (Some(second), Some(shared)) = (second_sdo.as_ref().first(), dictionary.shared_mut()) else {
            return false;
        };
        let [default, own] = second.begun;
        let (other, begun) = if nth == SECOND { (&*server, default) } else { (&second.server, own) };
        *shared = Shared::of(begun.filter(|_| other.is_busy()));
        dictionary.is_saving()
    }

    /// Notes what the server with this number began in its call. `was_saving`: a save was running before.
    #[inline] // rows `instructions.sdo_upload`, `instructions.sdo_download`
    pub(super) fn note_begun(&mut self, nth: usize, was_saving: bool) {
        let Self { dictionary, second_sdo, .. } = self;
        let (Some(second), Some(shared)) = (second_sdo.as_mut().first_mut(), dictionary.shared_mut()) else {
            return;
        };
        let begun = core::mem::take(shared).begun();
        if let (Some(last), Some(begun)) = (second.begun.get_mut(nth), begun) {
            *last = Some(begun);
        }
        if !was_saving && dictionary.is_saving() {
            second.is_saving = nth == SECOND;
        }
    }

    /// Returns the number of the server whose client asked for the running save.
    #[inline] // rows `instructions.sdo_upload`, `instructions.sdo_download`
    pub(super) fn saving_server(&self) -> usize {
        if self.second().is_some_and(|second| second.is_saving) { SECOND } else { DEFAULT }
    }

    /// Ends the transfer of the second server without an abort.
    pub(super) fn reset_second_sdo(&mut self) {
        let Self { dictionary, second_sdo, .. } = self;
        if let Some(second) = second_sdo.as_mut().first_mut() {
            second.server.no_sooner().reset(dictionary);
        }
    }

    /// Takes the COB-IDs of the second server from its object. Returns whether one has changed.
    pub(super) fn take_second_sdo(&mut self) -> bool {
        let Some(entries) = self.objects().sdo.cob_ids() else { return false };
        let ids = entries.map(|entry| Sealed::maybe(CobIdEntry::from_raw(entry).cob_id()));
        self.second_mut().is_some_and(|second| core::mem::replace(&mut second.ids, ids) != ids)
    }

    /// Follows a write to the object of the second server: a new COB-ID ends its transfer.
    pub(super) fn follow_second_sdo(&mut self, at: Address) {
        if D::Sdo::SECOND_SERVER == Some(at.index) && self.take_second_sdo() {
            self.reset_second_sdo();
        }
    }
}
