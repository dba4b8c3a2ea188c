//! Canonical form of the redundancy: what its machines forget, and what they keep.
//!
//! Consumer time 100 ms, heartbeat 40 ms, Ttoggle 3, unless a test says otherwise.

use ecss_can::profile::Profile;
use ecss_can::redundancy::machine::{
    Claim, Manager, MasterMessage, Peers, RivalReaction, Rivals, Selection, Selector, Standby,
};
use ecss_can::redundancy::{Parameters, Strap};
use ecss_can::types::NmtState::Operational;
use ecss_can::types::{Bus, Canonical, Instant, PerBus};
use proptest::prelude::*;

use crate::bench::{NOMINAL, REDUNDANT, ms, node, span};
use crate::manager::{GRACE, PARAMETERS, decisions};
use MasterMessage::Heartbeat;

const NO_WORK: PerBus<u32> = PerBus { nominal: 0, redundant: 0 };

/// The canonical form at `now`, milliseconds.
fn canonical<M: Canonical + Clone>(machine: &M, now: u64, context: &M::Context) -> M {
    let mut machine = machine.clone();
    machine.canonical(ms(now), context);
    machine
}

/// Returns the instant this many milliseconds after the origin of canonical states.
fn after(ms: u64) -> Instant {
    Instant::ORIGIN + span(ms)
}

/// Follows the master on the nominal bus, heard with these gaps; the last heartbeat is at `last`.
fn following(gaps: &[u64], last: u64) -> Selector {
    let mut at = last - gaps.iter().sum::<u64>();
    let mut selector = Selector::new(PARAMETERS);
    selector.start(ms(at - 10));
    selector.on_master(NOMINAL, Heartbeat, ms(at));
    for gap in gaps {
        at += gap;
        selector.on_master(NOMINAL, Heartbeat, ms(at));
    }
    selector
}

#[test]
fn a_selector_keeps_the_age_of_the_last_heartbeat() {
    let heard = |last| canonical(&following(&[40; 4], last), last + 50, &NO_WORK);
    assert_eq!(heard(1_000), heard(50_000));
    let later = canonical(&following(&[40; 4], 1_000), 1_051, &NO_WORK);
    assert_ne!(heard(1_000), later);
}

/// Given a gap that is older than a longer one, then it never decides: it goes first.
#[test]
fn a_selector_forgets_gaps_that_a_longer_one_outlives() {
    let heard = |gaps: [u64; 4]| canonical(&following(&gaps, 1_000), 1_000, &NO_WORK);
    assert_eq!(heard([30, 35, 60, 40]), heard([50, 20, 60, 40]));
    assert_ne!(heard([30, 35, 60, 40]), heard([30, 35, 40, 60]));
    assert_ne!(heard([70, 35, 60, 40]), heard([50, 35, 60, 40]));
}

/// Given a search that ended, then its Ctoggle is shown until the next one, and decides nothing.
#[test]
fn a_selector_forgets_the_count_of_an_ended_search() {
    let found = |start| {
        let mut selector = Selector::new(PARAMETERS);
        selector.start(ms(start));
        for at in [300, 600] {
            selector.poll(ms(at));
        }
        selector.on_master(NOMINAL, Heartbeat, ms(650));
        selector
    };
    assert_eq!((found(0).parameters().ctoggle, found(400).parameters().ctoggle), (2, 0));
    assert_eq!(canonical(&found(0), 660, &NO_WORK), canonical(&found(400), 660, &NO_WORK));
}

/// Given a move to the other bus, when it is older than 1.5 gaps, then it is forgotten; before, it can be taken back.
#[test]
fn a_selector_forgets_a_move_that_nothing_takes_back() {
    let moved = |last| {
        let mut selector = following(&[40; 4], last);
        selector.on_master(REDUNDANT, Heartbeat, ms(1_010));
        selector
    };
    let mut open = canonical(&moved(1_000), 1_030, &NO_WORK);
    let back = Selection::Contradicted { bus: NOMINAL, moved: true };
    assert_eq!(open.on_master(NOMINAL, Heartbeat, after(10)), Some(back));
    assert_ne!(canonical(&moved(1_000), 1_069, &NO_WORK), canonical(&moved(1_005), 1_069, &NO_WORK));
    assert_eq!(canonical(&moved(1_000), 1_070, &NO_WORK), canonical(&moved(1_005), 1_070, &NO_WORK));
}

/// Given contradicting buses, then it counts whether the master worked on a bus, not how much, and a node that counts
/// its frames from zero again decides the same.
#[test]
fn a_selector_keeps_only_whether_the_master_worked() {
    let mut selector = following(&[40; 4], 1_000);
    selector.on_master(REDUNDANT, Heartbeat, ms(1_010));
    selector.on_master(NOMINAL, Heartbeat, ms(1_040));
    let worked = |redundant| canonical(&selector, 1_045, &PerBus { nominal: 0, redundant });
    assert_eq!(worked(5), worked(9));
    assert_ne!(worked(5), worked(0));
    let follows = |redundant| {
        let mut form = worked(redundant);
        form.on_work(NO_WORK);
        form.on_master(REDUNDANT, Heartbeat, after(5)) == Some(Selection::Followed { to: REDUNDANT })
    };
    assert!(follows(5) && !follows(0));
}

/// Peers of which one was heard on the active bus, and missed since, if that was long enough ago.
fn heard(peers: &Peers<8>, at: u64, now: u64) -> Peers<8> {
    let mut peers = peers.clone();
    peers.on_heartbeat(node(5), Operational, true, ms(at), &PARAMETERS);
    while peers.next_lost(ms(now), PARAMETERS.consumer).is_some() {}
    peers.checked(ms(now), &PARAMETERS);
    peers.canonical(ms(now), &PARAMETERS);
    peers
}

