//! Frames with all their edges.
//!
//! Verifies: ECSS 7.2.3c, 7.2.3k

use can_twin::wire::frame::WireFrame;
use ecss_can::link::{Captured, EDGES, EdgeRing, Miss, Stamp};
use ecss_can::types::{CobId, Frame, Instant};
use proptest::prelude::*;

use crate::line::{BIT, Line, Node, PER_MICRO, Sent, error};
use crate::random::cases;

/// Largest error of a stamp when all edges were captured, ticks.
pub const LIMIT: f64 = EdgeRing::<PER_MICRO>::ERROR as f64;

pub fn sync() -> WireFrame {
    WireFrame::standard(0x080, &[])
}

pub fn frames() -> impl Strategy<Value = WireFrame> {
    (0..=0x7FFu16, prop::collection::vec(prop_oneof![any::<u8>(), Just(0), Just(0xFF), Just(0x55)], 0..=8))
        .prop_map(|(id, data)| WireFrame::standard(id, &data))
}

pub fn ways() -> impl Strategy<Value = Sent> {
    (-200.0..=200.0, 0.0..0.65, 0.0..0.65).prop_map(|(ppm, early, ack_late)| Sent { ppm, early, ack_late })
}

/// The edge that gives the stamp is 17 bits after SOF, the end of the frame 48 bits.
#[test]
fn a_sync_is_stamped_by_the_edge_of_dlc_bit_3() {
    let mut line = Line::new(1e6);
    let complete = line.frame(&sync(), Sent::default());
    assert_eq!(complete.end, 1e6 + 48.0 * BIT);
    let n = line.falls.iter().position(|at| *at == 1e6 + 17.0 * BIT).expect("the encoder has an edge there");
    line.falls[n] += 11.0;
    let mut node = Node::new(0);
    node.follow(&line, complete.end);
    let stamp = node.stamp(&sync(), complete.end, complete.end).unwrap();
    assert_eq!(stamp.fine().ticks(PER_MICRO) as f64, complete.end + 11.0);
}

/// Returns the error of a SYNC's stamp on a timer with another rate, ticks.
fn error_at<const RATE: u32>() -> f64 {
    let mut line = Line::new(1_000.0 * BIT);
    let end = line.frame(&sync(), Sent::default()).end * f64::from(RATE) / BIT;
    let ring = EdgeRing::<RATE>::new();
    for (cell, fall) in ring.cells().iter().zip(&line.falls) {
        let at = fall * f64::from(RATE) / BIT;
        cell.store(at as u32, std::sync::atomic::Ordering::Relaxed);
    }
    let line = Captured { next: line.falls.len(), alone_until: end as u32 + RATE };
    let reported = Stamp::interrupt(Instant::from_micros(end as u64 / u64::from(RATE)));
    let stamp = ring.stamp(line, &Frame::of(CobId::SYNC, []), reported, RATE).unwrap();
    (stamp.fine().ticks(RATE) as f64 - end).abs()
}

#[test]
fn timers_of_other_rates_stamp_frames_as_well() {
    let limits =
        [EdgeRing::<72>::ERROR, EdgeRing::<84>::ERROR, EdgeRing::<120>::ERROR, EdgeRing::<240>::ERROR];
    assert_eq!(limits, [4, 4, 5, 8]);
    let errors = [error_at::<72>(), error_at::<84>(), error_at::<120>(), error_at::<240>()];
    assert!(errors.iter().all(|ticks| *ticks < 1.0), "{errors:?}");
}

/// Given the earliest possible report, 1.3 bits before the end by a clock that is 1.9 us late, then the frame is found.
#[test]
fn a_frame_is_stamped_however_early_it_is_reported() {
    let mut line = Line::new(1e6);
    let complete = line.frame(&sync(), Sent::default());
    let mut node = Node::new(0);
    node.follow(&line, complete.end);
    let interrupt = complete.end - 1.3 * BIT - 1.9 * f64::from(PER_MICRO);
    let stamp = node.stamp(&sync(), interrupt, complete.end).unwrap();
    assert!(error(&stamp, &complete).abs() <= LIMIT);
}

