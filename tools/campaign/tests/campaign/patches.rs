//! The simplest script of each rule that a patch in `tools/campaign/tests/patches` breaks.

use campaign::{World, fly};

/// Name of the rule, and the script that the campaign made of a run without it.
const SCRIPTS: [(&str, &str); 5] = [
    (
        "foreign-master",
        "run seed=1 slaves=2 length=60000000\n\
         cut at=8000000 place=3\nforeign-master at=12000000 value=5 times=960 every=50000\n",
    ),
    (
        "unknown-node",
        "run seed=1 slaves=2 length=60000000\n\
         unknown-node at=17000000 bus=redundant node=127 value=5 times=2 every=1000000\n",
    ),
    ("lost-minority", "run seed=1 slaves=4 length=60000000\ncut at=19000000 place=9\n"),
    (
        "unconfigured",
        "run seed=1 slaves=2 assigned=1 length=60000000\n\
         cut at=15300000 lasts=1000000 place=3\nreset-slave at=15400000 node=3\n",
    ),
    ("bdefault", "run seed=1 slaves=2 length=60000000\ncut at=13000000 lasts=3000000 place=3\n"),
];

/// Given the scripts, nothing is violated. `cargo xtask mutants --patch` applies each patch: then this test fails, and names the rule
/// with what its script violates.
#[test]
fn scripts_of_patched_rules_violate_nothing() {
    let violated = SCRIPTS.map(|(rule, script)| {
        let violations = fly(World::Host, &script.parse().unwrap()).violations;
        violations.into_iter().map(|violation| format!("{rule}: {violation}\n")).collect::<String>()
    });
    let violated = violated.concat();
    assert!(violated.is_empty(), "{violated}");
}
