//! Room in a page: when pages are erased, and the result of saving into a full page.

use ecss_can::store;
use ecss_can::store::{Content, Loaded};

use super::*;

#[test]
fn an_erased_flash_is_taken_as_it_is() {
    let (mut log, opened) = open(Flash::erased());
    assert_eq!((opened, stored(&mut log)), (Opened::default(), vec![]));
    assert_eq!(log.read(0, &mut [0]), Err(StoreError::Size));
    let flash = log.into_flash();
    // Magic and epoch.
    assert_eq!((flash.programs, flash.erases), (2, 0));
    assert_eq!(open(flash.clone()).0.into_flash().operations(), 2, "once");
}

#[test]
fn sets_of_every_length_come_back() {
    for len in (0..70).chain([MAX_SET - 1, MAX_SET]) {
        let (mut log, _) = open(Flash::erased());
        save(&mut log, &set(9, len)).unwrap();
        assert_eq!(stored(&mut log), set(9, len));
        assert_eq!(after_restart(log.into_flash()), (set(9, len), Opened::default()));
    }
}

#[test]
fn the_old_set_is_read_while_the_new_one_is_written() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, b"old set").unwrap();
    log.begin(3).unwrap();
    log.append(b"ne").unwrap();
    assert_eq!(stored(&mut log), b"old set");
    log.append(b"w").unwrap();
    assert_eq!(stored(&mut log), b"old set");
    log.commit().unwrap();
    assert_eq!(stored(&mut log), b"new");
}

#[test]
fn a_set_is_as_long_as_announced_and_no_longer_than_the_longest() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, b"old set").unwrap();
    assert_eq!(log.begin(MAX_SET + 1), Err(StoreError::Size));
    assert_eq!(log.append(b"x"), Err(StoreError::Size), "nothing was begun");
    assert_eq!(log.commit(), Err(StoreError::Size));
    log.begin(4).unwrap();
    assert_eq!(log.append(b"12345"), Err(StoreError::Size));
    assert_eq!(log.commit(), Err(StoreError::Size));
    log.begin(4).unwrap();
    log.append(b"123").unwrap();
    assert_eq!(log.commit(), Err(StoreError::Size));
    assert_eq!(stored(&mut log), b"old set");
    save(&mut log, b"new set").unwrap();
    assert_eq!(after_restart(log.into_flash()), (b"new set".to_vec(), Opened::default()));
}

/// Given a full page, when a set is saved, then it is refused (08000022h) and the set before stays.
#[test]
fn a_full_page_refuses_and_the_next_start_makes_room() {
    let (mut log, _) = open(Flash::erased());
    let count = fill(&mut log, 1000);
    // 8 bytes of header; each set 1000 bytes, length, CRC and commit word.
    assert_eq!(usize::from(count), (PAGE - 8) / 1012);
    let before = log.flash().operations();
    assert_eq!(save(&mut log, &set(0, 1000)).unwrap_err().abort_code().code(), 0x0800_0022);
    assert_eq!(log.flash().operations(), before, "nothing is written of a set without room");
    assert_eq!(stored(&mut log), set(count - 1, 1000));
    save(&mut log, b"a smaller one").unwrap();

    let (mut log, opened) = open(log.into_flash());
    assert_eq!(opened, Opened::default(), "the other page was never used");
    assert_eq!(stored(&mut log), b"a smaller one");
    save(&mut log, &set(5, MAX_SET)).unwrap();
}

#[test]
fn every_start_leaves_room_for_the_longest_set() {
    for len in [10, 1000, 4000, MAX_SET] {
        let mut flash = Flash::erased();
        for number in 0..20 {
            let (mut log, opened) = open(flash);
            assert!(opened.erased <= 1);
            save(&mut log, &set(number, MAX_SET)).unwrap();
            while save(&mut log, &set(number, len)).is_ok() && len > 5000 {}
            flash = log.into_flash();
        }
    }
}

