//! Slower buses: one of the rates of the standard, and the slowest. The others fly in `tests/interop/tests/images/rates.rs`.

use flight::rates::{assert_carries_a_slave, assert_flies};

/// Verifies: ECSS 5.4.2a.3
/// Verifies: ECSS 5.4.3a
#[test]
fn spacecraft_at_125_kbit_per_second_survives_a_cut() {
    assert_flies(125);
}

#[test]
fn a_bus_of_10_kbit_per_second_carries_a_slave() {
    assert_carries_a_slave(10);
}
