//! COB-IDs that a node receives and sends, by its objects: acceptance filters and the boot-up process ask for them.

use super::Services;
use crate::heartbeat::{ConsumerSlots, monitored};
use crate::node::Device;
use crate::node::services::extension::Extension;
use crate::od::CobIdEntry;
use crate::pdo::PdoSlots;
use crate::types::CobId;

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Returns the COB-ID of an RPDO, if it is valid.
    pub(crate) fn rpdo_id(&self, number: usize) -> Option<CobId> {
        let pdo = self.objects().pdos.rpdos().0.get(number)?;
        CobIdEntry::from_raw(pdo.cob_id).cob_id()
    }

    /// Returns the COB-IDs of all valid RPDOs.
    pub fn rpdo_ids(&self) -> impl Iterator<Item = CobId> {
        (0..D::Pdos::RECEIVE).filter_map(|number| self.rpdo_id(number))
    }

    /// Returns the number of entries of 1016h.
    pub(crate) fn consumers(&self) -> usize {
        self.objects().consumers.entries().len()
    }

    /// Returns the COB-ID of the heartbeat that an entry of 1016h consumes, if the entry is in use.
    pub(crate) fn consumed(&self, entry: usize) -> Option<CobId> {
        let entry = self.objects().consumers.entries().get(entry)?;
        monitored(*entry).map(CobId::heartbeat)
    }

    /// Returns whether this is the COB-ID of SYNC.
    pub fn is_sync(&self, id: CobId) -> bool {
        self.sync_id.is(id)
    }

    /// Returns the COB-ID of SYNC as it was just written.
    pub fn written_sync_id(&self) -> CobId {
        self.objects().communication.sync.id()
    }

    /// Returns whether the node sends this COB-ID: in its emergencies or in a valid transmit PDO.
    pub fn sends(&self, id: CobId) -> bool {
        let objects = self.objects();
        let pdos = objects.pdos.tpdos().0.iter().map(|pdo| pdo.cob_id);
        let mut all = pdos.chain([objects.communication.emcy.cob_id]);
        all.any(|entry| CobIdEntry::from_raw(entry).cob_id() == Some(id))
    }
}
