//! Frames on a wire: every frame of ISO 11898-1, also those that nodes of this project never send.

/// Identifier of a frame. Its order is not that of arbitration, for which encoded bits have to be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WireId {
    /// 11 bits, `0..=0x7FF`.
    Standard(u16),
    /// 29 bits, `0..=0x1FFF_FFFF`.
    Extended(u32),
}

/// A frame as the wire carries it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct WireFrame {
    /// Identifier.
    pub id: WireId,
    /// Remote transmission request: no data field for any DLC.
    pub remote: bool,
    /// DLC as sent, `0..=15`; 9..15 mean 8 data bytes.
    pub dlc: u8,
    /// Data bytes; those at and above [`WireFrame::len`] are zero.
    pub data: [u8; 8],
}

impl WireFrame {
    /// A standard data frame.
    ///
    /// # Panics
    /// When `id` exceeds 11 bits or `data` 8 bytes: a mistake in a test, not an input.
    pub fn standard(id: u16, data: &[u8]) -> Self {
        assert!(id <= 0x7FF, "an 11-bit identifier is at most 7FFh, not {id:X}h");
        assert!(data.len() <= 8, "a CAN frame has at most 8 data bytes, not {}", data.len());
        let mut bytes = [0; 8];
        bytes[..data.len()].copy_from_slice(data);
        WireFrame { id: WireId::Standard(id), remote: false, dlc: data.len() as u8, data: bytes }
    }

    /// Number of data bytes on the wire, `0..=8`.
    pub fn len(&self) -> usize {
        if self.remote { 0 } else { usize::from(self.dlc.min(8)) }
    }

    /// Returns whether there are no data bytes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The data bytes on the wire.
    pub fn payload(&self) -> &[u8] {
        &self.data[..self.len()]
    }
}
