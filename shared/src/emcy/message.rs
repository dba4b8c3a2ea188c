//! The emergency message (CiA 301 7.2.7.2): error code, error register, five bytes of the manufacturer.

use super::{ErrorCode, ErrorRegister};
use crate::types::{CobId, Frame, NodeId};

/// What an emergency message tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Emergency {
    /// The error; [`ErrorCode::NO_ERROR`] when one is gone.
    pub code: ErrorCode,
    /// What was active when the message was made.
    pub register: ErrorRegister,
    /// Manufacturer-specific error field.
    pub info: [u8; 5],
}

impl Emergency {
    /// The frame, 8 data bytes.
    pub fn encode(self, id: CobId) -> Frame {
        let [low, high] = self.code.get().to_le_bytes();
        let [a, b, c, d, e] = self.info;
        Frame::of(id, [low, high, self.register.bits(), a, b, c, d, e])
    }

    /// That of any node, with the node by the pre-defined COB-ID. `None` when malformed: length other than 8, or no
    /// EMCY at all.
    pub fn decode(frame: &Frame) -> Option<(NodeId, Emergency)> {
        let id = frame.id();
        let node = id.node().filter(|_| id.function() == CobId::SYNC.function())?;
        let &[low, high, register, a, b, c, d, e] = frame.data() else { return None };
        let emergency = Emergency {
            code: ErrorCode::new(u16::from_le_bytes([low, high])),
            register: ErrorRegister::from_bits(register),
            info: [a, b, c, d, e],
        };
        Some((node, emergency))
    }
}
