//! Commands and telemetry in one PDO each: a 2-byte code and up to 6 bytes of data.
//!
//! Telecommand (object 6200h), telemetry request and telemetry (object 6100h) share this layout.

use crate::link::{CobId, Frame};

/// A telecommand, a telemetry request, or telemetry. Aligned to words, so that it moves in words.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(align(4))]
pub struct Message {
    code: u16,
    len: u8,
    /// Bytes at and above `len` are zero, so that equal messages compare equal.
    data: [u8; Message::MAX_DATA],
}

impl Message {
    /// Most data bytes beside the code.
    pub const MAX_DATA: usize = 6;

    /// `None` for more than [`Message::MAX_DATA`] bytes of data.
    pub fn new(code: u16, payload: &[u8]) -> Option<Message> {
        let mut data = [0; Self::MAX_DATA];
        data.get_mut(..payload.len())?.copy_from_slice(payload);
        Some(Message { code, len: payload.len() as u8, data })
    }

    /// A message whose length is known at compile time; `N` above 6 does not compile.
    pub fn of<const N: usize>(code: u16, payload: [u8; N]) -> Message {
        const { assert!(N <= Self::MAX_DATA, "a PDO has at most 6 bytes beside its code") };
        let mut data = [0; Self::MAX_DATA];
        for (slot, byte) in data.iter_mut().zip(payload) {
            *slot = byte;
        }
        Message { code, len: N as u8, data }
    }

    /// What it is about.
    pub const fn code(&self) -> u16 {
        self.code
    }

    /// The data beside the code.
    pub fn data(&self) -> &[u8] {
        self.data.get(..usize::from(self.len)).unwrap_or(&self.data)
    }

    /// The PDO: code little-endian, then data.
    pub fn encode(&self, id: CobId) -> Frame {
        let [low, high] = self.code.to_le_bytes();
        let [a, b, c, d, e, f] = self.data;
        Frame::from_dlc(id, self.len.saturating_add(2), [low, high, a, b, c, d, e, f])
    }

    /// `None` when malformed: shorter than the code.
    pub fn decode(frame: &Frame) -> Option<Message> {
        let (code, data) = frame.data().split_first_chunk::<2>()?;
        Message::new(u16::from_le_bytes(*code), data)
    }
}

impl core::fmt::Debug for Message {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:04X}:", self.code)?;
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}
