//! Two master boards at both ends of the cable, slaves 2 to 4 between them (profile `standby`: the standby takes over after
//! 400 ms of silence on both buses; heartbeats come every 100 ms, slaves miss one after 250 ms and change the bus after 500 ms).
//!
//! Verifies: ECSS 8.1a

use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;
use ecss_can::node::{MasterEvent, MasterRequest, SlaveEvent};
use ecss_can::redundancy::{RoleCause, RoleChange};
use ecss_can::types::{Bus, Scet};
use ecss_can_worlds::NodeKey;
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::world::{Sent, World};
use mission::TWO_MASTERS;
use proptest::prelude::*;

use crate::random::cases;
use crate::support::*;

const PRIME: NodeKey = NodeKey::MASTER;
const SECOND: NodeKey = NodeKey::SECOND_MASTER;
/// Positions between prime and slave 2, slaves 2 and 3, slaves 3 and 4, and slave 4 and the second board.
const GAPS_M: [f64; 4] = [3.0, 5.0, 7.0, 9.0];

/// Returns a world in which prime is active and all slaves run.
fn flying() -> MissionWorld {
    let world = flown(MissionWorld::pair(TWO_MASTERS, 3, |world| world.seed(7)));
    assert_eq!(world.active_masters(), [PRIME]);
    world
}

fn flown(mut world: MissionWorld) -> MissionWorld {
    world.run_until(ms(3_000));
    assert!(world.all_operational());
    world
}

fn cut_both(world: &mut World, position_m: f64) {
    Bus::ALL.into_iter().for_each(|bus| world.cut(bus, position_m));
}

fn heal_both(world: &mut World) {
    Bus::ALL.into_iter().for_each(|bus| world.heal(bus));
}

/// Returns the frames of one board on both buses that ended after `from`, in the order of time.
fn of(world: &World, key: NodeKey, from: Time) -> Vec<(Bus, Sent)> {
    let all = Bus::ALL
        .into_iter()
        .flat_map(|bus| world.frames(bus).iter().map(move |sent| (bus, Sent::clone(sent))));
    let mut all: Vec<_> = all.filter(|(_, sent)| sent.key == Some(key) && sent.end > from).collect();
    all.sort_by_key(|(_, sent)| sent.end);
    all
}

/// Returns the SYNCs of one board that ended after `from`.
fn syncs(world: &World, key: NodeKey, from: Time) -> Vec<Sent> {
    let frames = of(world, key, from).into_iter().map(|(_, sent)| sent);
    frames.filter(|sent| sent.id() == Some(0x080)).collect()
}

/// Returns the changes of the role of a board after `from`.
fn roles(world: &World, key: NodeKey, from: Time) -> Vec<(Time, RoleCause)> {
    let log = world.log_of(key).into_iter().filter(|(at, _)| *at >= from);
    log.filter_map(|(at, what)| match what {
        NodeEvent::Master(MasterEvent::Role(RoleChange { cause, .. })) => Some((at, cause)),
        _ => None,
    })
    .collect()
}

/// Returns whether a board has sent nothing since `from`. A frame that was on the wire may have ended later.
fn is_silent(world: &World, key: NodeKey, from: Time) -> bool {
    of(world, key, from + ms(1)).is_empty()
}

#[test]
fn of_two_boards_powered_together_prime_is_active() {
    for seed in 0..4 {
        let world = flown(MissionWorld::pair(TWO_MASTERS, 3, |world| world.seed(seed)));
        assert_eq!(world.active_masters(), [PRIME]);
        assert!(is_silent(&world, SECOND, Time::ZERO));
    }
}

#[test]
fn a_second_board_that_is_first_stays_active() {
    let plan = |world: ecss_can_worlds::Builder| world.powered_at(PRIME, ms(1_500));
    let world = flown(MissionWorld::pair(TWO_MASTERS, 3, plan));
    assert_eq!(world.active_masters(), [SECOND]);
    assert!(is_silent(&world, PRIME, Time::ZERO));
}

