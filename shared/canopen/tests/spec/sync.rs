//! SYNC: producer, counter, consumer, window, rules of writing its objects.
//!
//! Verifies: ECSS 6.3a

use async_canopen::sync;
use async_canopen::sync::machine::{Config, Consumer, Producer, UnexpectedLength};
use async_canopen::types::{AbortCode, Duration, Frame, Instant};

use crate::bench::{frame, ms};

/// 1005h of a producer on 080h.
const PRODUCER: u32 = 0x4000_0080;

/// The next `count` SYNCs and when they are due, in milliseconds.
fn next(producer: &mut Producer, count: usize) -> Vec<(u64, Frame)> {
    let mut sent = vec![];
    while sent.len() < count {
        let due = producer.deadline().expect("SYNC is produced");
        sent.push((due.as_micros() / 1_000, producer.poll(due).expect("due is due")));
    }
    sent
}

/// Verifies: ECSS 6.3b, 6.9c, 6.9d
#[test]
fn sync_on_the_wire_and_every_period() {
    let mut producer = Producer::with(Config::new(PRODUCER, 5_000_000, 0));
    assert_eq!(producer.deadline(), None);
    producer.start(ms(0));
    assert_eq!(producer.poll(ms(4_999)), None);
    assert_eq!(producer.poll(ms(5_000)), Some(frame(0x080, &[])));
    assert_eq!(producer.deadline(), Some(ms(10_000)));
}

/// Verifies: ECSS 6.3b, 11.1a, 6.9c
/// Notices: ECSS 6.3b: the counter goes on with 0 after its greatest value.
/// Notices: ECSS 11.1a: the counter goes one beyond its overflow value.
#[test]
fn the_counter_goes_from_1_to_the_overflow_value() {
    let mut producer = Producer::with(Config::new(PRODUCER, 10_000, 3));
    producer.start(ms(0));
    let expected = [1, 2, 3, 1, 2].map(|counter| frame(0x080, &[counter]));
    assert_eq!(next(&mut producer, 5).into_iter().map(|(_, frame)| frame).collect::<Vec<_>>(), expected);
}

/// Verifies: ECSS 6.3b, 6.9c
#[test]
fn the_highest_counter_is_240() {
    let mut producer = Producer::with(Config::new(PRODUCER, 1_000, 240));
    producer.start(ms(0));
    let sent = next(&mut producer, 241);
    assert_eq!(sent[239], (240, frame(0x080, &[240])));
    assert_eq!(sent[240], (241, frame(0x080, &[1])));
}

/// Verifies: ECSS 6.3b, 6.9c
#[test]
fn the_counter_begins_anew_with_every_start() {
    let mut producer = Producer::with(Config::new(PRODUCER, 10_000, 100));
    producer.start(ms(0));
    next(&mut producer, 7);
    producer.start(ms(1_000));
    assert_eq!(next(&mut producer, 1), [(1_010, frame(0x080, &[1]))]);
}

/// Given a producer that is polled late, then the following SYNCs are due as if it had been on time.
///
/// Verifies: ECSS 6.9d, 6.9c
/// Notices: ECSS 6.9d: the next SYNC is due a period after one that was late.
#[test]
fn a_late_sync_does_not_move_those_that_follow() {
    let mut producer = Producer::with(Config::new(PRODUCER, 100_000, 0));
    producer.start(ms(0));
    assert_eq!(producer.poll(ms(103)), Some(frame(0x080, &[])));
    assert_eq!(next(&mut producer, 2).into_iter().map(|(due, _)| due).collect::<Vec<_>>(), [200, 300]);
}

/// Verifies: ECSS 6.3b, 6.9c, 6.9d, 6.10c
/// Notices: ECSS 6.3a: a SYNC with a counter goes out on 080h whatever 1005h has.
#[test]
fn only_a_node_whose_1005h_says_so_produces_sync() {
    let mut producer = Producer::with(Config::new(0x0000_0080, 10_000, 0));
    producer.start(ms(0));
    assert_eq!(producer.deadline(), None);
    // Bit 30 set: the first SYNC within one period, on the identifier of then.
    producer.configure(Config::new(0x4000_0090, 10_000, 0), ms(100));
    assert_eq!(next(&mut producer, 2), [(110, frame(0x090, &[])), (120, frame(0x090, &[]))]);
    producer.configure(Config::new(0x4000_0090, 10_000, 2), ms(120));
    assert_eq!(next(&mut producer, 2), [(130, frame(0x090, &[1])), (140, frame(0x090, &[2]))]);
    producer.configure(Config::new(0x0000_0090, 10_000, 0), ms(141));
    assert_eq!(producer.deadline(), None);
}

