//! One jolt breaks the bus of a slave and resets it: every distance and order, see [`ecss_can_cli::campaign::jolt`].

use ecss_can_cli::campaign::jolt::table;
use ecss_can_cli::campaign::{World, fly};

use crate::wrong;

#[test]
fn slave_that_a_jolt_strikes_twice_is_served() {
    let scripts = table();
    let bad = wrong(scripts.len(), |number| {
        let violations = fly(World::Host, &scripts[number]).violations;
        if violations.is_empty() { Ok(()) } else { Err(format!("{violations:?}\n{}", scripts[number])) }
    });
    assert!(bad.is_empty(), "{} of {}:\n{}", bad.len(), scripts.len(), bad.join("\n"));
}
