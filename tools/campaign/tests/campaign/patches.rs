//! The simplest script of each rule that a patch in `tools/campaign/tests/patches` breaks.

use campaign::World;

use crate::violations;

/// Given the scripts, nothing is violated. `cargo xtask mutants --patch` applies each patch: then this test fails, and names the rule
/// with what its script violates.
#[test]
fn scripts_of_patched_rules_violate_nothing() {
    assert_eq!(violations("patches", World::Host), "");
}
