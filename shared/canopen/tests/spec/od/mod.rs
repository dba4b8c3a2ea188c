//! The object dictionary: what a declaration makes, places, access rights, limits.
//!
//! Verifies: ECSS 6.8a

mod types;

use async_canopen::od::machine::Transfer;
use async_canopen::od::{
    Domain, I24, Names, ObjectCode, Objects, Record, VisibleString, checked, sub_indices,
};
use async_canopen::types::AbortCode::{
    NoObject, NoSubIndex, ReadOnly, TooLong, TooShort, ValueRange, ValueTooHigh, ValueTooLow, WriteOnly,
};
use async_canopen::types::{AbortCode, Address};

/// A device with every kind of object.
#[derive(Clone, Debug, Objects)]
struct Device {
    /// Serial number.
    #[object(0x2001, constant, default = 0xCAFE)]
    serial: u32,
    /// Command
    #[object(0x2002, wo)]
    command: u16,
    /// Status
    ///
    /// What follows the first line is not its name.
    #[object(0x2003, ro, pdo)]
    status: u8,
    /// Level
    #[object(0x2004, rw, low = -100, high = 200)]
    level: i16,
    /// Floor
    #[object(0x2005, rw, low = 3)]
    floor: u8,
    /// Offset
    #[object(0x2006, rw, low = -8_000_000, high = -5)]
    offset: I24,
    /// Distance
    #[object(0x2007, rw, high = 1_000)]
    distance: u64,
    /// Name
    #[object(0x2008, rw, default = VisibleString::new(b"probe").unwrap_or_default())]
    name: VisibleString<8>,
    /// Blob
    #[object(0x2009, rw, default = Domain::new([0; 16]))]
    blob: Domain<[u8; 16]>,
    /// Gains
    #[object(0x3000, array, rw, default = [1, 2, 3])]
    gains: [u16; 3],
    /// Channel {}
    #[object(0x3100.., record)]
    channels: [Channel; 4],
    /// Counters {}
    #[object(0x3200.., array, ro)]
    counters: [[u32; 2]; 3],
    /// Switch {}
    #[object(0x3300.., rw)]
    switches: [bool; 2],
    /// Log
    #[object(0x3400, record)]
    log: Log,
    /// The first group
    #[objects]
    first: First,
    /// The second group
    #[objects]
    second: Second,
}

/// A channel.
#[derive(Clone, Copy, Debug, Record)]
#[record(0x40)]
struct Channel {
    /// Enabled
    #[sub(1, rw)]
    enabled: bool,
    /// Value
    #[sub(3, ro, pdo, default = 7)]
    value: u16,
}

/// Sub-index 0 is a number of its own; several in a row have others behind them.
#[derive(Clone, Copy, Debug, Record)]
struct Log {
    /// Number of lines
    #[sub(0, rw, high = 3)]
    lines: u8,
    /// Line
    #[sub(1.., ro, default = [10, 20, 30])]
    line: [u32; 3],
    /// Checksum
    #[sub(9, ro, default = 99)]
    checksum: u16,
}

/// A group within the range of the device's own.
#[derive(Clone, Debug, Objects)]
struct First {
    /// Between
    #[object(0x2FFF, rw, default = 11)]
    between: u8,
    /// A group of the group
    #[objects]
    inner: Inner,
}

/// A group in a group.
#[derive(Clone, Debug, Objects)]
struct Inner {
    /// Deep
    #[object(0x5000, rw, default = 22)]
    deep: u8,
}

/// Another group.
#[derive(Clone, Debug, Objects)]
struct Second {
    /// Last
    #[object(0xFFFF, rw, default = 33)]
    last: u8,
    /// First
    #[object(0x0100, rw, default = 44)]
    first: u8,
}

fn at(index: u16, sub: u8) -> Address {
    Address::new(index, sub)
}

fn read<D: Objects>(device: &mut D, index: u16, sub: u8) -> Result<Vec<u8>, AbortCode> {
    let mut found = checked::find(device, at(index, sub))?;
    let (Transfer::Whole(len) | Transfer::Stream(len)) = found.upload()?;
    let mut bytes = [0xEE; 32];
    let count = found.read(0, &mut bytes);
    assert_eq!(count, len);
    Ok(bytes[..count].to_vec())
}

