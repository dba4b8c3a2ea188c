//! What a write must obey beyond type and limits (CiA 301 7.5.2, ECSS 6.10b, 8.3.1).

use crate::heartbeat::ConsumerSlots;
use crate::nmt::{ErrorBehaviour, NmtStartup};
use crate::node::{Device, NodeObjects, index};
use crate::od::{CobIdEntry, EntryUse};
use crate::pdo::{Direction, PdoSlots};
use crate::types::{AbortCode, Address, Bus, NodeId};
use crate::{heartbeat, sync};

/// Objects above have no rules here.
pub const LAST: u16 = index::REDUNDANCY;

/// Whether `value`, a number of the right length, may be written to an object that is no PDO's.
///
/// # Errors
/// The abort code to answer.
pub fn check<D: Device>(
    id: NodeId,
    objects: &NodeObjects<D>,
    at: Address,
    value: u32,
) -> Result<(), AbortCode> {
    let present = &objects.communication;
    match (at.index, at.sub) {
        // Zero forgets the errors.
        (index::PRE_DEFINED_ERRORS, 0) if value != 0 => Err(AbortCode::ValueRange),
        // Only the master produces SYNC (ECSS 6.9d).
        (index::SYNC_COB_ID, _) if id != NodeId::MASTER && CobIdEntry::from_raw(value).flag() => {
            Err(AbortCode::ValueRange)
        }
        (index::SYNC_COB_ID, _) => {
            written(present.sync_cob_id, value, EntryUse::Sync)?;
            let sync = SYNC_IS_USED & value;
            let is_received = objects.pdos.rpdos().0.iter().any(|pdo| has(pdo.cob_id, sync));
            free(!(is_received || is_sent(objects, sync) || has(present.emcy_cob_id, sync)))
        }
        (index::CYCLE_PERIOD, _) => sync::check_period(value),
        (index::EMCY_COB_ID, _) => {
            written(present.emcy_cob_id, value, EntryUse::Emcy)?;
            free(!(has(SYNC_IS_USED & present.sync_cob_id, value) || is_sent(objects, value)))
        }
        (index::CONSUMER_HEARTBEAT, sub) => heartbeat::check_entry(objects.consumers.entries(), sub, value),
        (index::SYNC_OVERFLOW, _) => sync::check_overflow(value as u8, present.cycle_period),
        (index::ERROR_BEHAVIOUR, _) => ErrorBehaviour::from_byte(value as u8).map(drop),
        (index::NMT_STARTUP, _) => {
            NmtStartup::from_raw(value).written(NmtStartup::from_raw(present.nmt_startup))
        }
        (index::REQUEST_NMT, _) if !matches!(value, 4..=7 | 127) => Err(AbortCode::ValueRange),
        (index::REDUNDANCY, 1) if Bus::from_bdefault(value as u8).is_none() => Err(AbortCode::ValueRange),
        _ => Ok(()),
    }
}

fn written(present: u32, value: u32, entry_use: EntryUse) -> Result<(), AbortCode> {
    CobIdEntry::from_raw(present).written(value, entry_use).map(drop)
}

/// Whether a PDO that becomes valid may have its identifier: SYNC (1005h) is no PDO, and emergencies (1014h) are no TPDO.
///
/// # Errors
/// [`AbortCode::ParameterIncompatible`].
pub fn check_pdo(direction: Direction, sync: u32, emcy: u32, cob_id: u32) -> Result<(), AbortCode> {
    let is_emergency = direction == Direction::Transmit && has(emcy, cob_id);
    free(!(has(SYNC_IS_USED & sync, cob_id) || is_emergency))
}

/// 1005h is an identifier in use whatever its bit 31.
const SYNC_IS_USED: u32 = !(3 << 30);

fn free(is_free: bool) -> Result<(), AbortCode> {
    if is_free { Ok(()) } else { Err(AbortCode::ParameterIncompatible) }
}

/// Whether two COB-IDs are valid and have one identifier.
fn has(one: u32, other: u32) -> bool {
    let one = CobIdEntry::from_raw(one).cob_id();
    one.is_some() && one == CobIdEntry::from_raw(other).cob_id()
}

/// Whether a valid TPDO has this COB-ID.
fn is_sent<D: Device>(objects: &NodeObjects<D>, cob_id: u32) -> bool {
    objects.pdos.tpdos().0.iter().any(|pdo| has(pdo.cob_id, cob_id))
}
