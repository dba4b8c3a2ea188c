//! Acceptance filters of the master.

use async_canopen::node::extend::Part;

use super::{Master, Turn};
use crate::link::port::Filter;
use crate::node::index::SYNC_COB_ID;
use crate::node::services::TimeServices;
use crate::node::{BusCommand, Filters, SpacecraftDevice};
use crate::redundancy::MasterBoards;
use crate::types::{Address, Bus, CobId, Duration, Instant, NodeId};

/// Retry interval for changed filters.
const FILTER_PAUSE: Duration = Duration::from_millis(1);
/// Function codes of COB-IDs.
pub(super) const FUNCTIONS: u16 = 16;

/// Filters that the buses have, without the last one.
#[derive(Debug)]
pub(super) struct SentFilters {
    filters: [Filter; FUNCTIONS as usize],
    /// Some may have changed.
    is_due: bool,
    /// Those that found no room wait for a short pause.
    not_before: Instant,
}

impl SentFilters {
    pub const fn new() -> Self {
        let filters = [Filter::exact(CobId::NMT); FUNCTIONS as usize];
        SentFilters { filters, is_due: false, not_before: Instant::ZERO }
    }

    /// Notes that COB-IDs of RPDOs changed.
    pub fn note_change(&mut self) {
        (self.is_due, self.not_before) = (true, Instant::ZERO);
    }
}

impl Part for SentFilters {
    fn earliest(&self) -> Option<Instant> {
        self.is_due.then_some(self.not_before)
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Returns the filters by function codes: heartbeats, SDO responses, EMCY, SYNCs of another master, PDOs, and
    /// requests to the SDO server of the master.
    pub fn filters(&self) -> Filters {
        (0..=FUNCTIONS).map(|number| self.filter(number)).collect()
    }

    /// Returns a filter: all COB-IDs of one function code, heartbeats again if none of these is needed, or the
    /// requests to this server.
    pub(super) fn filter(&self, number: u16) -> Filter {
        let is_of = |id: CobId| id.raw() >> 7 == number;
        let node = NodeId::MASTER;
        let raw = D::RAW_FRAMES.iter().copied();
        let sync = self.services.written_sync_id();
        let own = [CobId::heartbeat(node), CobId::sdo_response(node), CobId::emcy(node), sync];
        let mut wanted = own
            .into_iter()
            .chain(self.of_other_master())
            .chain(self.services.rpdo_ids())
            .chain(raw)
            .filter(|id| is_of(*id));
        match wanted.next() {
            _ if number == FUNCTIONS => Filter::exact(CobId::sdo_request(node)),
            Some(id) => Filter::function(id),
            None => Filter::function(CobId::heartbeat(node)),
        }
    }

    /// Looks for flipped bits, a little with each heartbeat: in its Node-ID and in COB-IDs (ECSS 6.10d, k).
    pub(super) fn scrub(&mut self, turn: &Turn) {
        self.services.compare_node_ids(&mut { NodeId::MASTER });
        if self.services.compare_cob_ids(turn.now) {
            self.follow(Address::new(SYNC_COB_ID, 0), turn.now);
            // A bus may have taken a filter from the object that was wrong. None that is wanted: each is sent again.
            let sent = self.filters_mut();
            sent.filters = [Filter::ALL; FUNCTIONS as usize];
            sent.note_change();
        }
    }

    /// Returns the COB-IDs of another master that this one takes: claims, and the spacecraft time.
    fn of_other_master(&self) -> impl Iterator<Item = CobId> {
        let pair = self.redundancy.standby().map(|standby| *standby.pair());
        let ids = pair.map(|pair| pair.both_claims());
        let time = pair.and_then(|_| self.services.time_pdo()).map(|pdo| pdo.id);
        ids.into_iter().flatten().chain(time)
    }

    /// At power-on: the buses have the filters of the profile.
    pub(super) fn note_sent_filters(&mut self) {
        self.filters.no_sooner().filters = core::array::from_fn(|number| self.filter(number as u16));
    }

    /// Sends both buses the filters that have changed, as a standby, too.
    pub(super) fn run_filters(&mut self, turn: &mut Turn) {
        if self.filters.is_due {
            let is_due = !self.set_filters(turn);
            let filters = self.filters.no_sooner();
            (filters.is_due, filters.not_before) = (is_due, turn.now + FILTER_PAUSE);
        }
    }

    /// Sends changed filters, as many as fit into the outbox beside frames. Returns whether that is all.
    fn set_filters(&mut self, turn: &mut Turn) -> bool {
        for number in 0..FUNCTIONS {
            let filter = self.filter(number);
            let Some(sent) = self.filters.no_sooner().filters.get_mut(usize::from(number)) else { continue };
            if *sent != filter {
                if !turn.out.has_room() {
                    return false;
                }
                *sent = filter;
                let command = BusCommand::Filter { number: number as u8, filter };
                Bus::ALL.into_iter().for_each(|bus| turn.out.command(bus, command));
            }
        }
        true
    }
}
