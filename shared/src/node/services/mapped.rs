//! The time in the mapping of a PDO.

use crate::node::index::{SCET_GET, SCET_SET, UTC_GET, UTC_SET};
use crate::pdo::Mapping;

/// Kind of time that a receive PDO carries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MappedTime {
    /// No time at all.
    #[default]
    None,
    /// SCET by object 2010h.
    Scet,
    /// UTC by object 2012h.
    Utc,
}

impl MappedTime {
    pub fn of(mapping: &impl Mapping) -> MappedTime {
        let indices = mapping.objects().iter().map(|object| (object >> 16) as u16);
        indices.fold(MappedTime::None, |kind, index| match index {
            SCET_SET => MappedTime::Scet,
            UTC_SET => MappedTime::Utc,
            _ => kind,
        })
    }
}

/// Returns whether a mapping has an object for which `is_it` holds.
pub fn has(mapping: &impl Mapping, is_it: impl Fn(u16) -> bool) -> bool {
    mapping.objects().iter().any(|object| is_it((object >> 16) as u16))
}

/// Returns whether a mapping has the local time.
pub fn carries_time(mapping: &impl Mapping) -> bool {
    has(mapping, is_local_time)
}

/// Returns whether the object with this index is the local time.
pub fn is_local_time(index: u16) -> bool {
    matches!(index, SCET_GET | UTC_GET)
}
