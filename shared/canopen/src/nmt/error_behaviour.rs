//! Error behaviour, object 1029h sub-index 1: reaction of the NMT state to a communication error.

use crate::types::AbortCode;

/// Reaction of a node to a communication error. A missed master always leads to Pre-operational.
#[doc(alias("1029h", "error behaviour"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum ErrorBehaviour {
    /// Change from Operational to Pre-operational.
    #[default]
    PreOperational = 0,
    /// Keep the present state.
    Unchanged = 1,
    /// Enter the state Stopped.
    Stopped = 2,
}

impl ErrorBehaviour {
    /// Converts the value of the object.
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
