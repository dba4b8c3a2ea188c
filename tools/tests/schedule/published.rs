//! Values from the literature, and values by hand.

use std::time::Duration;

use ecss_can_cli::schedule::{Errors, Message, Network, response_times};

fn us(us: u64) -> Duration {
    Duration::from_micros(us)
}

/// 7 data bytes at 125 kbit/s: 125 bits, 1 ms.
fn message(id: u16, period: u64, deadline: u64) -> Message {
    Message { id, bytes: 7, period: us(period), jitter: us(0), deadline: us(deadline), after: None }
}

const SLOW: Network = Network { bit_rate: 125_000, errors: Errors::NONE };

/// The counter-example of Davis et al. 2007, section 3.3: the analysis of 1994 gives 3 ms for C, because it looks at the first
/// instance only. The second one takes 3.5 ms and misses its deadline of 3.25 ms.
#[test]
fn second_instance_in_the_busy_period_is_the_latest() {
    let set = [message(1, 2_500, 2_500), message(2, 3_500, 3_250), message(3, 3_500, 3_250)];
    assert_eq!(SLOW.transmission(&set[2]), us(1_000));
    let times = response_times(&set, &SLOW);
    assert_eq!(times, [Some(us(2_000)), Some(us(3_000)), Some(us(3_500))]);
    assert!(times[2] > Some(set[2].deadline));
}

/// Longest frames of the paper: 55 + 10 s bits. ISO 11898-1 counts 47 + 8 s without stuff bits, intermission included.
#[test]
fn longest_frames_have_55_bits_and_10_per_byte() {
    for bytes in 0..=8 {
        let longest = Message { bytes, ..message(1, 1_000, 1_000) }.longest_bits();
        assert_eq!(longest, 55 + 10 * u64::from(bytes));
    }
}

/// Calculated by hand, at 1 Mbit/s: 65 bits each, the lower priority blocks, and because of its jitter two frames of
/// the higher one may follow each other.
#[test]
fn jitter_and_blocking_by_hand() {
    let short = |id, period, jitter| Message { bytes: 1, jitter: us(jitter), ..message(id, period, period) };
    let fast = Network { bit_rate: 1_000_000, errors: Errors::NONE };
    let times = response_times(&[short(1, 200, 150), short(2, 1_000, 0)], &fast);
    // The higher: jitter, the blocking frame, itself. The lower: two of the higher (the second 50 us after the first), itself.
    assert_eq!(times, [Some(us(150 + 65 + 65)), Some(us(65 + 65 + 65))]);
}

/// Calculated by hand: an error costs 31 bits and the longest frame that may be on the bus.
#[test]
fn errors_cost_a_frame_and_31_bits_each() {
    let alone = [Message { bytes: 8, ..message(1, 10_000, 10_000) }];
    let time = |errors| response_times(&alone, &Network { bit_rate: 1_000_000, errors })[0];
    assert_eq!(time(Errors::NONE), Some(us(135)));
    assert_eq!(time(Errors { burst: 2, interval: None }), Some(us(135 + 2 * (31 + 135))));
    // With one error 301 us, two 467 us, three 633 us: each time one more interval of 200 us has begun. Four: 799 us.
    let every_200 = Errors { burst: 0, interval: Some(us(200)) };
    assert_eq!(time(every_200), Some(us(135 + 4 * 166)));
    // 166 us of recovery each 160 us: the frame is never sent.
    assert_eq!(time(Errors { burst: 0, interval: Some(us(160)) }), None);
}

/// Calculated by hand: an answer counts from the event of its request, and its interference grows with the jitter.
#[test]
fn answer_counts_from_the_event_of_its_request() {
    let request = Message { bytes: 8, ..message(5, 10_000, 10_000) };
    let answer = Message { bytes: 8, after: Some(0), ..message(4, 10_000, 10_000) };
    let times = response_times(&[request, answer], &Network { bit_rate: 1_000_000, errors: Errors::NONE });
    // Request: an older answer, then itself. Answer: the request, a blocking request, then itself.
    assert_eq!(times, [Some(us(270)), Some(us(270 + 135 + 135))]);
}

#[test]
fn overloaded_bus_has_no_bound_below_what_fills_it() {
    let set = [message(1, 1_500, 1_500), message(2, 2_500, 2_500), message(3, 9_000, 9_000)];
    let times = response_times(&set, &SLOW);
    assert!(times[0].is_some(), "{times:?}");
    // 1 / 1.5 + 1 / 2.5 is more than the whole bus.
    assert_eq!(times[1..], [None, None]);
}
