//! Commands that CAN delivers twice are executed once, and no command of a master that starts is lost.

use async_canopen::pdo::{RepeatFilter, Sequence};
use async_canopen::types::{Duration, Instant};

use crate::bench::{ms, span};

/// Sequence and bytes.
type Command = (u8, [u8; 2]);

const LIFETIME: Duration = Duration::from_millis(100);

fn filter() -> RepeatFilter<Command> {
    RepeatFilter::new(LIFETIME)
}

#[test]
fn a_repeat_within_the_lifetime_is_dropped_and_counted() {
    let mut filter = filter();
    assert!(filter.accept((0, [1, 2]), ms(10)), "nothing was before it");
    for at in [10, 11, 60, 110] {
        assert!(!filter.accept((0, [1, 2]), ms(at)), "{at} ms");
    }
    assert_eq!(filter.repeats(), 4);
    filter.reset_count();
    assert!(!filter.accept((0, [1, 2]), ms(110)), "the last command stays known");
    assert_eq!(filter.repeats(), 1);
}

#[test]
fn a_command_with_another_sequence_or_other_bytes_is_new() {
    let mut filter = filter();
    assert!(filter.accept((0, [1, 2]), ms(10)));
    assert!(filter.accept((1, [1, 2]), ms(10)), "commanded again");
    assert!(filter.accept((1, [1, 3]), ms(10)), "of another master, say");
    assert!(filter.accept((0, [1, 2]), ms(10)), "only the last one is compared");
    assert_eq!(filter.repeats(), 0);
}

#[test]
fn an_equal_command_after_the_lifetime_is_new() {
    let mut filter = filter();
    assert!(filter.accept((7, [1, 2]), ms(10)));
    assert!(!filter.accept((7, [1, 2]), ms(100)), "a repeat does not prolong the lifetime");
    assert!(filter.accept((7, [1, 2]), ms(116)));
    assert!(!filter.accept((7, [1, 2]), ms(117)));
    assert_eq!(filter.repeats(), 2);
}

#[test]
fn numbers_are_stepped_and_wrap() {
    let mut sequence = Sequence::new(ms(1_000), LIFETIME);
    let numbers: Vec<u8> = (0..257).filter_map(|_| sequence.step(ms(2_000))).collect();
    assert_eq!((numbers[0], numbers[1], numbers[255], numbers[256], numbers.len()), (0, 1, 255, 0, 257));
}

#[test]
fn every_number_of_a_fast_producer_is_new_to_its_consumer() {
    let (mut sequence, mut filter) = (Sequence::new(ms(0), LIFETIME), filter());
    for nth in 0..1_000 {
        let at = sequence.ready_at() + Duration::from_micros(nth);
        let number = sequence.step(at).unwrap();
        assert!(filter.accept((number, [0, 0]), at), "the {nth}th, all bytes alike");
    }
}

/// Given a master that is reset, or replaced, right after its first command
/// When the next one sends its first command as soon as it may
/// Then that is no repeat, though sequence and bytes are the same and the consumer takes its commands late.
#[test]
fn the_first_command_of_a_new_master_is_no_repeat() {
    let command = |sequence: &mut Sequence, at: Instant| (sequence.step(at).unwrap(), [1, 0]);
    let mut filter = filter();
    let mut one = Sequence::new(ms(0), LIFETIME);
    let first_at = one.ready_at();
    assert!(filter.accept(command(&mut one, first_at), first_at + span(4)));
    let mut other = Sequence::new(first_at, LIFETIME);
    let second_at = other.ready_at();
    assert!(filter.accept(command(&mut other, second_at), second_at));
    assert_eq!(filter.repeats(), 0);
}

#[test]
fn a_new_master_has_no_number_until_older_commands_are_past() {
    let mut sequence = Sequence::new(ms(500), LIFETIME);
    assert_eq!(sequence.ready_at(), ms(610), "the lifetime and 10 ms");
    assert_eq!(
        (sequence.step(ms(500)), sequence.step(ms(609)), sequence.step(ms(610))),
        (None, None, Some(0))
    );
}
