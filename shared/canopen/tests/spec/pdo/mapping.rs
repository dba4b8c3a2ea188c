//! Mappings: what may be mapped, and where its bits are.
//!
//! Verifies: ECSS 6.2a

use async_canopen::od::{Objects, TimeDifference, TimeOfDay, U24, checked};
use async_canopen::pdo::{Direction, Layout};
use async_canopen::types::{AbortCode, Address};
use proptest::prelude::*;

use super::device::{BOTH_WAYS, Device, WORDS, dump, entry, read};
use crate::random::cases;

use Direction::{Receive, Transmit};

fn resolve(direction: Direction, entries: &[u32]) -> Result<Layout, AbortCode> {
    Layout::new::<Device>(direction, entries)
}

#[test]
fn words_lie_one_behind_the_other_low_byte_first() {
    let mut device = Device::default();
    let layout = resolve(Receive, &WORDS).unwrap();
    assert_eq!(layout.bytes(), 8);
    layout.unpack(&mut device, u64::from_le_bytes([0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08]));
    assert_eq!(device.words, [0x0201, 0x0403, 0x0605, 0x0807, 0]);
    device.words = [0x1122, 0x3344, 0x5566, 0x7788, 0x99AA];
    let sent = resolve(Transmit, &WORDS).unwrap().pack(&device);
    assert_eq!(sent.to_le_bytes(), [0x22, 0x11, 0x44, 0x33, 0x66, 0x55, 0x88, 0x77]);
}

#[test]
fn bits_follow_each_other_without_gaps() {
    // Two flags, 24 bits, a flag, one of three in a row.
    let entries = [
        entry(0x6001, 1, 1),
        entry(0x6001, 8, 1),
        entry(0x6011, 1, 24),
        entry(0x6012, 2, 1),
        entry(0x6022, 0, 8),
    ];
    let mut device = Device { rwr: 0xA5, ..Device::default() };
    device.flags[7] = true;
    device.channels[1].gain = U24::new(0x123456);
    device.channels[2].enabled = true;
    let layout = resolve(Transmit, &entries).unwrap();
    assert_eq!(layout.bytes(), 5);
    let expected = 0b10 | 0x123456 << 2 | 1 << 26 | 0xA5 << 27;
    assert_eq!(layout.pack(&device), expected);
}

#[test]
fn the_number_of_bytes_covers_the_bits() {
    let flags: Vec<u32> = (1..=8).map(|sub| entry(0x6001, sub, 1)).collect();
    for mapped in 1..=8 {
        assert_eq!(resolve(Receive, &flags[..mapped]).unwrap().bytes(), 1);
    }
    assert_eq!(resolve(Receive, &[]).unwrap().bytes(), 0);
    assert_eq!(resolve(Receive, &[entry(0x6107, 0, 32), entry(0x6001, 1, 1)]).unwrap().bytes(), 5);
    assert_eq!(resolve(Receive, &[entry(0x611B, 0, 64)]).unwrap().bytes(), 8);
}

#[test]
fn what_cannot_be_mapped_is_refused_with_its_abort_code() {
    use AbortCode::{NoObject, NoSubIndex, NotMappable};
    let both = [
        (0, NoObject),
        (entry(0x5FFF, 0, 8), NoObject),
        (entry(0x6013, 1, 24), NoObject),
        (entry(0x6000, 6, 16), NoSubIndex),
        (entry(0x6012, 3, 1), NoSubIndex),
        (entry(0x6022, 1, 8), NoSubIndex),
        // Not for PDOs: declared so, sub-index 0, a text, which has no fixed size.
        (entry(0x6025, 0, 8), NotMappable),
        (entry(0x6000, 0, 8), NotMappable),
        (entry(0x6010, 0, 8), NotMappable),
        (entry(0x6026, 0, 64), NotMappable),
        (entry(0x6026, 0, 0), NotMappable),
        // Another number of bits than the type has.
        (entry(0x6000, 1, 8), NotMappable),
        (entry(0x6000, 1, 17), NotMappable),
        (entry(0x6000, 1, 0), NotMappable),
        (entry(0x6001, 1, 8), NotMappable),
        (entry(0x611B, 0, 65), NotMappable),
        // Dummies: sub-index and bits of their type, no others.
        (entry(0x0005, 1, 8), NoSubIndex),
        (entry(0x0005, 0, 16), NotMappable),
        (entry(0x0008, 0, 32), NoObject),
        (entry(0x0010, 0, 24), NoObject),
    ];
    for (entry, code) in both {
        for direction in [Receive, Transmit] {
            assert_eq!(resolve(direction, &[entry]), Err(code), "{entry:08X} {direction:?}");
        }
    }
}

