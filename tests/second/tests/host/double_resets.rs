//! A slave that is reset twice, at every moment of its boot-up process.

use ecss_can_cli::campaign::{World, fly};

/// Times from one reset to the next, microseconds. The boot-up process with all writes takes 5 ms.
const DISTANCES: std::ops::RangeInclusive<u64> = 100..=8_000;
const STEP: usize = 100;

/// Given a slave that the master configures, when Reset Node or Reset Communication comes twice, the second time anywhere in the boot-up
/// process, then the slave is Operational and has its configuration.
#[test]
fn slave_reset_while_it_is_configured_is_configured() {
    let mut bad = Vec::new();
    for command in [129, 130] {
        for distance in DISTANCES.step_by(STEP) {
            let text = format!(
                "run seed=1 slaves=3 assigned=1 length=60000000\n\
                 foreign-nmt at=14000000 bus=nominal node=4 value={command} times=2 every={distance}\n"
            );
            let outcome = fly(World::Host, &text.parse().expect("a script"));
            let violations = outcome.violations.into_iter();
            bad.extend(violations.map(|violation| format!("{command}, {distance} us: {violation}")));
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}
