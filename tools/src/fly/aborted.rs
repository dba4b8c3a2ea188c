//! Frames that a board aborted: it took them back before they were sent.
//!
//! A node aborts a frame when it leaves a bus, or when the frame is out of date. The emulated controller knows the result of the
//! latest attempt to send it.

use std::collections::BTreeMap;

use can_twin::bxcan::Attempt;
use can_twin::wire::frame::WireId;
use serde::Serialize;

use super::flight::Flight;
use super::record::{Node, seconds};

/// Aborted frames of a board with one COB-ID on one bus.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AbortedFrames {
    /// Board that aborted them.
    pub node: Node,
    /// Bus on which they waited.
    pub bus: &'static str,
    /// COB-ID, for example `701h`.
    pub cob_id: String,
    /// Number of frames.
    pub frames: u64,
    /// Frames whose latest attempt ended with an error, for example because no node acknowledged it.
    pub failed: u64,
    /// Frames whose latest attempt lost the arbitration.
    pub arbitration_lost: u64,
    /// Frames that the controller never tried to send.
    pub not_attempted: u64,
    /// Time of the first abort, virtual seconds.
    pub first_at_seconds: f64,
    /// Time of the last abort, virtual seconds.
    pub last_at_seconds: f64,
}

/// Returns the aborted frames of a flight by board, bus and COB-ID.
pub fn by_cob_id(flight: &Flight) -> Vec<AbortedFrames> {
    let mut found: BTreeMap<(Node, usize, String), AbortedFrames> = BTreeMap::new();
    for (node, frame) in
        flight.boards.iter().flat_map(|board| board.aborted.iter().map(|frame| (board.node, frame)))
    {
        let cob_id = match frame.id {
            WireId::Standard(id) => format!("{id:03X}h"),
            WireId::Extended(id) => format!("{id:08X}h"),
        };
        let at = seconds(frame.at);
        let entry =
            found.entry((node, frame.bus as usize, cob_id.clone())).or_insert_with(|| AbortedFrames {
                node,
                bus: frame.bus.name(),
                cob_id,
                frames: 0,
                failed: 0,
                arbitration_lost: 0,
                not_attempted: 0,
                first_at_seconds: at,
                last_at_seconds: at,
            });
        entry.frames += 1;
        match frame.last {
            Some(Attempt::ArbitrationLost) => entry.arbitration_lost += 1,
            Some(_) => entry.failed += 1,
            None => entry.not_attempted += 1,
        }
        entry.first_at_seconds = entry.first_at_seconds.min(at);
        entry.last_at_seconds = entry.last_at_seconds.max(at);
    }
    found.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::sample;

    /// Given two heartbeats of the master that no node acknowledged and a command that it did not try to send, then each COB-ID has its
    /// number, results and times.
    #[test]
    fn aborted_frames_are_counted_by_cob_id() {
        let found = by_cob_id(&sample::flight());
        let [command, heartbeat] = &found[..] else { panic!("{found:?}") };
        assert_eq!((command.node, command.bus, &*command.cob_id), (1, "nominal", "302h"));
        assert_eq!((command.frames, command.failed, command.not_attempted), (1, 0, 1));
        assert_eq!((&*heartbeat.cob_id, heartbeat.frames, heartbeat.failed), ("701h", 2, 2));
        assert_eq!((heartbeat.arbitration_lost, heartbeat.not_attempted), (0, 0));
        assert_eq!((heartbeat.first_at_seconds, heartbeat.last_at_seconds), (20.1, 20.35));
    }
}
