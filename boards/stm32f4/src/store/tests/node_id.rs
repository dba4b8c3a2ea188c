//! The Node-ID in three copies: damage of any copy, and power failure at any operation.
//!
//! Verifies: ECSS 6.10e, 6.10k

use ecss_can::store::identity::{Straps, node_id};

use super::power::{at_each_operation, start_on};
use super::*;

/// Copies of 3 and of 7 by their format with parity, computed on paper.
const THREE: [u16; 3] = [0xD061, 0xE073, 0xF07D];
const SEVEN: [u16; 3] = [0x50F5, 0x60E7, 0x70E9];
/// Bytes of a page before the first set, note or copy.
const HEADER: usize = 8;

fn id(raw: u8) -> Option<NodeId> {
    NodeId::new(raw)
}

fn found(flash: Flash) -> Option<NodeId> {
    open(flash).0.node_id()
}

fn store_on(flash: Flash, id: Option<NodeId>) -> (Flash, bool) {
    let (mut log, _) = open(flash);
    let done = log.store_node_id(id).is_ok();
    (log.into_flash(), done)
}

fn words(copies: &[u16]) -> Vec<u8> {
    copies.iter().flat_map(|copy| [copy.to_le_bytes(), (!copy).to_le_bytes()].concat()).collect()
}

/// Verifies: ECSS 6.10j
#[test]
fn three_copies_have_the_documented_format() {
    let (mut log, _) = open(Flash::erased());
    assert_eq!(log.node_id(), None);
    log.store_node_id(id(3)).unwrap();
    assert_eq!(log.flash().bytes[HEADER..HEADER + 16], [words(&THREE), vec![0xFF; 4]].concat());
    assert_eq!((log.node_id(), found(log.flash().clone())), (id(3), id(3)));
    // The next copies replace them.
    log.store_node_id(id(7)).unwrap();
    assert_eq!(log.flash().bytes[HEADER..HEADER + 24], [vec![0; 12], words(&SEVEN)].concat());
    assert_eq!((log.node_id(), found(log.flash().clone())), (id(7), id(7)));
    log.store_node_id(None).unwrap();
    assert_eq!((log.node_id(), found(log.into_flash())), (None, None));
}

/// Given a log with another Node-ID or none, when any Node-ID of a slave is stored, then it is found, also at the next start.
///
/// Verifies: ECSS 6.10j
/// Notices: ECSS 6.10j: the log finds no stored Node-ID above 63.
#[test]
fn every_node_id_of_a_slave_is_stored_and_found() {
    let (mut log, _) = open(Flash::erased());
    for raw in 2..=126 {
        log.store_node_id(id(raw)).unwrap();
        assert_eq!(log.node_id(), id(raw));
        assert_eq!(found(log.flash().clone()), id(raw));
        let (flash, done) = store_on(Flash::erased(), id(raw));
        assert_eq!((done, found(flash)), (true, id(raw)));
    }
}

/// Given copies of the Node-ID of the master or of maintenance mode, as an earlier program may have stored them, then
/// they are ignored.
///
/// Verifies: ECSS 9.1a
/// Notices: ECSS 9.1a: a stored Node-ID of the master is taken.
#[test]
fn copies_that_no_slave_may_have_are_none() {
    for raw in [1, 127] {
        let (flash, _) = store_on(Flash::erased(), id(raw));
        assert_eq!(found(flash), None, "{raw}");
    }
}

/// Verifies: ECSS 6.10j
/// Notices: ECSS 6.10j: a stored Node-ID is lost when the log changes its page.
#[test]
fn sets_notes_and_changes_of_pages_keep_the_node_id() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, &set(1, 30)).unwrap();
    log.write_note(1).unwrap();
    log.store_node_id(id(3)).unwrap();
    assert_eq!((stored(&mut log), log.note()), (set(1, 30), Some(1)));
    log.write_note(2).unwrap();
    let mut pages = [false; 2];
    for number in 0..40 {
        save(&mut log, &set(number, 9_000)).unwrap();
        log = open(log.into_flash()).0;
        assert_eq!((stored(&mut log), log.node_id()), (set(number, 9_000), id(3)));
        let is_first =
            log.flash().bytes[..4] == *b"CE\xBC\xBA" && log.flash().bytes[PAGE..PAGE + 4] != *b"CE\xBC\xBA";
        pages[usize::from(!is_first)] = true;
    }
    assert_eq!(pages, [true; 2]);
}

/// Returns a flash with a set, a note and the copies of 3, which replaced others.
fn written() -> Flash {
    let (mut log, _) = open(Flash::erased());
    log.store_node_id(id(7)).unwrap();
    save(&mut log, &set(1, 24)).unwrap();
    log.write_note(1).unwrap();
    log.store_node_id(id(3)).unwrap();
    save(&mut log, &set(2, 24)).unwrap();
    log.into_flash()
}