/// Verifies: ECSS 6.3b, 6.9c, 6.9d
/// Notices: ECSS 6.9c: a producer does not follow a new period.
#[test]
fn period_changes_while_sync_is_produced_and_counter_goes_on() {
    let mut producer = Producer::with(Config::new(PRODUCER, 100_000, 10));
    producer.start(ms(0));
    next(&mut producer, 2);
    producer.configure(Config::new(PRODUCER, 20_000, 10), ms(205));
    assert_eq!(next(&mut producer, 2), [(225, frame(0x080, &[3])), (245, frame(0x080, &[4]))]);
    producer.configure(Config::new(PRODUCER, 0, 10), ms(250));
    assert_eq!(producer.deadline(), None);
    producer.configure(Config::new(PRODUCER, 50_000, 10), ms(1_000));
    assert_eq!(next(&mut producer, 1), [(1_050, frame(0x080, &[1]))]);
}

/// Verifies: ECSS 6.9c
#[test]
fn the_same_values_again_change_nothing() {
    let mut producer = Producer::with(Config::new(PRODUCER, 100_000, 10));
    producer.start(ms(0));
    producer.configure(Config::new(PRODUCER, 100_000, 10), ms(90));
    assert_eq!(next(&mut producer, 1), [(100, frame(0x080, &[1]))]);
}

/// Verifies: ECSS 6.9c
#[test]
fn a_producer_is_configured_before_it_starts() {
    let mut producer = Producer::with(Config::new(PRODUCER, 100_000, 0));
    producer.configure(Config::new(PRODUCER, 30_000, 0), ms(10));
    assert_eq!(producer.deadline(), None);
    producer.start(ms(20));
    assert_eq!(producer.deadline(), Some(ms(50)));
}

/// Verifies: ECSS 6.9c
#[test]
fn a_period_is_zero_or_leaves_room_for_others() {
    for (period, expected) in
        [(0, Ok(())), (1, Err(AbortCode::ValueTooLow)), (99, Err(AbortCode::ValueTooLow)), (100, Ok(()))]
    {
        assert_eq!(sync::check_period(period), expected, "{period}");
    }
    assert_eq!(sync::check_period(u32::MAX), Ok(()));
}

/// Verifies: ECSS 6.3b
/// Notices: ECSS 6.3b: 1019h changes while SYNC has a period.
#[test]
fn overflow_is_0_or_2_to_240_and_fixed_while_there_is_a_period() {
    for overflow in 0..=255 {
        let legal = overflow == 0 || (2..=240).contains(&overflow);
        let expected = if legal { Ok(()) } else { Err(AbortCode::ValueRange) };
        assert_eq!(sync::check_overflow(overflow, 0), expected, "{overflow}");
        assert_eq!(sync::check_overflow(overflow, 1_000), Err(AbortCode::DeviceState), "{overflow}");
    }
}

/// Verifies: ECSS 6.3b, 6.9e
#[test]
fn a_sync_of_unexpected_length_is_ignored() {
    let [empty, counted, long] = [&[][..], &[7], &[7, 8]].map(|data| frame(0x080, data));
    let mut plain = Consumer::new(0, 1_000);
    let mut counting = Consumer::new(10, 1_000);
    assert_eq!(plain.on_sync(&empty, ms(10)), Ok(0));
    assert_eq!(counting.on_sync(&counted, ms(10)), Ok(7));
    for wrong in [counted, long] {
        assert_eq!(plain.on_sync(&wrong, ms(20)), Err(UnexpectedLength));
    }
    for wrong in [empty, long] {
        assert_eq!(counting.on_sync(&wrong, ms(20)), Err(UnexpectedLength));
    }
    // It opened no window.
    assert_eq!((plain.window_end(), counting.window_end()), (ms(11), ms(11)));
    plain.configure(10, 1_000);
    assert_eq!(plain.on_sync(&counted, ms(30)), Ok(7));
}

