//! Scripts run with the images, judged: searches, bus-offs, resets, noise, foreign and babbling nodes, a takeover.

use ecss_can_cli::campaign::{World, prepare_twin};

use crate::violations;

/// Given faults of the wire, of power and of foreign nodes, when the images run, then there is no violation and no
/// panic.
#[test]
fn images_violate_nothing() {
    [1, 2].into_iter().for_each(|masters| prepare_twin(masters, true).expect("images"));
    assert_eq!(violations("images", World::Twin), "");
}
