//! Entries of 1016h: node << 16 | milliseconds.

use crate::types::{AbortCode, NodeId};

/// Checks a `value` that a client writes to sub-index `sub` of 1016h, whose entries are `present`.
///
/// # Errors
/// [`AbortCode::NoSubIndex`] if there is no such entry, [`AbortCode::ValueRange`] for reserved bits,
/// [`AbortCode::ParameterIncompatible`] if another entry monitors the same node.
pub fn check_entry(present: &[u32], sub: u8, value: u32) -> Result<(), AbortCode> {
    let place = usize::from(sub).checked_sub(1).filter(|place| *place < present.len());
    let Some(place) = place else { return Err(AbortCode::NoSubIndex) };
    if value >> 24 != 0 {
        return Err(AbortCode::ValueRange);
    }
    let Some(node) = used(value) else { return Ok(()) };
    let twice = present.iter().enumerate().any(|(other, value)| other != place && used(*value) == Some(node));
    if twice { Err(AbortCode::ParameterIncompatible) } else { Ok(()) }
}

/// The node of an entry in use.
pub(super) const fn used(value: u32) -> Option<NodeId> {
    if value as u16 == 0 { None } else { NodeId::new((value >> 16) as u8) }
}