#[test]
fn wherever_the_ring_begins_and_the_timer_wraps() {
    let wrap = 4_294_967_296.0;
    for cell in 0..EDGES {
        for origin in [wrap - cell as f64 * BIT / 4.0, 3.0 * wrap - 20.0 * BIT, 1e6] {
            let mut line = Line::new(origin);
            line.frame(&WireFrame::standard(0x555, &[0x55; 8]), Sent::default());
            line.idle(3.0);
            let complete = line.frame(&sync(), Sent::default());
            let mut node = Node::new(cell);
            node.follow(&line, complete.end);
            let stamp = node.stamp(&sync(), complete.end + 5.0 * BIT, line.now + 9.0 * BIT).unwrap();
            assert!(error(&stamp, &complete).abs() <= 1.0, "cell {cell}, origin {origin}");
        }
    }
}

/// ISO 11898-1 8.4.2.4: a receiver has the frame one bit before its end.
#[test]
fn interrupt_may_be_a_bit_early_to_almost_a_frame_late() {
    for late in -1..=40 {
        let mut line = Line::new(1e6 + f64::from(late));
        let complete = line.frame(&sync(), Sent::default());
        let mut node = Node::new(0);
        node.follow(&line, complete.end);
        let stamp = node.stamp(&sync(), complete.end + f64::from(late) * BIT, 0.0);
        assert!(error(&stamp.unwrap(), &complete).abs() <= 1.0, "{late} bits late");
    }
}

#[test]
fn equal_frames_back_to_back_have_own_stamps_even_if_task_late() {
    for task_delay in [0.0, 20.0, 40.0] {
        let mut line = Line::new(1e6);
        let mut ends = Vec::new();
        for _ in 0..20 {
            ends.push(line.frame(&sync(), Sent::default()));
            line.idle(3.0);
        }
        let mut node = Node::new(7);
        for complete in &ends {
            let interrupt = complete.end + 9.0 * BIT;
            let task = interrupt + task_delay * BIT;
            node.follow(&line, task);
            let stamp = node.stamp(&sync(), interrupt, task).unwrap();
            assert!(error(&stamp, complete).abs() <= 1.0);
        }
    }
}

#[test]
fn a_stamp_is_given_once() {
    let mut line = Line::new(1e6);
    let complete = line.frame(&sync(), Sent::default());
    let mut node = Node::new(0);
    node.follow(&line, complete.end);
    assert!(node.stamp(&sync(), complete.end, complete.end).is_ok());
    assert_eq!(node.stamp(&sync(), complete.end, complete.end), Err(Miss::Mismatch));
    // The low word has wrapped to the same value.
    let round = complete.end + 4_294_967_296.0;
    assert_eq!(node.stamp(&sync(), round, round), Err(Miss::Mismatch));
}

#[test]
fn without_edges_there_is_no_stamp() {
    let node = Node::new(0);
    assert_eq!(node.stamp(&sync(), 1e9, 1e9), Err(Miss::Silent));
}

proptest! {
    #![proptest_config(cases(2_000))]

    /// Given any frame among others, at any position in the ring and of the timer, sent by a clock with an error of 200
    /// ppm, with contenders and late acknowledgements, then the stamp is within its error.
    #[test]
    fn every_frame_is_stamped_within_its_error(
        frame in frames(),
        others in prop::collection::vec(frames(), 0..4),
        after in prop::option::of(frames()),
        way in ways(),
        cell in 0..EDGES,
        origin in 1_000_000u64..20_000_000_000,
        latency in 0.0..15.0f64,
    ) {
        prop_assume!(others.iter().chain(&after).all(|other| *other != frame));
        let mut line = Line::new(origin as f64);
        for other in &others {
            line.frame(other, way);
            line.idle(3.0);
        }
        let complete = line.frame(&frame, way);
        if let Some(after) = &after {
            line.idle(3.0);
            line.frame(after, way);
        }
        let mut node = Node::new(cell);
        node.follow(&line, line.now);
        let stamp = node.stamp(&frame, complete.end + latency * BIT, line.now);
        let stamp = stamp.map_err(|miss| TestCaseError::fail(format!("{miss:?}")))?;
        prop_assert!(error(&stamp, &complete).abs() <= LIMIT, "off by {}", error(&stamp, &complete));
    }
}
