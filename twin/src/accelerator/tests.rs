//! The accelerator against RM0090 3.5, access by access.

use super::*;

const WS3: u32 = 3;
const WS5: u32 = 5;
const FLASH_BYTES: u32 = 1 << 20;

fn accelerator(acr: u32) -> Accelerator {
    let mut accelerator = Accelerator::new(FlashTiming::AsSet, FLASH_BYTES);
    accelerator.set(acr);
    accelerator
}

/// Runs instructions of one cycle each at these offsets, from `cycle` on. Returns the cycle after the last.
fn run(accelerator: &mut Accelerator, mut cycle: u64, offsets: impl IntoIterator<Item = u32>) -> u64 {
    for offset in offsets {
        accelerator.read(Purpose::Fetch, offset, cycle);
        cycle += 1 + u64::from(accelerator.take_waits());
    }
    cycle
}

/// Returns offsets of 32-bit instructions, four in each line.
fn wide(lines: Range<u32>) -> impl Iterator<Item = u32> {
    (lines.start * LINE..lines.end * LINE).step_by(4)
}

fn load(accelerator: &mut Accelerator, cycle: u64, line: u32) -> u32 {
    accelerator.read(Purpose::Load, line * LINE, cycle);
    accelerator.take_waits()
}

#[test]
fn without_prefetch_each_line_costs_the_wait_states() {
    assert_eq!(run(&mut accelerator(WS3), 0, wide(0..10)), 10 * (4 + 3));
    assert_eq!(run(&mut accelerator(0), 0, wide(0..10)), 10 * 4);
}

/// RM0090 figure 4: at 3 wait states four instructions of 32 bits last as long as the read of the next four.
#[test]
fn prefetch_hides_the_wait_states_of_straight_code() {
    assert_eq!(run(&mut accelerator(WS3 | PRFTEN), 0, wide(0..10)), 3 + 10 * 4);
    // At 5 wait states a read takes two cycles longer than four instructions.
    assert_eq!(run(&mut accelerator(WS5 | PRFTEN), 0, wide(0..10)), 5 + 4 + 9 * (4 + 2));
    // Eight instructions of 16 bits hide them all.
    let narrow = (0..10 * LINE).step_by(2);
    assert_eq!(run(&mut accelerator(WS5 | PRFTEN), 0, narrow), 5 + 10 * 8);
}

#[test]
fn a_branch_waits_for_the_read_ahead_to_end() {
    let mut accelerator = accelerator(WS5 | PRFTEN);
    // The line is available in cycle 5, the next one in cycle 11, another one 6 cycles later.
    assert_eq!(run(&mut accelerator, 0, [0]), 6);
    assert_eq!(run(&mut accelerator, 6, [0x100]), 11 + 6 + 1);
}

#[test]
fn a_loop_of_64_lines_costs_nothing_the_second_time() {
    let mut accelerator = accelerator(WS5 | ICEN);
    let first = run(&mut accelerator, 0, wide(0..64));
    assert_eq!(first, 64 * (4 + 5));
    assert_eq!(run(&mut accelerator, first, wide(0..64)), first + 64 * 4);
}

#[test]
fn the_least_recently_used_line_makes_room() {
    let mut accelerator = accelerator(WS5 | ICEN);
    let mut now = run(&mut accelerator, 0, wide(0..64));
    // Line 0 is used again, so line 64 replaces line 1.
    now = run(&mut accelerator, now, wide(0..1));
    now = run(&mut accelerator, now, wide(64..65));
    assert_eq!(run(&mut accelerator, now, wide(0..1)), now + 4);
    now += 4;
    assert_eq!(run(&mut accelerator, now, wide(1..2)), now + 4 + 5);
}

/// Only "requested data not present in the currently used instruction line, in the prefetched line or in the cache" is
/// cached.
#[test]
fn lines_that_were_read_ahead_are_not_kept() {
    let mut accelerator = accelerator(WS5 | ICEN | PRFTEN);
    let now = run(&mut accelerator, 0, wide(0..2));
    let now = now + 100;
    let again = run(&mut accelerator, now, wide(0..2));
    assert_eq!(again - now, 4 + 4 + 2, "line 0 is found, line 1 is read ahead once more");
}

#[test]
fn eight_lines_of_data_are_kept() {
    let mut accelerator = accelerator(WS5 | DCEN);
    let mut now = 0;
    let mut costs = |lines: Range<u32>| {
        let cost = |line| {
            now += 100;
            load(&mut accelerator, now, line)
        };
        lines.map(cost).sum::<u32>()
    };
    assert_eq!(costs(100..108), 8 * 5);
    assert_eq!(costs(100..108), 0);
    assert_eq!(costs(108..109), 5);
    assert_eq!(costs(101..108), 0);
    assert_eq!(costs(100..101), 5, "the one that was used least recently");
}

#[test]
fn without_data_cache_each_load_reads_flash() {
    let mut accelerator = accelerator(WS5);
    assert_eq!([load(&mut accelerator, 10, 3), load(&mut accelerator, 20, 3)], [5, 5]);
}

#[test]
fn a_load_waits_for_a_read_that_is_under_way() {
    let mut accelerator = accelerator(WS5 | PRFTEN);
    run(&mut accelerator, 0, [0]);
    // The next line is available in cycle 11, another one 6 cycles later.
    assert_eq!(load(&mut accelerator, 7, 50), 11 + 6 - 7);
}