fn write<D: Objects>(device: &mut D, index: u16, sub: u8, value: &[u8]) -> Result<(), AbortCode> {
    checked::find(device, at(index, sub))?.write(value)
}

/// Verifies: ECSS 6.1a
/// Notices: ECSS 6.8a: a sub-index that an object lacks is reported as an object that does not exist.
#[test]
fn what_is_not_there_is_told_apart() {
    let mut device = Device::default();
    for index in [
        0x0000, 0x00FF, 0x0101, 0x2000, 0x200A, 0x2FFE, 0x3001, 0x30FF, 0x3104, 0x3203, 0x3302, 0x5001,
        0xFFFE,
    ] {
        for sub in [0, 1, 255] {
            assert_eq!(read(&mut device, index, sub), Err(NoObject), "{index:04X}");
            assert_eq!(write(&mut device, index, sub, &[0]), Err(NoObject), "{index:04X}");
        }
    }
    let subs = [
        (0x2001, 1),
        (0x2001, 255),
        (0x3000, 4),
        (0x3100, 2),
        (0x3103, 4),
        (0x3200, 3),
        (0x3300, 1),
        (0x3400, 4),
        (0x3400, 8),
        (0x3400, 10),
        (0x2FFF, 1),
    ];
    for (index, sub) in subs {
        assert_eq!(read(&mut device, index, sub), Err(NoSubIndex), "{index:04X} {sub}");
        assert_eq!(write(&mut device, index, sub, &[0]), Err(NoSubIndex), "{index:04X} {sub}");
    }
}

/// Verifies: ECSS 6.1a
#[test]
fn access_rights() {
    let mut device = Device::default();
    for (index, sub, value) in
        [(0x2001, 0, &[0; 4][..]), (0x2003, 0, &[0]), (0x3200, 1, &[0; 4]), (0x3103, 3, &[0; 2])]
    {
        assert_eq!(write(&mut device, index, sub, value), Err(ReadOnly), "{index:04X}");
        assert!(read(&mut device, index, sub).is_ok());
    }
    assert_eq!(read(&mut device, 0x2002, 0), Err(WriteOnly));
    assert_eq!(write(&mut device, 0x2002, 0, &[0x34, 0x12]), Ok(()));
    assert_eq!(device.command, 0x1234);
    // The right comes before the length.
    assert_eq!(write(&mut device, 0x2003, 0, &[0; 9]), Err(ReadOnly));
}

#[test]
fn the_highest_sub_index_of_arrays_and_records() {
    let mut device = Device::default();
    for (index, highest) in [(0x3000, 3), (0x3100, 3), (0x3103, 3), (0x3200, 2), (0x3202, 2)] {
        assert_eq!(read(&mut device, index, 0), Ok(vec![highest]), "{index:04X}");
        assert_eq!(write(&mut device, index, 0, &[highest]), Err(ReadOnly), "{index:04X}");
    }
    // Declared as a value, it is one.
    assert_eq!(read(&mut device, 0x3400, 0), Ok(vec![0]));
    assert_eq!(write(&mut device, 0x3400, 0, &[2]), Ok(()));
    assert_eq!(write(&mut device, 0x3400, 0, &[4]), Err(ValueTooHigh));
    assert_eq!(device.log.lines, 2);
}

/// As many as there are.
#[derive(Objects)]
struct Wide {
    /// Value
    #[object(0x2000, array, rw, default = [7; 254])]
    values: [u8; 254],
}

#[test]
fn an_array_has_up_to_254_sub_indices() {
    let mut wide = Wide::default();
    assert_eq!(read(&mut wide, 0x2000, 0), Ok(vec![254]));
    assert_eq!(write(&mut wide, 0x2000, 254, &[9]), Ok(()));
    assert_eq!((wide.values[252], wide.values[253]), (7, 9));
    assert_eq!(read(&mut wide, 0x2000, 255), Err(NoSubIndex));
    assert_eq!(sub_indices(254), 254);
    assert!(std::panic::catch_unwind(|| sub_indices(255)).is_err());
}

