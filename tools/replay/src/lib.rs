//! x
#![forbid(unsafe_code)]
mod clock;
mod compare;
mod flown;
mod machine;
mod master;
mod output;
mod recording;
mod run;
mod slave;

use can_wire::time::Time;
use ecss_can::profile::Profile;
use ecss_can::types::NodeId;

pub use compare::{Comparison, Difference};
use compare::Compared;
use flown::Flown;
use machine::Machine;
use master::Master;
pub use output::{Output, Stream};
pub use recording::{BoardRecord, Entry, Part, Recording, What};
use slave::Slave;

/// Replays a recording and compares. `profile`: that of the images; `monitored`: slaves that 1016h of the master names;
/// `end`: end of the run.
pub fn compare(recording: &Recording, profile: &'static Profile, monitored: &[NodeId], end: Time) -> Comparison {
    let mut comparison = Comparison::default();
    for record in &recording.boards {
        comparison.add(compare_board(record, profile, monitored, end));
    }
    comparison
}

fn compare_board(
    record: &BoardRecord,
    profile: &'static Profile,
    monitored: &[NodeId],
    end: Time,
) -> Comparison {
    let (mut machine, id): (Box<dyn Machine>, NodeId) = match record.part {
        Part::Slave(id) => (Box::new(Slave::new(id, profile, late_heartbeats(&record.uid))), id),
        Part::Master(strap) => (Box::new(Master::new(strap, profile, monitored.to_vec())), NodeId::MASTER),
    };
    let flown = Flown::read(record, id, &*machine, end);
    let replayed = run::replay(record, &mut *machine, end + compare::EARLY);
    let pair = profile.standby.as_ref();
    let compared = Compared { name: &record.name, id, pair, flown: &flown };
    Comparison::board(&compared, &replayed)
}

/// Pattern of late heartbeats of a chip: CRC-32C of its unique ID.
fn late_heartbeats(uid: &[u8; 12]) -> u32 {
    crc::Crc::<u32>::new(&crc::CRC_32_ISCSI).checksum(uid)
}
/// debugging
pub fn trace(record: &BoardRecord, profile: &'static Profile, monitored: &[NodeId]) -> Vec<(Time, String)> {
    let mut machine: Box<dyn Machine> = match record.part {
        Part::Slave(id) => Box::new(Slave::new(id, profile, late_heartbeats(&record.uid))),
        Part::Master(strap) => Box::new(Master::new(strap, profile, monitored.to_vec())),
    };
    run::replay(record, &mut *machine, Time::ZERO).outputs.into_iter().map(|(at, o)| (at, format!("    EXP {o}"))).collect()
}
