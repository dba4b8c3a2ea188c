//! What a write must obey beyond type and limits (CiA 301 7.5.2, ECSS 6.10b, 8.3.1): each service has the rules of its objects,
//! those that concern several are here.

use crate::heartbeat::ConsumerSlots;
use crate::node::{Communication, Device, Extension, NetworkObjects, NodeObjects, index};
use crate::od::{CobIdEntry, Objects};
use crate::pdo::{Direction, PdoSlots};
use crate::redundancy::RedundancyObjects;
use crate::types::{AbortCode, Address, NodeId};

/// Objects above have no rules here.
pub const LAST: u16 = index::REDUNDANCY;

/// Whether `value`, a number of the right length, may be written to an object that is no PDO's.
///
/// # Errors
/// The abort code to answer.
pub fn check<D: Device, E: Extension>(
    id: NodeId,
    objects: &NodeObjects<D, E>,
    at: Address,
    value: u32,
) -> Result<(), AbortCode> {
    let Communication { sync, emcy, nmt, .. } = &objects.communication;
    sync.may_write(at, value, id == NodeId::MASTER)?;
    emcy.may_write(at, value)?;
    nmt.may_write(at, value)?;
    objects.consumers.may_write(at, value)?;
    // A node does not carry the rules of objects that it has not.
    if const { has_object::<D, E>(index::REDUNDANCY) } {
        RedundancyObjects::may_write(at, value)?;
    }
    if const { has_object::<D, E>(index::REQUEST_NMT) } {
        NetworkObjects::may_write(at, value)?;
    }
    match at.index {
        index::SYNC_COB_ID => {
            let sync = SYNC_IS_USED & value;
            let is_received = objects.pdos.rpdos().0.iter().any(|pdo| has(pdo.cob_id, sync));
            free(!(is_received || is_sent(objects, sync) || has(emcy.cob_id, sync)))
        }
        index::EMCY_COB_ID => free(!(has(SYNC_IS_USED & sync.cob_id, value) || is_sent(objects, value))),
        _ => Ok(()),
    }
}

/// Whether the node has the record or the array with this index.
const fn has_object<D: Device, E: Extension>(index: u16) -> bool {
    NodeObjects::<D, E>::DECLARED.find(Address::new(index, 1)).is_some()
}

/// Whether a PDO that becomes valid may have its identifier: SYNC (1005h) is no PDO, and emergencies (1014h) are no TPDO.
///
/// # Errors
/// [`AbortCode::ParameterIncompatible`].
pub fn check_pdo(direction: Direction, communication: &Communication, cob_id: u32) -> Result<(), AbortCode> {
    let Communication { sync, emcy, .. } = communication;
    let is_emergency = direction == Direction::Transmit && has(emcy.cob_id, cob_id);
    free(!(has(SYNC_IS_USED & sync.cob_id, cob_id) || is_emergency))
}

/// 1005h is an identifier in use whatever its bit 31.
const SYNC_IS_USED: u32 = !(3 << 30);

fn free(is_free: bool) -> Result<(), AbortCode> {
    if is_free { Ok(()) } else { Err(AbortCode::ParameterIncompatible) }
}

/// Whether two COB-IDs are valid and have one identifier.
#[inline(never)] // of several callers, neither in a hurry
fn has(one: u32, other: u32) -> bool {
    let one = CobIdEntry::from_raw(one).cob_id();
    one.is_some() && one == CobIdEntry::from_raw(other).cob_id()
}

/// Whether a valid TPDO has this COB-ID.
fn is_sent<D: Device, E: Extension>(objects: &NodeObjects<D, E>, cob_id: u32) -> bool {
    objects.pdos.tpdos().0.iter().any(|pdo| has(pdo.cob_id, cob_id))
}
