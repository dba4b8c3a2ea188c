//! The object dictionary: types, places, access rights, limits.

use ecss_can::nmt::NodeId;
use ecss_can::od::communication::{Communication, INVALID, Mapping, NO_REMOTE, StaticMapping};
use ecss_can::od::spacecraft::{ScetGet, ScetSet, Spacecraft};
use ecss_can::od::{
    AbortCode, Address, DataType, Domain, I24, I40, I48, I56, Names, ObjectCode, Objects, OctetString,
    Record, TimeDifference, TimeOfDay, Transfer, Typed, U24, U40, U48, U56, UnicodeString, VisibleString,
    checked, sub_indices,
};
use ecss_can::pdo::{Direction, Layout};
use ecss_can::time::Scet;

use AbortCode::{
    Length, NoObject, NoSubIndex, OutOfMemory, ReadOnly, TooLong, TooShort, ValueRange, ValueTooHigh,
    ValueTooLow, WriteOnly,
};

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
    let found = checked::find(device, at(index, sub))?;
    let (Transfer::Whole(len) | Transfer::Stream(len)) = found.upload()?;
    let mut bytes = [0xEE; 32];
    let count = found.read(0, &mut bytes);
    assert_eq!(count, len);
    Ok(bytes[..count].to_vec())
}

fn write<D: Objects>(device: &mut D, index: u16, sub: u8, value: &[u8]) -> Result<(), AbortCode> {
    checked::find(device, at(index, sub))?.write(value)
}

/// A value of this type: takes `bytes` and is `value` then, gives them back whole and in parts, refuses other lengths.
fn round_trip<T: Typed + Default + PartialEq + std::fmt::Debug>(data_type: DataType, bytes: &[u8], value: T) {
    assert_eq!(T::TYPE, data_type);
    let mut variable = T::default();
    variable.write(bytes).unwrap();
    assert_eq!(variable, value);
    assert_eq!((variable.len(), T::SIZE), (bytes.len(), bytes.len()));
    for offset in 0..=bytes.len() + 1 {
        let mut part = [0; 3];
        let count = variable.read(offset, &mut part);
        let rest = bytes.get(offset..).unwrap_or(&[]);
        assert_eq!(part[..count], rest[..rest.len().min(3)], "{data_type:?} from {offset}");
    }
    // In a PDO it has the same bits, and takes nothing of what lies above them.
    let mut low = [0; 8];
    low[..bytes.len()].copy_from_slice(bytes);
    assert_eq!(variable.bits(), u64::from_le_bytes(low));
    variable.set_bits(0);
    assert_eq!(variable.bits(), 0);
    let above = u64::MAX.checked_shl(u32::from(data_type.bits().unwrap())).unwrap_or(0);
    variable.set_bits(u64::from_le_bytes(low) | above);
    assert_eq!(variable, value);

    let longer = [bytes, &[0]].concat();
    assert_eq!(variable.write(&longer), Err(TooLong));
    assert_eq!(variable.write(&bytes[1..]), Err(TooShort));
    assert_eq!(variable, value);
}

