//! The report of a slave, shared by slaves and masters.

use ecss_can::emcy::ErrorCode;
use ecss_can::types::{CobId, NodeId};

/// Kind of a slave's report. Each kind is searched alone, because they are independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum What {
    /// An error, which starts, ends, and starts again.
    Error,
    /// A value that is declared as a state. It changes once.
    Value,
}

/// Code of the error.
pub const ERROR: ErrorCode = ErrorCode::TEMPERATURE_DEVICE;
/// Source of the error.
pub const SOURCE: u8 = 1;

/// COB-ID of the transmit PDO with the value.
pub fn value_id(node: NodeId) -> CobId {
    CobId::new(0x280 + u16::from(node.get())).expect("a COB-ID")
}
