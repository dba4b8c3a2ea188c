//! Lines with faults: no stamp rather than one of another frame.
//!
//! Verifies: ECSS 7.2.3c, 7.2.3k

use can_twin::wire::encode::encode;
use can_twin::wire::frame::WireFrame;
use ecss_can::link::{EDGES, Miss};
use proptest::prelude::*;

use crate::line::{BIT, Complete, Line, Node, Sent, error, falls, reference};
use crate::random::cases;
use crate::sound::{LIMIT, frames, sync, ways};

/// Bits of error flag, echo of it, delimiter and intermission until the next frame, as [`Line::destroyed`] has them.
const FLAG: usize = 6;

/// Most that an edge of the transmitter may be off and still be taken for it, ticks (250 ns).
const QUARTER: f64 = BIT / 4.0;

/// A frame with which random faults once found what [`spurious_edge_in_place_of_a_lost_one_is_taken_for_it`]
/// shows.
fn found() -> WireFrame {
    WireFrame::standard(0x528, &[0xFF, 0x55, 0x00, 0x55, 0x22, 0x55])
}

/// Returns the nominal time of the edge that gives the stamp of a frame, for a transmitter without clock error.
fn edge_of(complete: &Complete) -> f64 {
    let after = encode(&complete.frame).bits().len() - reference(&complete.frame);
    complete.end - after as f64 * BIT
}

/// Returns the stamp of `complete`, requested `bits` after the frame, when all edges of the line were captured.
fn stamp_of(line: &Line, complete: &Complete, bits: f64) -> Result<f64, Miss> {
    let mut node = Node::new(200);
    node.follow(line, line.now);
    node.stamp(&complete.frame, complete.end + bits * BIT, line.now).map(|stamp| error(&stamp, complete))
}

#[test]
fn a_missing_edge_is_missed() {
    for missing in 0..falls(&sync()).len() {
        let mut line = Line::new(1e6);
        let complete = line.frame(&sync(), Sent::default());
        line.falls.remove(missing);
        assert_eq!(stamp_of(&line, &complete, 3.0), Err(Miss::Mismatch), "edge {missing}");
    }
}

#[test]
fn extra_edge_is_noticed_from_idle_bus_to_end_of_frame() {
    for tenth in -100..=465 {
        let mut line = Line::new(1e6);
        let complete = line.frame(&sync(), Sent::default());
        line.falls.push(1e6 + f64::from(tenth) / 10.0 * BIT);
        line.falls.sort_by(f64::total_cmp);
        assert_eq!(stamp_of(&line, &complete, 3.0), Err(Miss::Mismatch), "{tenth} tenths of a bit after SOF");
    }
}

#[test]
fn an_edge_in_a_wrong_place_is_noticed() {
    for (wrong, at) in falls(&sync()).into_iter().enumerate() {
        for off in [-0.9, 0.8] {
            let mut line = Line::new(1e6);
            let complete = line.frame(&sync(), Sent::default());
            line.falls[wrong] += off * BIT;
            let result = stamp_of(&line, &complete, 3.0);
            assert_eq!(result, Err(Miss::Mismatch), "the edge {at} bits after SOF, off by {off}");
        }
    }
}

/// An edge may be early or late by jitter, which cannot be distinguished from a disturbance that moves it.
#[test]
fn stamp_follows_an_edge_off_by_up_to_a_quarter_of_a_bit() {
    for frame in [sync(), found()] {
        for (moved, at) in falls(&frame).into_iter().enumerate() {
            for off in -42..=42 {
                let mut line = Line::new(1e6);
                let complete = line.frame(&frame, Sent::default());
                line.falls[moved] += f64::from(off);
                let expected = if at == reference(&frame) { f64::from(off) } else { 0.0 };
                match stamp_of(&line, &complete, 3.0) {
                    Ok(error) => {
                        assert_eq!(error, expected, "the edge {at} bits after SOF, {off} ticks off");
                        assert!(expected.abs() <= QUARTER);
                    }
                    Err(miss) => {
                        assert_eq!(miss, Miss::Mismatch);
                        assert!(
                            f64::from(off).abs() > QUARTER,
                            "the edge {at} bits after SOF, {off} ticks off"
                        );
                    }
                }
            }
        }
    }
}

