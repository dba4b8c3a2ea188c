//! Power fails in each operation: a start finds the old set or the new one, never a mixture, never none.

use ecss_can::store::Loss;

use super::*;

/// Cuts power in each operation of `act` on `flash`; `check` gets the number of the operation from the end, the flash
/// with power back, and whether `act` had reported success.
pub(super) fn at_each_operation(
    flash: &Flash,
    mixtures: u64,
    act: impl Fn(Flash) -> (Flash, bool),
    check: impl Fn(u64, Flash, bool),
) -> u64 {
    let (after, _) = act(flash.clone());
    let operations = after.operations() - flash.operations();
    for operation in 1..=operations {
        for remains in Remains::all(mixtures) {
            let mut flash = flash.clone();
            flash.cut_at(operation, remains);
            let (flash, done) = act(flash);
            assert!(!flash.powered, "operation {operation} took place");
            check(operations - operation, flash.revived(), done);
        }
    }
    operations
}

fn save_on(flash: Flash, set: &[u8]) -> (Flash, bool) {
    let (mut log, _) = open(flash);
    let done = save(&mut log, set).is_ok();
    (log.into_flash(), done)
}

/// Starts on a flash. A power failure during the start does not fail the test.
pub(super) fn start_on(flash: Flash) -> (Flash, bool) {
    let mut flash = flash;
    let done = ParameterLog::open(&mut flash, 0).is_ok();
    (flash, done)
}

/// Checks that after a failure the next set is saved and found again.
fn goes_on(flash: Flash) {
    let (flash, done) = save_on(flash, b"afterwards");
    assert!(done);
    assert_eq!(after_restart(flash).0, b"afterwards");
}

/// Verifies: ECSS 6.10d
/// Notices: ECSS 6.10d: a set whose save was cut short is taken.
#[test]
fn a_save_cut_short_leaves_the_old_set_or_the_new() {
    for len in [0, 1, 4, 6, 61] {
        for old in [None, Some(set(1, 33))] {
            let (mut log, _) = open(Flash::erased());
            old.iter().for_each(|old| save(&mut log, old).unwrap());
            let flash = log.into_flash();
            let (old, new) = (old.unwrap_or_default(), set(2, len));
            // Length, data, CRC, commit.
            let words = 3 + len.div_ceil(4) as u64;
            let operations = at_each_operation(
                &flash,
                20,
                |flash| save_on(flash, &new),
                |left, flash, done| {
                    let (found, opened) = after_restart(flash.clone());
                    assert!(found == new || found == old && !done, "{found:X?}");
                    assert_eq!(
                        (opened.erased, opened.damaged),
                        (0, 0),
                        "an interrupted save damages nothing"
                    );
                    // Up to the length word the save leaves nothing; once a bit of the commit word is written it is
                    // complete.
                    let is_new = found == new;
                    assert!(
                        !(opened.is_interrupted && is_new && new != old),
                        "{left} operations before the end"
                    );
                    assert!(opened.is_interrupted || is_new || left >= words - 1 || left == 0);
                    goes_on(flash);
                },
            );
            assert_eq!(operations, words);
        }
    }
}

#[test]
fn many_saves_cut_short_use_up_room_and_nothing_else() {
    let (mut log, _) = open(Flash::erased());
    save(&mut log, &set(1, 40)).unwrap();
    let mut flash = log.into_flash();
    for operation in 1..=13 {
        for remains in Remains::all(3) {
            flash.cut_at(operation, remains);
            let (cut, done) = save_on(flash, &set(1, 40));
            assert!(!done || operation == 13);
            flash = cut.revived();
            assert_eq!(after_restart(flash.clone()).0, set(1, 40));
        }
    }
    goes_on(flash);
}

/// Returns a flash with a full page, and its last set, of `len` bytes. `other`: content of the other page at that time.
fn full_page(other: Option<u8>, len: usize) -> (Flash, Vec<u8>) {
    let mut flash = Flash::erased();
    if let Some(byte) = other {
        flash.bytes[PAGE..].fill(byte);
    }
    let (mut log, opened) = open(flash);
    assert_eq!(opened.erased, 0);
    fill(&mut log, 1001);
    save(&mut log, &set(77, len)).unwrap();
    (log.into_flash(), set(77, len))
}

#[test]
fn a_change_of_pages_cut_short_keeps_the_set() {
    for other in [None, Some(0x00), Some(0x5A)] {
        let (flash, expected) = full_page(other, 93);
        let operations = at_each_operation(&flash, 12, start_on, |_, flash, _| {
            assert_eq!(after_restart(flash.clone()).0, expected);
            goes_on(flash);
        });
        // Erasing, length, data, CRC, commit, magic, epoch.
        assert_eq!(operations, u64::from(other.is_some()) + 1 + 24 + 1 + 1 + 2);
    }
}

