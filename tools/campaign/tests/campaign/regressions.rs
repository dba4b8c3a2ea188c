//! Scripts that once violated something, as the campaign made them simple.

use campaign::{World, fly};

/// What was wrong, and the script.
const SCRIPTS: [(&str, &str); 17] = [
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
        "a slave with selective access that a foreign node deceives to the end counted as lost",
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
    (
        "two masters that met while the oscillator of one was wrong were active for too long",
        "run seed=2168582732283471682 masters=2 slaves=2 length=60000000\n\
         drift at=16000000 lasts=500000 bus=nominal node=128 value=86658\n",
    ),
    (
        "the same, after a glitch on the bus",
        "run seed=4300394883998841374 masters=2 slaves=2 length=60000000\n\
         glitch at=3410000 lasts=100000 bus=nominal node=128 value=2\n\
         drift at=3500000 lasts=300000 bus=nominal node=128 value=102681\n",
    ),
    (
        "a standby that was restarted took over from a cut beside it, and yielded, without end",
        "run seed=1 masters=2 slaves=5 length=60000000\n\
         reset-master at=9000000 node=128\n\
         cut at=17000000 bus=nominal place=11\n",
    ),
    (
        "the same, with two slaves beyond the cut",
        "run seed=1 masters=2 slaves=5 length=60000000\n\
         reset-master at=9000000 node=128\n\
         cut at=17000000 bus=nominal place=9\n",
    ),
    (
        "a foreign heartbeat of the master made the active one forget a standby without a stub",
        "run seed=1 masters=2 slaves=2 length=60000000\n\
         disconnect at=10000000 bus=nominal node=128\n\
         foreign-master at=11000000 bus=nominal node=1 value=5 times=46 every=1000000\n",
    ),
    (
        "the same, with the foreign node four seconds after the stub was lost",
        "run seed=1 masters=2 slaves=2 length=60000000\n\
         disconnect at=10000000 bus=nominal node=128\n\
         foreign-master at=14000000 bus=nominal node=1 value=5 times=46 every=1000000\n",
    ),
    (
        "time in which a master was bus-off counted as time in which it heard the other one",
        "run seed=1 masters=2 slaves=2 length=60000000\n\
         short at=8000000 bus=redundant place=6\n\
         short at=16000000 lasts=300000 bus=nominal place=6\n",
    ),
    (
        "a foreign node kept slaves on the nominal bus while the master tried the other one, which counted as failed",
        "run seed=1 slaves=3 selective=1 length=60000000\n\
         foreign-master at=18000000 bus=nominal node=1 value=5 times=7 every=100000\n\
         disconnect at=17100000 bus=nominal node=2\n",
    ),
    (
        "the same, with four slaves and a slower foreign node",
        "run seed=1 slaves=4 selective=1 length=60000000\n\
         foreign-master at=14000000 bus=nominal node=1 value=5 times=5 every=300000\n\
         disconnect at=13600000 bus=nominal node=5\n",
    ),
    (
        "the same, with six slaves",
        "run seed=1 slaves=6 selective=1 length=60000000\n\
         foreign-master at=11000000 bus=nominal node=1 value=5 times=7 every=200000\n\
         disconnect at=10700000 bus=nominal node=7\n",
    ),
    (
        "the same, with the foreign node a second after the stub was lost",
        "run seed=1 slaves=4 selective=1 length=60000000\n\
         disconnect at=16000000 bus=nominal node=5\n\
         foreign-master at=17000000 bus=nominal node=1 value=5 times=4 every=200000\n",
    ),
    (
        "a slave that was reset as its stub broke did not count any more, and the master stayed where it was not heard",
        "run seed=1 slaves=3 length=60000000\n\
         disconnect at=18000000 bus=nominal node=4\n\
         reset-slave at=18000000 node=4\n",
    ),
    (
        "a slave that was reset again while it was configured kept its defaults and the date of its configuration",
        "run seed=1 slaves=3 assigned=1 length=60000000\n\
         foreign-nmt at=14000000 bus=nominal node=4 value=130 times=2 every=3000\n",
    ),
];

#[test]
fn what_was_mended_stays_so() {
    for (what, script) in SCRIPTS {
        let flown = fly(World::Host, &script.parse().unwrap());
        assert!(flown.violations.is_empty(), "{what}: {:?}\n{script}", flown.violations);
    }
}
