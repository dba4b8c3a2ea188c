//! Records what the machines of redundancy need for a replay.

use can_wire::time::Time;
use ecss_can::redundancy::Strap;
use ecss_can::types::{Bus, NodeId};
use host_worlds::NodeKey;
use replay::{BoardRecord, Entry, Part, Recording, What};
use twin::bxcan::Side;
use twin::spacecraft::{BoardId, Spacecraft};

/// The controllers of a pyboard: CAN1 is on the nominal bus.
const SIDES: [(Side, Bus); 2] = [(Side::Can1, Bus::Nominal), (Side::Can2, Bus::Redundant)];

/// Recorder of a run.
pub struct Recorder {
    recording: Recording,
}

impl Recorder {
    /// Begins to record these boards, which are those of the spacecraft.
    pub fn begin(spacecraft: &mut Spacecraft, keys: &[NodeKey]) -> Recorder {
        let is_pair = keys.contains(&NodeKey::SECOND_MASTER);
        let boards = keys.iter().enumerate().map(|(number, key)| {
            let board = spacecraft.board_mut(BoardId(number));
            board.keep_journal();
            let config = board.config();
            let part = match key.node() {
                NodeId::MASTER if key.is_second() => Part::Master(Some(Strap::Second)),
                NodeId::MASTER => Part::Master(is_pair.then_some(Strap::Prime)),
                node => Part::Slave(node),
            };
            let (name, ppm, uid) = (config.name.clone(), config.crystal.ppm, board.uid());
            BoardRecord { name, part, ppm, uid, entries: Vec::new() }
        });
        Recorder { recording: Recording { boards: boards.collect() } }
    }

    /// Adds a line of the log of board `number`.
    pub fn line(&mut self, number: usize, at: Time, text: &str) {
        let entry = Entry { at, what: What::Line(text.into()) };
        self.recording.boards[number].entries.push(entry);
    }

    /// Takes the recording.
    pub fn finish(mut self, spacecraft: &mut Spacecraft) -> Recording {
        for (number, record) in self.recording.boards.iter_mut().enumerate() {
            let board = spacecraft.board_mut(BoardId(number));
            for (side, bus) in SIDES {
                let journal = board.take_journal(side).into_iter();
                let entry = |(at, exchange)| Entry { at, what: What::Exchange(bus, exchange) };
                record.entries.extend(journal.map(entry));
            }
            record.entries.sort_by_key(|entry| entry.at);
        }
        self.recording
    }
}
