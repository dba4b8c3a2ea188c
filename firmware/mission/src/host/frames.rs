//! Prints frames: all in the format of candump, or a selection as text.

use std::collections::HashMap;

use ecss_can::mock::SentFrame;
use ecss_can::types::{Bus, CobId, Duration, Frame, Instant, NmtState};
use ecss_can::{heartbeat, types::NodeId};

use super::Console;
use crate::{Command, Message, Telemetry};

/// Least time between lines of one COB-ID on one bus.
const PERIOD: Duration = Duration::from_millis(1_000);

/// Prints frames.
#[derive(Debug)]
pub struct Frames {
    is_candump: bool,
    shown: HashMap<(Bus, CobId), Shown>,
}

/// The last printed frame of a COB-ID.
#[derive(Clone, Copy, Debug)]
struct Shown {
    at: Instant,
    /// NMT state, if it is a heartbeat.
    state: Option<NmtState>,
}

impl Frames {
    /// Makes a printer of every frame in the format of candump, or of a selection as text.
    pub fn new(is_candump: bool) -> Frames {
        Frames { is_candump, shown: HashMap::new() }
    }

    /// Prints a frame if it is selected: the first of its COB-ID on its bus within a second, or a heartbeat whose state
    /// differs from the one before.
    pub fn show(&mut self, console: &Console, sent: &SentFrame) {
        let SentFrame { at, bus, frame } = sent;
        if self.is_candump {
            let us = at.as_micros();
            return console.raw(format_args!(
                "({:010}.{:06}) {} {frame:?}",
                us / 1_000_000,
                us % 1_000_000,
                name(*bus)
            ));
        }
        let Some(text) = describe(frame) else { return };
        let shown = Shown { at: *at, state: state(frame) };
        let last = self.shown.get(&(*bus, frame.id()));
        if last.is_none_or(|last| last.at + PERIOD <= *at || last.state != shown.state) {
            self.shown.insert((*bus, frame.id()), shown);
            console.line(name(*bus), text);
        }
    }
}

fn name(bus: Bus) -> &'static str {
    match bus {
        Bus::Nominal => "nominal",
        Bus::Redundant => "redundant",
    }
}

fn state(frame: &Frame) -> Option<NmtState> {
    (frame.id().raw() > 0x700).then(|| heartbeat::decode(frame)).flatten()
}

/// Describes a heartbeat, a SYNC, a command or telemetry of the mission. Returns `None` for other frames.
fn describe(frame: &Frame) -> Option<String> {
    let (id, node) = (frame.id().raw(), frame.id().node().map(NodeId::get));
    match (id & 0x780, node) {
        (0x080, None) => Some("SYNC".into()),
        (0x300, Some(node)) => {
            let command = Message::decode(frame).as_ref().and_then(Command::decode);
            Some(format!("TC to node {node}: {}", command.map_or("unknown".into(), |it| format!("{it:?}"))))
        }
        (0x380, Some(node)) => {
            let telemetry = Message::decode(frame).as_ref().and_then(Telemetry::decode);
            Some(format!("TM of node {node}: {}", telemetry.map_or("unknown".into(), |it| format!("{it:?}"))))
        }
        (0x700, Some(node)) => match state(frame)? {
            NmtState::Initialising => Some(format!("boot-up of node {node}")),
            state => Some(format!("heartbeat of node {node}: {state:?}")),
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(id: u16, data: &[u8]) -> Option<String> {
        describe(&Frame::new(CobId::new(id).unwrap(), data).unwrap())
    }

    /// COB-IDs and bytes are those of CiA 301 and of the mission's data sheets.
    ///
    /// Verifies: ECSS 6.5.2a
    #[test]
    fn frames_of_interest_are_described() {
        let cases: [(u16, &[u8], Option<&str>); 11] = [
            (0x080, &[], Some("SYNC")),
            (0x701, &[0x05], Some("heartbeat of node 1: Operational")),
            (0x703, &[0x7F], Some("heartbeat of node 3: PreOperational")),
            (0x703, &[0x85], Some("heartbeat of node 3: Operational")),
            (0x703, &[0x80], None),
            (0x703, &[0x00], Some("boot-up of node 3")),
            (0x302, &[1, 0, 1, 0, 0, 0, 0, 7], Some("TC to node 2: SetLed(true)")),
            (0x302, &[9, 9, 0, 0, 0, 0, 0, 0], Some("TC to node 2: unknown")),
            (0x382, &[2, 1, 5, 0, 0, 0, 0, 0], Some("TM of node 2: Value(5)")),
            (0x082, &[0; 8], None),
            (0x181, &[0; 7], None),
        ];
        for (id, data, expected) in cases {
            assert_eq!(text(id, data).as_deref(), expected, "{id:03X}");
        }
    }
}
