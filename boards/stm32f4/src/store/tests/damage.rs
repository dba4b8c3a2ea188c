//! Bits that flip and bits that cannot be programmed.

use ecss_can::store::Loss;

use super::*;

const NODE: NodeId = NodeId::of::<9>();

/// Returns a flash with two sets in a page, of 21 and of 30 bytes.
fn two_sets() -> (Flash, Vec<u8>, Vec<u8>) {
    let (old, new) = (set(1, 21), set(2, 30));
    let (mut log, _) = open(Flash::erased());
    save(&mut log, &old).unwrap();
    save(&mut log, &new).unwrap();
    (log.into_flash(), old, new)
}

/// Offset behind the header, the first set of 4 + 24 + 4 + 4 bytes, and the length of the second.
const SECOND: usize = 8 + 36 + 4;

/// Returns a flash with two sets, a note and a Node-ID.
fn all_kinds() -> Flash {
    let (mut log, _) = open(two_sets().0);
    log.write_note(0x123).unwrap();
    log.store_node_id(Some(NODE)).unwrap();
    log.into_flash()
}

/// Returns whether a start finds all of [`all_kinds`], its report, and the flash after it.
fn finds_all(flash: Flash) -> (bool, Opened, Flash) {
    let (mut log, opened) = open(flash);
    let found = (stored(&mut log), log.note(), log.node_id(), log.check());
    (found == (set(2, 30), Some(0x123), Some(NODE), None), opened, log.into_flash())
}

fn flip(flash: &mut Flash, bit: usize) {
    flash.bytes[bit / 8] ^= 1 << (bit % 8);
}

/// Verifies: ECSS 6.10d, 6.10k
/// Notices: ECSS 6.10d: a flipped bit of a stored set is read as it is.
#[test]
fn a_flipped_bit_anywhere_loses_nothing_and_is_mended() {
    let flash = all_kinds();
    let end = flash.bytes.iter().rposition(|byte| *byte != 0xFF).unwrap() + 9;
    for bit in 0..8 * end {
        let mut damaged = flash.clone();
        flip(&mut damaged, bit);
        let (all, _, mended) = finds_all(damaged);
        assert!(all, "bit {bit}");
        // Nothing is left to correct.
        let before = mended.operations();
        let (all, opened, after) = finds_all(mended.clone());
        assert!(all && opened == Opened::default() && after.operations() == before, "bit {bit}: {opened:?}");
        // So another bit of the same word may flip.
        for page in [0, 8 * PAGE] {
            let mut again = mended.clone();
            flip(&mut again, page + (bit ^ 5));
            assert!(finds_all(again).0, "bit {bit}, then another one");
        }
    }
}

/// Verifies: ECSS 6.10d, 6.10k
#[test]
fn five_hundred_flipped_bits_lose_nothing() {
    let mut random = fastrand::Rng::with_seed(500);
    let mut flash = all_kinds();
    let mut corrected = 0;
    for number in 0..500 {
        // Most flips hit written words, in either page.
        let begin = PAGE * random.usize(..2);
        let bytes = if number % 4 == 0 { PAGE } else { 120 };
        flip(&mut flash, 8 * begin + random.usize(..8 * bytes));
        let (all, opened, after) = finds_all(flash);
        assert!(all, "flip {number}: {opened:?}");
        corrected += opened.corrected;
        flash = after;
    }
    assert!(corrected > 20, "flips of what is stored were among them: {corrected}");
}

#[test]
fn two_flips_in_last_set_are_reported_and_the_set_before_holds() {
    let (flash, old, new) = two_sets();
    for bit in 1..8 * new.len() {
        let mut flash = flash.clone();
        flip(&mut flash, 8 * SECOND + bit);
        flip(&mut flash, 8 * SECOND + bit / 2);
        let (mut log, opened) = open(flash);
        assert_eq!(stored(&mut log), old, "bit {bit}");
        assert_eq!((opened.damaged, opened.is_interrupted, log.check()), (1, false, Some(Loss::Damaged)));
    }
}

#[test]
fn two_flipped_bits_in_only_set_leave_defaults_until_next_save() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, &set(3, 40)).unwrap();
    let mut flash = log.into_flash();
    flash.bytes[8 + 4 + 20] ^= 0x11;
    for _ in 0..2 {
        let (mut log, opened) = open(flash);
        assert_eq!((stored(&mut log), opened), (vec![], Opened { damaged: 1, ..Opened::default() }));
        assert_eq!(log.check(), Some(Loss::Damaged), "at each start");
        flash = log.into_flash();
    }
    let (mut log, _) = open(flash);
    save(&mut log, b"again").unwrap();
    assert_eq!(log.check(), None);
    assert_eq!(after_restart(log.into_flash()), (b"again".to_vec(), Opened::default()));
}

#[test]
fn a_page_whose_epoch_is_damaged_is_reported() {
    let (mut flash, _, _) = two_sets();
    flash.bytes[4] ^= 3;
    let (mut log, opened) = open(flash);
    assert_eq!((stored(&mut log), opened.damaged, log.check()), (vec![], 1, Some(Loss::Damaged)));
}

