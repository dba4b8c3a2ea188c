//! Which of two master boards is active.
//!
//! Consumer time 400 ms; the board strapped prime listens for 700 ms, the other one for 1 s. Claims 680h and 681h.
//!
//! Verifies: ECSS 8.1a

use ecss_can::profile::Profile;
use ecss_can::redundancy::machine::{Claim, RivalReaction, Standby};
use ecss_can::redundancy::{Pair, Role, RoleCause, RoleChange, Strap};
use ecss_can::types::Instant;

use crate::bench::{NOMINAL, REDUNDANT, frame, ms};

const PAIR: Pair = Profile::PAIR;

const ALONE: RoleChange = RoleChange { role: Role::Active, cause: RoleCause::Alone };
const HEARD: RoleChange = RoleChange { role: Role::Standby, cause: RoleCause::MasterHeard };
const SILENT: RoleChange = RoleChange { role: Role::Active, cause: RoleCause::MasterSilent };
const YIELDED: RoleChange = RoleChange { role: Role::Standby, cause: RoleCause::Yielded };

fn started(strap: Strap) -> Standby {
    let mut standby = Standby::new(PAIR, strap);
    standby.start(ms(0));
    standby
}

fn active(strap: Strap) -> Standby {
    let mut standby = started(strap);
    assert_eq!(standby.poll(standby.deadline().unwrap()), Some(ALONE));
    standby
}

fn standing_by(at: u64) -> Standby {
    let mut standby = started(Strap::Prime);
    assert_eq!(standby.on_master(REDUNDANT, ms(at)), RivalReaction::Changed(HEARD));
    standby
}

fn claim(slaves: u8, strap: Strap) -> Claim {
    Claim { slaves, strap }
}

/// Given a board that hears nothing, when it has listened for its time, then it is active, and not before; the one that is
/// strapped prime is first.
#[test]
fn a_board_that_hears_no_master_becomes_active_prime_first() {
    for (strap, listens) in [(Strap::Prime, 700), (Strap::Second, 1_000)] {
        let mut standby = started(strap);
        assert_eq!((standby.role(), standby.deadline()), (Role::Listening, Some(ms(listens))));
        assert_eq!(standby.poll(Instant::from_micros(listens * 1_000 - 1)), None);
        assert_eq!(standby.poll(ms(listens)), Some(ALONE));
        assert!(standby.is_active());
        assert_eq!((standby.deadline(), standby.heard()), (None, None));
    }
}

#[test]
fn board_that_hears_a_master_is_the_standby_while_it_hears_it() {
    for strap in [Strap::Prime, Strap::Second] {
        let mut standby = started(strap);
        assert_eq!(standby.on_master(NOMINAL, ms(699)), RivalReaction::Changed(HEARD));
        for at in (700..5_000).step_by(399) {
            assert_eq!(standby.poll(ms(at)), None, "{at} ms");
            assert_eq!(standby.on_master(NOMINAL, ms(at)), RivalReaction::Nothing);
        }
        assert_eq!(standby.role(), Role::Standby);
    }
}

#[test]
fn standby_takes_over_after_consumer_time_silent_on_both_buses() {
    let mut standby = standing_by(100);
    // The active one changes the bus: no silence.
    assert_eq!(standby.on_master(NOMINAL, ms(480)), RivalReaction::Nothing);
    assert_eq!(standby.deadline(), Some(ms(880)));
    assert_eq!(standby.poll(Instant::from_micros(879_999)), None);
    assert_eq!(standby.poll(ms(880)), Some(SILENT));
    assert_eq!(standby.heard(), Some(NOMINAL));
    assert_eq!((standby.poll(ms(5_000)), standby.deadline()), (None, None), "it hands back never by itself");
}

/// The claim that an active board sends with its heartbeat.
fn call(board: &mut Standby, at: u64, slaves: u8) -> Claim {
    board.call(ms(at), slaves).unwrap()
}

