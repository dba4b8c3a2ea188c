//! Circles of arrows.

use std::collections::{BTreeMap, BTreeSet};

/// `from` names `to`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arrow {
    pub from: String,
    pub to: String,
    /// File and line.
    pub place: String,
}

/// Returns a text for each circle, with its arrows.
pub fn circles(arrows: &[Arrow]) -> Vec<String> {
    let mut next = BTreeMap::<&str, BTreeSet<&str>>::new();
    for arrow in arrows {
        next.entry(&arrow.from).or_default().insert(&arrow.to);
    }
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        next.keys().map(|from| (*from, reach(from, &next))).collect();
    let is_reached = |from: &str, to: &str| reached.get(from).is_some_and(|reached| reached.contains(to));
    let mut members = BTreeSet::<BTreeSet<&str>>::new();
    for module in next.keys().filter(|module| is_reached(module, module)) {
        members.insert(reached[module].iter().filter(|other| is_reached(other, module)).copied().collect());
    }
    members.iter().map(|members| report(members, arrows)).collect()
}

/// Returns all names that are reached from `from`.
fn reach<'a>(from: &str, next: &BTreeMap<&'a str, BTreeSet<&'a str>>) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut ahead: Vec<&str> = next.get(from).into_iter().flatten().copied().collect();
    while let Some(module) = ahead.pop() {
        if reached.insert(module) {
            ahead.extend(next.get(module).into_iter().flatten());
        }
    }
    reached
}

fn report(members: &BTreeSet<&str>, arrows: &[Arrow]) -> String {
    let names: Vec<&str> = members.iter().copied().collect();
    let is_part =
        |arrow: &&Arrow| members.contains(arrow.from.as_str()) && members.contains(arrow.to.as_str());
    let line = |Arrow { from, to, place }: &Arrow| format!("\n  {place}: {from} names {to}");
    let mut lines: Vec<String> = arrows.iter().filter(is_part).map(line).collect();
    // A `use` of several names.
    lines.sort();
    lines.dedup();
    format!("circle of {}:{}", names.join(", "), lines.concat())
}
