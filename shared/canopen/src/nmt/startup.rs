//! NMT startup, object 1F80h (CiA 302-2): how a node enters Operational after its boot-up.

use crate::types::AbortCode;

/// View of object 1F80h. A slave obeys bit 2.
#[doc(alias("1F80h", "NMT startup"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NmtStartup(u32);

impl NmtStartup {
    /// Value of a master that starts each slave individually.
    pub const MASTER: NmtStartup = NmtStartup(1);

    /// Bit 2: do not enter Operational automatically.
    const ON_COMMAND: u32 = 1 << 2;

    /// Returns the value of a slave.
    pub const fn of_slave(autostart: bool) -> NmtStartup {
        NmtStartup(if autostart { 0 } else { Self::ON_COMMAND })
    }

    /// Views the value of the object.
    pub const fn from_raw(raw: u32) -> NmtStartup {
        NmtStartup(raw)
    }

    /// Returns the value of the object.
    pub const fn raw(self) -> u32 {
        self.0
    }

    /// Checks that a client may replace `present` by this value. In a slave only bit 2 may change, in a master no bit.
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`] for any other change.
    pub const fn written(self, present: NmtStartup) -> Result<(), AbortCode> {
        let free = if present.0 == Self::MASTER.0 { 0 } else { Self::ON_COMMAND };
        if (self.0 ^ present.0) & !free == 0 { Ok(()) } else { Err(AbortCode::ValueRange) }
    }

    /// Returns whether the node enters Operational by itself (CiA 301 7.3.2.2.1).
    pub const fn autostart(self) -> bool {
        self.0 & Self::ON_COMMAND == 0
    }
}
