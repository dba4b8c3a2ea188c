//! Commands and telemetry in one PDO each: a 2-byte code and 6 bytes of data.
//!
//! Telecommand (object 6200h), telemetry request and telemetry (objects 6101h, 6100h) share this layout. The last data
//! byte of a telecommand is its sequence: see [`RepeatFilter`](ecss_can::pdo::RepeatFilter).

use ecss_can::od::{U40, U48};
use ecss_can::types::{CobId, Frame};

/// A telecommand, a telemetry request, or telemetry. Aligned to words, so that it is copied by words.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(align(4))]
pub struct Message {
    code: u16,
    data: [u8; Message::DATA],
}

impl Message {
    /// Number of data bytes besides the code.
    pub const DATA: usize = 6;

    /// Makes a message from code and data.
    pub const fn new(code: u16, data: [u8; Self::DATA]) -> Message {
        Message { code, data }
    }

    /// Makes a message from up to 6 data bytes; the rest is zero. `N` above 6 does not compile.
    pub fn of<const N: usize>(code: u16, payload: [u8; N]) -> Message {
        const { assert!(N <= Self::DATA, "a PDO has 6 bytes beside its code") };
        let mut data = [0; Self::DATA];
        for (slot, byte) in data.iter_mut().zip(payload) {
            *slot = byte;
        }
        Message { code, data }
    }

    /// Returns the code of the command or of the telemetry.
    pub const fn code(&self) -> u16 {
        self.code
    }

    /// Returns the data besides the code.
    pub const fn data(&self) -> [u8; Self::DATA] {
        self.data
    }

    /// Returns code and data as in the PDOs of requests and telemetry.
    pub fn values(&self) -> (u16, U48) {
        let [a, b, c, d, e, f] = self.data;
        (self.code, U48::new(u64::from_le_bytes([a, b, c, d, e, f, 0, 0])))
    }

    /// Returns code, data and sequence as in the PDO of telecommands.
    pub fn telecommand(&self) -> (u16, U40, u8) {
        let [a, b, c, d, e, sequence] = self.data;
        (self.code, U40::new(u64::from_le_bytes([a, b, c, d, e, 0, 0, 0])), sequence)
    }

    /// Returns the frame of the PDO: code little-endian, then data.
    pub fn encode(&self, id: CobId) -> Frame {
        let [low, high] = self.code.to_le_bytes();
        let [a, b, c, d, e, f] = self.data;
        Frame::of(id, [low, high, a, b, c, d, e, f])
    }

    /// Returns the message of a frame. `None` if it is shorter than code and data.
    pub fn decode(frame: &Frame) -> Option<Message> {
        Self::from_payload(frame.data())
    }

    /// Makes a message from a payload of 2 to 8 bytes; missing bytes are zero (ECSS Figure 9-2). Returns `None` for any
    /// other length.
    pub fn from_start(payload: &[u8]) -> Option<Message> {
        let mut padded = [0; 2 + Self::DATA];
        padded.get_mut(..payload.len())?.copy_from_slice(payload);
        if payload.len() < 2 { None } else { Self::from_payload(&padded) }
    }

    /// Makes a message from the payload of a PDO. Returns `None` if it is shorter than code and data.
    pub fn from_payload(payload: &[u8]) -> Option<Message> {
        let &[low, high, a, b, c, d, e, f] = payload else { return None };
        Some(Message { code: u16::from_le_bytes([low, high]), data: [a, b, c, d, e, f] })
    }
}

impl core::fmt::Debug for Message {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:04X}:", self.code)?;
        self.data.iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}
