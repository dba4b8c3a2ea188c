//! Slower buses: an image for each bit rate.

use can_twin::bxcan::Side;
use flight::rates::{assert_carries_a_slave, assert_flies, at};
use flight::{Flight, MASTER_AND_THREE, STANDARD};

/// Verifies: ECSS 5.4.2a.1, 5.4.2a.2, 5.4.2a.3
/// Verifies: ECSS 5.4.3a
#[test]
fn spacecraft_at_slower_bit_rates_survives_a_cut() {
    for kbit in [500, 250, 125, 50] {
        println!("{kbit} kbit/s");
        assert_flies(kbit);
    }
}

#[test]
fn a_bus_of_10_or_20_kbit_per_second_carries_a_slave() {
    for kbit in [10, 20] {
        println!("{kbit} kbit/s");
        assert_carries_a_slave(kbit);
    }
}

/// CAN_BTR (RM0090 32.9.2): SJW - 1, TS2 - 1, TS1 - 1 and prescaler - 1 at bits 24, 20, 16 and 0.
const fn btr(prescaler: u32, ts1: u32, ts2: u32, sjw: u32) -> u32 {
    (sjw - 1) << 24 | (ts2 - 1) << 20 | (ts1 - 1) << 16 | (prescaler - 1)
}

/// Given images for two bit rates, then both controllers of each board have the time quanta, the sample point and the jump width that
/// docs/decisions/clocks-and-bit-timing.md derives: 14 quanta and 85.7 %, or 16 quanta and 87.5 %.
///
/// Verifies: ECSS 5.4.3a, 5.4.3c
#[test]
fn controllers_have_the_bit_timing_of_their_network() {
    for (images, expected) in [(STANDARD.clone(), btr(3, 11, 2, 1)), (at(125, "standard"), btr(21, 13, 2, 1))]
    {
        let mut flight = Flight::with(&MASTER_AND_THREE[..2], &images);
        flight.fly_to(1_000);
        for (id, board) in flight.twin.boards() {
            for side in [Side::Can1, Side::Can2] {
                assert_eq!(board.can_btr(side), expected, "{id:?} {side:?}: {:08X}h", board.can_btr(side));
            }
        }
    }
}

/// Rates of the standard beside 1 Mbit/s, kbit/s.
const REQUIRED: [&str; 3] = ["500", "250", "125"];

/// Given the rates of the images in their manifests and data sheets, then each image with a rate in addition to those
/// of the standard has all rates of the standard.
///
/// Verifies: ECSS 5.4.2b
#[test]
fn images_with_further_rates_have_all_rates_of_the_standard() {
    let manifests = [
        include_str!("../../../../firmware/master/Cargo.toml"),
        include_str!("../../../../firmware/slave/Cargo.toml"),
        include_str!("../../../../firmware/minimal/Cargo.toml"),
    ];
    for manifest in manifests {
        let features = manifest.lines().filter_map(|line| line.strip_prefix("kbit-")?.split_once(" = "));
        let rates: Vec<_> =
            features.inspect(|(rate, of)| assert_eq!(*of, format!("[\"mission/kbit-{rate}\"]"))).collect();
        assert_complete(&rates.into_iter().map(|(rate, _)| rate).collect::<Vec<_>>());
    }
    let sheets = [
        include_str!("../../../../docs/eds/master.eds"),
        include_str!("../../../../docs/eds/slave.eds"),
        include_str!("../../../../docs/eds/minimal.eds"),
        include_str!("../../../../docs/eds/minimal-librecube.eds"),
    ];
    for sheet in sheets {
        let rates: Vec<_> =
            sheet.lines().filter_map(|line| line.strip_prefix("BaudRate_")?.strip_suffix("=1")).collect();
        assert!(rates.contains(&"1000"));
        assert_complete(&rates);
    }
}

fn assert_complete(rates: &[&str]) {
    let has_further = rates.iter().any(|rate| !REQUIRED.contains(rate) && *rate != "1000");
    assert!(has_further, "the slower rates of CiA 301: {rates:?}");
    assert!(REQUIRED.iter().all(|rate| rates.contains(rate)), "{rates:?}");
}
