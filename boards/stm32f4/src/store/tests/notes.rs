//! Notes: one word each, the last one since the last set.
//!
//! Verifies: ECSS 8.3.2a

use ecss_can::store;
use ecss_can::store::Content;

use super::power::{at_each_operation, start_on};
use super::*;

/// Returns what the next start finds: set, note, number of damaged sets.
fn found(flash: Flash) -> (Vec<u8>, Option<u16>, u32) {
    let (mut log, opened) = open(flash);
    (stored(&mut log), log.note(), opened.damaged)
}

fn note_on(flash: Flash, note: u16) -> (Flash, bool) {
    let (mut log, _) = open(flash);
    let done = log.write_note(note).is_ok();
    (log.into_flash(), done)
}

/// Notices: ECSS 8.3.2a: a noted Bdefault is lost at the next start.
#[test]
fn a_note_costs_one_word_and_is_found_at_the_next_start() {
    for set in [vec![], set(1, 30)] {
        for note in [0, 1, 0x0501, 0x0FFF] {
            let (mut log, _) = open(Flash::erased());
            if !set.is_empty() {
                save(&mut log, &set).unwrap();
            }
            let before = log.flash().operations();
            assert_eq!(log.note(), None);
            log.write_note(note).unwrap();
            assert_eq!((log.note(), log.flash().operations() - before), (Some(note), 1));
            assert_eq!(found(log.into_flash()), (set.clone(), Some(note), 0));
        }
    }
}

/// The note 501h: 4501h, which has even parity, and its complement.
#[test]
fn a_note_has_the_documented_format() {
    let (mut log, _) = open(Flash::erased());
    log.write_note(0x0501).unwrap();
    assert_eq!(log.flash().bytes[8..16], [0x01, 0x45, 0xFE, 0xBA, 0xFF, 0xFF, 0xFF, 0xFF]);
    assert_eq!(log.write_note(0x1000), Err(StoreError::Size));
}

#[test]
fn the_last_note_counts_until_a_set_is_stored() {
    let (mut log, _) = open(Flash::erased());
    log.write_note(1).unwrap();
    save(&mut log, &set(1, 9)).unwrap();
    assert_eq!(log.note(), None);
    assert_eq!(found(log.flash().clone()), (set(1, 9), None, 0));
    log.write_note(2).unwrap();
    log.write_note(3).unwrap();
    assert_eq!(found(log.flash().clone()), (set(1, 9), Some(3), 0));
    // An uncommitted set does not invalidate the note, also when another note was written meanwhile.
    log.begin(12).unwrap();
    log.append(&[0; 12]).unwrap();
    assert_eq!(found(log.flash().clone()), (set(1, 9), Some(3), 0));
    log.write_note(4).unwrap();
    assert_eq!(log.commit(), Err(StoreError::Size));
    assert_eq!(found(log.flash().clone()), (set(1, 9), Some(4), 0));
    save(&mut log, &set(2, 9)).unwrap();
    assert_eq!(found(log.into_flash()), (set(2, 9), None, 0));
}

#[test]
fn a_note_between_a_set_and_a_damaged_one_holds() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, &set(1, 8)).unwrap();
    log.write_note(1).unwrap();
    save(&mut log, &set(2, 8)).unwrap();
    let mut flash = log.flash().clone();
    // Header, set, note, length: the second set.
    flash.bytes[8 + 20 + 4 + 4] ^= 3;
    assert_eq!(found(flash), (set(1, 8), Some(1), 1));
    log.write_note(2).unwrap();
    let mut flash = log.into_flash();
    flash.bytes[8 + 20 + 4 + 4] ^= 3;
    assert_eq!(found(flash), (set(1, 8), Some(2), 1), "the newest note");
}

#[test]
fn two_flipped_bits_in_a_note_leave_the_one_before() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, &set(1, 8)).unwrap();
    log.write_note(0x0300).unwrap();
    log.write_note(0x0301).unwrap();
    let flash = log.into_flash();
    for bit in 0..32 {
        let mut once = flash.clone();
        let at = 8 + 20 + 4;
        once.bytes[at + bit / 8] ^= 1 << (bit % 8);
        assert_eq!(found(once.clone()), (set(1, 8), Some(0x0301), 0), "bit {bit}");
        for other in (0..32).filter(|other| *other != bit) {
            let mut twice = once.clone();
            twice.bytes[at + other / 8] ^= 1 << (other % 8);
            assert_eq!(found(twice), (set(1, 8), Some(0x0300), 0), "bits {bit}, {other}");
        }
    }
}

#[test]
fn stuck_bit_fails_the_note_and_the_next_note_goes_elsewhere() {
    for byte in 0..4 {
        let mut flash = open(Flash::erased()).0.into_flash();
        flash.stuck = Some((8 + byte, 0xFF));
        let (mut log, _) = open(flash);
        assert_eq!(log.write_note(0x0330), Err(StoreError::Hardware), "byte {byte}");
        assert_eq!(log.note(), None);
        log.write_note(0x0103).unwrap();
        assert_eq!(found(log.into_flash()), (vec![], Some(0x0103), 0));
    }
}