/// Given an active master that went to the redundant bus, when it loses its power, then the standby is active on that bus within
/// its consumer time and 10 ms, and no slave changes the bus.
///
/// Verifies: ECSS 8.3.3a, 6.5.3a
#[test]
fn a_standby_takes_over_on_the_bus_heard_last() {
    for bus in Bus::ALL {
        let mut world = flying();
        world.request(MasterRequest::SwitchBus(bus));
        world.run_for(ms(1_050));
        let off = world.now();
        world.power_off(PRIME);
        world.run_for(ms(2_000));
        let heartbeats = between(&world, bus, 0x701, Time::ZERO, off);
        let last = heartbeats.last().unwrap().end;
        // On the other bus a claim may precede it.
        let of_second = of(&world, SECOND, Time::ZERO);
        let (_, first) = of_second.iter().find(|(place, _)| *place == bus).unwrap();
        assert_eq!((first.id(), first.frame.payload()), (Some(0x701), &[0][..]));
        let taken = first.end.since(last);
        assert!(taken > ms(399) && taken < ms(410), "{} us", taken.as_us());
        assert_eq!(roles(&world, SECOND, off).len(), 1);
        assert!(world.all_operational());
        for node in [TWO, THREE, FOUR] {
            let moved = told(
                &world,
                node,
                off,
                |event| matches!(event, SlaveEvent::ActiveBus { bus: to, .. } if *to != bus),
            );
            assert_eq!(moved, [], "slave {}", node.get());
            let commanded = world.reactions(node).into_iter().filter(|(at, _)| *at > first.end).count();
            assert!(commanded > 10, "slave {} is commanded: {commanded}", node.get());
        }
    }
}

/// Given a standby that was reset and is cut off from the active bus, then it hears claims on the other bus and stays the
/// standby. A foreign 701h on either bus changes nothing.
#[test]
fn standby_cut_off_from_the_active_bus_stays_the_standby() {
    let mut world = flying();
    let cut = world.now();
    world.reset(SECOND);
    let stub = world.index(SECOND);
    world.strike(Bus::Nominal, Fault::Disconnect(stub));
    for second in 0..20 {
        world.inject(Bus::ALL[second % 2], standard(0x701, &[5]));
        world.run_for(ms(1_000));
    }
    let causes: Vec<_> = roles(&world, SECOND, cut).into_iter().map(|(_, cause)| cause).collect();
    assert_eq!(causes, [RoleCause::MasterHeard]);
    assert_eq!((world.active_masters(), roles(&world, PRIME, cut)), (vec![PRIME], vec![]));
    assert!(world.all_operational() && is_silent(&world, SECOND, cut));

    world.power_off(PRIME);
    world.run_for(ms(15_000));
    assert_eq!(world.active_masters(), [SECOND]);
    assert!(world.all_operational());
}

/// Given a standby that has taken over, when the other board is back, then the roles stay.
#[test]
fn a_board_that_was_reset_in_flight_is_the_standby_for_ever() {
    let mut world = flying();
    let reset = world.now();
    world.reset(PRIME);
    world.run_for(ms(20_000));
    assert_eq!(world.active_masters(), [SECOND]);
    assert!(world.all_operational() && is_silent(&world, PRIME, reset));
    let causes = |key| -> Vec<_> { roles(&world, key, reset).into_iter().map(|(_, cause)| cause).collect() };
    assert_eq!(causes(SECOND), [RoleCause::MasterSilent]);
    assert_eq!(causes(PRIME), [RoleCause::MasterHeard]);
}

#[test]
fn a_commanded_handover_takes_the_consumer_time() {
    let mut world = flying();
    let now = world.now();
    world.request(MasterRequest::StandBy);
    world.run_for(ms(2_000));
    let taken = of(&world, SECOND, Time::ZERO).remove(0).1.end.since(now);
    assert!(taken > ms(290) && taken < ms(410), "{} us", taken.as_us());
    assert!(world.all_operational() && world.active_masters() == [SECOND] && is_silent(&world, PRIME, now));
    // Hands over again.
    let now = world.now();
    world.request_to(SECOND, MasterRequest::StandBy);
    world.run_for(ms(2_000));
    assert!(world.all_operational() && world.active_masters() == [PRIME] && is_silent(&world, SECOND, now));
}