#[test]
fn every_sub_index_is_the_value_declared_for_it() {
    let mut device = Device::default();
    for (sub, value) in [(1, 1), (2, 2), (3, 3)] {
        assert_eq!(read(&mut device, 0x3000, sub), Ok(vec![value, 0]));
    }
    for (sub, value) in [(1, 10), (2, 20), (3, 30)] {
        assert_eq!(read(&mut device, 0x3400, sub), Ok(vec![value, 0, 0, 0]));
    }
    assert_eq!(read(&mut device, 0x3400, 9), Ok(vec![99, 0]));
    assert_eq!(write(&mut device, 0x3000, 2, &[0xCD, 0xAB]), Ok(()));
    assert_eq!(device.gains, [1, 0xABCD, 3]);
}

#[test]
fn objects_in_a_row_are_told_apart() {
    let mut device = Device::default();
    for (nth, index) in (0x3100..=0x3103).enumerate() {
        device.channels[nth].value = index;
        assert_eq!(read(&mut device, index, 3), Ok(index.to_le_bytes().to_vec()));
        assert_eq!(write(&mut device, index, 1, &[1]), Ok(()));
        assert_eq!(device.channels.iter().filter(|channel| channel.enabled).count(), nth + 1);
    }
    device.counters = [[1, 2], [3, 4], [5, 6]];
    assert_eq!(read(&mut device, 0x3201, 2), Ok(vec![4, 0, 0, 0]));
    assert_eq!(read(&mut device, 0x3202, 1), Ok(vec![5, 0, 0, 0]));
    assert_eq!(write(&mut device, 0x3301, 0, &[1]), Ok(()));
    assert_eq!(device.switches, [false, true]);
}

#[test]
fn groups_nest() {
    let mut device = Device::default();
    for (index, value) in [(0x2FFF, 11), (0x5000, 22), (0xFFFF, 33), (0x0100, 44)] {
        assert_eq!(read(&mut device, index, 0), Ok(vec![value]), "{index:04X}");
        assert_eq!(write(&mut device, index, 0, &[value + 1]), Ok(()));
    }
    let Device { first, second, .. } = device;
    assert_eq!((first.between, first.inner.deep, second.last, second.first), (12, 23, 34, 45));
    assert_eq!(Device::COUNT, 14 + 2 + 2);
}

#[test]
fn every_place_is_found_once() {
    let mut places = vec![];
    for index in 0..=u16::MAX {
        for sub in 0..=10 {
            if let Ok((place, entry)) = Device::find(at(index, sub)) {
                assert!(!places.contains(&place), "{index:04X} {sub}");
                places.push(place);
                let is_there = Device::default().variable(place).is_some();
                assert_eq!(is_there, entry.fixed().is_none(), "{index:04X} {sub}");
            }
        }
    }
    // Single values, then arrays and records with their sub-indices.
    assert_eq!(places.len(), 9 + 4 + 4 * 3 + 3 * 3 + 2 + 5 + 4);
}

