//! Rules for writing the parameters of a PDO by SDO (CiA 301 7.5.2.35 to 7.5.2.38).
//!
//! The procedure: make the PDO invalid (bit 31 of its COB-ID), set the number of mapped objects to zero, write
//! them, set their number, make the PDO valid. CiA 301 leaves some abort codes open. Here they are:
//!
//! | refused | with |
//! | --- | --- |
//! | another identifier, inhibit time, SYNC start value, or anything of the mapping, while valid | 06010000h |
//! | a mapped object while their number is not zero | 06010000h |
//! | extended frames, restricted identifiers, reserved transmission types, remote requests (252, 253) | 06090030h |
//! | a valid TPDO that allows remote frames (bit 30 clear); for RPDOs and invalid ones the bit means nothing | 06090030h |
//! | making a PDO valid that carries nothing, or a TPDO with the identifier of another | 06040043h |
//! | making a PDO valid with the identifier of SYNC, or a TPDO with that of the node's own emergencies | 06040043h |
//!
//! The write that makes a PDO invalid may change its identifier, as configuration tools do.
//! Transmission type and event timer may change while valid; they take effect at once.

use super::{Direction, Layout};
use crate::od::{CobIdEntry, EntryUse, INVALID, NO_REMOTE, Objects, Record};
use crate::pdo::{MAPPED, Mapping, PdoParameters};
use crate::types::{AbortCode, CobId};

/// Greatest cyclic transmission type: every 240th SYNC. Types above it do not depend on SYNC.
pub const LAST_CYCLIC: u8 = 240;

/// Returns whether a transmission type depends on SYNC.
pub const fn is_synchronous(transmission: u8) -> bool {
    transmission <= LAST_CYCLIC
}

/// Returns the parameters of a PDO after a write.
///
/// # Errors
/// See the table above. [`AbortCode::ValueTooHigh`] for a value that does not fit, [`AbortCode::NoSubIndex`].
pub fn parameters(
    direction: Direction,
    old: &PdoParameters,
    sub: u8,
    value: u32,
) -> Result<PdoParameters, AbortCode> {
    let mut new = *old;
    check(direction, old.cob_id, sub, value)?;
    // A receive PDO has no SYNC start value.
    let is_there = sub != 6 || direction == Direction::Transmit;
    let field = new.variable(sub).filter(|_| is_there).ok_or(AbortCode::NoSubIndex)?;
    field.set_bits(value.into());
    Ok(new)
}

fn check(direction: Direction, cob_id: u32, sub: u8, value: u32) -> Result<(), AbortCode> {
    let old = CobIdEntry::from_raw(cob_id);
    let valid = old.cob_id().is_some();
    match sub {
        1 => {
            let new = old.written(value, EntryUse::Pdo)?;
            let remote = direction == Direction::Transmit && value & NO_REMOTE == 0;
            if new.cob_id().is_some() && remote { Err(AbortCode::ValueRange) } else { Ok(()) }
        }
        2 => check_transmission(value),
        3 | 6 if valid => Err(AbortCode::UnsupportedAccess),
        3 | 5 if value > 0xFFFF => Err(AbortCode::ValueTooHigh),
        6 if value > 240 => Err(AbortCode::ValueTooHigh),
        _ => Ok(()),
    }
}

/// Returns whether a transmission type may be used. Reserved types (241 to 251) and remote requests (252, 253)
/// may not.
pub const fn is_transmission_type(transmission: u8) -> bool {
    matches!(transmission, 0..=240 | 254 | 255)
}

fn check_transmission(value: u32) -> Result<(), AbortCode> {
    if u8::try_from(value).is_ok_and(is_transmission_type) { Ok(()) } else { Err(AbortCode::ValueRange) }
}

/// Checks a `value` that a client writes to a sub-index of the mapping of the PDO that has `cob_id`.
///
/// # Errors
/// See the table above; as [`Layout::new`] for a mapped object, zero excepted, and for their number;
/// [`AbortCode::NoSubIndex`].
pub fn mapping<D: Objects>(
    direction: Direction,
    cob_id: u32,
    mapping: &mut impl Mapping,
    sub: u8,
    value: u32,
) -> Result<(), AbortCode> {
    if CobIdEntry::from_raw(cob_id).cob_id().is_some() {
        return Err(AbortCode::UnsupportedAccess);
    }
    match usize::from(sub) {
        0 => {
            // Those beyond the present number, too: it is zero while they are written.
            let mut entries = [0; MAPPED];
            for (sub, entry) in (1_u8..).zip(&mut entries) {
                *entry = mapping.variable(sub).map_or(0, |variable| variable.bits() as u32);
            }
            let mapped = entries.get(..value as usize).ok_or(AbortCode::PdoLength)?;
            Layout::new::<D>(direction, mapped).map(drop)
        }
        1..=MAPPED if !mapping.objects().is_empty() => Err(AbortCode::UnsupportedAccess),
        1..=MAPPED if value == 0 => Ok(()),
        1..=MAPPED => Layout::new::<D>(direction, &[value]).map(drop),
        _ => Err(AbortCode::NoSubIndex),
    }
}

/// Returns the PDO with these parameters and this mapping, `None` if it is not valid.
///
/// # Errors
/// [`AbortCode::ValueRange`] for a restricted identifier, an extended frame, and a reserved transmission type.
/// [`AbortCode::ParameterIncompatible`] if nothing is mapped. As [`Layout::new`].
#[inline(never)] // once for both directions
pub fn resolve<D: Objects>(
    direction: Direction,
    parameters: &PdoParameters,
    mapping: &[u32],
) -> Result<Option<(CobId, Layout)>, AbortCode> {
    if parameters.cob_id & INVALID != 0 {
        return Ok(None);
    }
    let entry = CobIdEntry::from_raw(INVALID).written(parameters.cob_id, EntryUse::Pdo)?;
    check_transmission(u32::from(parameters.transmission))?;
    if mapping.is_empty() {
        return Err(AbortCode::ParameterIncompatible);
    }
    let layout = Layout::new::<D>(direction, mapping)?;
    Ok(entry.cob_id().map(|id| (id, layout)))
}
