//! Rules for writing beyond type and limits (CiA 301 7.5.2). Each service has the rules of its
//! objects. The rules that concern several services are here.

use crate::heartbeat::{ConsumerSlots, check_entry, monitored};
use crate::node::services::extension::Extension;
use crate::node::services::objects::NodeObjects;
use crate::node::{Communication, Device, index};
use crate::od::{CobIdEntry, EntryUse, INVALID};
use crate::pdo::{Direction, PdoSlots};
use crate::sdo::SdoServers;
use crate::sync;
use crate::types::{AbortCode, Address, CobId, NodeId};

/// Checks a `value`, a number of the right length, that a client writes to an object other than those of PDOs.
///
/// # Errors
/// The abort code to answer.
pub fn check<D: Device, E: Extension<D>>(
    id: NodeId,
    objects: &NodeObjects<D, E>,
    at: Address,
    value: u32,
) -> Result<(), AbortCode> {
    let Communication { sync, emcy, nmt, .. } = &objects.communication;
    sync.may_write(at, value, id == NodeId::MASTER)?;
    emcy.may_write(at, value)?;
    nmt.may_write(at, value)?;
    objects.sdo.may_write(at, value)?;
    objects.consumers.may_write(at, value)?;
    E::may_write(id, at, value)?;
    match at.index {
        index if is_channel::<D>(index, at.sub) => check_channel(id, objects, at, value),
        index::SYNC_COB_ID => {
            let sync = SYNC_IS_USED & value;
            let is_received = objects.pdos.rpdos().0.iter().any(|pdo| has(pdo.cob_id, sync));
            let is_own = has(emcy.cob_id, sync) || is_of_second_sdo(&objects.sdo, sync);
            free(!(is_received || is_sent(objects, sync) || is_own))
        }
        index::EMCY_COB_ID => {
            check_sender(id, &objects.consumers, value)?;
            let is_own = has(SYNC_IS_USED & sync.cob_id, value) || is_of_second_sdo(&objects.sdo, value);
            free(!(is_own || is_sent(objects, value)))
        }
        _ => Ok(()),
    }
}

/// Checks a stored value before communication starts. As [`check`], except that nothing is in use yet: a value that
/// a client has to write in steps may be the final one. [`are_possible`] checks SYNC and emergencies after
/// everything is loaded. PDOs are checked when they are set up.
///
/// # Errors
/// As [`check`].
pub fn check_stored<D: Device, E: Extension<D>>(
    id: NodeId,
    objects: &NodeObjects<D, E>,
    at: Address,
    value: u32,
) -> Result<(), AbortCode> {
    match at.index {
        index if is_channel::<D>(index, at.sub) => {
            objects.sdo.may_write(at, value)?;
            check_free(&objects.communication, value)
        }
        index::SYNC_COB_ID | index::EMCY_COB_ID => Ok(()),
        index::SYNC_OVERFLOW => sync::check_overflow(value as u8, 0),
        // Those above are taken already, those below are of before.
        index::CONSUMER_HEARTBEAT => {
            let taken = objects.consumers.entries().get(..usize::from(at.sub));
            check_entry(taken.unwrap_or_default(), at.sub, value)
        }
        _ => check(id, objects, at, value),
    }
}

/// Returns whether SYNC and emergencies may have their present identifiers.
pub fn are_possible(id: NodeId, communication: &Communication) -> bool {
    let (sync, emcy) = (communication.sync.cob_id, communication.emcy.cob_id);
    let unused = CobIdEntry::from_raw(INVALID);
    unused.written(sync, EntryUse::Sync).is_ok()
        && unused.written(emcy, EntryUse::Emcy).is_ok()
        && (id == NodeId::MASTER || !CobIdEntry::from_raw(sync).flag())
        && !has(SYNC_IS_USED & sync, emcy)
}

/// Sub-index of the COB-ID of requests in the object of an SDO channel.
const REQUEST: u8 = 1;
/// Sub-index of the COB-ID of answers.
const ANSWER: u8 = 2;

/// Returns whether this is a COB-ID of the second SDO server.
pub fn is_channel<D: Device>(index: u16, sub: u8) -> bool {
    D::Sdo::SECOND_SERVER == Some(index) && matches!(sub, REQUEST | ANSWER)
}

