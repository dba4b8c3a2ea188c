//! Error behaviour, object 1029h sub-index 1: what a communication error does to the NMT state.

use crate::types::AbortCode;

/// Reaction to a communication error. A missed master always leads to Pre-operational (ECSS 8.3.3e.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum ErrorBehaviour {
    /// Pre-operational when Operational.
    #[default]
    PreOperational = 0,
    /// No change of state.
    Unchanged = 1,
    /// Stopped.
    Stopped = 2,
}

impl ErrorBehaviour {
    /// From the value of the object.
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`] for values that CiA 301 reserves.
    pub const fn from_byte(byte: u8) -> Result<ErrorBehaviour, AbortCode> {
        match byte {
            0 => Ok(ErrorBehaviour::PreOperational),
            1 => Ok(ErrorBehaviour::Unchanged),
            2 => Ok(ErrorBehaviour::Stopped),
            _ => Err(AbortCode::ValueRange),
        }
    }
}
