//! Guards COB-IDs against a flipped bit in memory.
//!
//! | copy of a COB-ID | place | used for |
//! | --- | --- | --- |
//! | first | the object | reads and writes of clients |
//! | second, with its complement | [`Guarded`] | nothing else |
//! | third, with its complement | the service | the frames: none is sent or taken while a bit of it is wrong |
//!
//! After each heartbeat the node compares one COB-ID, or a few. So the comparison needs no wake-up of its own and
//! no long step (row `rx.inside_look`). Within [`HEARTBEATS`] it has compared all. The second copy is right while
//! it fits its complement. Otherwise the object is right.
//!
//! The other parameters of the services are compared with the COB-IDs.

mod parameters;
#[cfg(test)]
mod tests;

use self::parameters::Codes;
use super::Services;
use crate::emcy::ErrorCode;
use crate::node::Device;
use crate::node::index::{EMCY_COB_ID, LAST_RPDO, LAST_TPDO, RPDO, SYNC_COB_ID, TPDO};
use crate::node::services::extension::Extension;
use crate::node::services::rules::{SYNC_IS_USED, is_channel};
use crate::od::copies::{Copied, Copies};
use crate::pdo::{Direction, PdoSlots};
use crate::sdo::SdoServers;
use crate::types::{Address, CobId, Instant, NodeId, Sealed, correct};

/// Source of the emergency that reports a flipped bit; the number of those that were mended follows.
const FLIPPED: u8 = 1;

/// All COB-IDs are compared within this number of heartbeats: 8 s, at one every 250 ms.
const HEARTBEATS: usize = 32;

/// Numbers of SYNC and emergencies among the COB-IDs. Receive PDOs follow, then transmit PDOs.
const SYNC: usize = 0;
const EMCY: usize = 1;
const FIRST_RPDO: usize = 2;

/// Second copies of the COB-IDs of a node.
#[derive(Debug)]
pub struct Guarded<S: PdoSlots> {
    sync: Copied,
    emcy: Copied,
    rpdos: S::Receive<Copied>,
    tpdos: S::Transmit<Copied>,
    codes: Codes<S>,
    /// Number of the COB-ID that is compared next.
    next: usize,
}

impl<S: PdoSlots> Guarded<S> {
    /// Number of the first COB-ID behind those of the PDOs.
    const BEHIND: usize = FIRST_RPDO + S::RECEIVE + S::TRANSMIT;

    pub fn new() -> Self {
        let none = Copied::NONE;
        let (rpdos, tpdos) = (S::receive(none), S::transmit(none));
        Guarded { sync: none, emcy: none, rpdos, tpdos, codes: Codes::new(), next: 0 }
    }
}

