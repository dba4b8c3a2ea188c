//! Scripts that once violated something, as the campaign made them simple.

use campaign::World;

use crate::violations;

#[test]
fn what_was_mended_stays_so() {
    assert_eq!(violations("regressions", World::Host), "");
}