/// Given two active masters, when each hears the other's claim, then exactly one yields: that with fewer slaves, at a tie
/// the one that is not strapped prime.
///
/// Verifies: ECSS 5.3.3.2.3j
/// Notices: ECSS 8.1a: at a tie each claim outranks the other, and both boards yield.
/// Notices: ECSS 5.3.3.2.3j: two boards that became active in the short both stay so at a tie.
#[test]
fn of_two_active_masters_exactly_the_right_one_yields() {
    for (primes, seconds) in [(3, 2), (2, 3), (2, 2), (0, 0), (126, 0)] {
        for prime_hears_first in [true, false] {
            let (mut prime, mut second) = (active(Strap::Prime), active(Strap::Second));
            let second_stays = seconds > primes;
            let (first, other, counts) = if prime_hears_first {
                (&mut prime, &mut second, (primes, seconds))
            } else {
                (&mut second, &mut prime, (seconds, primes))
            };
            let sent = call(first, 2_000, counts.0);
            let reply = other.on_claim(NOMINAL, &sent, ms(2_001), counts.1);
            if let RivalReaction::Claim(reply) = reply {
                assert_eq!(
                    first.on_claim(NOMINAL, &reply, ms(2_002), counts.0),
                    RivalReaction::Changed(YIELDED)
                );
            } else {
                assert_eq!(reply, RivalReaction::Changed(YIELDED));
            }
            assert_eq!((prime.is_active(), second.is_active()), (!second_stays, second_stays));
        }
    }
}

/// Given claims that cross, when the numbers of slaves change between sending and receiving, then one master yields and not
/// both: the claim that was sent stands.
///
/// Verifies: ECSS 5.3.3.2.3k.2
/// Notices: ECSS 5.3.3.2.3k.2: two boards that meet when the cut is healed both yield.
#[test]
fn claims_that_cross_while_slaves_come_and_go_make_one_yield() {
    let (mut prime, mut second) = (active(Strap::Prime), active(Strap::Second));
    let (primes, seconds) = (call(&mut prime, 2_000, 3), call(&mut second, 2_000, 4));
    assert_eq!((primes.slaves, seconds.slaves), (3, 4));
    let prime_after = prime.on_claim(NOMINAL, &seconds, ms(2_001), 5);
    let second_after = second.on_claim(NOMINAL, &primes, ms(2_001), 1);
    assert_eq!(prime_after, RivalReaction::Changed(YIELDED));
    assert_ne!(second_after, RivalReaction::Changed(YIELDED));
}

/// Notices: ECSS 8.1a: a claim has the present number of slaves, not that of the first contact.
#[test]
fn claim_is_as_at_first_contact_until_consumer_time_of_silence() {
    let mut prime = active(Strap::Prime);
    let fewer = claim(2, Strap::Second);
    assert_eq!(call(&mut prime, 1_900, 3), claim(3, Strap::Prime));
    assert_eq!(prime.on_claim(NOMINAL, &fewer, ms(2_000), 1), RivalReaction::Claim(claim(3, Strap::Prime)));
    assert_eq!(call(&mut prime, 2_399, 1), claim(3, Strap::Prime));
    assert_eq!(call(&mut prime, 2_400, 4), claim(4, Strap::Prime));
}

/// A heartbeat of node 1 may be forged: an active master has nothing to do with it.
#[test]
fn heartbeats_without_a_claim_move_nobody_and_provoke_nothing() {
    let mut second = active(Strap::Second);
    let before = second.clone();
    assert_eq!(second.on_master(NOMINAL, ms(2_000)), RivalReaction::Nothing);
    assert_eq!(call(&mut second, 2_100, 1), claim(1, Strap::Second));
    assert_eq!((second.role(), second.heard(), before.heard()), (Role::Active, Some(NOMINAL), None));
}

/// Given an active master that hears claims without end, when it answers, then once in 10 ms.
#[test]
fn claims_are_answered_once_in_ten_milliseconds() {
    let mut prime = active(Strap::Prime);
    let fewer = claim(0, Strap::Second);
    let answers = (0..1_000).map(|at| prime.on_claim(NOMINAL, &fewer, ms(2_000 + at), 3));
    assert_eq!(answers.filter(|answer| matches!(answer, RivalReaction::Claim(_))).count(), 100);
    assert!(prime.is_active());
}

#[test]
fn a_master_whose_heartbeat_is_not_heard_is_known_by_its_claim() {
    let mut prime = active(Strap::Prime);
    let answer = prime.on_claim(NOMINAL, &claim(1, Strap::Second), ms(2_000), 2);
    assert_eq!(answer, RivalReaction::Claim(claim(2, Strap::Prime)));
    assert_eq!(
        prime.on_claim(NOMINAL, &claim(3, Strap::Second), ms(2_001), 2),
        RivalReaction::Changed(YIELDED)
    );
}

