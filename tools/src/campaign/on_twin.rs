//! The twin: the images that are flashed, on emulated boards.
//!
//! The log and the memory of a board show its events. In contrast to the host's world, the creation time of a command
//! and Bdefault of a slave are not known.

mod log;
mod spacecraft;
mod watched;

use can_twin::guest::Presence;
use can_twin::spacecraft::{BoardId, Event, GuestId, LogRecord, Spacecraft};
use can_twin::wire::fault::Fault;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;
use ecss_can::types::{Bus, NodeId, PerBus, Scet};
use ecss_can_worlds::NodeKey;
pub use spacecraft::prepare;
use watched::Watched;

use crate::campaign::flight::BABBLED;
use crate::campaign::scene::{News, Noted, Reading, Scene, Sent};
use crate::campaign::script::Script;

/// Boards on both buses.
pub struct Twin {
    spacecraft: Spacecraft,
    guests: PerBus<GuestId>,
    news: Vec<Noted>,
    frames: PerBus<Vec<Sent>>,
    clocks: Vec<Reading>,
    wrongs: Vec<String>,
    /// Observed state of each board.
    boards: Vec<Watched>,
}

impl Twin {
    /// The spacecraft of a script.
    ///
    /// # Panics
    /// Without [`prepare`] for its number of masters before.
    pub fn new(script: &Script) -> Twin {
        let (spacecraft, guests) = spacecraft::spacecraft(script);
        let nodes = (1..=script.slaves + 1).filter_map(NodeId::new).map(NodeKey::from);
        let second = (script.masters == 2).then_some(NodeKey::SECOND_MASTER);
        Twin {
            spacecraft,
            guests,
            news: Vec::new(),
            frames: PerBus::default(),
            clocks: Vec::new(),
            wrongs: Vec::new(),
            boards: nodes.chain(second).map(Watched::new).collect(),
        }
    }

    /// Returns the node at an index of both wires; `None` for a foreign node.
    fn key(&self, index: usize) -> Option<NodeKey> {
        self.boards.get(index).map(|board| board.key)
    }

    fn note(&mut self, key: NodeKey, news: News) {
        self.news.push(Noted { at: self.spacecraft.now(), key, news });
    }

    fn read_wires(&mut self) {
        for wire in self.spacecraft.take_frames() {
            let Some(bus) = here(wire.bus) else { continue };
            match wire.record {
                Observation::Completed { trace, receivers, .. } => {
                    let (key, id) = (self.key(trace.transmitter), standard(&trace.frame));
                    let sent =
                        Sent { start: trace.start, end: trace.end, key, id, receivers: receivers.len() };
                    self.frames[bus].push(sent);
                    self.read_clock(&sent, &trace.frame);
                    self.read_command(&trace.frame, &receivers);
                }
                Observation::Destroyed { frame, receivers, .. } => self.read_command(&frame, &receivers),
                Observation::ReceivedLate { at, node, frame, .. } => self.read_command(&frame, &[(node, at)]),
                _ => {}
            }
        }
    }

    /// Reads the time of a slave at the last SYNC.
    fn read_clock(&mut self, sent: &Sent, frame: &WireFrame) {
        let Some(node) = sent.key.map(NodeKey::node) else { return };
        if let Some(scet) = clock(node, sent.id, frame.payload()) {
            self.clocks.push(Reading { at: sent.start, node, scet });
        }
    }

    fn read_command(&mut self, frame: &WireFrame, receivers: &[(usize, Time)]) {
        for &(index, at) in receivers {
            let Some(board) = self.boards.get_mut(index) else { continue };
            let node = board.key.node();
            if node != NodeId::MASTER && standard(frame) == Some(0x300 + u16::from(node.get())) {
                board.on_command(frame, at);
            }
        }
    }

    fn read_logs(&mut self) {
        for LogRecord { at, board, text, .. } in self.spacecraft.take_logs() {
            let Some(watched) = self.boards.get_mut(board.0) else { continue };
            let key = watched.key;
            if let Some(news) = log::news(key, &text) {
                if news == News::PowerOn {
                    watched.on_start();
                }
                self.news.push(Noted { at, key, news });
            }
        }
    }