/// Verifies: ECSS 6.1a
#[test]
fn limits_have_their_abort_codes() {
    let mut device = Device { level: 1, floor: 3, offset: I24::new(-5), distance: 1, ..Device::default() };
    let i16 = |value: i16| value.to_le_bytes().to_vec();
    let i24 = |value: i32| value.to_le_bytes()[..3].to_vec();
    let u64 = |value: u64| value.to_le_bytes().to_vec();
    let table = [
        (0x2004, i16(-100), Ok(())),
        (0x2004, i16(200), Ok(())),
        (0x2004, i16(-101), Err(ValueTooLow)),
        (0x2004, i16(i16::MIN), Err(ValueTooLow)),
        (0x2004, i16(201), Err(ValueTooHigh)),
        (0x2004, i16(i16::MAX), Err(ValueTooHigh)),
        (0x2005, vec![3], Ok(())),
        (0x2005, vec![255], Ok(())),
        (0x2005, vec![2], Err(ValueTooLow)),
        (0x2006, i24(-5), Ok(())),
        (0x2006, i24(-8_000_000), Ok(())),
        (0x2006, i24(-4), Err(ValueTooHigh)),
        (0x2006, i24(0x7F_FFFF), Err(ValueTooHigh)),
        (0x2006, i24(-8_000_001), Err(ValueTooLow)),
        (0x2007, u64(0), Ok(())),
        (0x2007, u64(1_000), Ok(())),
        (0x2007, u64(1_001), Err(ValueTooHigh)),
        (0x2007, u64(i64::MAX as u64), Err(ValueTooHigh)),
        (0x2007, u64(u64::MAX), Err(ValueTooHigh)),
        // Length before value.
        (0x2007, vec![1; 7], Err(TooShort)),
        (0x2004, vec![0; 3], Err(TooLong)),
    ];
    for (index, value, expected) in table {
        let before = read(&mut device, index, 0).unwrap();
        assert_eq!(write(&mut device, index, 0, &value), expected, "{index:04X} = {value:02X?}");
        let after = if expected.is_ok() { value } else { before };
        assert_eq!(read(&mut device, index, 0), Ok(after), "{index:04X}");
    }
}

/// Verifies: ECSS 6.1a
#[test]
fn download_of_wrong_size_is_refused_before_its_data() {
    let mut device = Device::default();
    let mut download = |index, size| checked::find(&mut device, at(index, 0)).unwrap().download(size);
    assert_eq!(download(0x2004, Some(2)), Ok(Transfer::Whole(2)));
    assert_eq!(download(0x2004, None), Ok(Transfer::Whole(2)));
    assert_eq!(download(0x2004, Some(1)), Err(TooShort));
    assert_eq!(download(0x2004, Some(20_000)), Err(TooLong));
    assert_eq!(download(0x2008, Some(0)), Ok(Transfer::Whole(8)));
    assert_eq!(download(0x2008, Some(9)), Err(TooLong));
    assert_eq!(download(0x2003, Some(1)), Err(ReadOnly));
    assert_eq!(download(0x3000, Some(1)), Err(ReadOnly));
}

/// Verifies: ECSS 6.6a
#[test]
fn names_and_kinds_are_those_of_the_declaration() {
    let mut described = vec![];
    Device::describe(&mut |object, names: &Names| described.push((*object, *names)));
    let of = |index| *described.iter().find(|(object, _)| object.index == index).unwrap();
    assert_eq!(described.len(), 18);
    let (object, names) = of(0x2001);
    assert_eq!(
        (names.code, object.count, names.object, names.structure),
        (ObjectCode::Var, 1, "Serial number", 0)
    );
    assert_eq!(of(0x2003).1.object, "Status");
    assert_eq!(of(0x2009).1.code, ObjectCode::Domain);
    let (_, names) = of(0x3000);
    assert_eq!(
        (names.code, names.entries),
        (ObjectCode::Array, &["Highest sub-index supported", "Gains"][..])
    );
    let (object, names) = of(0x3100);
    assert_eq!((names.code, object.count, names.object), (ObjectCode::Record, 4, "Channel {}"));
    assert_eq!(
        (names.entries, names.structure),
        (&["Highest sub-index supported", "Enabled", "Value"][..], 0x40)
    );
    assert_eq!(of(0x3400).1.entries, ["Number of lines", "Line", "Checksum"]);
    assert_eq!(of(0x5000).1.object, "Deep");
}

/// Verifies: ECSS 6.1a
#[test]
fn abort_codes_are_known_by_their_values() {
    for code in AbortCode::ALL {
        assert_eq!(AbortCode::from_code(code.code()), Some(code));
    }
    for (code, value) in
        [(NoObject, 0x0602_0000), (ValueRange, 0x0609_0030), (AbortCode::NoData, 0x0800_0024)]
    {
        assert_eq!(code.code(), value);
    }
    for unknown in [0, 0x0503_0001, 0x0800_0025, u32::MAX] {
        assert_eq!(AbortCode::from_code(unknown), None);
    }
}
