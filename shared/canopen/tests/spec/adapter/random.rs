//! Random frames over drivers that replace frames: none is lost, doubled or out of order.

use std::collections::BTreeMap;

use async_canopen::link::port::{CanPort, PortEvent};
use proptest::prelude::*;

use super::chip::{Bench, Replaces};
use crate::bench::frame;

/// What happens next.
#[derive(Clone, Debug)]
enum Step {
    /// The node sends a frame with this identifier.
    Send(u16),
    /// The driver sends a frame.
    Leaves,
    /// The task of the bus runs.
    Runs,
}

fn step() -> impl Strategy<Value = Step> {
    let id = prop::sample::select(vec![0x000, 0x080, 0x083, 0x181, 0x283, 0x583, 0x703]);
    prop_oneof![3 => id.prop_map(Step::Send), 1 => Just(Step::Leaves), 2 => Just(Step::Runs)]
}

proptest! {
    #[test]
    fn every_frame_leaves_once_and_in_order(
        steps in prop::collection::vec(step(), 1..80),
        mailboxes in 1_usize..4,
        is_fifo in any::<bool>(),
    ) {
        let replaces = if is_fifo { Replaces::Never } else { Replaces::Lowest };
        let mut bench = Bench::joined(mailboxes, replaces);
        let (mut sent, mut left, mut ends) = (Vec::new(), Vec::new(), Vec::new());
        for (number, step) in (0_u8..).zip(steps) {
            match step {
                Step::Send(id) => {
                    let frame = frame(id, &[number]);
                    sent.extend(bench.port.send(&frame).map(|_| frame));
                }
                Step::Leaves => left.extend(bench.chip.borrow_mut().sends()),
                Step::Runs => ends.extend(bench.events()),
            }
        }
        ends.extend(bench.events());
        // Each frame that leaves makes room for one that waits, and the end of that one is taken.
        while !bench.chip.borrow().pending.is_empty() {
            left.extend(bench.chip.borrow_mut().sends());
            ends.extend(bench.events());
        }
        let by_id = |frames: &[_]| {
            let mut all = BTreeMap::<u16, Vec<u8>>::new();
            for frame in frames {
                let frame: &async_canopen::types::Frame = frame;
                all.entry(frame.id().raw()).or_default().extend(frame.data());
            }
            all
        };
        prop_assert_eq!(by_id(&left), by_id(&sent));
        prop_assert_eq!(ends.len(), sent.len());
        let is_sent = |end: &PortEvent| matches!(end, PortEvent::Transmitted { .. });
        prop_assert!(ends.iter().all(is_sent));
    }
}