/// Flips every written bit: header, copies, replaced copies, sets, notes.
#[test]
fn every_flipped_bit_of_the_log_leaves_the_node_id() {
    let flash = written();
    let end = flash.bytes.iter().rposition(|byte| *byte != 0xFF).unwrap() + 1;
    for bit in 0..8 * end {
        let mut flash = flash.clone();
        flash.bytes[bit / 8] ^= 1 << (bit % 8);
        let found = found(flash);
        assert_eq!(found, id(3), "bit {bit}");
        assert_eq!(node_id(Straps::Closed(NodeId::of::<3>()), found), Ok(NodeId::of::<3>()));
    }
}

#[test]
fn a_copy_that_differs_is_written_anew_at_the_next_start() {
    let (mut log, _) = open(Flash::erased());
    log.store_node_id(id(3)).unwrap();
    let flash = log.into_flash();
    for bit in 0..96 {
        let mut damaged = flash.clone();
        damaged.bytes[HEADER + bit / 8] ^= 1 << (bit % 8);
        let (mut log, _) = open(damaged);
        assert_eq!(log.node_id(), id(3), "bit {bit}");
        assert_eq!(log.flash().bytes[PAGE + HEADER..][..12], words(&THREE), "bit {bit}");
        // Afterwards another copy may fail.
        for copy in 0..3 {
            let mut again = log.flash().clone();
            again.bytes[PAGE + HEADER + 4 * copy] ^= 3;
            assert_eq!(found(again), id(3), "bit {bit}, then copy {copy}");
        }
    }
    let before = flash.operations();
    assert_eq!(open(flash).0.flash().operations(), before, "what is right is left alone");
}

#[test]
fn two_copies_that_fail_leave_no_node_id() {
    let (mut log, _) = open(Flash::erased());
    log.store_node_id(id(7)).unwrap();
    log.store_node_id(id(3)).unwrap();
    let mut flash = log.into_flash();
    flash.bytes[HEADER + 12] ^= 3;
    flash.bytes[HEADER + 16] ^= 3;
    assert_eq!(found(flash), None, "not the one before");
}

#[test]
fn a_node_id_cut_short_leaves_the_old_one_or_the_new() {
    for old in [None, id(7)] {
        let (mut log, _) = open(Flash::erased());
        log.store_node_id(old).unwrap();
        save(&mut log, &set(1, 21)).unwrap();
        let flash = log.into_flash();
        let operations = at_each_operation(
            &flash,
            200,
            |flash| store_on(flash, id(3)),
            |_, flash, done| {
                let (mut log, _) = open(flash.clone());
                assert_eq!(stored(&mut log), set(1, 21));
                let found = log.node_id();
                assert!(found == id(3) || found == old && !done, "{found:?}");
                let (flash, done) = store_on(flash, id(2));
                assert!(done);
                assert_eq!(self::found(flash), id(2), "it goes on");
            },
        );
        assert_eq!(operations, 6, "three copies, three that are replaced");
    }
}

#[test]
fn a_repair_cut_short_keeps_the_node_id() {
    let (mut log, _) = open(Flash::erased());
    log.store_node_id(id(3)).unwrap();
    let mut flash = log.into_flash();
    flash.bytes[HEADER] ^= 1;
    let operations = at_each_operation(&flash, 100, start_on, |_, flash, _| assert_eq!(found(flash), id(3)));
    assert_eq!(operations, 3 + 2, "three copies, magic and epoch of the other page");
}

#[test]
fn a_change_of_pages_cut_short_keeps_the_node_id() {
    let (mut log, _) = open(Flash::erased());
    log.store_node_id(id(3)).unwrap();
    save(&mut log, &set(1, 8)).unwrap();
    (0..).find(|&number| log.write_note(number & 0xFFF) == Err(StoreError::Full)).unwrap();
    assert_eq!(log.store_node_id(id(7)), Err(StoreError::Full), "until the next start");
    let flash = log.into_flash();
    let operations = at_each_operation(&flash, 20, start_on, |_, flash, _| assert_eq!(found(flash), id(3)));
    // Length, data, CRC, commit, note, copies, magic, epoch.
    assert_eq!(operations, 1 + 2 + 1 + 1 + 1 + 3 + 2);
    let (mut log, _) = open(flash);
    log.store_node_id(id(7)).unwrap();
    assert_eq!(found(log.into_flash()), id(7));
}

#[test]
fn stuck_bit_is_reported_and_gives_no_other_node_id() {
    for byte in 0..12 {
        let (mut log, _) = open(Flash::erased());
        log.store_node_id(id(7)).unwrap();
        let mut flash = log.into_flash();
        flash.stuck = Some((HEADER + 12 + byte, 0xFF));
        let (mut log, _) = open(flash);
        assert_eq!(log.store_node_id(id(3)), Err(StoreError::Hardware), "byte {byte}");
        let found = log.node_id();
        assert!(found == id(3) || found == id(7), "byte {byte}: {found:?}");
        log.store_node_id(id(3)).unwrap();
        assert_eq!(self::found(log.into_flash()), id(3), "byte {byte}");
    }
}