/// Given two faults that cancel each other: after two destroyed attempts the frame loses the edge of its stamp, and a
/// spurious edge falls 0.094 bits later.
#[test]
fn spurious_edge_in_place_of_a_lost_one_is_taken_for_it() {
    let mut line = Line::new(1e6);
    line.frame(&WireFrame::standard(0x163, &[]), Sent::default());
    line.idle(3.0);
    for flag in [8, 6] {
        line.destroyed(&found(), 26, flag);
        line.idle(3.0);
    }
    let complete = line.frame(&found(), Sent::default());
    let edge = line.falls.iter_mut().find(|at| **at == edge_of(&complete)).expect("it is there");
    *edge += 0.094 * BIT;
    let late = (0.094 * BIT).floor(); // as the timer has it
    assert_eq!(stamp_of(&line, &complete, 0.0), Ok(late));
}

/// Given an error flag at any bit of an attempt, then only the retransmission is stamped.
#[test]
fn a_destroyed_attempt_is_not_stamped_and_its_retransmission_is() {
    let length = encode(&sync()).bits().len();
    for bits in 1..length {
        for flag in FLAG..=12 {
            let mut line = Line::new(1e6);
            line.destroyed(&sync(), bits, flag);
            line.idle(3.0);
            let attempts = line.falls.len();
            let complete = line.frame(&sync(), Sent::default());
            let result = stamp_of(&line, &complete, 5.0);
            if [length - 9, length - 8, length - 1].contains(&bits) {
                // The flag is at or next to the acknowledgement and looks like it, or only the transmitter has found an
                // error.
                assert_eq!(result, Err(Miss::Ambiguous));
            } else {
                assert!(result.is_ok_and(|off| off.abs() <= 1.0), "{bits} bits, flag {flag}: {result:?}");
            }

            line.falls.truncate(attempts);
            assert!(stamp_of(&line, &complete, 5.0).is_err(), "{bits} bits, flag {flag}, edges lost");
        }
    }
}

/// Given a dominant last bit of EOF, when the receivers have the frame and its transmitter repeats it, then each has
/// its own stamp.
#[test]
fn each_of_a_doubled_frame_has_its_own_stamp() {
    let length = encode(&sync()).bits().len();
    let mut line = Line::new(1e6);
    let first = Complete { frame: sync(), end: 1e6 + length as f64 * BIT };
    line.destroyed(&sync(), length - 1, FLAG);
    line.idle(3.0);
    let second = line.frame(&sync(), Sent::default());

    // The task is late: most edges of the second frame are in the ring when the stamp of the first is requested.
    let mut node = Node::new(0);
    for (complete, task) in [(first, second.end - 2.0 * BIT), (second, second.end + 9.0 * BIT)] {
        node.follow(&line, task);
        let stamp = node.stamp(&sync(), complete.end + 4.0 * BIT, task).unwrap();
        assert!(error(&stamp, &complete).abs() <= 1.0);
    }
}

#[test]
fn frames_that_begin_with_the_same_edges_are_others() {
    let counted = WireFrame::standard(0x080, &[0x00]);
    let remote = WireFrame { remote: true, ..sync() };
    let emergency = WireFrame::standard(0x081, &[]);
    for other in [counted, remote, emergency] {
        let mut line = Line::new(1e6);
        let complete = line.frame(&other, Sent::default());
        let reported = Complete { frame: sync(), ..complete };
        assert_eq!(stamp_of(&line, &reported, 5.0), Err(Miss::Mismatch), "{other:?}");
    }
}

/// The edges of the frame may be disturbed, and the ones in the ring may be those of an earlier frame whose report was
/// lost.
#[test]
fn an_interrupt_that_is_a_frame_late_gives_no_stamp() {
    let mut line = Line::new(1e6);
    let complete = line.frame(&sync(), Sent::default());
    assert_eq!(stamp_of(&line, &complete, 48.0), Err(Miss::Late));
    // Two equal frames, one report lost or late.
    line.idle(3.0);
    let second = line.frame(&sync(), Sent::default());
    assert_eq!(stamp_of(&line, &second, 2.0), Err(Miss::Ambiguous));
}

#[test]
fn after_a_miss_the_next_frame_is_stamped() {
    let mut line = Line::new(1e6);
    let mut node = Node::new(0);
    let late = line.frame(&sync(), Sent::default());
    node.follow(&line, line.now);
    assert_eq!(node.stamp(&sync(), late.end + 60.0 * BIT, 0.0), Err(Miss::Late));
    line.idle(100.0);
    let complete = line.frame(&sync(), Sent::default());
    node.follow(&line, line.now);
    let stamp = node.stamp(&sync(), complete.end, 0.0).unwrap();
    assert!(error(&stamp, &complete).abs() <= 1.0);
}

