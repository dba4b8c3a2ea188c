//! Bits that change and bits that do not.

use super::*;

/// Two sets in a page.
fn two_sets() -> (Flash, Vec<u8>, Vec<u8>) {
    let (old, new) = (set(1, 21), set(2, 30));
    let (mut log, _) = open(Flash::erased());
    save(&mut log, &old).unwrap();
    save(&mut log, &new).unwrap();
    (log.into_flash(), old, new)
}

#[test]
fn a_changed_bit_in_the_last_set_is_noticed_and_the_one_before_holds() {
    let (flash, old, new) = two_sets();
    // Header, the first set of 4 + 24 + 4 bytes, the second's length.
    let data = 8 + 32 + 4;
    for bit in 0..8 * (new.len() + 2 + 4) {
        let mut flash = flash.clone();
        flash.bytes[data + bit / 8] ^= 1 << (bit % 8);
        let padding = (new.len()..new.len() + 2).contains(&(bit / 8));
        let expected = if padding { (new.clone(), 0) } else { (old.clone(), 1) };
        let (found, opened) = after_restart(flash);
        assert_eq!((found, opened.damaged), expected, "bit {bit}");
    }
}

#[test]
fn a_changed_bit_in_the_only_set_leaves_defaults_and_is_told() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, &set(3, 40)).unwrap();
    let mut flash = log.into_flash();
    flash.bytes[8 + 4 + 20] ^= 0x10;
    assert_eq!(after_restart(flash.clone()), (vec![], Opened { erased: 0, damaged: 1 }));
    let (mut log, _) = open(flash);
    save(&mut log, b"again").unwrap();
    assert_eq!(after_restart(log.into_flash()), (b"again".to_vec(), Opened::default()));
}

#[test]
fn whatever_bit_changes_a_set_is_found_as_it_was_saved_or_not_at_all() {
    let (flash, old, new) = two_sets();
    for bit in 0..8 * 100 {
        let mut flash = flash.clone();
        flash.bytes[bit / 8] ^= 1 << (bit % 8);
        let (found, _) = after_restart(flash);
        assert!(found == new || found == old || found.is_empty(), "bit {bit}: {found:X?}");
    }
}

/// CRC-32 as in ISO 3309: 123456789 gives CBF43926h.
#[test]
fn the_format_is_the_documented_one() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, b"123456789").unwrap();
    let expected = [
        &b"ECPS\x01\x00\xFE\xFF"[..],
        b"\x09\x00\xF6\xFF123456789\xFF\xFF\xFF",
        &0xCBF4_3926_u32.to_le_bytes(),
        &[0xFF; 4],
    ];
    assert_eq!(log.into_flash().bytes[..8 + 4 + 12 + 4 + 4], expected.concat());
}

#[test]
fn a_length_beyond_the_page_is_none() {
    let mut flash = open(Flash::erased()).0.into_flash();
    flash.bytes[8..12].copy_from_slice(&[0xF0, 0xFF, 0x0F, 0x00]);
    let (mut log, opened) = open(flash);
    assert_eq!((opened, stored(&mut log)), (Opened::default(), vec![]));
    save(&mut log, b"a set").unwrap();
    let flash = log.into_flash();
    assert!(flash.bytes[PAGE..].iter().all(|&byte| byte == 0xFF), "a word is lost, not a page");
    assert_eq!(after_restart(flash), (b"a set".to_vec(), Opened::default()));
}

/// Another program may have had longer sets: they are none of ours and do not stop a start.
#[test]
fn a_set_that_is_too_long_is_passed_over() {
    let mut flash = open(Flash::erased()).0.into_flash();
    let len = MAX_SET as u16 + 1;
    flash.bytes[8..10].copy_from_slice(&len.to_le_bytes());
    flash.bytes[10..12].copy_from_slice(&(!len).to_le_bytes());
    flash.bytes[12..12 + MAX_SET + 8].fill(0);
    let (mut log, opened) = open(flash);
    assert_eq!((opened, stored(&mut log)), (Opened::default(), vec![]));
    fill(&mut log, 3000);
    save(&mut log, b"a set").unwrap();
    assert_eq!(after_restart(log.into_flash()), (b"a set".to_vec(), Opened::default()));
}

#[test]
fn a_bit_that_does_not_take_fails_the_save_and_the_next_one_goes_elsewhere() {
    let (flash, _, stored_set) = two_sets();
    // Where the third set goes: length, data, CRC.
    let third = 8 + 32 + 40;
    for byte in 0..4 + 16 + 4 {
        let mut flash = flash.clone();
        flash.stuck = Some((third + byte, 0xFF));
        let (mut log, _) = open(flash);
        let outcome = save(&mut log, &[0; 16]);
        if outcome.is_ok() {
            // The byte was to stay erased.
            assert_eq!(byte, 3, "of the complement of the length");
            continue;
        }
        assert_eq!(outcome, Err(StoreError::Hardware), "byte {byte}");
        assert_eq!(stored(&mut log), stored_set);
        save(&mut log, b"elsewhere").unwrap();
        assert_eq!(after_restart(log.into_flash()).0, b"elsewhere");
    }
}

#[test]
fn a_flash_that_does_not_answer_is_told() {
    let mut flash = Flash::erased();
    flash.powered = false;
    assert_eq!(Log::open(flash, 0).err(), Some(StoreError::Hardware));
}
