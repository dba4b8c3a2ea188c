//! What a slave reports while its bus fails is known to the master afterwards, see [`host::events`].

use host::events::{flights, fly};

/// One flight in 67: reports come at three moments of each failure. The second tier flies every millisecond.
#[test]
fn reports_during_a_failure_of_the_bus_are_known_afterwards() {
    let wrong: Vec<String> =
        flights().into_iter().step_by(67).filter_map(|flight| fly(flight).err()).collect();
    assert!(wrong.is_empty(), "{} flights:\n{}", wrong.len(), wrong.join("\n"));
}
