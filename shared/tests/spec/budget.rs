//! The token buckets of a node: bounds by hand.
//!
//! Verifies: ECSS 5.3.3.1b

use ecss_can::link::budget::{Budget, BudgetPolicy, BudgetStep, Over, Rate};
use ecss_can::profile::Profile;
use ecss_can::types::{CobId, Duration, Instant};

use crate::bench::ms;

const PDO: u16 = 0x285;
const HEARTBEAT: u16 = 0x705;

/// Four frames at once with one COB-ID, a new one each 10 ms; eight of the node, a new one each 5 ms.
const POLICY: BudgetPolicy = BudgetPolicy {
    cob_id: Rate::new(4, 100),
    slave: Rate::new(8, 200),
    master: Rate::new(100, 1_000),
    heard: Rate::new(512, 3_000),
    silence: Duration::from_millis(300),
};

/// What becomes of this many frames at once.
fn at_once(budget: &mut Budget, id: u16, frames: usize, now: Instant) -> Vec<Option<Over>> {
    (0..frames).map(|_| budget.take(CobId::new(id).unwrap(), now)).collect()
}

fn steps(budget: &mut Budget, now: Instant) -> Vec<BudgetStep> {
    std::iter::from_fn(|| budget.poll(now)).collect()
}

/// Given a full bucket of four, when six frames come, then two are refused, and all until it is full again.
#[test]
fn an_empty_bucket_is_closed_until_it_is_full() {
    let mut budget = Budget::of_slave(&POLICY);
    let (sent, refused) = (None, Some(Over::CobId));
    assert_eq!(at_once(&mut budget, PDO, 6, ms(1_000)), [sent, sent, sent, sent, refused, refused]);
    // One token came back, and three.
    assert_eq!(at_once(&mut budget, PDO, 1, ms(1_010)), [refused]);
    assert_eq!(at_once(&mut budget, PDO, 1, ms(1_039)), [refused]);
    assert_eq!(at_once(&mut budget, PDO, 5, ms(1_040)), [sent, sent, sent, sent, refused]);
    // Another COB-ID is not concerned.
    assert_eq!(at_once(&mut budget, HEARTBEAT, 1, ms(1_040)), [sent]);
}

/// A frame each 10 ms is what comes back. Each 9 ms the bucket loses a tenth of a token with each frame: of its three spare
/// tokens nothing is left after thirty.
#[test]
fn the_rate_is_that_of_the_profile() {
    let mut budget = Budget::of_slave(&POLICY);
    let id = CobId::new(PDO).unwrap();
    assert!((0..1_000).all(|n| budget.take(id, ms(10 * n)).is_none()));
    let mut budget = Budget::of_slave(&POLICY);
    assert_eq!((0..1_000).position(|n| budget.take(id, ms(9 * n)).is_some()), Some(31));
}

#[test]
fn a_long_pause_fills_a_bucket_and_no_more() {
    let mut budget = Budget::of_slave(&POLICY);
    let year = Instant::from_micros(365 * 86_400 * 1_000_000);
    for now in [Instant::ZERO, year, year + Duration::from_millis(40)] {
        let sent = at_once(&mut budget, PDO, 6, now).iter().filter(|sent| sent.is_none()).count();
        assert_eq!(sent, 4, "{now:?}");
    }
}

/// Buckets count microseconds in 32 bits: 71.6 minutes. Around the instant at which they begin again nothing is special.
#[test]
fn buckets_wrap_without_a_trace() {
    let wrap = Instant::from_micros(1 << 32);
    for before in [1, 5_000, 10_000, 39_999, 40_000] {
        let mut budget = Budget::of_slave(&POLICY);
        let empty_at = wrap - Duration::from_micros(before);
        assert_eq!(at_once(&mut budget, PDO, 1, empty_at - Duration::from_millis(100)), [None]);
        assert_eq!(at_once(&mut budget, PDO, 5, empty_at)[4], Some(Over::CobId));
        let full_at = empty_at + Duration::from_millis(40);
        let early = full_at - Duration::from_micros(1);
        assert_eq!(at_once(&mut budget, PDO, 1, early), [Some(Over::CobId)], "{before} us before");
        assert_eq!(
            at_once(&mut budget, PDO, 5, full_at)[3..],
            [None, Some(Over::CobId)],
            "{before} us before"
        );
    }
}

/// At the end of time nothing panics.
#[test]
fn a_bucket_at_the_end_of_time_saturates() {
    let mut budget = Budget::of_slave(&POLICY);
    let last = Instant::from_micros(u64::MAX - 1);
    assert_eq!(at_once(&mut budget, PDO, 3, last), [None; 3]);
    assert_eq!(steps(&mut budget, last), []);
}

