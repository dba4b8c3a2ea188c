//! Frames of this system: data frames with an 11-bit identifier.
//!
//! Remote and extended frames cannot be expressed. Ports filter those of other systems.

use thiserror::Error;

use crate::types::CobId;

/// CAN 2.0A data frame. It is aligned to words, so that it is moved in words.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(align(4))]
pub struct Frame {
    id: CobId,
    len: u8,
    /// Bytes at and above `len` are zero, so that equal frames compare equal.
    data: [u8; 8],
}

/// Error: the frame cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FrameError {
    /// There are more than 8 data bytes.
    #[error("a CAN frame has at most 8 data bytes")]
    TooLong,
}

impl Frame {
    /// Makes a frame with up to 8 data bytes.
    ///
    /// # Errors
    /// [`FrameError::TooLong`] for more than 8.
    pub fn new(id: CobId, payload: &[u8]) -> Result<Frame, FrameError> {
        let mut data = [0; 8];
        let Some(head) = data.get_mut(..payload.len()) else { return Err(FrameError::TooLong) };
        head.copy_from_slice(payload);
        Ok(Frame { id, len: payload.len() as u8, data })
    }

    /// Makes a frame whose length is known at compile time. `N` above 8 does not compile.
    pub fn of<const N: usize>(id: CobId, payload: [u8; N]) -> Frame {
        const { assert!(N <= 8, "a CAN frame has at most 8 data bytes") };
        let mut data = [0; 8];
        if let Some(head) = data.first_chunk_mut() {
            *head = payload;
        }
        Frame { id, len: N as u8, data }
    }

    /// Makes a frame from the registers of a controller. DLC 9 to 15 mean 8 data bytes (ISO 11898-1 8.4.2.4).
    pub const fn from_dlc(id: CobId, dlc: u8, data: [u8; 8]) -> Frame {
        if dlc >= 8 {
            return Frame { id, len: 8, data };
        }
        let known = (1 << (8 * dlc)) - 1;
        Frame::of_bits(id, dlc, u64::from_le_bytes(data) & known)
    }

    /// From the bits of a PDO, which has none above its length.
    pub(crate) const fn of_bits(id: CobId, len: u8, bits: u64) -> Frame {
        Frame { id, len, data: bits.to_le_bytes() }
    }

    /// Returns the COB-ID.
    pub const fn id(&self) -> CobId {
        self.id
    }

    /// Returns the data bytes.
    pub fn data(&self) -> &[u8] {
        self.data.get(..usize::from(self.len)).unwrap_or(&self.data)
    }

    /// Returns the data if they are eight bytes.
    pub const fn full(&self) -> Option<&[u8; 8]> {
        if self.len == 8 { Some(&self.data) } else { None }
    }

    /// Returns the data as a number, the first byte lowest, zero above the length: the values of a PDO.
    pub const fn bits(&self) -> u64 {
        u64::from_le_bytes(self.data)
    }

    /// Returns the data length, `0..=8`.
    pub const fn dlc(&self) -> u8 {
        self.len
    }

    /// Returns all eight bytes, zero above the length, for the data registers of a controller.
    pub const fn padded(&self) -> [u8; 8] {
        self.data
    }
}

impl core::fmt::Debug for Frame {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:03X}#", self.id.raw())?;
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}
