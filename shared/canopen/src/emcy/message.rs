//! The emergency message (CiA 301 7.2.7.2): error code, error register, five bytes of the manufacturer.

use super::{ErrorCode, ErrorRegister};
use crate::types::{CobId, Frame, NodeId};

/// Content of an emergency message.
#[doc(alias = "EMCY")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Emergency {
    /// Error code, [`ErrorCode::NO_ERROR`] when an error is gone.
    pub code: ErrorCode,
    /// Error register (1001h) at the time of the message.
    pub register: ErrorRegister,
    /// Manufacturer-specific error field. In messages of this crate the first byte is the source of an error that
    /// appeared. For one that is gone see [`Emergency::ended`].
    pub info: [u8; 5],
}

impl Emergency {
    /// Makes the frame of the message, with 8 data bytes.
    pub fn encode(self, id: CobId) -> Frame {
        let [low, high] = self.code.get().to_le_bytes();
        let [a, b, c, d, e] = self.info;
        Frame::of(id, [low, high, self.register.bits(), a, b, c, d, e])
    }

    /// Returns code and source of the error that is gone, if the message says so as a
    /// [`Producer`](super::Producer) does. Other senders may give no code (CiA 301 leaves the field to them): then all
    /// errors outside the register are gone.
    pub fn ended(&self) -> Option<(ErrorCode, u8)> {
        let [low, high, source, ..] = self.info;
        let code = ErrorCode::new(u16::from_le_bytes([low, high]));
        (self.code == ErrorCode::NO_ERROR && code != ErrorCode::NO_ERROR).then_some((code, source))
    }

    /// Decodes the message of any node. The node follows from the pre-defined COB-ID. `None` if the length is not
    /// 8, or if the frame is not an EMCY.
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
