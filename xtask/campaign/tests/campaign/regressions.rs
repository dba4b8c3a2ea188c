//! Scripts that once violated something, as the campaign made them simple.

use campaign::{World, fly};

/// What was wrong, and the script.
const SCRIPTS: [(&str, &str); 4] = [
    (
        "the master did not go back to a bus that had served more slaves",
        "run seed=1 slaves=5 length=60000000\n\
         cut at=5000000 bus=nominal place=11\n\
         foreign-load at=11000000 bus=redundant value=1619 times=2141\n",
    ),
    (
        "a slave that babbled when its master started stayed stopped",
        "run seed=1 slaves=2 assigned=1 length=60000000\n\
         babble at=18000000 lasts=100000 bus=nominal node=2 value=386\n\
         power-master at=18000000 lasts=10000 node=1\n",
    ),
    (
        "a slave with selective access that a stranger deceives to the end counted as lost",
        "run seed=1 slaves=3 selective=1 length=60000000\n\
         disconnect at=8000000 bus=nominal node=1\n\
         foreign-master at=8000000 bus=nominal node=1 value=5 times=566 every=100000\n",
    ),
    (
        "once a second the master left a bus with half of the slaves for one that was dead",
        "run seed=1 slaves=6 length=60000000\n\
         cut at=8000000 bus=nominal place=9\n\
         short at=9800000 bus=redundant place=12\n",
    ),
];

#[test]
fn what_was_mended_stays_so() {
    for (what, script) in SCRIPTS {
        let flown = fly(World::Host, &script.parse().unwrap());
        assert!(flown.violations.is_empty(), "{what}: {:?}\n{script}", flown.violations);
    }
}
