//! NMT startup, object 1F80h (CiA 302-2): how a node goes to Operational after its boot-up.

use crate::types::AbortCode;

/// View of the object. A slave obeys bit 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NmtStartup(u32);

impl NmtStartup {
    /// The value of a master: it starts each slave by itself.
    pub const MASTER: NmtStartup = NmtStartup(1);

    /// Bit 2: do not enter Operational automatically.
    const ON_COMMAND: u32 = 1 << 2;

    /// The value of a slave.
    pub const fn of_slave(autostart: bool) -> NmtStartup {
        NmtStartup(if autostart { 0 } else { Self::ON_COMMAND })
    }

    /// As it is stored.
    pub const fn from_raw(raw: u32) -> NmtStartup {
        NmtStartup(raw)
    }

    /// As it is stored.
    pub const fn raw(self) -> u32 {
        self.0
    }

    /// Whether it may replace `present`: a slave has bit 2 to choose, a master nothing.
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`].
    pub const fn written(self, present: NmtStartup) -> Result<(), AbortCode> {
        let free = if present.0 == Self::MASTER.0 { 0 } else { Self::ON_COMMAND };
        if (self.0 ^ present.0) & !free == 0 { Ok(()) } else { Err(AbortCode::ValueRange) }
    }

    /// Whether the node goes on to Operational by itself (CiA 301 7.3.2.2.1, ECSS Table 11-1).
    pub const fn autostart(self) -> bool {
        self.0 & Self::ON_COMMAND == 0
    }
}