/// Given claims of the active master alone, as a board hears them that is cut off from the active bus, then it stays the standby.
/// It makes none itself.
///
/// Verifies: ECSS 5.3.3.2.3k
/// Notices: ECSS 5.3.3.2.3k: a standby behind the cut takes over although it hears claims on the other bus.
#[test]
fn a_standby_that_hears_claims_alone_stays_the_standby() {
    let mut second = active(Strap::Second);
    assert_eq!(
        second.on_claim(NOMINAL, &claim(3, Strap::Prime), ms(2_100), 0),
        RivalReaction::Changed(YIELDED)
    );
    assert_eq!(second.call(ms(2_100), 0), None);
    for at in (2_200..4_000).step_by(399) {
        assert_eq!(second.poll(ms(at)), None, "{at} ms");
        assert_eq!(second.on_claim(NOMINAL, &claim(3, Strap::Prime), ms(at), 0), RivalReaction::Nothing);
    }
}

/// Given a standby, Then it knows the most slaves that the active master claimed, until it was active itself.
#[test]
fn standby_notes_the_largest_claim_of_the_active_master() {
    let mut second = standing_by(100);
    assert_eq!(second.claimed(), 0, "no claim was heard");
    for (slaves, claimed) in [(1, 1), (2, 2), (0, 2)] {
        second.on_claim(NOMINAL, &claim(slaves, Strap::Prime), ms(200), 0);
        assert_eq!(second.claimed(), claimed, "{slaves} claimed");
    }
    second.poll(ms(600)).expect("it takes over");
    second.stand_by(ms(700), RoleCause::Commanded);
    assert_eq!(second.claimed(), 0);
}

#[test]
fn a_board_that_hears_a_claim_after_power_on_is_the_standby() {
    let mut second = started(Strap::Second);
    assert_eq!(second.on_claim(NOMINAL, &claim(3, Strap::Prime), ms(300), 0), RivalReaction::Changed(HEARD));
    assert_eq!((second.deadline(), second.heard()), (Some(ms(700)), Some(NOMINAL)));
}

/// Two boards with the same strap are a fault of the wiring: the numbers of slaves decide, and a tie floods no bus.
#[test]
fn boards_strapped_alike_decide_by_slaves_and_stay_at_a_tie() {
    for strap in [Strap::Prime, Strap::Second] {
        let mut board = active(strap);
        assert_eq!(board.on_claim(NOMINAL, &claim(2, strap), ms(2_000), 2), RivalReaction::Nothing);
        assert!(board.is_active());
        assert_eq!(board.on_claim(NOMINAL, &claim(3, strap), ms(2_100), 2), RivalReaction::Changed(YIELDED));
    }
}

#[test]
fn who_yielded_takes_over_again_when_the_other_one_falls_silent() {
    let mut second = active(Strap::Second);
    second.on_master(REDUNDANT, ms(2_000));
    assert_eq!(
        second.on_claim(NOMINAL, &claim(0, Strap::Prime), ms(2_000), 0),
        RivalReaction::Changed(YIELDED)
    );
    assert_eq!(second.on_claim(NOMINAL, &claim(9, Strap::Prime), ms(2_001), 0), RivalReaction::Nothing);
    second.on_master(REDUNDANT, ms(2_100));
    assert_eq!(second.deadline(), Some(ms(2_500)));
    assert_eq!(second.poll(ms(2_500)), Some(SILENT));
    assert_eq!(second.heard(), Some(REDUNDANT));
}

#[test]
fn commanded_standby_waits_a_consumer_time_and_takes_over_again() {
    let mut prime = active(Strap::Prime);
    let change = prime.stand_by(ms(3_000), RoleCause::Commanded);
    assert_eq!(change, RoleChange { role: Role::Standby, cause: RoleCause::Commanded });
    assert_eq!(prime.poll(ms(3_399)), None);
    assert_eq!(prime.poll(ms(3_400)), Some(SILENT));
}

/// Verifies: ECSS 6.10l, 6.10m
/// Notices: ECSS 6.10l: the second master board claims with the COB-ID of the prime one.
/// Notices: ECSS 6.10m: a claim with the COB-ID of one board and the strap of the other is taken.
#[test]
fn claims_as_frames_and_back_and_nothing_else_is_one() {
    for (expected, bytes) in [
        (claim(3, Strap::Prime), frame(0x680, &[3, 0])),
        (claim(126, Strap::Second), frame(0x681, &[126, 1])),
    ] {
        assert_eq!(PAIR.frame(expected), bytes);
        assert_eq!(PAIR.claim(&bytes), Some(expected));
    }
    for wrong in [
        frame(0x680, &[3]),
        frame(0x680, &[3, 1]),
        frame(0x681, &[3, 0]),
        frame(0x681, &[3, 2]),
        frame(0x680, &[3, 0, 0]),
        frame(0x682, &[3, 0]),
        frame(0x701, &[5]),
    ] {
        assert_eq!(PAIR.claim(&wrong), None, "{wrong:?}");
    }
}
