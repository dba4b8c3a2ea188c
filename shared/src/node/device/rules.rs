//! What a write must obey beyond type and limits (CiA 301 7.5.2, ECSS 6.10b, 8.3.1).

use crate::nmt::{ErrorBehaviour, NmtStartup};
use crate::node::Communication;
use crate::od::{CobIdEntry, EntryUse};
use crate::pdo::{Direction, Mapping};
use crate::types::{AbortCode, Address, Bus, NodeId};
use crate::{heartbeat, sync};

/// Objects above have no rules here.
pub const LAST: u16 = 0x2000;

/// Whether `value`, a number of the right length, may be written to an object that is no PDO's.
///
/// # Errors
/// The abort code to answer.
pub fn check<const R: usize, const T: usize, M: Mapping>(
    id: NodeId,
    present: &Communication<R, T, M>,
    at: Address,
    value: u32,
) -> Result<(), AbortCode> {
    match (at.index, at.sub) {
        // Zero forgets the errors.
        (0x1003, 0) if value != 0 => Err(AbortCode::ValueRange),
        // Only the master produces SYNC (ECSS 6.9d).
        (0x1005, _) if id != NodeId::MASTER && CobIdEntry::from_raw(value).flag() => {
            Err(AbortCode::ValueRange)
        }
        (0x1005, _) => {
            written(present.sync_cob_id, value, EntryUse::Sync)?;
            let sync = SYNC_IS_USED & value;
            let is_received = present.rpdos.iter().any(|pdo| has(pdo.cob_id, sync));
            free(!(is_received || is_sent(present, sync) || has(present.emcy_cob_id, sync)))
        }
        (0x1006, _) => sync::check_period(value),
        (0x1014, _) => {
            written(present.emcy_cob_id, value, EntryUse::Emcy)?;
            free(!(has(SYNC_IS_USED & present.sync_cob_id, value) || is_sent(present, value)))
        }
        (0x1016, sub) => heartbeat::check_entry(&present.consumer_heartbeat, sub, value),
        (0x1019, _) => sync::check_overflow(value as u8, present.cycle_period),
        (0x1029, _) => ErrorBehaviour::from_byte(value as u8).map(drop),
        (0x1F80, _) => NmtStartup::from_raw(value).written(NmtStartup::from_raw(present.nmt_startup)),
        (0x1F82, _) if !matches!(value, 4..=7 | 127) => Err(AbortCode::ValueRange),
        (0x2000, 1) if Bus::from_bdefault(value as u8).is_none() => Err(AbortCode::ValueRange),
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
fn is_sent<const R: usize, const T: usize, M: Mapping>(
    present: &Communication<R, T, M>,
    cob_id: u32,
) -> bool {
    present.tpdos.iter().any(|pdo| has(pdo.cob_id, cob_id))
}