#[test]
fn a_change_of_pages_cut_short_twice_keeps_the_set() {
    let (flash, expected) = full_page(Some(0x00), 9);
    at_each_operation(&flash, 1, start_on, |_, flash, _| {
        at_each_operation(&flash, 1, start_on, |_, flash, _| {
            assert_eq!(after_restart(flash).0, expected);
        });
    });
}

/// An old set never returns: the other page holds older sets when power fails during its erase.
#[test]
fn pages_change_back_and_forth_with_every_erase_cut_short() {
    let (mut flash, mut expected) = full_page(None, 93);
    for round in 0..8 {
        let (log, opened) = open(flash);
        assert_eq!(opened.erased, u32::from(round > 0));
        flash = log.into_flash();
        assert_eq!(after_restart(flash.clone()).0, expected);
        let (mut log, _) = open(flash);
        let count = fill(&mut log, 900 + round);
        expected = set(count - 1, 900 + round);
        flash = log.into_flash();
        for seed in 0..4 {
            flash.cut_at(1, Remains::Mixed(seed));
            let (cut, done) = start_on(flash);
            assert!(!done);
            flash = cut.revived();
        }
    }
}

#[test]
fn a_first_start_cut_short_is_made_up_for() {
    for content in [0xFF, 0x00, 0x5A] {
        let mut flash = Flash::erased();
        flash.bytes.fill(content);
        at_each_operation(&flash, 20, start_on, |_, flash, _| {
            assert_eq!(after_restart(flash.clone()).0, []);
            goes_on(flash);
        });
    }
}

/// Compares saves, starts and power failures in random order with the two sets that a start may find.
#[test]
fn any_history_keeps_the_old_set_or_the_new() {
    for seed in 0..100 {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut flash = Flash::erased();
        let mut holds: Vec<u8> = Vec::new();
        for number in 0..30 {
            if random.bool() {
                flash.cut_at(random.u64(1..1200), Remains::Mixed(random.u64(..)));
            }
            let new = set(number, random.usize(0..4000));
            let (after, started) = start_on(flash);
            flash = after;
            if started {
                let (after, done) = save_on(flash, &new);
                flash = after.revived();
                let (found, _) = after_restart(flash.clone());
                assert!(found == new || found == holds && !done, "seed {seed}, set {number}");
                holds = found;
            } else {
                flash = flash.revived();
                assert_eq!(after_restart(flash.clone()).0, holds, "seed {seed}, set {number}");
            }
        }
    }
}

/// Saves until power fails, five hundred times, at instants spread over saves, changes of pages and erases.
#[test]
fn five_hundred_power_cuts_lose_nothing() {
    let mut random = fastrand::Rng::with_seed(1500);
    let mut flash = Flash::erased();
    let mut holds: Vec<u8> = Vec::new();
    let (mut cuts, mut erases, mut interrupted) = (0, 0, 0);
    while cuts < 500 {
        // Every third one within a start, the first operation of which may be an erase.
        let operations = if cuts % 3 == 0 { random.u64(1..4) } else { random.u64(1..1200) };
        flash.cut_at(operations, Remains::Mixed(random.u64(..)));
        let mut last = None;
        let (after, started) = start_on(flash);
        flash = after;
        if started {
            let (mut log, _) = open(flash);
            while log.flash().powered {
                let new = set(random.u8(..), random.usize(0..4000));
                match save(&mut log, &new) {
                    Ok(()) => holds = new,
                    Err(StoreError::Full) => break,
                    Err(_) => last = Some(new),
                }
            }
            flash = log.into_flash();
        }
        cuts += u32::from(!flash.powered);
        flash = flash.revived();
        let (mut log, opened) = open(flash);
        let found = stored(&mut log);
        assert!(found == holds || Some(&found) == last.as_ref(), "cut {cuts}");
        assert_eq!((opened.damaged, log.check() == Some(Loss::Damaged)), (0, false), "cut {cuts}");
        assert_eq!(log.check().is_some(), opened.is_interrupted);
        assert!(last.is_some() || started || !opened.is_interrupted || found == holds);
        (erases, interrupted) = (erases + opened.erased, interrupted + u32::from(opened.is_interrupted));
        holds = found;
        flash = log.into_flash();
    }
    assert!(erases > 20 && interrupted > 200, "{erases} erases, {interrupted} interrupted saves");
}