#[test]
fn a_note_cut_short_leaves_the_old_one_or_the_new() {
    for old in [None, Some(0x0500)] {
        let (mut log, _) = open(Flash::erased());
        save(&mut log, &set(1, 21)).unwrap();
        old.iter().for_each(|note| log.write_note(*note).unwrap());
        let operations = at_each_operation(
            &log.into_flash(),
            200,
            |flash| note_on(flash, 0x0501),
            |_, flash, done| {
                let (set_found, note, damaged) = found(flash.clone());
                assert_eq!((set_found, damaged), (set(1, 21), 0));
                assert!(note == Some(0x0501) || note == old && !done, "{note:?}");
                let (flash, done) = note_on(flash, 0x0502);
                assert!(done);
                assert_eq!(found(flash).1, Some(0x0502), "it goes on");
            },
        );
        assert_eq!(operations, 1);
    }
}

/// Words for notes in a page: three quarters of it without the header.
const NOTES: usize = (PAGE * 3 / 4 - 8) / 4;

/// Words of a set of 40 bytes: length, bytes, CRC, commit.
const SET: usize = 1 + 10 + 1 + 1;

/// Returns a flash with a set of 40 bytes and notes up to the last quarter of the page.
fn full_of_notes() -> Flash {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, &set(1, 40)).unwrap();
    let count = (0_u16..).find(|&number| log.write_note(number & 0xFFF) == Err(StoreError::Full)).unwrap();
    assert_eq!(usize::from(count), NOTES - SET);
    assert_eq!(log.note(), Some((count - 1) & 0xFFF));
    log.into_flash()
}

#[test]
fn notes_leave_the_last_quarter_to_sets_and_a_start_makes_room() {
    let flash = full_of_notes();
    let last = Some(((NOTES - SET - 1) & 0xFFF) as u16);
    assert_eq!(flash.bytes[PAGE * 3 / 4..], [0xFF; PAGE * 5 / 4], "not a word of the last quarter");
    let (mut log, _) = open(flash);
    assert_eq!((stored(&mut log), log.note()), (set(1, 40), last));
    assert_eq!(log.flash().bytes[PAGE..PAGE + 4], *b"CE\xBC\xBA", "in the other page");
    log.write_note(7).unwrap();
    save(&mut log, &set(2, MAX_SET)).unwrap();
    assert_eq!(found(log.into_flash()), (set(2, MAX_SET), None, 0));
}

#[test]
fn a_change_of_pages_cut_short_keeps_set_and_note() {
    let flash = full_of_notes();
    let last = Some(((NOTES - SET - 1) & 0xFFF) as u16);
    let operations = at_each_operation(&flash, 12, start_on, |_, flash, _| {
        assert_eq!(found(flash), (set(1, 40), last, 0));
    });
    // Set, note, magic, epoch.
    assert_eq!(operations, SET as u64 + 1 + 2);
}

/// Given notes, sets, starts and power failures in random order, then a start finds the result of the last operation or
/// of the one before.
#[test]
fn any_history_keeps_the_old_state_or_the_new() {
    for seed in 0..200 {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut flash = Flash::erased();
        let mut holds: (Vec<u8>, Option<u16>) = (Vec::new(), None);
        for number in 0..60 {
            if random.u8(..4) == 0 {
                flash.cut_at(random.u64(1..300), Remains::Mixed(random.u64(..)));
            }
            let (after, started) = start_on(flash);
            flash = after;
            if !started {
                flash = flash.revived();
            }
            let (mut log, _) = open(flash.clone().revived());
            assert_eq!((stored(&mut log), log.note()), holds, "seed {seed}, {number}");
            let (mut log, _) = if started { open(flash) } else { (log, Opened::default()) };
            let (new, outcome) = if random.bool() {
                let note = random.u16(..0x1000);
                ((holds.0.clone(), Some(note)), log.write_note(note))
            } else {
                let set = set(number, random.usize(0..900));
                ((set.clone(), None), save(&mut log, &set))
            };
            flash = log.into_flash().revived();
            let (mut log, _) = open(flash.clone());
            let found = (stored(&mut log), log.note());
            assert!(found == new || found == holds && outcome.is_err(), "seed {seed}, {number}: {found:?}");
            holds = found;
        }
    }
}

/// Stores Bdefault of node 3 through 1010h and 1011h, as a slave does.
///
/// Verifies: ECSS 8.3.3l
#[test]
fn a_noted_bdefault_follows_saves_and_restores() {
    let node = NodeId::of::<3>();
    let (mut log, _) = open(Flash::erased());
    let loaded = |log: &mut Log| {
        let mut bdefault = None;
        store::load(log, node, &mut |at, content| {
            if let (0x2000, 1, Content::Whole(&[value])) = (at.index, at.sub, content) {
                bdefault = Some(value);
            }
            Ok(())
        })
        .unwrap();
        bdefault
    };
    store::note_bdefault(&mut log, node, ecss_can::types::Bus::Redundant).unwrap();
    assert_eq!(loaded(&mut log), Some(1));
    store_values(&mut log, Group::Communication, StoreRequest::Save, &[(Address::new(0x1017, 0), &[1, 0])]);
    let (mut log, _) = open(log.into_flash());
    assert_eq!((loaded(&mut log), log.note()), (Some(1), None), "it is in the set now");
    store_values(&mut log, Group::Manufacturer, StoreRequest::Restore, &[]);
    assert_eq!(loaded(&mut log), None);
}
