//! Bit rates that `cargo test` does not fly: an image for each.

use flight::rates::{assert_carries_a_slave, assert_flies};

/// Verifies: ECSS 5.4.2a.1
/// Verifies: ECSS 5.4.3a
#[test]
fn spacecraft_at_500_kbit_per_second_survives_a_cut() {
    assert_flies(500);
}

/// Verifies: ECSS 5.4.2a.2
#[test]
fn spacecraft_at_250_kbit_per_second_survives_a_cut() {
    assert_flies(250);
}

#[test]
fn spacecraft_at_50_kbit_per_second_survives_a_cut() {
    assert_flies(50);
}

#[test]
fn a_bus_of_20_kbit_per_second_carries_a_slave() {
    assert_carries_a_slave(20);
}