#[test]
fn a_vector_costs_nothing_and_uses_a_line() {
    let mut accelerator = accelerator(WS5 | ICEN);
    accelerator.read(Purpose::Vector, 0x40, 0);
    assert_eq!(accelerator.take_waits(), 0);
    assert_eq!(run(&mut accelerator, 100, [0x1000]), 100 + 6);
    assert_eq!(run(&mut accelerator, 200, [0x40]), 201, "in the cache");
}

#[test]
fn ideal_memory_costs_nothing_and_no_accelerator_everything() {
    let all = WS5 | PRFTEN | ICEN | DCEN;
    for (timing, once, again) in [
        (FlashTiming::Ideal, 10 * 4, 10 * 4),
        (FlashTiming::AsSet, 5 + 4 + 9 * (4 + 2), 4 + 9 * (4 + 2)),
        (FlashTiming::Unaccelerated, 10 * (4 + 5), 10 * (4 + 5)),
    ] {
        let mut accelerator = Accelerator::new(timing, FLASH_BYTES);
        accelerator.set(all);
        assert_eq!(run(&mut accelerator, 0, wide(0..10)), once, "{timing:?}");
        assert_eq!(run(&mut accelerator, 1000, wide(0..10)), 1000 + again, "{timing:?}, once more");
    }
}

const OLD: [u8; 64] = [0x11; 64];
const NEW: [u8; 64] = [0xFF; 64];

/// Lines 2 and 3 in both caches, then their sector is erased.
fn erased(acr: u32) -> Accelerator {
    let mut accelerator = accelerator(acr);
    for line in 2..4 {
        load(&mut accelerator, 0, line);
        run(&mut accelerator, 0, [line * LINE]);
    }
    accelerator.change(0..64, &OLD, &NEW, None);
    accelerator
}

fn shows(accelerator: &mut Accelerator, access: Purpose, line: u32) -> Option<u8> {
    accelerator.read(access, line * LINE, 0).map(|bytes| bytes[0])
}

#[test]
fn an_erase_leaves_stale_lines_until_the_cache_is_reset() {
    const CACHES: u32 = ICEN | DCEN;
    let mut accelerator = erased(CACHES);
    for access in [Purpose::Load, Purpose::Fetch] {
        assert_eq!(shows(&mut accelerator, access, 1), None, "not in a cache");
        assert_eq!(shows(&mut accelerator, access, 2), Some(0x11));
    }
    accelerator.set(ICEN);
    assert_eq!(shows(&mut accelerator, Purpose::Load, 2), None, "the data cache is off");
    accelerator.set(CACHES);
    assert_eq!(shows(&mut accelerator, Purpose::Load, 2), Some(0x11), "and on again, and was not reset");
    accelerator.set(ICEN | DCRST);
    accelerator.set(CACHES);
    assert_eq!(
        [Purpose::Load, Purpose::Fetch].map(|access| shows(&mut accelerator, access, 2)),
        [None, Some(0x11)]
    );
    accelerator.set(DCEN | ICRST);
    accelerator.set(CACHES);
    assert_eq!(shows(&mut accelerator, Purpose::Fetch, 2), None);
}

#[test]
fn a_reset_of_the_chip_empties_the_caches() {
    let mut accelerator = erased(ICEN | DCEN);
    accelerator.reset();
    accelerator.set(ICEN | DCEN);
    assert_eq!([Purpose::Load, Purpose::Fetch].map(|access| shows(&mut accelerator, access, 2)), [None; 2]);
}

/// Given a line that is stale since an erase, when a word of it is programmed, then the data cache shows that word.
#[test]
fn programming_writes_through_the_data_cache_alone() {
    let mut accelerator = erased(ICEN | DCEN);
    let mut programmed = NEW;
    programmed[36..40].fill(0x22);
    accelerator.change(0..64, &NEW, &programmed, Some((36, &[0x22; 4])));
    let mut line = |access| accelerator.read(access, 2 * LINE, 0).expect("stale");
    let mut expected = [0x11; 16];
    assert_eq!(line(Purpose::Fetch), expected);
    expected[4..8].fill(0x22);
    assert_eq!(line(Purpose::Load), expected);
}

/// RM0090 3.6.4: a store to flash modifies the data in the cache as well, with the value that was stored. Given a line that the data
/// cache holds, when flash keeps some of the bits that are to be programmed, then the cache shows the stored bytes until it is reset.
#[test]
fn data_cache_shows_what_was_stored_and_not_what_flash_took() {
    let mut accelerator = accelerator(ICEN | DCEN);
    load(&mut accelerator, 0, 2);
    let mut programmed = NEW;
    programmed[36..40].fill(0x32);
    accelerator.change(0..64, &NEW, &programmed, Some((36, &[0x22; 4])));
    let mut expected = [0xFF; 16];
    expected[4..8].fill(0x22);
    assert_eq!(accelerator.read(Purpose::Load, 2 * LINE, 0), Some(expected));
    accelerator.set(ICEN | DCRST);
    accelerator.set(ICEN | DCEN);
    assert_eq!(accelerator.read(Purpose::Load, 2 * LINE, 0), None, "flash itself");
}