#[test]
fn values_of_every_type_of_fixed_size() {
    use DataType as T;
    round_trip(T::Boolean, &[1], true);
    round_trip(T::Integer8, &[0x80], -128_i8);
    round_trip(T::Integer16, &[0xFE, 0xFF], -2_i16);
    round_trip(T::Integer24, &[0x00, 0x00, 0x80], I24::new(-0x80_0000));
    round_trip(T::Integer32, &[0x78, 0x56, 0x34, 0x92], -0x6DCB_A988_i32);
    round_trip(T::Integer40, &[0xFF; 5], I40::new(-1));
    round_trip(T::Integer48, &[0, 0, 0, 0, 0, 0x80], I48::new(-0x8000_0000_0000));
    round_trip(T::Integer56, &[1, 0, 0, 0, 0, 0, 0xFF], I56::new(-0xFFFF_FFFF_FFFF));
    round_trip(T::Integer64, &[0, 0, 0, 0, 0, 0, 0, 0x80], i64::MIN);
    round_trip(T::Unsigned8, &[0xA5], 0xA5_u8);
    round_trip(T::Unsigned16, &[0x34, 0x12], 0x1234_u16);
    round_trip(T::Unsigned24, &[0x56, 0x34, 0xF2], U24::new(0xF2_3456));
    round_trip(T::Unsigned32, &[0x78, 0x56, 0x34, 0xF2], 0xF234_5678_u32);
    round_trip(T::Unsigned40, &[0x9A, 0x78, 0x56, 0x34, 0xF2], U40::new(0xF2_3456_789A));
    round_trip(T::Unsigned48, &[0xBC, 0x9A, 0x78, 0x56, 0x34, 0xF2], U48::new(0xF234_5678_9ABC));
    round_trip(T::Unsigned56, &[0xDE, 0xBC, 0x9A, 0x78, 0x56, 0x34, 0xF2], U56::new(0xF2_3456_789A_BCDE));
    round_trip(T::Unsigned64, &[1, 2, 3, 4, 5, 6, 7, 0xF8], 0xF807_0605_0403_0201_u64);
    round_trip(T::Real32, &[0, 0, 0x20, 0xC1], -10.0_f32);
    round_trip(T::Real64, &[0, 0, 0, 0, 0, 0, 0xE0, 0x3F], 0.5_f64);
    round_trip(T::TimeOfDay, &[4, 3, 2, 1, 6, 5], TimeOfDay { days: 0x0506, ms: 0x0102_0304 });
    round_trip(T::TimeDifference, &[4, 3, 2, 1, 6, 5], TimeDifference { days: 0x0506, ms: 0x0102_0304 });
}

#[test]
fn numbers_of_odd_widths_are_cut_off_and_extended() {
    assert_eq!(U24::new(0x1234_5678).get(), 0x34_5678);
    assert_eq!(U56::new(u64::MAX).get(), 0xFF_FFFF_FFFF_FFFF);
    assert_eq!(I24::new(0x80_0000).get(), -0x80_0000);
    assert_eq!(I24::new(0x17F_FFFF).get(), 0x7F_FFFF);
    assert_eq!(I56::new(-1).get(), -1);
}

#[test]
fn the_reserved_bits_of_a_time_are_not_kept() {
    let mut time = TimeOfDay::default();
    ecss_can::od::Variable::write(&mut time, &[0xFF, 0xFF, 0xFF, 0xFF, 1, 0]).unwrap();
    assert_eq!(time, TimeOfDay { days: 1, ms: 0x0FFF_FFFF });
}

#[test]
fn the_bits_of_every_type() {
    let sizes = [
        (DataType::Boolean, 1),
        (DataType::Integer24, 24),
        (DataType::TimeOfDay, 48),
        (DataType::Real64, 64),
    ];
    for (data_type, bits) in sizes {
        assert_eq!(data_type.bits(), Some(bits));
    }
    for text in [DataType::VisibleString, DataType::OctetString, DataType::UnicodeString, DataType::Domain] {
        assert_eq!((text.bits(), text.size()), (None, None));
    }
}

#[test]
fn strings_have_the_length_they_were_given() {
    let mut device = Device::default();
    assert_eq!(read(&mut device, 0x2008, 0), Ok(b"probe".to_vec()));
    for text in [&b"12345678"[..], b"x", b""] {
        assert_eq!(write(&mut device, 0x2008, 0, text), Ok(()));
        assert_eq!(read(&mut device, 0x2008, 0), Ok(text.to_vec()));
        assert_eq!(device.name.as_bytes(), text);
    }
    assert_eq!(write(&mut device, 0x2008, 0, b"123456789"), Err(TooLong));
    assert_eq!(write(&mut device, 0x2008, 0, b"tab\t"), Err(ValueRange));
    assert_eq!(write(&mut device, 0x2008, 0, &[0xFC]), Err(ValueRange));
    assert_eq!(read(&mut device, 0x2008, 0), Ok(vec![]));
    assert_eq!(OctetString::<3>::new(&[0, 255, 9]).unwrap().as_bytes(), [0, 255, 9]);
    assert_eq!(OctetString::<3>::new(&[0; 4]), None);
    assert_eq!(UnicodeString::<4>::new(&[0x41, 0, 0x42, 0]).unwrap().as_bytes(), [0x41, 0, 0x42, 0]);
    let mut text = UnicodeString::<4>::empty();
    assert_eq!(ecss_can::od::Variable::write(&mut text, &[0x41]), Err(Length));
    // Equal whatever stood there before.
    let mut again = VisibleString::<8>::new(b"long").unwrap();
    ecss_can::od::Variable::write(&mut again, b"x").unwrap();
    assert_eq!(Some(again), VisibleString::new(b"x"));
}

