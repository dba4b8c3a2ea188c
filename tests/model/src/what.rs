//! What a slave reports, as slaves and masters know it.

use ecss_can::emcy::ErrorCode;
use ecss_can::types::{CobId, NodeId};

/// What a slave reports: one is searched without the other, because neither depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum What {
    /// An error, which appears, is gone, and appears again.
    Error,
    /// A value that is declared as a state. It changes once.
    Value,
}

/// The error.
pub const ERROR: ErrorCode = ErrorCode::TEMPERATURE_DEVICE;
/// Its source.
pub const SOURCE: u8 = 1;

/// COB-ID of the transmit PDO with the value.
pub fn value_id(node: NodeId) -> CobId {
    CobId::new(0x280 + u16::from(node.get())).expect("a COB-ID")
}