/// Verifies: ECSS 6.10d
#[test]
fn bit_flipped_after_start_is_corrected_when_the_set_is_checked() {
    let (flash, _, new) = two_sets();
    let (mut log, _) = open(flash);
    log.flash_mut().bytes[SECOND + 17] ^= 4;
    assert_eq!(log.check(), None);
    assert_eq!(stored(&mut log), new);
    for (offset, byte) in new.iter().enumerate() {
        let mut read = [0];
        log.read(offset, &mut read).unwrap();
        assert_eq!(read, [*byte]);
    }
    log.flash_mut().bytes[SECOND + 3] ^= 4;
    assert_eq!((log.check(), log.stored_len()), (Some(Loss::Damaged), 0), "two are too many");
}

#[test]
fn any_two_flipped_bits_leave_a_set_as_saved_or_no_set() {
    let (flash, old, new) = two_sets();
    let mut random = fastrand::Rng::with_seed(2);
    for _ in 0..20_000 {
        let mut flash = flash.clone();
        let bits = [random.usize(..800), random.usize(..800)];
        bits.iter().for_each(|bit| flip(&mut flash, *bit));
        let (found, _) = after_restart(flash);
        assert!(found == new || found == old || found.is_empty(), "bits {bits:?}: {found:X?}");
    }
}

/// CRC-32C as in RFC 3720: 123456789 gives E306 9283h.
#[test]
fn the_format_is_the_documented_one() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, b"123456789").unwrap();
    let expected = [
        // 1 has an odd number of ones, 9 an even number.
        &b"CE\xBC\xBA\x01\x80\xFE\x7F"[..],
        b"\x09\x00\xF6\xFF123456789\xFF\xFF\xFF",
        &0xE306_9283_u32.to_le_bytes(),
        &[0; 4],
        &[0xFF; 4],
    ];
    assert_eq!(log.into_flash().bytes[..8 + 4 + 12 + 4 + 4 + 4], expected.concat());
}

/// Given a page of the former format, which begins with another word, then it is not read.
#[test]
fn a_page_of_the_former_format_is_erased() {
    let mut flash = Flash::erased();
    flash.bytes[..16].copy_from_slice(b"ECPS\x01\x00\xFE\xFF\x01\x00\xFE\xFF\x07\xFF\xFF\xFF");
    let (mut log, opened) = open(flash);
    assert_eq!((opened, stored(&mut log)), (Opened { erased: 1, ..Opened::default() }, vec![]));
    assert_eq!(log.check(), None);
}

#[test]
fn a_length_beyond_the_page_is_none() {
    let mut flash = open(Flash::erased()).0.into_flash();
    // A length of 10,000 bytes, which has an odd number of ones, at 31 KiB: 9 KiB before the end of the page.
    let at = 31 * 1024;
    flash.bytes[8..at].fill(0);
    flash.bytes[at..at + 4].copy_from_slice(&[0x10, 0xA7, 0xEF, 0x58]);
    let (mut log, opened) = open(flash);
    assert_eq!((opened, stored(&mut log)), (Opened::default(), vec![]));
    save(&mut log, b"a set").unwrap();
    assert_eq!(after_restart(log.into_flash()), (b"a set".to_vec(), Opened::default()));
}

#[test]
fn stuck_bit_fails_the_save_and_the_next_save_goes_elsewhere() {
    let (flash, _, stored_set) = two_sets();
    // Offset of the third set; the second has length, data, CRC, commit.
    let third = SECOND + 32 + 8;
    for byte in 0..4 + 16 + 4 + 4 {
        let mut flash = flash.clone();
        flash.stuck = Some((third + byte, 0xFF));
        let (mut log, _) = open(flash);
        let outcome = save(&mut log, &[0; 16]);
        assert_eq!(outcome, Err(StoreError::Hardware), "byte {byte}");
        assert_eq!(stored(&mut log), stored_set);
        save(&mut log, b"elsewhere").unwrap();
        assert_eq!(after_restart(log.into_flash()).0, b"elsewhere");
    }
}

#[test]
fn a_flipped_bit_where_the_next_set_goes_is_left_out() {
    let (flash, _, _) = two_sets();
    let third = SECOND + 32 + 8;
    for bit in 0..8 * 60 {
        let mut flash = flash.clone();
        flip(&mut flash, 8 * third + bit);
        flip(&mut flash, 8 * (third + 200) + 7);
        let (mut log, _) = open(flash);
        save(&mut log, &set(3, 40)).unwrap();
        save(&mut log, &set(4, 300)).unwrap();
        assert_eq!(after_restart(log.into_flash()), (set(4, 300), Opened::default()), "bit {bit}");
    }
}

#[test]
fn a_flash_that_does_not_answer_is_told() {
    let mut flash = Flash::erased();
    flash.powered = false;
    assert_eq!(Log::open(flash, 0).err(), Some(StoreError::Hardware));
}
