//! Aimed upsets of a spacecraft with one master, and their outcomes.

use campaign::upsets::fly::fly;
use campaign::upsets::outcome::Outcome;
use campaign::upsets::place::Upset;
use campaign::upsets::world::World;

/// Upsets by their text, with their outcomes. Board 0 is the master, board 1 the slave with parallel access, and board 2 that with
/// selective access.
const AIMED: [(&str, &str, Outcome); 0] = [];

/// Given a spacecraft in flight, when one bit flips, then the outcome is the known one.
#[test]
fn aimed_upsets_have_known_outcomes() {
    let world = World::prepare(1, 1, false).expect("images");
    let wrong: Vec<String> = AIMED
        .iter()
        .filter_map(|(name, place, expected)| {
            let text = format!("upset masters=1 at=5499455 {place}");
            let upset: Upset = text.parse().expect(name);
            let flown = fly(&world, &upset);
            let is_named = flown.name.contains(name);
            (flown.outcome != *expected || !is_named).then(|| format!("{name}: {flown:?}"))
        })
        .collect();
    assert_eq!(wrong, [""; 0]);
}
