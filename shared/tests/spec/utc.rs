//! Spacecraft UTC, and its objects.
//!
//! Verifies: ECSS 7.1.1c, 7.1.3a, 7.1.3b, 7.1.3d, 7.1.3e

use ecss_can::od::{Record, checked};
use ecss_can::pdo::{Direction, Layout};
use ecss_can::time::{LocalUtc, UtcGet, UtcSet};
use ecss_can::types::{Address, Duration, FineScet, Scet, Utc, UtcRelation};

fn utc(day: u16, ms: u32, micros: u16) -> Utc {
    Utc::new(day, ms, micros).unwrap()
}

/// Entries of a mapping in the order of Figure 7-2.
fn figure_7_2(index: u32) -> [u32; 3] {
    [index << 16 | 0x0310, index << 16 | 0x0220, index << 16 | 0x0110]
}

const OCTETS: [u8; 8] = [0xE7, 0x03, 0x04, 0x03, 0x02, 0x01, 0xCD, 0xAB];

/// Notices: ECSS 7.1.3e: day and submilliseconds are exchanged.
#[test]
fn figure_7_2_submilliseconds_first_little_endian() {
    let time = utc(0xABCD, 0x0102_0304, 999);
    assert_eq!(time.encode(), OCTETS);
    assert_eq!(Utc::decode(&OCTETS), Some(time));
    assert_eq!(Utc::decode(&OCTETS[..7]), None);
}

#[test]
fn a_day_has_its_milliseconds_and_those_of_a_leap_second() {
    let last = utc(u16::MAX, 86_400_999, 999);
    assert_eq!((last.day(), last.ms(), last.micros()), (u16::MAX, 86_400_999, 999));
    assert_eq!(Utc::new(0, 86_401_000, 0), None);
    assert_eq!(Utc::decode(&[0, 0, 0xE8, 0x5F, 0x26, 0x05, 0, 0]).map(Utc::ms), None);
    assert_eq!(Utc::decode(&[0, 0, 0xE7, 0x5F, 0x26, 0x05, 0, 0]).map(Utc::ms), Some(86_400_999));
}

/// The 16-bit submillisecond segment of CDS counts microseconds (CCSDS 301.0-B-4 3.3).
#[test]
fn submilliseconds_are_microseconds() {
    assert_eq!(Utc::new(0, 0, 1_000), None);
    assert_eq!(Utc::decode(&[0xE8, 0x03, 0, 0, 0, 0, 0, 0]), None);
    assert_eq!(utc(0, 0, 999).plus(Duration::from_micros(1)), utc(0, 1, 0));
}

/// Verifies: ECSS 7.1.3f, 7.1.3g
#[test]
fn a_device_without_submilliseconds_has_zero_there() {
    assert_eq!(utc(3, 4, 567).whole_ms(), utc(3, 4, 0));
}

/// A day has 86,400,000 ms.
///
/// Notices: ECSS 7.1.1c: each day has the 86,401 s of one with a leap second.
/// Notices: ECSS 7.1.3d: a day before another one counts as 65,535 days after it.
#[test]
fn days_are_carried_and_wrap() {
    let span = Duration::from_micros;
    assert_eq!(utc(9, 86_399_999, 999).plus(span(1)), utc(10, 0, 0));
    assert_eq!(utc(10, 0, 0).minus(span(1)), utc(9, 86_399_999, 999));
    assert_eq!(utc(u16::MAX, 86_399_999, 999).plus(span(1)), utc(0, 0, 0));
    assert_eq!(utc(0, 0, 0).minus(span(86_400_000_000)), utc(u16::MAX, 0, 0));
    assert_eq!(utc(10, 0, 1).micros_since(utc(9, 86_399_999, 999)), 2);
    assert_eq!(utc(u16::MAX, 0, 0).micros_since(utc(0, 0, 0)), -86_400_000_000);
    assert!(utc(1, 0, 0) < utc(1, 0, 1) && utc(0, 86_400_999, 999) < utc(1, 0, 0));
}

/// SCET 1000 s was day 5, 0:00:00.5.
///
/// Verifies: ECSS 7.1.1b, 7.1.3c
/// Notices: ECSS 7.1.1b: UTC before the relation is a second off.
/// Notices: ECSS 7.1.3c: seconds before the relation are rounded to the wrong side.
#[test]
fn scet_and_utc_follow_from_one_relation() {
    let scet = |coarse, fine| Scet::new(coarse, fine).unwrap();
    let relation = UtcRelation { scet: scet(1_000, 0), utc: utc(5, 500, 0) };
    for (elapsed, universal) in [
        (scet(1_000, 0), utc(5, 500, 0)),
        (scet(1_001, 0x80_0000), utc(5, 2_000, 0)),
        (scet(999, 0x80_0000), utc(5, 0, 0)),
        (scet(999, 0), utc(4, 86_399_500, 0)),
        (scet(1_000 + 86_400, 0), utc(6, 500, 0)),
    ] {
        assert_eq!(relation.utc(elapsed.into()), universal);
        assert_eq!(relation.scet(universal), elapsed);
    }
    // 1 us is 4294.967 units of 2^-32 s.
    let after = |units| relation.utc(FineScet::from(scet(1_000, 0)).plus(units));
    assert_eq!((after(2_147), after(2_148)), (utc(5, 500, 0), utc(5, 500, 1)));
}

/// Verifies: ECSS 7.1.3c
/// Notices: ECSS 7.1.3d: submilliseconds are the milliseconds of the second.
#[test]
fn a_device_with_utc_is_set_and_read_over_the_bus() {
    let mut device = LocalUtc::default();
    for (sub, value) in [(1, &[0xCD, 0xAB][..]), (2, &[0x04, 0x03, 0x02, 0x01]), (3, &[0xE7, 0x03])] {
        checked::find(&mut device, Address::new(0x2012, sub)).unwrap().write(value).unwrap();
    }
    assert_eq!(Utc::try_from(device.utc_set), Ok(utc(0xABCD, 0x0102_0304, 999)));
    device.utc_get = utc(1, 2, 3).into();
    let mut read = [0; 4];
    for (sub, expected) in [(1, &[1, 0][..]), (2, &[2, 0, 0, 0]), (3, &[3, 0])] {
        let mut found = checked::find(&mut device, Address::new(0x2013, sub)).unwrap();
        let count = found.read(0, &mut read);
        assert_eq!(&read[..count], expected);
        assert!(found.write(expected).is_err(), "it is the device's");
    }
    assert_eq!((UtcSet::STRUCTURE, UtcGet::STRUCTURE), (0x41, 0x41));
}

/// Verifies: ECSS 7.1.3c
#[test]
fn it_goes_by_pdo_as_figure_7_2_has_it() {
    let mut device = LocalUtc::default();
    let received = Layout::new::<LocalUtc>(Direction::Receive, &figure_7_2(0x2012)).unwrap();
    assert!(received.unpack(&mut device, u64::from_le_bytes(OCTETS)));
    assert_eq!(Utc::try_from(device.utc_set).ok(), Utc::decode(&OCTETS));
    device.utc_get = utc(0xABCD, 0x0102_0304, 999).into();
    let sent = Layout::new::<LocalUtc>(Direction::Transmit, &figure_7_2(0x2013)).unwrap();
    assert_eq!(sent.pack(&device).to_le_bytes(), OCTETS);
}

#[test]
fn what_no_day_has_is_no_time() {
    assert!(Utc::try_from(UtcSet { day: 1, ms: 86_401_000, submilliseconds: 0 }).is_err());
}