#[test]
fn nothing_is_erased_but_at_a_start() {
    let mut flash = Flash::erased();
    let mut erased = 0;
    for _ in 0..10 {
        let (mut log, opened) = open(flash);
        erased += u64::from(opened.erased);
        assert_eq!(log.flash().erases, erased);
        fill(&mut log, 500);
        assert_eq!(log.flash().erases, erased);
        flash = log.into_flash();
    }
    assert_eq!(erased, 8, "one of two starts found the other page erased, the first had nothing to move");
}

#[test]
fn foreign_content_is_erased_once() {
    // The second begins like an epoch of 1 and sets of one byte.
    for word in [0xA5A5_A5A5_u32, 0xFFFE_0001] {
        let mut flash = Flash::erased();
        flash.bytes.chunks_mut(4).for_each(|chunk| chunk.copy_from_slice(&word.to_le_bytes()));
        let (mut log, opened) = open(flash);
        assert_eq!((opened, stored(&mut log)), (Opened { erased: 1, ..Opened::default() }, vec![]));
        save(&mut log, b"a set").unwrap();
        assert_eq!(after_restart(log.into_flash()), (b"a set".to_vec(), Opened::default()));
    }
}

/// The CRC of these bytes is FFFF FFFFh, because the CRC-32C of 32 ones is FFFF FFFFh.
#[test]
fn a_set_that_looks_erased_comes_back() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, &[0xFF; 4]).unwrap();
    assert_eq!(after_restart(log.into_flash()), (vec![0xFF; 4], Opened::default()));
}

/// Compared with another implementation of the CRC. Page header and length are 12 bytes.
#[test]
fn a_set_ends_with_the_crc_of_castagnoli() {
    for len in [1, 4, 7, 64, 65, 300] {
        let (mut log, _) = open(Flash::erased());
        save(&mut log, &set(9, len)).unwrap();
        let at = 12 + len.next_multiple_of(4);
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISCSI).checksum(&set(9, len));
        assert_eq!(log.flash().bytes[at..at + 8], [crc.to_le_bytes(), [0; 4]].concat(), "{len} bytes");
    }
}

#[test]
fn the_pages_may_lie_anywhere() {
    let mut flash = Flash::erased();
    flash.bytes = vec![0x77; 5 * PAGE];
    flash.bytes[2 * PAGE..4 * PAGE].fill(0xFF);
    let base = 2 * PAGE as u32;
    for _ in 0..5 {
        let (mut log, _) = Log::open(flash, base).unwrap();
        fill(&mut log, 2000);
        flash = log.into_flash();
    }
    let beside = [&flash.bytes[..2 * PAGE], &flash.bytes[4 * PAGE..]].concat();
    assert!(beside.iter().all(|&byte| byte == 0x77));
}

/// Uses 1010h and 1011h over restarts and a change of pages.
///
/// Verifies: ECSS 6.8a
/// Notices: ECSS 6.8a: a saved value is lost when the log changes its page.
#[test]
fn parameters_of_a_dictionary_are_saved_loaded_and_restored() {
    let node = NodeId::of::<3>();
    let mut flash = Flash::erased();
    let load = |log: &mut Log| {
        let mut values = Vec::new();
        let loaded = store::load(log, node, &mut |at, content| {
            let Content::Whole(value) = content else { panic!("{content:?}") };
            values.push((at.index, value.to_vec()));
            Ok(())
        });
        (values, loaded.unwrap())
    };
    for number in 0..=255 {
        let (mut log, _) = open(flash);
        let values: [(_, &[u8]); 2] =
            [(Address::new(0x1017, 0), &[number, 0]), (Address::new(0x2000, 1), &[0; 60])];
        store_values(&mut log, Group::All, StoreRequest::Save, &values);
        store_values(&mut log, Group::Manufacturer, StoreRequest::Restore, &[]);
        let expected = (vec![(0x1017, vec![number, 0])], Loaded::Set { applied: 1, skipped: 0 });
        let (mut log, _) = open(log.into_flash());
        assert_eq!(load(&mut log), expected);
        flash = log.into_flash();
    }
}