/// Verifies: ECSS 6.9e
#[test]
fn synchronous_pdos_go_within_the_window_after_a_sync() {
    let sync = frame(0x080, &[]);
    let mut consumer = Consumer::new(0, 2_000);
    assert_eq!(consumer.window_end(), Instant::NEVER);
    consumer.on_sync(&sync, ms(100)).unwrap();
    assert_eq!(consumer.window_end(), ms(102));
    consumer.on_sync(&sync, ms(200)).unwrap();
    assert_eq!(consumer.window_end(), ms(200) + Duration::from_millis(2));
}

/// Verifies: ECSS 9.4.7.3d, 6.9e
/// Notices: ECSS 9.4.7.3d: a window of zero, which is not in use, ends with its SYNC.
#[test]
fn a_new_window_is_that_of_the_next_sync() {
    let sync = frame(0x080, &[]);
    let mut consumer = Consumer::new(0, 2_000);
    consumer.on_sync(&sync, ms(100)).unwrap();
    consumer.configure(0, 5_000);
    assert_eq!(consumer.window_end(), ms(102));
    consumer.on_sync(&sync, ms(200)).unwrap();
    assert_eq!(consumer.window_end(), ms(205));
    // None at all: open for ever, at once.
    for sync_follows in [false, true] {
        consumer.configure(0, 0);
        if sync_follows {
            consumer.on_sync(&sync, ms(300)).unwrap();
        }
        assert_eq!(consumer.window_end(), Instant::NEVER);
    }
}

#[test]
fn a_window_that_is_opened_stays_open_until_the_next_sync() {
    let sync = frame(0x080, &[]);
    let mut consumer = Consumer::new(0, 2_000);
    consumer.on_sync(&sync, ms(100)).unwrap();
    consumer.open();
    assert_eq!(consumer.window_end(), Instant::NEVER);
    consumer.on_sync(&sync, ms(200)).unwrap();
    assert_eq!(consumer.window_end(), ms(202));
}

/// When the next `count` SYNCs are due, microseconds.
fn due(producer: &mut Producer, count: usize) -> Vec<u64> {
    let next = |_| {
        let due = producer.deadline().expect("SYNC is produced");
        assert_eq!(producer.poll(Instant::from_micros(due.as_micros() - 1)), None, "not before it is due");
        assert!(producer.poll(due).is_some());
        due.as_micros()
    };
    (0..count).map(next).collect()
}

/// Verifies: ECSS 6.9c, 6.9d
#[test]
fn dither_delays_each_sync_by_part_of_quantum_and_keeps_grid() {
    const PERIOD: u64 = 1_000_000;
    let mut producer = Producer::with(Config::new(PRODUCER, PERIOD as u32, 0));
    producer.set_dither(15);
    producer.start(ms(0));
    let late: Vec<u64> =
        (1..).zip(due(&mut producer, 400)).map(|(n, due): (u64, u64)| due - n * PERIOD).collect();
    // The first one is announced before there is a delay for it.
    for amount in 0..=15 {
        let count = late.iter().filter(|late| **late == amount).count();
        assert!((10..=45).contains(&count), "{count} of 400 are late by {amount} us");
    }
    // No two neighbours go together: a delay says nothing of the next one.
    let pairs: std::collections::BTreeSet<_> = late.windows(2).collect();
    assert!(pairs.len() > 180, "{} pairs of delays in 400", pairs.len());
    producer.set_dither(0);
    assert_eq!(due(&mut producer, 2), [401 * PERIOD, 402 * PERIOD]);
}

/// Verifies: ECSS 6.9c, 6.9d
#[test]
fn dither_is_at_most_half_of_the_period() {
    let mut producer = Producer::with(Config::new(PRODUCER, 100, 0));
    producer.set_dither(1_000);
    producer.start(ms(0));
    let late: Vec<u64> =
        (1..).zip(due(&mut producer, 100)).map(|(n, due): (u64, u64)| due - n * 100).collect();
    assert!(late.iter().all(|late| *late <= 50), "{late:?}");
    assert!(late.contains(&50));
}