#[test]
fn peers_forget_when_a_slave_that_counts_was_lost() {
    let mut peers = Peers::new();
    peers.assign(node(5), true);
    assert_eq!(heard(&peers, 100, 5_000), heard(&peers, 4_800, 5_000));
    assert_ne!(heard(&peers, 4_950, 5_000), heard(&peers, 4_951, 5_000));
}

#[test]
fn peers_keep_the_age_of_a_foreign_node_for_its_memory() {
    let peers = Peers::new();
    assert_ne!(heard(&peers, 4_300, 5_000), heard(&peers, 4_301, 5_000));
    // Ten consumer times.
    assert_eq!(heard(&peers, 3_900, 5_000), heard(&peers, 4_000, 5_000));
}

/// Given a node with a consumer time of its own, 400 ms, then the horizon of its heartbeat is that one.
#[test]
fn peers_have_a_horizon_for_each_node() {
    let mut peers = Peers::new();
    peers.set_times(&[5 << 16 | 400]);
    assert_ne!(heard(&peers, 4_700, 5_000), heard(&peers, 4_701, 5_000));
}

/// Given a master that hears no slave and changed the bus twice, and one that did four times, then they are alike if
/// nothing limits the number.
#[test]
fn a_manager_forgets_a_count_without_a_limit() {
    let changed = |ntoggle, until| {
        let mut manager: Manager = Manager::new(Parameters { ntoggle, ..PARAMETERS }, 50, span(1_000), GRACE);
        manager.start(ms(0));
        assert_eq!(decisions(&mut manager, until).len() as u64, until / 1_000);
        canonical(&manager, until, &())
    };
    assert_eq!(changed(Parameters::NO_LIMIT, 2_010), changed(Parameters::NO_LIMIT, 4_010));
    assert_ne!(changed(9, 2_010), changed(9, 4_010));
}

/// Given a master that may always change the bus, then it may also without a slave that was heard.
#[test]
fn a_manager_forgets_a_heard_slave_without_a_limit() {
    let heard = |ntoggle, buses: &[Bus]| {
        let mut manager: Manager = Manager::new(Parameters { ntoggle, ..PARAMETERS }, 50, span(1_000), GRACE);
        manager.peers_mut().assign(node(2), true);
        manager.start(ms(0));
        buses.iter().for_each(|bus| manager.on_frame(*bus, Some(node(2)), ms(0)));
        canonical(&manager, 10, &())
    };
    assert_eq!(heard(Parameters::NO_LIMIT, &[]), heard(Parameters::NO_LIMIT, &[REDUNDANT]));
    assert_ne!(heard(9, &[]), heard(9, &[REDUNDANT]));
}

#[test]
fn rivals_keep_the_age_of_a_heartbeat_for_the_silence() {
    let last = |at| {
        let mut rivals = Rivals::default();
        rivals.on_heartbeat(REDUNDANT, ms(at));
        canonical(&rivals, 1_000, &span(300))
    };
    assert_eq!(last(600), last(700));
    assert_ne!(last(700), last(701));
}

/// Given an active board that hears the claim of another one, when none was heard for the consumer time, 400 ms, then it
/// is as if it had heard none.
#[test]
fn a_standby_forgets_an_encounter_after_the_consumer_time() {
    let mut alone = Standby::new(Profile::PAIR, Strap::Prime);
    alone.start(ms(0));
    assert!(alone.poll(ms(700)).is_some());
    let mut met = alone.clone();
    let weaker = Claim { slaves: 0, strap: Strap::Second };
    assert!(matches!(met.on_claim(NOMINAL, &weaker, ms(1_000), 2), RivalReaction::Claim(_)));
    assert_ne!(canonical(&met, 1_399, &()), canonical(&alone, 1_399, &()));
    assert_eq!(canonical(&met, 1_400, &()), canonical(&alone, 1_400, &()));
}

#[test]
fn an_active_board_forgets_when_it_became_active() {
    let active = |now, at| {
        let mut standby = Standby::new(Profile::PAIR, Strap::Prime);
        standby.start(ms(at));
        assert!(standby.poll(ms(5_000)).is_some());
        canonical(&standby, now, &())
    };
    assert_eq!(active(6_000, 0), active(9_000, 4_000));
}

/// A heartbeat, or only time.
fn steps() -> impl Strategy<Value = Vec<(u64, Option<Bus>)>> {
    let bus = prop_oneof![Just(None), Just(Some(NOMINAL)), Just(Some(REDUNDANT))];
    prop::collection::vec((1_u64..120, bus), 1..60)
}

proptest! {
    /// Given random heartbeats on both buses, when one of two equal selectors takes its canonical form after each step, then
    /// both decide the same at the same time.
    #[test]
    fn a_canonical_selector_decides_like_the_other_one(steps in steps()) {
        let (mut other, mut form) = (Selector::new(PARAMETERS), Selector::new(PARAMETERS));
        other.start(ms(0));
        form.start(ms(0));
        form.canonical(ms(0), &NO_WORK);
        let mut now = 0;
        for (wait, bus) in steps {
            now += wait;
            loop {
                let (one, two) = (other.poll(ms(now)), form.poll(after(wait)));
                prop_assert_eq!(one, two);
                if one.is_none() {
                    break;
                }
            }
            if let Some(bus) = bus {
                prop_assert_eq!(
                    other.on_master(bus, Heartbeat, ms(now)),
                    form.on_master(bus, Heartbeat, after(wait))
                );
            }
            form.canonical(after(wait), &NO_WORK);
            prop_assert_eq!(other.selected(), form.selected());
        }
    }
}
