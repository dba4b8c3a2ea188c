//! Objects 1029h and 1F80h, and the rules for writing them.

use super::{ErrorBehaviour, NmtStartup};
use crate::od::Objects;
use crate::types::{AbortCode, Address};

/// Objects of network management (1029h, 1F80h).
#[doc(alias("1029h", "1F80h"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct NmtObjects {
    /// Error behaviour
    ///
    /// Communication error: 0 pre-operational, 1 no change, 2 stopped.
    #[object(0x1029, array, rw, high = 2)]
    pub error_behaviour: [u8; 1],
    /// NMT startup
    ///
    /// Bit 0: NMT master. Bit 2: not to Operational without a command. A stored value holds from the next
    /// reset on.
    #[object(0x1F80, rw, default = NmtStartup::of_slave(false).raw())]
    pub startup: u32,
}

const ERROR_BEHAVIOUR: u16 = NmtObjects::ERROR_BEHAVIOUR.index();
const STARTUP: u16 = NmtObjects::STARTUP.index();

impl NmtObjects {
    /// Returns the reaction to a communication error.
    pub(crate) fn error_behaviour(&self) -> ErrorBehaviour {
        let [behaviour] = self.error_behaviour;
        ErrorBehaviour::from_byte(behaviour).unwrap_or_default()
    }

    /// Returns how the node enters Operational after its boot-up.
    pub(crate) const fn startup(&self) -> NmtStartup {
        NmtStartup::from_raw(self.startup)
    }

    /// Checks a `value` that a client writes. Accepts every value for objects of other services.
    ///
    /// # Errors
    /// As [`ErrorBehaviour::from_byte`] and [`NmtStartup::written`].
    pub(crate) fn may_write(&self, at: Address, value: u32) -> Result<(), AbortCode> {
        match at.index {
            ERROR_BEHAVIOUR => ErrorBehaviour::from_byte(value as u8).map(drop),
            STARTUP => NmtStartup::from_raw(value).written(self.startup()),
            _ => Ok(()),
        }
    }
}
