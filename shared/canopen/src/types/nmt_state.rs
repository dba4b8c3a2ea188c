//! NMT states and their heartbeat bytes (CiA 301 7.2.8.3.2.2, 7.3.2.2).

/// NMT state of a node, with the byte that its heartbeat carries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum NmtState {
    /// The node sends nothing but its boot-up message, which carries this byte.
    #[default]
    Initialising = 0x00,
    /// Only heartbeat and module control work.
    Stopped = 0x04,
    /// All services work.
    Operational = 0x05,
    /// All services but PDOs work.
    PreOperational = 0x7F,
}

impl NmtState {
    /// Returns the state of the byte of a heartbeat. `None` for a byte that CiA 301 does not define.
    ///
    /// Bit 7 is reserved, and some nodes set it: it is the toggle bit of node guarding. It is ignored, but not in 80h: a
    /// node that was not reset must not look as if it was.
    pub const fn from_byte(byte: u8) -> Option<NmtState> {
        match byte {
            0x00 => Some(NmtState::Initialising),
            0x04 | 0x84 => Some(NmtState::Stopped),
            0x05 | 0x85 => Some(NmtState::Operational),
            0x7F | 0xFF => Some(NmtState::PreOperational),
            _ => None,
        }
    }

    /// Returns the byte of the heartbeat.
    pub const fn byte(self) -> u8 {
        self as u8
    }

    /// Returns whether PDOs are sent and obeyed (CiA 301 table 37).
    pub const fn allows_pdo(self) -> bool {
        matches!(self, NmtState::Operational)
    }

    /// Returns whether SYNC is produced and consumed.
    pub const fn allows_sync(self) -> bool {
        matches!(self, NmtState::Operational | NmtState::PreOperational)
    }

    /// Returns whether SDOs are served.
    pub const fn allows_sdo(self) -> bool {
        self.allows_sync()
    }

    /// Returns whether EMCYs are sent.
    pub const fn allows_emcy(self) -> bool {
        self.allows_sync()
    }
}