#[test]
fn a_domain_is_empty_until_it_is_whole() {
    let mut device = Device::default();
    assert_eq!(read(&mut device, 0x2009, 0), Ok(vec![]));
    let mut found = checked::find(&mut device, at(0x2009, 0)).unwrap();
    assert_eq!(found.download(Some(16)), Ok(Transfer::Stream(16)));
    assert_eq!(found.download(None), Ok(Transfer::Stream(16)));
    assert_eq!(found.download(Some(17)), Err(OutOfMemory));
    let blob = found.variable.as_mut().unwrap();
    blob.write_part(0, b"first ").unwrap();
    blob.write_part(6, b"second").unwrap();
    assert_eq!(blob.len(), 0);
    blob.finish(12).unwrap();
    assert_eq!(found.upload(), Ok(Transfer::Stream(12)));
    assert_eq!(device.blob.as_bytes(), b"first second");
    let blob = checked::find(&mut device, at(0x2009, 0)).unwrap().variable.unwrap();
    assert_eq!(blob.write_part(10, b"1234567"), Err(OutOfMemory));
    blob.cancel();
    assert_eq!(device.blob.as_bytes(), b"");
    assert_eq!(write(&mut device, 0x2009, 0, b"all at once"), Ok(()));
    assert_eq!(read(&mut device, 0x2009, 0), Ok(b"all at once".to_vec()));
}

#[test]
fn a_value_that_is_no_domain_takes_no_parts() {
    let mut device = Device::default();
    let value = checked::find(&mut device, at(0x2004, 0)).unwrap().variable.unwrap();
    assert_eq!(value.write_part(0, &[1]), Err(AbortCode::UnsupportedAccess));
    assert_eq!(value.finish(1), Err(AbortCode::UnsupportedAccess));
    assert_eq!(value.capacity(), 0);
}

/// Verifies: ECSS 6.1a
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
                assert_eq!(is_there, entry.fixed.is_none(), "{index:04X} {sub}");
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

