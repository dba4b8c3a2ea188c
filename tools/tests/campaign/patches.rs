//! The simplest script of each rule that a patch in `tools/tests/patches` breaks.

use ecss_can_cli::campaign::World;

use crate::violations;

/// Given the scripts, nothing is violated. `cargo xtask mutants --patch` applies each patch: then this test fails, and
/// names the rule and the violation.
#[test]
fn scripts_of_patched_rules_violate_nothing() {
    assert_eq!(violations("patches", World::Host), "");
}
