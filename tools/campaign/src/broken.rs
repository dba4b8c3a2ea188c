//! Rules that are broken on purpose: the campaign must find each.
//!
//! Each was missing once, and a spacecraft did not fly (docs/verification/mutants.md). The campaign flies random scripts of the kinds
//! that may meet it. Rules that only a change inside of the nodes breaks are patches in `tests/patches`.

use crate::flight;
use crate::host::Host;
use crate::outcome::Outcome;
use crate::rule::Rule;
use crate::script::Script;

/// Flies a script on the host where a rule does not hold.
pub fn fly(rule: Rule, script: &Script) -> Outcome {
    flight::fly(script, || Host::new(script, Some(rule)))
}

/// The first run that finds the broken rule.
pub fn find(rule: Rule, campaign: u64, runs: u64) -> Option<(u64, Script, Outcome)> {
    let flown = (0..runs).map(|number| {
        let script = rule.script(campaign, number);
        let outcome = fly(rule, &script);
        (number, script, outcome)
    });
    let mut bad = flown.filter(|(.., outcome)| !outcome.violations.is_empty());
    bad.next()
}
