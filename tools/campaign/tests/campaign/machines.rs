//! The images against the machines of redundancy: what flies is what the model searches.

use campaign::script::Script;
use campaign::{compare, fly_compared, prepare_twin, record};
use can_wire::time::Time;
use ecss_can::profile::Profile;
use ecss_can::types::{Bus, CobId, NodeId};
use replay::{Comparison, Difference, Entry, Mission, Recording, Stream, What};
use twin::bxcan::Exchange;

/// Slaves of the mission.
const MONITORED: [NodeId; 2] = [NodeId::of::<2>(), NodeId::of::<3>()];

/// The master goes bus-off on both buses, on the second one too often.
const BUS_OFFS: &str = "run seed=5543303039800390226 slaves=2 length=5000000\n\
    dominant at=3581687 lasts=2970 bus=nominal place=6 in_frame=1\n\
    short at=3603686 bus=redundant place=4 in_frame=1\n";

/// A slave boots up while the master waits for the answer of a node that there is not.
const QUESTIONS: &str = "run seed=8996252604400556510 slaves=2 length=12000000\n\
    unknown-node at=10169877 bus=nominal node=127 value=5 times=39 every=226715\n\
    reset-slave at=10361938 node=3\n";

/// Noise lets the error state of the master change ten times a second: an EMCY finds the queue full.
const NOISE: &str = "run seed=6506986047076237374 slaves=2 length=24000000\n\
    noise at=19831395 bus=nominal value=4 in_frame=1\n\
    foreign-master at=22055391 bus=nominal node=1 value=5 times=35 every=2015\n";

/// A babbling slave holds the bus of the master for longer than the lifetime of a heartbeat.
const BABBLE: &str = "run seed=944461058010338757 masters=2 slaves=2 length=6500000\n\
    babble at=5003161 lasts=568669 bus=redundant node=2 value=130 in_frame=1\n\
    short at=5108677 lasts=686139 bus=nominal place=2 in_frame=1\n";

/// The master is without power from 2 s to 5 s: the slaves search it.
const SEARCH: &str = "run seed=9 slaves=2 length=6000000\npower-master at=2000000 lasts=3000000 node=1\n";

fn script(text: &str) -> Script {
    text.parse().expect("a script")
}

/// Flies scripts with this number of masters, and compares. Each run has something to compare.
fn compared(masters: u8, texts: &[&str]) -> Comparison {
    prepare_twin(masters, true).expect("images");
    let mut sum = Comparison::default();
    for text in texts {
        let comparison = fly_compared(&script(text)).comparison.expect("nothing panicked");
        assert!(comparison.frames > 500 && comparison.outputs[&Stream::Heartbeat] > 100, "{comparison:?}");
        sum.add(comparison);
    }
    sum
}

/// Given cuts, a search, bus-offs, resets, unknown nodes and a foreign NMT master, when one master and two slaves fly, then bus, state, heartbeats, EMCYs,
/// commands and logs of the images are those of the machines.
#[test]
fn images_do_what_the_machines_decide() {
    let found = compared(
        1,
        &[
            SEARCH,
            "run seed=5 slaves=2 length=5000000\ncut at=2000000 place=3\n",
            "run seed=6 slaves=2 length=5000000\nreset-slave at=2000000 node=2\nreset-master at=2500000 node=1\n",
            BUS_OFFS,
            QUESTIONS,
            NOISE,
            "run seed=7 slaves=2 length=5000000\nforeign-nmt at=2000000 node=0 value=129 times=3 every=50000\n",
        ],
    );
    assert_eq!(found.differences, []);
    assert!(found.given_up >= 1, "noise: {found:?}");
    assert!(found.outputs[&Stream::Command] >= 8 && found.outputs[&Stream::Emergency] >= 2, "{found:?}");
    assert!(found.outputs[&Stream::Line] > 50, "{found:?}");
}

/// Given two master boards, when the active one loses its power and returns, or its bus is held by another node, then both do what the
/// machines decide.
#[test]
fn two_masters_do_what_the_machines_decide() {
    let text = "run seed=5 masters=2 slaves=2 length=7000000\npower-master at=3000000 lasts=2000000 node=1\n";
    let found = compared(2, &[text, BABBLE]);
    assert_eq!(found.differences, []);
    let claims = Bus::ALL.map(|bus| found.outputs[&Stream::Claim(bus)]);
    assert!(claims.iter().all(|claims| *claims > 30), "{found:?}");
}

/// A recording of the search.
fn search() -> (Script, Recording) {
    prepare_twin(1, true).expect("images");
    let script = script(SEARCH);
    let recording = record(&script).1.expect("nothing panicked");
    assert_eq!(compare(&script, &recording).differences, []);
    (script, recording)
}

/// Returns the differences of node 2, as they are shown.
fn shown(differences: &[Difference]) -> Vec<String> {
    differences.iter().filter(|one| one.board == "node 2").map(ToString::to_string).collect()
}

/// Changes the heartbeats of the master that node 2 took after 1 s.
fn with_heartbeats(recording: &Recording, change: impl Fn(&Entry) -> Option<Entry>) -> Recording {
    let mut changed = recording.clone();
    let heartbeat = CobId::heartbeat(NodeId::MASTER).raw();
    let is_heartbeat = |entry: &Entry| match &entry.what {
        What::Exchange(_, Exchange::Taken(wire)) => {
            wire.id == can_wire::frame::WireId::Standard(heartbeat) && entry.at > Time::from_ms(1_000)
        }
        _ => false,
    };
    let entries = &mut changed.boards[1].entries;
    *entries = entries
        .iter()
        .filter_map(|entry| if is_heartbeat(entry) { change(entry) } else { Some(entry.clone()) })
        .collect();
    changed
}

/// Given a flight in which slaves searched their master, when it is replayed with a defect (another Ttoggle, a lost heartbeat, the
/// other bus), then the comparison names board, instant, and what both did.
#[test]
fn a_replay_with_a_defect_differs() {
    let (script, recording) = search();

    let profile: &'static Profile = Box::leak(Box::new(Profile { ttoggle: 3, ..mission::STANDARD }));
    let end = Time::from_us(script.length);
    let patient = replay::compare(&recording, &Mission { profile, monitored: &MONITORED }, end);
    let found = shown(&patient.differences);
    let toggled = "the board \"active bus: Redundant (Toggled)\" at 2.";
    assert!(found.iter().any(|text| text.starts_with("node 2, 2.") && text.contains(toggled)), "{found:#?}");

    let deaf = with_heartbeats(&recording, |entry| (entry.at > Time::from_ms(1_500)).then(|| entry.clone()));
    let found = shown(&compare(&script, &deaf).differences);
    let missed = "Line: the machine \"master missed on Nominal\", the board ";
    assert!(found.iter().any(|text| text.starts_with("node 2, 1.") && text.contains(missed)), "{found:#?}");

    let inverted = with_heartbeats(&recording, |entry| match &entry.what {
        What::Exchange(bus, exchange) => {
            Some(Entry { at: entry.at, what: What::Exchange(bus.other(), *exchange) })
        }
        What::Line(_) => None,
    });
    let found = shown(&compare(&script, &inverted).differences);
    let bus = format!(
        "bus and state: the machine {:?}, Operational, the board Nominal, Operational",
        Bus::Redundant
    );
    assert!(found.iter().any(|text| text.starts_with("node 2, 1.") && text.contains(&bus)), "{found:#?}");
}