#[test]
fn the_access_right_says_which_way_a_value_may_go() {
    let table = [(0x6020, false, true), (0x6021, true, false), (0x6022, false, true), (0x6023, true, false)];
    for (index, receive, transmit) in table.into_iter().chain([(0x6024, false, true), (0x6102, true, true)]) {
        for (direction, allowed) in [(Receive, receive), (Transmit, transmit)] {
            let expected = if allowed { Ok(1) } else { Err(AbortCode::NotMappable) };
            let bytes = resolve(direction, &[entry(index, 0, 8)]).map(|layout| layout.bytes());
            assert_eq!(bytes, expected, "{index:04X} {direction:?}");
        }
    }
}

#[test]
fn dummies_skip_bits_of_a_receive_pdo() {
    let dummies = [(1, 1), (2, 8), (3, 16), (4, 32), (5, 8), (6, 16), (7, 32)];
    for (index, bits) in dummies {
        let entries = [entry(index, 0, bits), entry(0x6103, 0, 16)];
        let layout = resolve(Receive, &entries).unwrap();
        let mut device = Device::default();
        let mut expected = device.clone();
        expected.wide.i16 = 0x1234;
        layout.unpack(&mut device, u64::MAX >> (64 - bits) | 0x1234 << bits);
        assert_eq!(dump(&mut device), dump(&mut expected), "{index:04X}");
        assert_eq!(layout.bytes(), (u32::from(bits) + 16).div_ceil(8) as u8);
        assert_eq!(resolve(Transmit, &entries), Err(AbortCode::NotMappable), "{index:04X}");
    }
}

#[test]
fn more_than_a_pdo_holds_is_refused() {
    let too_long = Err(AbortCode::PdoLength);
    assert_eq!(resolve(Receive, &[entry(0x611B, 0, 64), entry(0x6001, 1, 1)]), too_long);
    assert_eq!(resolve(Receive, &[entry(0x611A, 0, 56), entry(0x6103, 0, 16)]), too_long);
    assert_eq!(resolve(Transmit, &[entry(0x611B, 0, 64); 8]), too_long);
    assert_eq!(resolve(Transmit, &[entry(0x6001, 1, 1); 9]), too_long);
    assert!(resolve(Transmit, &[entry(0x6001, 1, 1); 8]).is_ok());
    assert!(resolve(Transmit, &[entry(0x611A, 0, 56), entry(0x6102, 0, 8)]).is_ok());
}

/// More in a row than anybody has PDOs for.
#[derive(Objects)]
struct Many {
    /// Value {}
    #[object(0x6000.., rw, pdo)]
    values: [u16; 513],
}

#[test]
fn the_last_of_many_objects_in_a_row() {
    let mut many = Many::default();
    let entries = [entry(0x6000, 0, 16), entry(0x60FF, 0, 16), entry(0x6100, 0, 16), entry(0x61FF, 0, 16)];
    let layout = Layout::new::<Many>(Receive, &entries).unwrap();
    assert!(layout.unpack(&mut many, 0x0004_0003_0002_0001));
    assert_eq!([0, 255, 256, 511].map(|nth| many.values[nth]), [1, 2, 3, 4]);
    assert_eq!(many.values.iter().filter(|value| **value != 0).count(), 4);
    assert_eq!(Layout::new::<Many>(Receive, &[entry(0x6200, 0, 16)]), Err(AbortCode::NotMappable));
}

#[test]
fn times_go_in_a_pdo_as_they_go_in_an_sdo() {
    let mut device = Device::default();
    device.wide.time = TimeOfDay { days: 0xABCD, ms: 0x0765_4321 };
    device.wide.difference = TimeDifference { days: 0x1234, ms: u32::MAX };
    for index in [0x610C, 0x610D] {
        let layout = resolve(Transmit, &[entry(index, 0, 48)]).unwrap();
        let sent = layout.pack(&device).to_le_bytes();
        assert_eq!(sent[..6], read(&mut device, Address::new(index, 0)));
        assert_eq!(sent[6..], [0, 0]);
    }
}

#[test]
fn it_knows_the_values_it_carries() {
    let layout = resolve(Transmit, &[entry(0x6000, 2, 16), entry(0x6011, 1, 24)]).unwrap();
    let place = |index, sub| Device::find(Address::new(index, sub)).unwrap().0;
    assert!(layout.carries(place(0x6000, 2)) && layout.carries(place(0x6011, 1)));
    for (index, sub) in [(0x6000, 1), (0x6000, 3), (0x6010, 1), (0x6012, 1), (0x6011, 2), (0x6020, 0)] {
        assert!(!layout.carries(place(index, sub)), "{index:04X} {sub}");
    }
}