#[test]
fn a_ring_that_was_overwritten_gives_no_stamp() {
    let dense = WireFrame::standard(0x555, &[0x55; 8]);
    let mut line = Line::new(1e6);
    let complete = line.frame(&sync(), Sent::default());
    let edges = line.falls.len();
    while line.falls.len() < EDGES + edges {
        line.idle(3.0);
        line.frame(&dense, Sent::default());
        let kept = line.falls.len() < EDGES;
        assert_eq!(stamp_of(&line, &complete, 5.0).is_ok(), kept, "{} edges", line.falls.len());
    }
    assert_eq!(stamp_of(&line, &complete, 5.0), Err(Miss::Silent));
}

#[derive(Clone, Debug)]
enum Fault {
    /// An edge is missing, by its position in the sequence of edges.
    Missing(prop::sample::Index),
    /// A spurious edge, by its position on the line.
    Noise(f64),
}

fn faults() -> impl Strategy<Value = Vec<Fault>> {
    let missing = any::<prop::sample::Index>().prop_map(Fault::Missing);
    let noise = (0.0..1.0f64).prop_map(Fault::Noise);
    prop::collection::vec(prop_oneof![missing, noise], 0..4)
}

proptest! {
    #![proptest_config(cases(2_000))]

    /// Given attempts, equal and foreign frames, lost and spurious edges, then a stamp is right, or its error is that
    /// of a spurious edge in place of the one that gives the stamp.
    #[test]
    fn a_stamp_is_right_or_there_is_none(
        frame in frames(),
        before in frames(),
        attempts in prop::collection::vec((1..60usize, FLAG..=12usize), 0..3),
        twice in any::<bool>(),
        faults in faults(),
        cell in 0..EDGES,
        origin in 1_000_000u64..20_000_000_000,
        latency in -1.0..120.0f64,
        task in 0.0..60.0f64,
    ) {
        prop_assume!(before != frame);
        let mut line = Line::new(origin as f64);
        line.frame(&before, Sent::default());
        line.idle(3.0);
        for (bits, flag) in attempts {
            line.destroyed(&frame, bits.min(encode(&frame).bits().len() - 1), flag);
            line.idle(3.0);
        }
        let mut complete = vec![line.frame(&frame, Sent::default())];
        if twice {
            line.idle(3.0);
            complete.push(line.frame(&frame, Sent::default()));
        }
        for fault in faults {
            match fault {
                Fault::Missing(index) => drop(line.falls.remove(index.index(line.falls.len()))),
                Fault::Noise(at) => line.falls.push(origin as f64 + at * (line.now - origin as f64)),
            }
        }
        line.falls.sort_by(f64::total_cmp);
        let mut node = Node::new(cell);
        node.follow(&line, line.now);
        for (n, complete_frame) in complete.iter().enumerate() {
            let interrupt = complete_frame.end + latency * BIT;
            let task = interrupt + task.max(1.0) * BIT;
            // A receiver has a frame one bit before its end. If there is a later equal frame, no stamp is requested.
            let alone = complete[n + 1..].iter().all(|later| later.end - BIT > task);
            if alone && let Ok(stamp) = node.stamp(&frame, interrupt, task) {
                let off = line.falls.iter().map(|at| at - edge_of(complete_frame));
                let off = off.min_by(|a, b| a.abs().total_cmp(&b.abs())).expect("there is a stamp");
                prop_assert!(off.abs() <= QUARTER + 1.0, "its edge is {off} ticks off");
                let error = error(&stamp, complete_frame);
                prop_assert!((error - off).abs() <= 1.0, "{error} ticks off, its edge {off}");
            }
        }
    }

    /// Given contenders, distant acknowledgements, a clock error, and one displaced edge, then the error is at most a
    /// quarter of a bit.
    #[test]
    fn no_edge_out_of_its_place_makes_more_than_a_quarter_of_a_bit(
        frame in frames(),
        way in ways(),
        moved in any::<prop::sample::Index>(),
        off in -1.0..1.0f64,
    ) {
        let mut line = Line::new(1e6);
        let complete = line.frame(&frame, way);
        let moved = moved.index(line.falls.len());
        line.falls[moved] += off * BIT;
        line.falls.sort_by(f64::total_cmp);
        if let Ok(error) = stamp_of(&line, &complete, 3.0) {
            let is_of_stamp = falls(&frame)[moved] == reference(&frame);
            let limit = if is_of_stamp { QUARTER + LIMIT } else { LIMIT };
            prop_assert!(error.abs() <= limit, "{error} ticks off");
        }
    }
}