    fn read_boards(&mut self) {
        let at = self.spacecraft.now();
        for (id, board) in self.spacecraft.boards() {
            self.wrongs.append(&mut self.boards[id.0].look(board, at));
        }
    }
}

impl Scene for Twin {
    fn now(&self) -> Time {
        self.spacecraft.now()
    }

    fn run_until(&mut self, end: Time) {
        // A board stopped by a refused access stays stopped, which is a violation.
        while self.spacecraft.run_until(end).is_err() {}
    }

    fn take_news(&mut self) -> Vec<Noted> {
        self.read_logs();
        let mut news = std::mem::take(&mut self.news);
        news.sort_by_key(|noted| noted.at);
        news
    }

    fn take_frames(&mut self) -> PerBus<Vec<Sent>> {
        self.read_wires();
        std::mem::take(&mut self.frames)
    }

    fn take_clocks(&mut self) -> Vec<Reading> {
        std::mem::take(&mut self.clocks)
    }

    fn take_wrongs(&mut self) -> Vec<String> {
        self.read_boards();
        std::mem::take(&mut self.wrongs)
    }

    fn disturbance(&self, bus: Bus) -> u64 {
        let counters = self.spacecraft.wire(there(bus)).counters();
        counters.destroyed + counters.ack_errors
    }

    fn is_busy(&self, bus: Bus) -> bool {
        !self.spacecraft.wire(there(bus)).is_idle(0)
    }

    fn is_powered(&self, key: NodeKey) -> bool {
        self.boards[self.index(key)].is_powered
    }

    fn power(&mut self, key: NodeKey, on: bool) {
        let index = self.index(key);
        self.boards[index].is_powered = on;
        self.spacecraft.schedule(self.spacecraft.now(), BoardId(index), Event::Power(on));
        if !on {
            self.note(key, News::PowerOff);
        }
    }

    fn reset(&mut self, key: NodeKey) {
        self.spacecraft.reset(BoardId(self.index(key)));
        self.note(key, News::PowerOff);
    }

    fn nodes(&self) -> usize {
        self.boards.len()
    }

    fn index(&self, key: NodeKey) -> usize {
        let at = self.boards.iter().position(|board| board.key == key);
        at.expect("a board of the script")
    }

    fn strike(&mut self, bus: Bus, fault: Fault) {
        let now = self.spacecraft.now();
        self.spacecraft.wire_mut(there(bus)).schedule(now, fault).expect("a fault of this wire");
    }

    fn inject(&mut self, bus: Bus, frame: WireFrame) {
        let (guest, now) = (self.guests[bus], self.spacecraft.now());
        self.spacecraft.set_presence(guest, Presence::Present);
        self.spacecraft.inject(guest, now, frame);
    }
}

fn there(bus: Bus) -> can_twin::spacecraft::Bus {
    match bus {
        Bus::Nominal => can_twin::spacecraft::Bus::Nominal,
        Bus::Redundant => can_twin::spacecraft::Bus::Redundant,
    }
}

fn here(bus: can_twin::spacecraft::Bus) -> Option<Bus> {
    Bus::ALL.into_iter().find(|other| there(*other) == bus)
}

fn standard(frame: &WireFrame) -> Option<u16> {
    match frame.id {
        WireId::Standard(id) => Some(id),
        WireId::Extended(_) => None,
    }
}

/// Returns the time in the first TPDO of a slave. Frames of a babbling controller do not count.
fn clock(node: NodeId, id: Option<u16>, payload: &[u8]) -> Option<Scet> {
    let is_telemetry = node != NodeId::MASTER && id == Some(0x180 + u16::from(node.get()));
    if is_telemetry && payload != BABBLED { Scet::decode(payload) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_node_babbles_is_not_the_time_of_a_slave() {
        let time = [0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0, 1];
        let slave = NodeId::of::<3>();
        assert_eq!(clock(slave, Some(0x183), &time), Scet::decode(&time));
        assert!(clock(slave, Some(0x183), &time).is_some());
        assert_eq!(clock(slave, Some(0x183), &BABBLED), None);
        assert_eq!(clock(slave, Some(0x283), &time), None);
        assert_eq!(clock(slave, Some(0x182), &time), None);
        assert_eq!(clock(NodeId::MASTER, Some(0x181), &time), None);
        assert_eq!(clock(slave, Some(0x183), &time[..3]), None);
    }
}
