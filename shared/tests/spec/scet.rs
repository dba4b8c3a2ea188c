//! Spacecraft Elapsed Time.
//!
//! Verifies: ECSS 7.1.1a, 7.1.2e, 7.1.2f

use ecss_can::types::{Duration, FineInstant, FineScet, Instant, Scet};

use crate::bench::span;

fn scet(coarse: u32, fine: u32) -> Scet {
    Scet::new(coarse, fine).unwrap()
}

/// Notices: ECSS 7.1.2f: the coarse time is big-endian.
#[test]
fn figure_7_1_fine_time_first_little_endian() {
    let time = scet(0x0102_0304, 0x00AA_BBCC);
    assert_eq!(time.encode(), [0xCC, 0xBB, 0xAA, 0x04, 0x03, 0x02, 0x01]);
    assert_eq!(Scet::decode(&[0xCC, 0xBB, 0xAA, 0x04, 0x03, 0x02, 0x01]), Some(time));
}

#[test]
fn longer_time_pdo_is_used_as_mapped_and_shorter_one_is_none() {
    assert_eq!(Scet::decode(&[1, 0, 0, 2, 0, 0, 0, 99]), Some(scet(2, 1)));
    assert_eq!(Scet::decode(&[1, 0, 0, 2, 0, 0]), None);
}

#[test]
fn coarse_has_32_bits_and_fine_24() {
    let last = scet(u32::MAX, 0x00FF_FFFF);
    assert_eq!((last.coarse(), last.fine()), (u32::MAX, 0x00FF_FFFF));
    assert_eq!(Scet::new(0, 0x0100_0000), None);
}

#[test]
fn all_24_bits_of_fine_time_have_their_places() {
    for bit in 0..24 {
        let mut octets = [0; 7];
        octets[bit / 8] = 1 << (bit % 8);
        assert_eq!(scet(0, 1 << bit).encode(), octets, "bit {bit}");
        assert_eq!(Scet::decode(&octets), Some(scet(0, 1 << bit)), "bit {bit}");
    }
}

/// Verifies: ECSS 7.1.2g
#[test]
fn bits_that_a_device_lacks_are_zero_and_nothing_is_rounded_up() {
    for (bits, fine) in [(24, 0xFF_FFFF), (16, 0xFF_FF00), (8, 0xFF_0000), (1, 0x80_0000), (0, 0)] {
        assert_eq!(scet(7, 0xFF_FFFF).truncated(bits), scet(7, fine), "{bits} bits");
    }
}

/// A third of a second is 5,592,405.33 units.
#[test]
fn parts_of_a_second_follow_each_other() {
    let thirds = [scet(7, 0), scet(7, 5_592_406), scet(7, 11_184_811), scet(8, 0)];
    for pair in thirds.windows(2) {
        assert_eq!(pair[0].next_part(3), pair[1]);
    }
    assert_eq!(scet(7, 5_592_405).next_part(3), scet(7, 5_592_406));
    assert_eq!(scet(7, 1).next_part(1), scet(8, 0));
    assert_eq!(scet(u32::MAX, 1).next_part(0), scet(0, 0));
    let mut time = scet(9, 0);
    (0..1_000).for_each(|_| time = time.next_part(1_000));
    assert_eq!(time, scet(10, 0));
}

#[test]
fn order_goes_the_shorter_way_round() {
    assert!(scet(u32::MAX, 0xFF_FFFF).is_before(scet(0, 0)));
    assert!(scet(5, 1).is_before(scet(5, 2)));
    assert!(!scet(5, 2).is_before(scet(5, 2)));
    assert!(!scet(0, 0).is_before(scet(u32::MAX, 0)));
}

/// A tick of 84 MHz is 256 / 84 = 3.047... units of 2^-8 us.
#[test]
fn ticks_of_a_timer_become_the_nearest_unit_and_come_back() {
    for (ticks, units) in
        [(0, 0), (1, 3), (2, 6), (10, 30), (11, 34), (83, 253), (84, 256), (84_000_001, 256_000_003)]
    {
        let at = FineInstant::from_ticks(ticks, 84);
        assert_eq!((at.units(), at.ticks(84)), (units, ticks));
    }
    // 2^28 s, far beyond any mission: nothing has piled up.
    let late = FineInstant::from_ticks((1 << 28) * 84_000_000 + 41, 84);
    assert_eq!(late.units(), (1 << 28) * 256_000_000 + 125);
    assert_eq!(FineInstant::from_units(255).instant(), Instant::ZERO);
}

#[test]
fn a_time_of_32_bits_of_fraction_becomes_the_nearest_of_24() {
    for (units, fine) in [(0x7F, 0), (0x80, 1), (0x017F, 1), (0xFFFF_FF7F, 0xFF_FFFF)] {
        assert_eq!(FineScet::from_units(units).scet(), scet(0, fine));
    }
    assert_eq!(FineScet::from_units(u64::MAX).scet(), scet(0, 0));
    assert_eq!(FineScet::from(scet(1, 2)).units(), 0x1_0000_0200);
}

#[test]
fn spans_are_rounded_to_the_nearest_unit() {
    let plus_us = |us| scet(0, 0).plus(Duration::from_micros(us));
    assert_eq!(plus_us(500_000), scet(0, 0x0080_0000));
    // 1 us = 16.777216 units, 2 us = 33.554432, 3 us = 50.331648.
    assert_eq!(plus_us(1), scet(0, 17));
    assert_eq!(plus_us(2), scet(0, 34));
    assert_eq!(plus_us(3), scet(0, 50));
    assert_eq!(plus_us(999_999), scet(0, 16_777_199));
    assert_eq!(scet(5, 0).minus(span(500)), scet(4, 0x0080_0000));
}

#[test]
fn the_counter_wraps() {
    assert_eq!(scet(u32::MAX, 0x0080_0000).plus(span(500)), scet(0, 0));
    assert_eq!(scet(0, 0).minus(span(1_000)), scet(u32::MAX, 0));
}

#[test]
fn differences_are_signed_and_go_the_shorter_way() {
    assert_eq!(scet(11, 0x0080_0000).micros_since(scet(10, 0)), 1_500_000);
    assert_eq!(scet(10, 0).micros_since(scet(11, 0x0080_0000)), -1_500_000);
    assert_eq!(scet(1, 0).micros_since(scet(u32::MAX, 0)), 2_000_000);
    assert_eq!(scet(0, 17).micros_since(scet(0, 0)), 1);
}

#[test]
fn a_span_there_and_back_is_exact_to_the_microsecond() {
    for us in [1, 2, 3, 59, 999_999, 1_000_001, 86_400_000_000, 4_294_967_295_999_999] {
        let there = scet(3, 5).plus(Duration::from_micros(us));
        assert_eq!(there.minus(Duration::from_micros(us)), scet(3, 5));
    }
}