/// Bits `first..first + bits`, one by one.
fn cut(pdo: [u8; 8], first: usize, bits: usize) -> Vec<u8> {
    let mut bytes = vec![0; bits.div_ceil(8)];
    for bit in 0..bits {
        let from = first + bit;
        if pdo[from / 8] & 1 << (from % 8) != 0 {
            bytes[bit / 8] |= 1 << (bit % 8);
        }
    }
    bytes
}

#[test]
fn of_a_row_with_limits_only_what_keeps_them_is_written() {
    let mut device = Device::default();
    let layout = resolve(Receive, &[1, 2, 3].map(|sub| entry(0x6028, sub, 8))).unwrap();
    assert!(layout.unpack(&mut device, u64::from_le_bytes([5, 0xFB, 1, 0xFF, 0, 0, 0, 0])));
    assert_eq!(device.trims.trim, [5, -5, 1]);
    assert!(!layout.unpack(&mut device, u64::from_le_bytes([2, 6, 0xFE, 0, 0, 0, 0, 0])));
    assert_eq!(device.trims.trim, [2, -5, -2]);
}

proptest! {
    #![proptest_config(cases(2_000))]

    #[test]
    fn sub_indices_in_a_row_move_as_each_alone(
        rows in proptest::collection::vec((any::<bool>(), 1..=8_u8, 1..=8_u8), 1..=4),
        pdo in any::<[u8; 8]>(),
    ) {
        // Of the flags and words, so many from one on, until the PDO is full.
        let (mut entries, mut fields, mut at) = (vec![], vec![], 0);
        for (is_flag, first, count) in rows {
            let (index, last, bits) = if is_flag { (0x6001, 8, 1) } else { (0x6000, 5, 16) };
            for sub in (first..=last).take(count.into()) {
                let address = Address::new(index, sub);
                if at + bits <= 64 && entries.len() < 8 && fields.iter().all(|(other, _)| *other != address) {
                    entries.push(entry(index, sub, bits as u8));
                    fields.push((address, cut(pdo, at, bits)));
                    at += bits;
                }
            }
        }
        let (mut device, mut expected) = (Device::default(), Device::default());
        for (address, value) in &fields {
            checked::find(&mut expected, *address).unwrap().write(value).unwrap();
        }
        let layout = resolve(Receive, &entries).unwrap();
        layout.unpack(&mut device, u64::from_le_bytes(pdo));
        prop_assert_eq!(dump(&mut device), dump(&mut expected));
        prop_assert_eq!(usize::from(layout.bytes()), at.div_ceil(8));

        let sent = resolve(Transmit, &entries).unwrap();
        let mut whole = cut(pdo, 0, at);
        whole.resize(8, 0);
        prop_assert_eq!(sent.pack(&device).to_le_bytes().to_vec(), whole);
        for (index, last) in [(0x6000, 5), (0x6001, 8)] {
            for sub in 1..=last {
                let address = Address::new(index, sub);
                let (place, _) = Device::find(address).unwrap();
                prop_assert_eq!(sent.carries(place), fields.iter().any(|(mapped, _)| *mapped == address));
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(2_000))]

    #[test]
    fn every_mapping_reads_and_writes_its_bits_and_no_others(
        order in Just(BOTH_WAYS.to_vec()).prop_shuffle(),
        pdo in any::<[u8; 8]>(),
        before in any::<[u8; 64]>(),
    ) {
        // As many as fit.
        let (mut entries, mut fields, mut at) = (vec![], vec![], 0);
        for (index, sub, bits) in order {
            if at + usize::from(bits) <= 64 && entries.len() < 8 {
                entries.push(entry(index, sub, bits));
                fields.push((Address::new(index, sub), cut(pdo, at, usize::from(bits))));
                at += usize::from(bits);
            }
        }
        let mut device = Device::default();
        for (bytes, (index, sub, bits)) in before.windows(8).zip(BOTH_WAYS) {
            let value = if bits == 1 { vec![bytes[0] & 1] } else { bytes[..usize::from(bits / 8)].to_vec() };
            checked::find(&mut device, Address::new(index, sub)).unwrap().write(&value).unwrap();
        }
        let mut expected = device.clone();
        for (address, value) in &fields {
            checked::find(&mut expected, *address).unwrap().write(value).unwrap();
        }

        let received = resolve(Receive, &entries).unwrap();
        received.unpack(&mut device, u64::from_le_bytes(pdo));
        prop_assert_eq!(dump(&mut device), dump(&mut expected));
        prop_assert_eq!(usize::from(received.bytes()), at.div_ceil(8));

        // What goes out again is what came in, and zero above.
        let sent = resolve(Transmit, &entries).unwrap().pack(&device).to_le_bytes();
        let mut whole = cut(pdo, 0, at);
        whole.resize(8, 0);
        prop_assert_eq!(sent.to_vec(), whole);
    }
}