/// Number of the COB-ID at an address.
fn number_of<D: Device>(at: Address) -> Option<usize> {
    match at.index {
        index if is_channel::<D>(index, at.sub) => Some(Guarded::<D::Pdos>::BEHIND + usize::from(at.sub - 1)),
        SYNC_COB_ID => Some(SYNC),
        EMCY_COB_ID => Some(EMCY),
        index @ RPDO..=LAST_RPDO => Some(FIRST_RPDO + usize::from(index - RPDO)),
        index @ TPDO..=LAST_TPDO => Some(FIRST_RPDO + D::Pdos::RECEIVE + usize::from(index - TPDO)),
        _ => None,
    }
}

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// COB-IDs of the node. Those of the second SDO server are the last ones.
    const COB_IDS: usize = Guarded::<D::Pdos>::BEHIND + if D::Sdo::SECOND_SERVER.is_some() { 2 } else { 0 };
    /// COB-IDs that are compared with each heartbeat.
    const EACH_HEARTBEAT: usize = Self::COB_IDS.div_ceil(HEARTBEATS);

    /// Compares the Node-ID of the node with the copies in its services, and the COB-ID of SDO with it.
    /// What is wrong is corrected, and an emergency reports it.
    pub fn compare_node_ids(&mut self, own: &mut NodeId) {
        let is_wrong = correct([own, &mut self.id, self.dictionary.id_mut()]);
        let sdo_id = Sealed::of(CobId::sdo_request(*own));
        if is_wrong || self.sdo_id != sdo_id {
            self.sdo_id = sdo_id;
            self.report_flipped();
        }
    }

    /// Copies all COB-IDs after the services took them.
    pub(crate) fn copy_cob_ids(&mut self) {
        for number in 0..Self::COB_IDS {
            self.copy_cob_id(number);
            self.copy_parameters(number);
        }
    }

    /// Copies the COB-ID of an object that was written, and computes the code of its parameters, as far as it has them. The other
    /// copies stay as they are, so that a flipped bit in one of them is still found.
    pub(crate) fn copy_written(&mut self, at: Address) {
        if let Some(number) = number_of::<D>(at) {
            self.copy_cob_id(number);
        }
        self.copy_written_parameters(at);
    }

    fn copy_cob_id(&mut self, number: usize) {
        if let Some(copies) = self.copies(number) {
            copies.renew();
        }
    }

    /// Compares the copies of the next COB-IDs in turn. If one is wrong, all three are corrected, also in the
    /// services, and an emergency reports it. Returns whether one was wrong.
    pub fn compare_cob_ids(&mut self, now: Instant) -> bool {
        let mut is_wrong = false;
        for _ in 0..Self::EACH_HEARTBEAT {
            let number = self.guarded.next;
            self.guarded.next = (number + 1) % Self::COB_IDS;
            is_wrong |= self.copies(number).is_some_and(Copies::correct);
            is_wrong |= self.compare_parameters(number, now);
        }
        if is_wrong {
            self.sync_id = Sealed::of(self.written_sync_id());
            self.dictionary.configure_emcy();
            self.take_second_sdo();
            self.dictionary.set_pdos(now);
            self.report_flipped();
        }
        is_wrong
    }

    /// Returns the copies of a COB-ID.
    fn copies(&mut self, number: usize) -> Option<Copies<'_>> {
        let Self { dictionary, guarded, sync_id, second_sdo, .. } = self;
        match number {
            SYNC => {
                let object = &mut dictionary.objects_mut().communication.sync.cob_id;
                Some(Copies::new(object, &mut guarded.sync, *sync_id).of_bits(SYNC_IS_USED))
            }
            EMCY => {
                let in_use = dictionary.emcy().id();
                let object = &mut dictionary.objects_mut().communication.emcy.cob_id;
                Some(Copies::new(object, &mut guarded.emcy, in_use))
            }
            _ => {
                if D::Sdo::SECOND_SERVER.is_some()
                    && let Some(nth) = number.checked_sub(Guarded::<D::Pdos>::BEHIND)
                {
                    let ids = dictionary.objects_mut().sdo.cob_ids_mut()?;
                    return second_sdo.as_mut().first_mut()?.copies(nth, ids);
                }
                let nth = number.checked_sub(FIRST_RPDO)?;
                let (direction, nth, second, in_use) = match nth.checked_sub(D::Pdos::RECEIVE) {
                    None => {
                        let second = guarded.rpdos.as_mut().get_mut(nth)?;
                        (Direction::Receive, nth, second, dictionary.rpdos().sealed(nth))
                    }
                    Some(nth) => {
                        let second = guarded.tpdos.as_mut().get_mut(nth)?;
                        (Direction::Transmit, nth, second, dictionary.tpdos().sealed(nth))
                    }
                };
                let (pdo, _) = dictionary.objects_mut().pdos.pdo_mut(direction, nth)?;
                Some(Copies::new(&mut pdo.cob_id, second, in_use))
            }
        }
    }

    /// Reports that a flipped bit was corrected.
    #[inline(never)] // row `size.pyboard-v11.slave.flash`
    pub fn report_flipped(&mut self) {
        let [low, high] = self.objects_mut().extension.count_mended().to_le_bytes();
        self.report_past(ErrorCode::HARDWARE, [FLIPPED, low, high, 0, 0]);
    }
}
