//! Aimed upsets of a spacecraft with one master, and their outcomes.

mod minimal;
mod ports;
mod program;
mod registers;
mod time_base;

use ecss_can_cli::campaign::upsets::fly::{Flown, fly};
use ecss_can_cli::campaign::upsets::outcome::Outcome;
use ecss_can_cli::campaign::upsets::place::Upset;
use ecss_can_cli::campaign::upsets::world::World;

/// Instant of the upsets, microseconds.
const AT_US: u64 = 5_499_455;
/// Index of the slave with parallel access.
const SLAVE: usize = 1;

/// Upsets of the slave with parallel access: name, place, outcome.
const AIMED: [(&str, &str, Outcome); 3] = [
    ("S31 bit 3", "core board=1 register=S31 bit=3", Outcome::None),
    ("PC bit 20", "core board=1 register=PC bit=20", Outcome::Reset),
    // The emulator refuses settings of a PLL that runs.
    ("RCC.PLLCFGR bit 7", "peripherals board=1 address=40023804 bit=7", Outcome::Unjudged),
];

/// Flies an upset of the spacecraft with one master.
fn fly_at(world: &World, place: &str) -> Flown {
    let upset: Upset = format!("upset masters=1 at={AT_US} place={place}").parse().expect(place);
    fly(world, &upset)
}

/// Flies an upset of the slave with parallel access. Returns a text if name or outcome differ.
fn differs(world: &World, name: &str, place: &str, expected: Outcome) -> Option<String> {
    let flown = fly_at(world, place);
    let is_named = flown.name.contains(name);
    (flown.outcome != expected || !is_named).then(|| format!("{name}: {flown:?}"))
}

/// Given a spacecraft in flight, when one bit flips, then the outcome is the known one.
#[test]
fn aimed_upsets_have_known_outcomes() {
    let world = World::prepare(1, 1, false).expect("images");
    let wrong = AIMED.iter().filter_map(|(name, place, expected)| differs(&world, name, place, *expected));
    assert_eq!(wrong.collect::<Vec<_>>(), [""; 0]);
}
