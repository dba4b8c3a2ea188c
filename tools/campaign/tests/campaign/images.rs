//! Scripts that the images fly, judged: searches, bus-offs, resets, noise, foreign and babbling nodes, a takeover.

use campaign::{World, fly, prepare_twin};

/// With one master.
const ONE: [&str; 7] = [
    // The master is without power from 2 s to 5 s: the slaves search it.
    "run seed=9 slaves=2 length=16000000\npower-master at=2000000 lasts=3000000 node=1\n",
    "run seed=5 slaves=2 length=15000000\ncut at=2000000 place=3\n",
    "run seed=6 slaves=2 length=15000000\nreset-slave at=2000000 node=2\nreset-master at=2500000 node=1\n",
    // The master goes bus-off on both buses, on the second one too often.
    "run seed=5543303039800390226 slaves=2 length=15000000\n\
     dominant at=3581687 lasts=2970 bus=nominal place=6 in_frame=1\n\
     short at=3603686 bus=redundant place=4 in_frame=1\n",
    // A slave boots up while the master waits for the answer of a node that there is not.
    "run seed=8996252604400556510 slaves=2 length=22000000\n\
     unknown-node at=10169877 bus=nominal node=127 value=5 times=39 every=226715\n\
     reset-slave at=10361938 node=3\n",
    // Noise lets the error state of the master change ten times a second: an EMCY finds the queue full.
    "run seed=6506986046077236374 slaves=2 length=34000000\n\
     noise at=19831395 bus=nominal value=4 in_frame=1\n\
     foreign-master at=22055391 bus=nominal node=1 value=5 times=35 every=2015\n",
    "run seed=7 slaves=2 length=15000000\nforeign-nmt at=2000000 node=0 value=129 times=3 every=50000\n",
];

/// With two masters.
const TWO: [&str; 2] = [
    "run seed=5 masters=2 slaves=2 length=17000000\npower-master at=3000000 lasts=2000000 node=1\n",
    // A babbling slave holds the bus of the master for longer than the lifetime of a heartbeat.
    "run seed=944461058010338757 masters=2 slaves=2 length=16500000\n\
     babble at=5003161 lasts=568669 bus=redundant node=2 value=130 in_frame=1\n\
     short at=5108677 lasts=686139 bus=nominal place=2 in_frame=1\n",
];

/// Given faults of the wire, of power and of foreign nodes, when the images fly, then nothing is violated and nothing panics.
#[test]
fn images_violate_nothing() {
    let mut violated = Vec::new();
    for (masters, scripts) in [(1, &ONE[..]), (2, &TWO[..])] {
        prepare_twin(masters, true).expect("images");
        for text in scripts {
            let outcome = fly(World::Twin, &text.parse().expect("a script"));
            violated.extend(outcome.violations.into_iter().map(|violation| format!("{violation}:\n{text}")));
        }
    }
    assert!(violated.is_empty(), "{}", violated.concat());
}
