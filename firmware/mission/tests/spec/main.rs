//! The demonstration mission: profiles, PDOs of both images, commands and telemetry.

mod choice;
mod messages;
mod page;
mod pdos;
mod profiles;

use ecss_can::types::{CobId, Duration, Frame, Instant, NodeId};

fn ms(ms: u64) -> Instant {
    Instant::from_micros(ms * 1_000)
}

fn span(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(CobId::new(id).unwrap(), data).unwrap()
}

fn node(raw: u8) -> NodeId {
    NodeId::new(raw).unwrap()
}
