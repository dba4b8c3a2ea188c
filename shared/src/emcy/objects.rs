//! Object 1003h.

use crate::od::Record;

/// Pre-defined error field (1003h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct ErrorField {
    /// Number of errors
    #[sub(0, rw, volatile)]
    pub count: u8,
    /// Standard error field
    ///
    /// The newest first: error code in the low half, information of the manufacturer in the high one.
    #[sub(1.., ro)]
    pub errors: [u32; 8],
}
