//! Entries of 1016h: node << 16 | milliseconds.

use crate::types::{AbortCode, Duration, NodeId};

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
    let Some(node) = monitored(value) else { return Ok(()) };
    let is_same = |value: &u32| monitored(*value) == Some(node);
    let twice = present.iter().enumerate().any(|(other, value)| other != place && is_same(value));
    if twice { Err(AbortCode::ParameterIncompatible) } else { Ok(()) }
}

/// Returns the node that an entry of 1016h monitors. `None` if the entry is not in use: its time is zero, or its
/// Node-ID is not in 1 to 127 (CiA 301 7.5.2.15).
///
/// ```
/// use async_canopen::heartbeat::machine::monitored;
/// use async_canopen::types::NodeId;
///
/// assert_eq!(monitored(0x0003_00FA), Some(NodeId::of::<3>())); // 250 ms
/// assert_eq!([monitored(0x0003_0000), monitored(0x0000_00FA), monitored(0x0080_00FA)], [None; 3]);
/// ```
pub const fn monitored(entry: u32) -> Option<NodeId> {
    if entry as u16 == 0 { None } else { NodeId::new((entry >> 16) as u8) }
}

/// Returns the consumer time of `node`. `None`: no entry names it.
pub fn time_of(entries: &[u32], node: NodeId) -> Option<Duration> {
    let entry = entries.iter().find(|entry| monitored(**entry) == Some(node))?;
    Some(Duration::from_millis(u64::from(entry & 0xFFFF)))
}

/// Returns the longest consumer time of all nodes. `None`: no entry names a node.
pub fn longest_time(entries: &[u32]) -> Option<Duration> {
    let in_use = entries.iter().filter(|entry| monitored(**entry).is_some());
    let longest = in_use.map(|entry| *entry as u16).max()?;
    Some(Duration::from_millis(u64::from(longest)))
}
