//! Acceptance filters of a slave, and the set of the COB-IDs that it takes.

use super::SlaveCore;
use crate::link::port::Filter;
use crate::node::services::Extension;
use crate::node::turn::Turn;
use crate::node::{Device, Filters, MAX_FILTERS};
use crate::pdo::PdoSlots;
use crate::sdo::SdoServers;
use crate::types::{Bus, CobId, NodeId};

/// Number of the filter of SYNC, behind that of NMT. The filters of SDO and of the master's heartbeat follow it.
pub const SYNC_FILTER: usize = 1;
/// Number of the first filter of a node that 1016h monitors.
pub const FILTERS_OF_PEERS: usize = 4;

impl<D: Device, E: Extension<D>> SlaveCore<D, E> {
    /// Returns the filters: exact COB-IDs only. There is one for each entry of 1016h and for each RPDO, in
    /// use or not. Behind them is one for heartbeats of another node with this Node-ID (on two buses), and one for the second SDO server
    /// if the device has one. Filters above [`MAX_FILTERS`] are
    /// left out.
    pub fn filters(&self) -> Filters {
        (0..self.wanted_filters().min(MAX_FILTERS)).map(|number| self.filter(number)).collect()
    }

    /// Returns the number of filters that the node would have without a limit.
    pub(crate) fn wanted_filters(&self) -> usize {
        self.second_sdo_filter() + usize::from(D::Sdo::SECOND_SERVER.is_some())
    }

    /// Returns the number of the filter of the second SDO server.
    pub(crate) fn second_sdo_filter(&self) -> usize {
        self.filters_of_rpdos() + D::Pdos::RECEIVE + 1
    }

    /// Returns the number of the first filter of an RPDO.
    pub(crate) fn filters_of_rpdos(&self) -> usize {
        FILTERS_OF_PEERS + self.services.consumers()
    }

    /// Returns the filter with this number by the dictionary, that of NMT again if it is not used.
    fn filter(&self, number: usize) -> Filter {
        Filter::exact(self.filtered_id(number))
    }

    /// Returns the filter with this number as the dictionary has it, `None` if there is no such filter.
    pub fn wanted_filter(&self, number: usize) -> Option<Filter> {
        (number < self.wanted_filters().min(MAX_FILTERS)).then(|| self.filter(number))
    }

    fn filtered_id(&self, number: usize) -> CobId {
        if self.is_maintained() {
            return self.services.sdo_id();
        }
        let id = match number {
            SYNC_FILTER => Some(self.services.written_sync_id()),
            2 => Some(self.services.sdo_id()),
            3 if E::HAS_TWO_BUSES => Some(CobId::heartbeat(NodeId::MASTER)),
            0..FILTERS_OF_PEERS => None,
            _ => match number.checked_sub(self.filters_of_rpdos()) {
                None => self.services.consumed(number - FILTERS_OF_PEERS),
                // Behind the RPDOs: another node with this Node-ID.
                Some(pdo) if E::HAS_TWO_BUSES && pdo == D::Pdos::RECEIVE => {
                    Some(CobId::heartbeat(self.control.id()))
                }
                Some(last) if D::Sdo::SECOND_SERVER.is_some() && last > D::Pdos::RECEIVE => {
                    self.services.second_sdo_id()
                }
                Some(pdo) => self.services.rpdo_id(pdo),
            },
        };
        id.unwrap_or(CobId::NMT)
    }

    /// Notes that a filter has changed. The node sends it to its buses when it runs next.
    pub(crate) fn note_filter(&mut self, number: usize) {
        self.changed_filters.change(self.services.wakes_mut()).note(number);
    }

    /// Sends all filters to the buses.
    pub(crate) fn note_all_filters(&mut self) {
        let count = self.wanted_filters();
        self.changed_filters.change(self.services.wakes_mut()).note_all(count);
    }

    /// Sends changed filters to `buses` while there is room beside the frames. Filters of RPDOs go first.
    pub fn set_filters(&mut self, buses: &[Bus], turn: &mut Turn<'_, E::SlaveEvent>) {
        let mut changed = *self.changed_filters;
        changed.send(buses, |number| self.filter(number), turn);
        *self.changed_filters.no_sooner() = changed;
    }

    /// Returns whether a frame with this COB-ID may be for this node.
    pub fn may_take(&self, id: CobId) -> bool {
        self.taken.may_have(id)
    }

    /// Computes the set of the COB-IDs that the node takes.
    pub(crate) fn update_taken(&mut self) {
        self.taken = (0..self.wanted_filters()).map(|number| self.filtered_id(number)).collect();
    }
}
