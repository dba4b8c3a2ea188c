//! NMT startup, object 1F80h (CiA 302-2): how a node goes to Operational after its boot-up.

/// View of the object. A slave obeys bit 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NmtStartup(u32);

impl NmtStartup {
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

    /// Whether the node goes on to Operational by itself (CiA 301 7.3.2.2.1, ECSS Table 11-1).
    pub const fn autostart(self) -> bool {
        self.0 & Self::ON_COMMAND == 0
    }
}
