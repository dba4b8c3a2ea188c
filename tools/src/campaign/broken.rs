//! Rules that are broken on purpose: the campaign must detect each.
//!
//! Each rule was missing once, and a spacecraft failed (docs/verification/mutants.md). The campaign runs random
//! scripts with the kinds of faults that may show it. Rules that only a change of the nodes' code can break are patches
//! in `tests/patches`.

use crate::campaign::flight;
use crate::campaign::host::Host;
use crate::campaign::outcome::Outcome;
use crate::campaign::rule::Rule;
use crate::campaign::script::Script;

/// Runs a script on the host with a broken rule.
pub fn fly(rule: Rule, script: &Script) -> Outcome {
    flight::fly(script, || Host::new(script, Some(rule)))
}

/// Returns the first run that detects the broken rule.
pub fn find(rule: Rule, campaign: u64, runs: u64) -> Option<(u64, Script, Outcome)> {
    let flown = (0..runs).map(|number| {
        let script = rule.script(campaign, number);
        let outcome = fly(rule, &script);
        (number, script, outcome)
    });
    let mut bad = flown.filter(|(.., outcome)| !outcome.violations.is_empty());
    bad.next()
}