/// Given three COB-IDs within their own buckets, when the ninth frame of the node comes, then the node is silent for its time.
/// What the network lives on goes out in the meantime, within its own bucket.
#[test]
fn a_node_above_its_budget_is_silent_for_a_time() {
    let mut budget = Budget::of_slave(&POLICY);
    assert_eq!(at_once(&mut budget, 0x285, 4, ms(0)), [None; 4]);
    assert_eq!(at_once(&mut budget, 0x385, 4, ms(0)), [None; 4]);
    assert!(!budget.is_silent());
    assert_eq!(at_once(&mut budget, 0x485, 2, ms(0)), [Some(Over::Node), Some(Over::Silent)]);
    assert!(budget.is_silent());
    assert_eq!((budget.deadline(), steps(&mut budget, ms(0))), (Some(ms(300)), vec![]));
    let vital = at_once(&mut budget, HEARTBEAT, 5, ms(0));
    assert_eq!(vital, [None, None, None, None, Some(Over::CobId)]);
    assert_eq!(at_once(&mut budget, 0x085, 1, ms(0)), [None], "the report");
    assert_eq!(at_once(&mut budget, PDO, 1, ms(299)), [Some(Over::Silent)]);
    assert_eq!((budget.deadline(), steps(&mut budget, ms(299))), (Some(ms(300)), vec![]));
    assert_eq!(steps(&mut budget, ms(300)), [BudgetStep::Resume]);
    assert_eq!(at_once(&mut budget, PDO, 4, ms(300)), [None; 4]);
    assert_eq!(steps(&mut budget, ms(1_299)), []);
    assert_eq!(steps(&mut budget, ms(1_300)), [BudgetStep::Calm]);
}

#[test]
fn calm_is_a_second_after_the_last_refusal() {
    let mut budget = Budget::of_slave(&POLICY);
    assert_eq!(budget.deadline(), None);
    at_once(&mut budget, PDO, 5, ms(0));
    at_once(&mut budget, PDO, 1, ms(30));
    assert_eq!((budget.deadline(), steps(&mut budget, ms(1_029))), (Some(ms(1_030)), vec![]));
    assert_eq!(steps(&mut budget, ms(1_030)), [BudgetStep::Calm]);
    assert_eq!(budget.deadline(), None);
}

/// A client asks for each of them, or for a sub-block of at most 127.
#[test]
fn sdo_has_no_bucket() {
    let mut budget = Budget::of_slave(&POLICY);
    for id in [0x581, 0x585, 0x5FF, 0x601, 0x67F] {
        assert_eq!(at_once(&mut budget, id, 1_000, ms(0)), [None; 1_000], "{id:03X}h");
    }
    assert!(at_once(&mut budget, 0x57F, 5, ms(0)).contains(&Some(Over::CobId)));
    assert!(at_once(&mut budget, 0x680, 5, ms(0)).contains(&Some(Over::CobId)));
}

/// The COB-IDs of each slave have buckets of their own: PDOs, emergencies, heartbeats. Nothing that is a PDO closes the bucket of
/// what the network lives on, of any node.
#[test]
fn cob_ids_of_a_node_do_not_share_a_bucket() {
    for node in 1..=127 {
        let mut budget = Budget::of_master(&POLICY);
        for id in [0x180, 0x280, 0x380, 0x480, 0x080, 0x700].map(|function| function + node) {
            assert_eq!(at_once(&mut budget, id, 4, ms(0)), [None; 4], "{id:03X}h");
        }
    }
    for pdo in (0x182..0x580).chain(0x680..0x700) {
        let mut budget = Budget::of_master(&POLICY);
        assert_eq!(at_once(&mut budget, pdo, 5, ms(0))[4], Some(Over::CobId), "{pdo:03X}h");
        for id in [0x000, 0x080, 0x081, 0x181, 0x701] {
            assert_eq!(at_once(&mut budget, id, 1, ms(0)), [None], "{id:03X}h beside {pdo:03X}h");
        }
    }
}

/// A master that commands 126 slaves ten times a second, and asks each for telemetry as often, is within the default budget,
/// however its commands lie in each tenth: here in five steps of 26 slaves.
#[test]
fn a_master_of_all_slaves_is_within_the_default_budget() {
    let mut budget = Budget::of_master(&Profile::DEFAULT.budget);
    for tenth in 0..100 {
        for (step, nodes) in (2..=127_u16).collect::<Vec<_>>().chunks(26).enumerate() {
            let now = ms(100 * tenth + step as u64);
            for node in nodes {
                assert_eq!(at_once(&mut budget, 0x300 + node, 1, now), [None]);
                assert_eq!(at_once(&mut budget, 0x400 + node, 1, now), [None]);
            }
        }
        assert_eq!(at_once(&mut budget, 0x701, 1, ms(100 * tenth)), [None]);
        assert_eq!(at_once(&mut budget, 0x080, 1, ms(100 * tenth)), [None]);
    }
}

#[test]
fn a_rate_admits_twice_the_frames_of_a_period() {
    let rate = Rate::new(4, 100);
    assert!(rate.is_twice(Duration::from_millis(20)) && rate.is_twice(Duration::ZERO));
    assert!(!rate.is_twice(Duration::from_micros(19_999)));
    assert!(!Rate::new(1, 100).is_twice(Duration::from_millis(20)), "two at once");
    assert!(rate.is_at_least(Rate::new(4, 100)) && !rate.is_at_least(Rate::new(5, 100)));
    assert!(!rate.is_at_least(Rate::new(4, 101)));
}