#[test]
fn a_download_is_refused_before_its_data_when_its_size_says_enough() {
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

#[test]
fn names_and_kinds_are_those_of_the_declaration() {
    let mut described = vec![];
    Device::describe(&mut |object, names: &Names| described.push((*object, *names)));
    let of = |index| *described.iter().find(|(object, _)| object.index == index).unwrap();
    assert_eq!(described.len(), 18);
    let (object, names) = of(0x2001);
    assert_eq!(
        (object.code, object.count, names.object, names.structure),
        (ObjectCode::Var, 1, "Serial number", 0)
    );
    assert_eq!(of(0x2003).1.object, "Status");
    assert_eq!(of(0x2009).0.code, ObjectCode::Domain);
    let (object, names) = of(0x3000);
    assert_eq!(
        (object.code, names.entries),
        (ObjectCode::Array, &["Highest sub-index supported", "Gains"][..])
    );
    let (object, names) = of(0x3100);
    assert_eq!((object.code, object.count, names.object), (ObjectCode::Record, 4, "Channel {}"));
    assert_eq!(
        (names.entries, names.structure),
        (&["Highest sub-index supported", "Enabled", "Value"][..], 0x40)
    );
    assert_eq!(of(0x3400).1.entries, ["Number of lines", "Line", "Checksum"]);
    assert_eq!(of(0x5000).1.object, "Deep");
}

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

/// Verifies: ECSS 6.10a
#[test]
fn a_node_has_the_cob_ids_of_the_pre_defined_connection_set_until_it_is_told_otherwise() {
    let objects = Communication::<6, 5>::new(NodeId::new(5).unwrap());
    assert_eq!(objects.emcy_cob_id, 0x85);
    let ids = |cob_ids: &[u32]| cob_ids.iter().map(|raw| raw & !(INVALID | NO_REMOTE)).collect::<Vec<_>>();
    let received = objects.rpdos.map(|pdo| pdo.cob_id);
    let sent = objects.tpdos.map(|pdo| pdo.cob_id);
    assert_eq!(ids(&received), [0x205, 0x305, 0x405, 0x505, 0, 0]);
    assert_eq!(ids(&sent), [0x185, 0x285, 0x385, 0x485, 0]);
    // None of them is in use: nothing is mapped.
    assert!(received.iter().chain(&sent).all(|raw| raw & INVALID != 0));
    assert!(
        objects
            .rpdo_mappings
            .iter()
            .chain(&objects.tpdo_mappings)
            .all(|mapping| mapping.objects().is_empty())
    );
}

#[test]
fn a_static_mapping_cannot_be_written() {
    let mut objects = Communication::<1, 1, StaticMapping>::new(NodeId::new(5).unwrap());
    objects.tpdo_mappings[0].map(&[0x1001_0008]);
    assert_eq!(read(&mut objects, 0x1A00, 0), Ok(vec![1]));
    assert_eq!(read(&mut objects, 0x1A00, 1), Ok(vec![0x08, 0x00, 0x01, 0x10]));
    for sub in 0..=8 {
        let value = if sub == 0 { &[0][..] } else { &[0; 4] };
        assert_eq!(write(&mut objects, 0x1A00, sub, value), Err(ReadOnly), "{sub}");
    }
}

/// Verifies: ECSS 8.3.1a, 8.3.1c
#[test]
fn the_redundancy_object_has_four_programmable_values() {
    let mut objects = Spacecraft::default();
    assert_eq!(read(&mut objects, 0x2000, 0), Ok(vec![4]));
    for sub in 1..=4 {
        assert_eq!(write(&mut objects, 0x2000, sub, &[sub + 10]), Ok(()), "{sub}");
        assert_eq!(read(&mut objects, 0x2000, sub), Ok(vec![sub + 10]));
    }
    let redundancy = objects.redundancy;
    assert_eq!(
        [redundancy.bdefault, redundancy.ttoggle, redundancy.ntoggle, redundancy.ctoggle],
        [11, 12, 13, 14]
    );
}

/// Verifies: ECSS 7.1.2b, 7.1.2c, 7.1.2d, 7.1.2e, 7.1.2f
#[test]
fn spacecraft_time_is_set_and_got_in_the_format_of_the_figure() {
    let mut objects = Spacecraft::default();
    // Fine time first, both little-endian.
    let frame = [0x56, 0x34, 0x12, 0xEF, 0xCD, 0xAB, 0x89, 0];
    let set = Layout::new::<Spacecraft>(Direction::Receive, &[0x2010_0218, 0x2010_0120]).unwrap();
    assert!(set.unpack(&mut objects, u64::from_le_bytes(frame)));
    assert_eq!(objects.scet_set, ScetSet { coarse: 0x89AB_CDEF, fine: U24::new(0x12_3456) });
    let scet = Scet::from(objects.scet_set);
    assert_eq!((scet.coarse(), scet.fine()), (0x89AB_CDEF, 0x12_3456));
    objects.scet_get = ScetGet::from(scet);
    let get = Layout::new::<Spacecraft>(Direction::Transmit, &[0x2011_0218, 0x2011_0120]).unwrap();
    assert_eq!((get.bytes(), get.pack(&objects).to_le_bytes()), (7, frame));
    assert_eq!(read(&mut objects, 0x2011, 1), Ok(frame[3..7].to_vec()));
    assert_eq!(read(&mut objects, 0x2011, 2), Ok(frame[..3].to_vec()));
    assert_eq!(write(&mut objects, 0x2011, 1, &[0; 4]), Err(ReadOnly));
}

/// Verifies: ECSS 6.7b, 6.7c
#[test]
fn the_self_test_is_started_by_one_object_and_told_by_another() {
    let mut objects = Spacecraft::default();
    assert_eq!(write(&mut objects, 0x2030, 0, &[0]), Err(ValueTooLow));
    assert_eq!(write(&mut objects, 0x2030, 0, &[2]), Err(ValueTooHigh));
    assert_eq!(write(&mut objects, 0x2030, 0, &[1]), Ok(()));
    assert_eq!(read(&mut objects, 0x2030, 0), Err(WriteOnly));
    objects.self_test.progress = 3;
    objects.self_test.failures = 0x8000_0001;
    assert_eq!(read(&mut objects, 0x2031, 1), Ok(vec![3]));
    assert_eq!(read(&mut objects, 0x2031, 2), Ok(vec![1, 0, 0, 0x80]));
    assert_eq!(write(&mut objects, 0x2031, 1, &[0]), Err(ReadOnly));
}
