//! Values of every type: their bytes, their bits, what they refuse.
//!
//! Verifies: ECSS 6.8a

use async_canopen::od::checked::Found;
use async_canopen::od::machine::Transfer;
use async_canopen::od::{
    Access, Bytes, DataType, Entry, I24, I40, I48, I56, OctetString, Place, TimeDifference, TimeOfDay, Typed,
    U24, U40, U48, U56, UnicodeString, Variable, VisibleString, checked,
};
use async_canopen::types::AbortCode;
use async_canopen::types::AbortCode::{Length, OutOfMemory, TooLong, TooShort, ValueRange};

use super::{Device, at, read, write};

/// A value and its declaration, as if a dictionary had found it.
fn found<'a, T: Variable>(variable: &'a mut T, entry: &'static Entry) -> Found<'a> {
    Found { place: Place { object: 0, instance: 0, sub: 0 }, entry, variable: Some(variable) }
}

/// A value of this type: takes `bytes` and is `value` then, gives them back whole and in parts, refuses other lengths.
fn round_trip<T: Typed + Default + PartialEq + std::fmt::Debug>(data_type: DataType, bytes: &[u8], value: T) {
    assert_eq!(T::TYPE, data_type);
    let entry: &'static Entry = Box::leak(Box::new(Entry::of::<T>(0, 1, Access::Rw)));
    let mut variable = T::default();
    found(&mut variable, entry).write(bytes).unwrap();
    assert_eq!(variable, value);
    assert_eq!((found(&mut variable, entry).upload_len(), T::SIZE), (bytes.len(), bytes.len()));
    for offset in 0..=bytes.len() + 1 {
        let mut part = [0; 3];
        let count = found(&mut variable, entry).read(offset, &mut part);
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
    assert_eq!(found(&mut variable, entry).write(&longer), Err(TooLong));
    assert_eq!(found(&mut variable, entry).write(&bytes[1..]), Err(TooShort));
    assert_eq!(variable, value);
}

/// Verifies: ECSS 6.2a
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
    async_canopen::od::Variable::set_bits(&mut time, 0x0001_FFFF_FFFF);
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
    assert_eq!(async_canopen::od::Bytes::write(&mut text, &[0x41]), Err(Length));
    // Equal whatever stood there before.
    let mut again = VisibleString::<8>::new(b"long").unwrap();
    async_canopen::od::Bytes::write(&mut again, b"x").unwrap();
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
    let blob = found.bytes().unwrap();
    blob.write_part(0, b"first ").unwrap();
    blob.write_part(6, b"second").unwrap();
    assert_eq!(blob.len(), 0);
    blob.finish(12).unwrap();
    assert_eq!(found.upload(), Ok(Transfer::Stream(12)));
    assert_eq!(device.blob.as_bytes(), b"first second");
    let mut found = checked::find(&mut device, at(0x2009, 0)).unwrap();
    let blob = found.bytes().unwrap();
    assert_eq!(blob.write_part(10, b"1234567"), Err(OutOfMemory));
    blob.cancel();
    assert_eq!(device.blob.as_bytes(), b"");
    assert_eq!(write(&mut device, 0x2009, 0, b"all at once"), Ok(()));
    assert_eq!(read(&mut device, 0x2009, 0), Ok(b"all at once".to_vec()));
}

#[test]
fn a_number_and_a_text_that_never_changes_take_no_parts() {
    let mut device = Device::default();
    assert!(checked::find(&mut device, at(0x2004, 0)).unwrap().bytes().is_none());
    let text: &mut dyn Bytes = &mut "constant";
    assert_eq!(text.write_part(0, &[1]), Err(AbortCode::UnsupportedAccess));
    assert_eq!(text.finish(1), Err(AbortCode::UnsupportedAccess));
    assert_eq!(text.capacity(), 0);
}
