//! Short forms of the values that tests write most.

use async_canopen::types::{Bus, CobId, Duration, Frame, Instant, NodeId};

pub const NOMINAL: Bus = Bus::Nominal;
pub const REDUNDANT: Bus = Bus::Redundant;

pub fn ms(ms: u64) -> Instant {
    Instant::from_micros(ms * 1_000)
}

pub fn span(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

pub fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(CobId::new(id).unwrap(), data).unwrap()
}

pub fn node(raw: u8) -> NodeId {
    NodeId::new(raw).unwrap()
}