/// Given both buses cut at one place, when they are healed, then of the two active masters the one that hears fewer slaves
/// yields, at a tie the one that is not strapped prime, within two heartbeat periods. While the halves are apart each master with a slave sends
/// SYNC in its half; from 210 ms after the healing on the one that stays sends it, in its period of 100 ms.
///
/// Verifies: ECSS 6.9d
/// Notices: ECSS 6.9d: a board that is strapped second sends no SYNC when it is active.
#[test]
fn of_two_halves_that_meet_the_larger_one_keeps_its_master() {
    // Cuts between the slaves: prime has one of three slaves, or two. In the last case one slave is off, and each
    // master has one.
    for (gap, is_off, stays) in
        [(0, false, SECOND), (1, false, SECOND), (2, false, PRIME), (3, false, PRIME), (1, true, PRIME)]
    {
        let mut world = flying();
        if is_off {
            world.power_off(FOUR);
            world.run_for(ms(1_000));
        }
        cut_both(&mut world, GAPS_M[gap]);
        world.run_for(ms(3_000));
        assert_eq!(world.active_masters(), [PRIME, SECOND], "gap {gap}");
        let healed = world.now();
        // The frames of a master without a slave are not acknowledged, so none completes.
        for (key, alone) in [(PRIME, 0), (SECOND, 3)] {
            let apart = syncs(&world, key, healed - ms(1_000)).len();
            assert_eq!(apart, if gap == alone { 0 } else { 10 }, "gap {gap}: {key:?}");
        }
        heal_both(&mut world);
        world.run_for(ms(3_000));
        assert_eq!(world.active_masters(), [stays], "gap {gap}, {is_off}");
        let yields = if stays == PRIME { SECOND } else { PRIME };
        let [(at, cause)] = roles(&world, yields, healed)[..] else { panic!("gap {gap}") };
        assert_eq!(cause, RoleCause::Yielded);
        assert!(at.since(healed) < ms(210), "gap {gap}: {} us", at.since(healed).as_us());
        assert!(roles(&world, stays, healed).is_empty() && is_silent(&world, yields, at));
        assert_eq!(syncs(&world, yields, healed + ms(210)), [], "gap {gap}");
        let periods = periods_us(&syncs(&world, stays, healed + ms(210)));
        assert!(periods.len() >= 26 && periods.iter().all(|us| us.abs_diff(100_000) < 2_000), "{periods:?}");
        world.power_on(FOUR);
        world.run_for(ms(2_000));
        assert!(world.all_operational(), "gap {gap}");
    }
}

/// Given a standby alone with a foreign node, when the foreign node sends, then no node acknowledges, because silent
/// mode drives no bit. A slave is added afterwards.
#[test]
fn a_standby_acknowledges_nothing() {
    let mut world = MissionWorld::pair(TWO_MASTERS, 1, |world| {
        world.powered_at(PRIME, Time::NEVER).powered_at(TWO, ms(800))
    });
    world.inject(Bus::Nominal, standard(0x701, &[5]));
    world.run_until(ms(790));
    assert_eq!((world.frames(Bus::Nominal), world.active_masters()), (&[][..], vec![]));
    let [(_, RoleCause::MasterHeard)] = roles(&world, SECOND, Time::ZERO)[..] else { panic!() };
    world.run_until(ms(900));
    assert_eq!(since(&world, Bus::Nominal, 0x701, Time::ZERO)[0].key, None, "the foreign node's");
    world.run_until(ms(2_500));
    assert!(world.all_operational() && world.active_masters() == [SECOND]);
}

/// Given no slave, when prime is active without acknowledgements, then the other board stays the standby, and the first
/// slave that appears is started.
#[test]
fn two_masters_without_a_slave_do_not_take_turns() {
    let mut world = MissionWorld::pair(TWO_MASTERS, 1, |world| world.powered_at(TWO, ms(5_000)));
    world.run_until(ms(5_000));
    assert_eq!(world.active_masters(), [PRIME]);
    assert_eq!(roles(&world, SECOND, Time::ZERO).len(), 1);
    assert!(Bus::ALL.into_iter().all(|bus| world.frames(bus).is_empty()));
    world.run_for(ms(3_000));
    assert!(world.all_operational() && world.active_masters() == [PRIME]);
}

/// Given slaves that follow the time of prime, when prime is lost before the other board heard a time, then the slaves
/// keep their time: the new master sends none until its clock is set.
///
/// Verifies: ECSS 7.2.2b, 6.9d, 7.2.2c, 7.2.3d
#[test]
fn a_new_master_without_a_time_changes_no_clock() {
    let mut world = MissionWorld::pair(TWO_MASTERS, 2, |world| world.powered_at(SECOND, Time::NEVER));
    world.run_until(ms(3_000));
    let set = world.now();
    world.request(MasterRequest::SetTime(Scet::new(1_000_000, 0).unwrap()));
    world.run_for(ms(5_000));
    // The time is sent every second. The second board hears heartbeats for 300 ms, and no time.
    let last = since(&world, Bus::Nominal, 0x181, Time::ZERO).last().unwrap().end;
    world.run_until(last + ms(1_010));
    world.power_on(SECOND);
    world.run_for(ms(300));
    world.power_off(PRIME);
    let off = world.now();
    world.run_for(ms(10_000));
    assert_eq!(world.active_masters(), [SECOND]);
    assert!(since(&world, Bus::Nominal, 0x080, off).len() > 80);
    assert_eq!(since(&world, Bus::Nominal, 0x181, off), []);
    for node in [TWO, THREE] {
        let kept = world.status(node).scet.micros_since(Scet::new(1_000_000, 0).unwrap());
        let passed = world.now().since(set).as_us() as i64;
        assert!((kept - passed).abs() < 10_000, "slave {}: {kept} us of {passed}", node.get());
    }
    world.request_to(SECOND, MasterRequest::SetTime(Scet::new(2_000_000, 0).unwrap()));
    world.run_for(ms(3_000));
    assert!(
        [TWO, THREE]
            .into_iter()
            .all(|node| (2_000_000..2_000_004).contains(&world.status(node).scet.coarse()))
    );
}

