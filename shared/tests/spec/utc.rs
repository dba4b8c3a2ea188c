//! Spacecraft UTC, and its objects.

use ecss_can::od::{Record, checked};
use ecss_can::pdo::{Direction, Layout};
use ecss_can::time::{LocalUtc, UtcGet, UtcSet};
use ecss_can::types::{Address, Utc};

fn utc(day: u16, ms: u32, submilliseconds: u16) -> Utc {
    Utc::new(day, ms, submilliseconds).unwrap()
}

/// Entries of a mapping in the order of Figure 7-2.
fn figure_7_2(index: u32) -> [u32; 3] {
    [index << 16 | 0x0310, index << 16 | 0x0220, index << 16 | 0x0110]
}

const OCTETS: [u8; 8] = [0xBB, 0xAA, 0x04, 0x03, 0x02, 0x01, 0xCD, 0xAB];

/// Verifies: ECSS 7.1.3e
#[test]
fn figure_7_2_submilliseconds_first_little_endian() {
    let time = utc(0xABCD, 0x0102_0304, 0xAABB);
    assert_eq!(time.encode(), OCTETS);
    assert_eq!(Utc::decode(&OCTETS), Some(time));
    assert_eq!(Utc::decode(&OCTETS[..7]), None);
}

/// Verifies: ECSS 7.1.3d
#[test]
fn a_day_has_its_milliseconds_and_those_of_a_leap_second() {
    let last = utc(u16::MAX, 86_400_999, u16::MAX);
    assert_eq!((last.day(), last.ms(), last.submilliseconds()), (u16::MAX, 86_400_999, u16::MAX));
    assert_eq!(Utc::new(0, 86_401_000, 0), None);
    assert_eq!(Utc::decode(&[0, 0, 0xE8, 0x5F, 0x26, 0x05, 0, 0]).map(Utc::ms), None);
    assert_eq!(Utc::decode(&[0, 0, 0xE7, 0x5F, 0x26, 0x05, 0, 0]).map(Utc::ms), Some(86_400_999));
}

/// No bit is unused, so that none has to be zero and none may be ignored.
///
/// Verifies: ECSS 7.1.3f, 7.1.3g
#[test]
fn all_16_bits_of_the_submilliseconds_are_sent_and_understood() {
    for bit in 0..16 {
        let mut octets = [0; 8];
        octets[bit / 8] = 1 << (bit % 8);
        assert_eq!(utc(0, 0, 1 << bit).encode(), octets, "bit {bit}");
        assert_eq!(Utc::decode(&octets), Some(utc(0, 0, 1 << bit)), "bit {bit}");
    }
}

/// Verifies: ECSS 7.1.3a, 7.1.3b, 7.1.3c, 7.1.3d
#[test]
fn a_device_with_utc_is_set_and_read_over_the_bus() {
    let mut device = LocalUtc::default();
    for (sub, value) in [(1, &[0xCD, 0xAB][..]), (2, &[0x04, 0x03, 0x02, 0x01]), (3, &[0xBB, 0xAA])] {
        checked::find(&mut device, Address::new(0x2012, sub)).unwrap().write(value).unwrap();
    }
    assert_eq!(Utc::try_from(device.utc_set), Ok(utc(0xABCD, 0x0102_0304, 0xAABB)));
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

/// Verifies: ECSS 7.1.3e
#[test]
fn it_goes_by_pdo_as_figure_7_2_has_it() {
    let mut device = LocalUtc::default();
    let received = Layout::new::<LocalUtc>(Direction::Receive, &figure_7_2(0x2012)).unwrap();
    assert!(received.unpack(&mut device, u64::from_le_bytes(OCTETS)));
    assert_eq!(Utc::try_from(device.utc_set).ok(), Utc::decode(&OCTETS));
    device.utc_get = utc(0xABCD, 0x0102_0304, 0xAABB).into();
    let sent = Layout::new::<LocalUtc>(Direction::Transmit, &figure_7_2(0x2013)).unwrap();
    assert_eq!(sent.pack(&device).to_le_bytes(), OCTETS);
}

#[test]
fn what_no_day_has_is_no_time() {
    assert!(Utc::try_from(UtcSet { day: 1, ms: 86_401_000, submilliseconds: 0 }).is_err());
}
