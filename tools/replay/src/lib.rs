//! Replays recorded flights of the images through the machines of redundancy.
//!
//! The model (`tests/model`) searches all states of [`SlaveRedundancy`] and [`MasterRedundancy`]. The images contain the same
//! machines, inside a node, a runner, a driver and an executor. A *replay* shows that these change nothing: it takes the inputs
//! of a flight from a record, gives them to fresh machines, and compares what both did.
//!
//! ```text
//! controllers ── journal ──┐                     ┌─ outputs of the machine ──┐
//! log ──────── inputs ─────┼─ machine of a node ─┤                           ├─ comparison
//!                          │                     └─ bus and state            │
//!                          └─ frames and lines of the flight ────────────────┘
//! ```
//!
//! [`compare`] does this for all boards of a [`Recording`]. A board that differs gives a [`Difference`]:
//!
//! ```text
//! node 2, 4.752013 s, Line: the machine "active bus: Redundant (Toggled)", the board nothing more
//! ```
//!
//! # Inputs
//!
//! | input | from |
//! | --- | --- |
//! | frames that the program took from a FIFO, each at that instant | journal |
//! | frames of the node that were sent or aborted, at the instant at which the program noticed | journal |
//! | error states of a master's controllers, each when the program read it | journal |
//! | requests, answers and aborts of SDO transfers of a master | journal |
//! | resets, loss of power | journal |
//! | start of the node | log |
//!
//! Nothing else is an input. What a node keeps over a reset (Bdefault, resets in a row) the replay keeps itself.
//!
//! # Outputs
//!
//! | output | compared |
//! | --- | --- |
//! | heartbeats and boot-up messages | bus, state, instant of the request |
//! | NMT commands and claims of a master, begins of its SDO transfers | bus, content, instant |
//! | EMCYs of a missed master and of collisions | error, source, order |
//! | lines of the log: bus, state, role, lost slaves, clashes, refused resets, kept Bdefault | text, order, instant |
//! | bus and state after each frame | value |
//!
//! No output may be missing, and none may be too many.
//!
//! # Limits
//!
//! - Slaves with parallel access, and images whose applications give no commands for the redundancy.
//! - Parameters that an SDO client writes, and budgets of own frames, are no inputs: no campaign has them.
//!
//! [`SlaveRedundancy`]: ecss_can::redundancy::SlaveRedundancy
//! [`MasterRedundancy`]: ecss_can::redundancy::MasterRedundancy

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod clock;
mod compare;
mod difference;
mod esr;
mod flown;
mod machine;
mod mailboxes;
mod master;
mod output;
mod recording;
mod run;
mod slave;

use can_wire::time::Time;
use ecss_can::profile::Profile;
use ecss_can::types::{Duration, NodeId};

use compare::Compared;
pub use compare::Comparison;
pub use difference::Difference;
use flown::Flown;
use machine::Machine;
use master::Master;
pub use output::Stream;
pub use recording::{BoardRecord, Entry, Part, Recording, What};
use slave::Slave;

/// A deadline and a frame that are closer than this have no order in a record. If a board differs, the other order is tried.
const UNORDERED: Duration = Duration::from_micros(10);

/// Numbers that images and machines share.
#[derive(Clone, Copy, Debug)]
pub struct Mission<'a> {
    /// Profile of the images.
    pub profile: &'static Profile,
    /// Slaves that 1016h of the master names.
    pub monitored: &'a [NodeId],
}

/// Replays a recording of a run that ended at `end`, and compares.
pub fn compare(recording: &Recording, mission: &Mission<'_>, end: Time) -> Comparison {
    let mut comparison = Comparison::default();
    for record in &recording.boards {
        comparison.add(compare_board(record, mission, end));
    }
    comparison
}

fn compare_board(record: &BoardRecord, mission: &Mission<'_>, end: Time) -> Comparison {
    let profile = mission.profile;
    let machine = || -> Box<dyn Machine> {
        match record.part {
            Part::Slave(id) => Box::new(Slave::new(id, profile, late_heartbeats(&record.uid))),
            Part::Master(strap) => Box::new(Master::new(strap, profile, mission.monitored.to_vec())),
        }
    };
    let id = match record.part {
        Part::Slave(id) => id,
        Part::Master(_) => NodeId::MASTER,
    };
    let flown = Flown::read(record, id, &*machine(), end);
    let compared = Compared { name: &record.name, id, pair: profile.standby.as_ref(), flown: &flown };
    let compare = |stamped| {
        let replayed = run::replay(record, &mut *machine(), end + compare::EARLY, stamped);
        Comparison::board(&compared, &replayed)
    };
    let comparison = compare(Duration::ZERO);
    if comparison.differences.is_empty() {
        return comparison;
    }
    let other = compare(UNORDERED);
    if other.differences.is_empty() { Comparison { reordered: 1, ..other } } else { comparison }
}

/// Pattern of late heartbeats of a chip: CRC-32C of its unique ID.
fn late_heartbeats(uid: &[u8; 12]) -> u32 {
    crc::Crc::<u32>::new(&crc::CRC_32_ISCSI).checksum(uid)
}
