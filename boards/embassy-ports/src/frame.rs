//! Frames and errors of embassy-stm32.

use async_canopen::link::port::LastError;
use async_canopen::types::{CobId, Frame};
use embassy_stm32::can;
use embassy_stm32::can::enums::BusError;
use embedded_can::Id;

/// Converts a frame to the driver's type.
pub fn to_driver(frame: &Frame) -> Option<can::Frame> {
    can::Frame::new_standard(frame.id().raw(), frame.data()).ok()
}

/// Converts a data frame with an 11-bit identifier. Returns `None` for any other frame.
pub fn from_driver(frame: &can::Frame) -> Option<Frame> {
    let header = frame.header();
    let Id::Standard(id) = *header.id() else { return None };
    if header.rtr() {
        return None;
    }
    Frame::new(CobId::new(id.as_raw())?, frame.data()).ok()
}

/// Converts the cause of an error. `BitRecessive` of the driver: a dominant level was sent and a recessive one was
/// read.
pub fn cause(error: &BusError) -> LastError {
    match error {
        BusError::Stuff => LastError::Stuff,
        BusError::Form => LastError::Form,
        BusError::Acknowledge => LastError::Ack,
        BusError::BitRecessive => LastError::BitRecessive,
        BusError::BitDominant => LastError::BitDominant,
        BusError::Crc => LastError::Crc,
        BusError::Software => LastError::None,
    }
}