/// Checks a COB-ID that a client gives to the second SDO server: SYNC, emergencies and PDOs of the node do not have it,
/// and that of answers does not belong to another node.
///
/// # Errors
/// [`AbortCode::ParameterIncompatible`].
fn check_channel<D: Device, E: Extension<D>>(
    id: NodeId,
    objects: &NodeObjects<D, E>,
    at: Address,
    value: u32,
) -> Result<(), AbortCode> {
    if at.sub == ANSWER {
        check_sender(id, &objects.consumers, value)?;
    }
    let is_received = objects.pdos.rpdos().0.iter().any(|pdo| has(pdo.cob_id, value));
    free(!(is_received || is_sent(objects, value)))?;
    check_free(&objects.communication, value)
}

/// Checks that neither SYNC nor the emergencies of the node have a COB-ID.
fn check_free(communication: &Communication, cob_id: u32) -> Result<(), AbortCode> {
    let Communication { sync, emcy, .. } = communication;
    free(!(has(SYNC_IS_USED & sync.cob_id, cob_id) || has(emcy.cob_id, cob_id)))
}

/// Checks the identifier of a PDO that becomes valid: the second SDO server does not have it.
///
/// # Errors
/// [`AbortCode::ParameterIncompatible`].
pub fn check_pdo_of_server(sdo: &impl SdoServers, cob_id: u32) -> Result<(), AbortCode> {
    free(!is_of_second_sdo(sdo, cob_id))
}

/// Returns whether a COB-ID of the second SDO server is valid and has this identifier.
fn is_of_second_sdo(sdo: &impl SdoServers, cob_id: u32) -> bool {
    sdo.cob_ids().is_some_and(|ids| ids.into_iter().any(|own| has(own, cob_id)))
}

/// Checks the identifier of a PDO that becomes valid: no PDO may have that of SYNC (1005h), no TPDO that of the
/// emergencies (1014h).
///
/// # Errors
/// [`AbortCode::ParameterIncompatible`].
pub fn check_pdo(direction: Direction, communication: &Communication, cob_id: u32) -> Result<(), AbortCode> {
    let Communication { sync, emcy, .. } = communication;
    let is_emergency = direction == Direction::Transmit && has(emcy.cob_id, cob_id);
    free(!(has(SYNC_IS_USED & sync.cob_id, cob_id) || is_emergency))
}

/// Checks the COB-ID that a client gives to a TPDO or to the emergencies of the node: it must not belong to
/// another node. A COB-ID that the device declares is the allocation of the mission, and is accepted.
///
/// # Errors
/// [`AbortCode::ParameterIncompatible`].
pub fn check_sender(id: NodeId, consumers: &impl ConsumerSlots, cob_id: u32) -> Result<(), AbortCode> {
    free(!is_anothers(id, consumers, cob_id))
}

/// Returns whether a valid COB-ID belongs to another node in the pre-defined connection set, as far as this one knows
/// others: the master, and those that 1016h names.
fn is_anothers(id: NodeId, consumers: &impl ConsumerSlots, cob_id: u32) -> bool {
    let is_heard = |owner: NodeId| {
        let of_owner = |entry: &u32| monitored(*entry) == Some(owner);
        owner == NodeId::MASTER || consumers.entries().iter().any(of_owner)
    };
    let owner = CobIdEntry::from_raw(cob_id).cob_id().and_then(CobId::sender);
    owner.is_some_and(|owner| owner != id && is_heard(owner))
}

/// Mask of 1005h: its identifier is in use whatever bit 31 is.
pub const SYNC_IS_USED: u32 = !(3 << 30);

fn free(is_free: bool) -> Result<(), AbortCode> {
    if is_free { Ok(()) } else { Err(AbortCode::ParameterIncompatible) }
}

/// Returns whether two COB-IDs are valid and have one identifier.
fn has(one: u32, other: u32) -> bool {
    let one = CobIdEntry::from_raw(one).cob_id();
    one.is_some() && one == CobIdEntry::from_raw(other).cob_id()
}

/// Returns whether a valid TPDO has this COB-ID.
fn is_sent<D: Device, E: Extension<D>>(objects: &NodeObjects<D, E>, cob_id: u32) -> bool {
    objects.pdos.tpdos().0.iter().any(|pdo| has(pdo.cob_id, cob_id))
}
