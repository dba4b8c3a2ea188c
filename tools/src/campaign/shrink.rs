//! Simplifies a script with a violation as long as the violation remains.

use crate::campaign::outcome::Outcome;
use crate::campaign::script::{Fault, SECOND_BOARD, Script, UNUSED_NODE};

/// Greatest number of runs.
const FLIGHTS: usize = 300;

/// Returns the simplest script found that still has a violation. `can_fly`: whether there is a spacecraft for a script.
/// `fly` runs it.
pub fn shrink(
    script: &Script,
    can_fly: impl Fn(&Script) -> bool,
    fly: impl Fn(&Script) -> Outcome,
) -> Script {
    let mut best = script.clone();
    let mut flights = 0;
    loop {
        let better = candidates(&best).into_iter().filter(&can_fly).find(|candidate| {
            flights += 1;
            flights <= FLIGHTS && !fly(candidate).violations.is_empty()
        });
        match better {
            Some(better) => best = better,
            None => return best,
        }
    }
}

/// Returns simpler scripts, the simplest first. None equals `script`.
fn candidates(script: &Script) -> Vec<Script> {
    let mut all = Vec::new();
    for index in 0..script.faults.len() {
        let mut fewer = script.clone();
        fewer.faults.remove(index);
        all.push(fewer);
    }
    let highest =
        script.faults.iter().map(|fault| fault.node).filter(|node| *node < UNUSED_NODE).max().unwrap_or(0);
    let farthest = script.faults.iter().map(|fault| fault.place.div_ceil(2) as u8).max().unwrap_or(0);
    let least = highest.max(farthest).max(3) - 1;
    all.extend(
        [least, script.slaves.saturating_sub(1).max(least)].map(|slaves| Script { slaves, ..script.clone() }),
    );
    if script.faults.iter().all(|fault| fault.node != SECOND_BOARD) {
        all.push(Script { masters: 1, ..script.clone() });
    }
    all.push(Script { selective: false, ..script.clone() });
    all.push(Script { assigned: false, ..script.clone() });
    all.push(Script { seed: 1, ..script.clone() });
    all.push(Script { length: script.shortest_length(), ..script.clone() });
    for index in 0..script.faults.len() {
        for fault in rounder(&script.faults[index]) {
            let mut changed = script.clone();
            changed.faults[index] = fault;
            changed.length = changed.shortest_length();
            all.push(changed);
        }
    }
    all.retain(|candidate| candidate != script && candidate.slaves <= script.slaves);
    all.dedup();
    all
}

/// Returns the fault with rounder times, and with fewer frames.
fn rounder(fault: &Fault) -> Vec<Fault> {
    let mut all = Vec::new();
    for unit in [1_000_000, 100_000, 10_000, 1_000] {
        let round = |time: u64| time.div_ceil(unit) * unit;
        if !fault.at.is_multiple_of(unit) {
            all.push(Fault { at: round(fault.at), ..*fault });
        }
        if let Some(lasts) = fault.lasts.filter(|lasts| !lasts.is_multiple_of(unit)) {
            all.push(Fault { lasts: Some(round(lasts)), ..*fault });
        }
        if !fault.every.is_multiple_of(unit) {
            all.push(Fault { every: round(fault.every), ..*fault });
        }
    }
    if fault.in_frame {
        all.push(Fault { in_frame: false, ..*fault });
    }
    if fault.times > 1 {
        all.extend([1, fault.times / 2, fault.times - 1].map(|times| Fault { times, ..*fault }));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::kind::Kind;

    /// A spacecraft that fails whenever a cut occurs after 5 s.
    fn fails(script: &Script) -> Outcome {
        let is_bad = script.faults.iter().any(|fault| fault.kind == Kind::Cut && fault.at > 5_000_000);
        Outcome { violations: if is_bad { vec!["cut".into()] } else { vec![] }, ..Outcome::default() }
    }

    /// Given runs that fail whenever a cut occurs after 5 s, then the script is shrunk to a single cut at 6 s.
    #[test]
    fn script_ends_with_what_it_needs() {
        let script = "run seed=9 slaves=6 selective=1 length=70000000\nflip at=3123456 value=3\ncut at=5234567 lasts=777777 place=3\n";
        let shrunk = shrink(&script.parse().unwrap(), |_| true, fails);
        let expected =
            "run seed=1 slaves=2 selective=0 length=60000000\ncut at=6000000 lasts=1000000 place=3\n";
        assert_eq!(shrunk, expected.parse().unwrap());
    }

    /// Given a spacecraft for two masters only, as the twin builds it, then the script keeps both.
    #[test]
    fn script_keeps_what_the_spacecraft_has() {
        let script = "run seed=9 masters=2 slaves=2 length=70000000\ncut at=6000000 lasts=1000000 place=3\n";
        let shrunk = shrink(&script.parse().unwrap(), |script| script.masters == 2, fails);
        assert_eq!((shrunk.masters, shrunk.seed), (2, 1));
    }
}