/// Given two masters without a fault, then the inactive bus carries one claim of the active master with each heartbeat
/// and no other frame, and no slave changes the bus because of it.
///
/// Verifies: ECSS 8.3.3d
#[test]
fn claims_on_the_other_bus_move_no_slave() {
    let mut world = flying();
    let from = world.now();
    world.run_for(ms(10_000));
    let there: Vec<_> = world.frames(Bus::Redundant).iter().filter(|sent| sent.end > from).collect();
    assert!((99..=101).contains(&there.len()), "{} frames", there.len());
    assert!(there.iter().all(|sent| sent.key == Some(PRIME) && sent.id() == Some(0x680)));
    assert!(there.iter().all(|sent| sent.frame.payload() == [3, 0]), "three slaves, strapped prime");
    assert!((99..=101).contains(&between(&world, Bus::Nominal, 0x680, from, world.now()).len()));
    for node in [TWO, THREE, FOUR] {
        assert_eq!(told(&world, node, from, |event| matches!(event, SlaveEvent::ActiveBus { .. })), []);
    }
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Wait { ms: u64 },
    Cut { bus: Bus, gap: usize },
    Heal { bus: Bus },
    Reset { key: NodeKey },
    Off { key: NodeKey },
    On { key: NodeKey },
    HandOver { key: NodeKey },
    Switch { key: NodeKey, to: Bus },
}

fn step() -> impl Strategy<Value = Step> {
    let bus = || prop::sample::select(&Bus::ALL[..]);
    let master = || prop::sample::select(&[PRIME, SECOND][..]);
    let key = || prop::sample::select(vec![PRIME, SECOND, TWO.into(), THREE.into(), FOUR.into()]);
    prop_oneof![
        4 => (0..1_500_u64).prop_map(|ms| Step::Wait { ms }),
        3 => (bus(), 0..GAPS_M.len()).prop_map(|(bus, gap)| Step::Cut { bus, gap }),
        2 => bus().prop_map(|bus| Step::Heal { bus }),
        2 => key().prop_map(|key| Step::Reset { key }),
        2 => key().prop_map(|key| Step::Off { key }),
        1 => key().prop_map(|key| Step::On { key }),
        1 => master().prop_map(|key| Step::HandOver { key }),
        1 => (master(), bus()).prop_map(|(key, to)| Step::Switch { key, to }),
    ]
}

fn perform(world: &mut World, step: Step) {
    match step {
        Step::Wait { ms: span } => world.run_for(ms(span)),
        Step::Cut { bus, gap } => world.cut(bus, GAPS_M[gap]),
        Step::Heal { bus } => world.heal(bus),
        Step::Reset { key } => world.reset(key),
        Step::Off { key } => world.power_off(key),
        Step::On { key } => world.power_on(key),
        Step::HandOver { key } if world.is_powered(key) => world.request_to(key, MasterRequest::StandBy),
        Step::Switch { key, to } if world.is_powered(key) => {
            world.request_to(key, MasterRequest::SwitchBus(to));
        }
        Step::HandOver { .. } | Step::Switch { .. } => {}
    }
}

proptest! {
    #![proptest_config(cases(16))]

    #[test]
    fn one_master_is_active_and_all_run_after_everything_is_healed(
        seed in any::<u64>(),
        script in prop::collection::vec(step(), 1..16),
    ) {
        let mut world = MissionWorld::pair(TWO_MASTERS, 3, |world| world.seed(seed));
        world.run_until(ms(1_500));
        for step in script {
            perform(&mut world, step);
        }
        heal_both(&mut world);
        [PRIME, SECOND, TWO.into(), THREE.into(), FOUR.into()].into_iter().for_each(|key| world.power_on(key));
        world.run_for(ms(6_000));
        prop_assert!(world.all_operational(), "{:?}", world.active_masters());
        // The state is stable: the same master is active, and the other one silent.
        let (settled, active) = (world.now(), world.active_masters());
        world.run_for(ms(2_000));
        prop_assert!(world.all_operational());
        prop_assert_eq!(world.active_masters(), active.clone());
        let standby = if active == [PRIME] { SECOND } else { PRIME };
        prop_assert!(is_silent(&world, standby, settled));
    }
}
