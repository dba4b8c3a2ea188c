//! The master leaves a bus; parallel slaves follow its first message, selective ones find it by toggling.
//!
//! Verifies: ECSS 8.3.3e, 8.3.3g

use can_twin::wire::time::Time;
use ecss_can::node::{MasterEvent, MasterRequest};
use ecss_can::profile::Profile;
use ecss_can::redundancy::{BusCause, SwitchCause};
use ecss_can::types::{Bus, NmtState, NodeId};
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::world::World;
use mission::Command;
use mission::{LIBRECUBE, STANDARD};

use crate::support::*;

/// Returns the end of the last heartbeat of the master on the nominal bus.
fn last_heartbeat(world: &World) -> Time {
    since(world, Bus::Nominal, 0x701, Time::ZERO).pop().expect("a heartbeat").end
}

fn switched_at(world: &World, from: Time) -> (Time, SwitchCause) {
    let log = world.log_of(MASTER).into_iter();
    let mut switches = log.filter_map(|(at, what)| match what {
        NodeEvent::Master(MasterEvent::BusSwitched { cause, .. }) if at >= from => Some((at, cause)),
        _ => None,
    });
    let first = switches.next().expect("the master switched");
    assert_eq!(switches.next(), None, "one switch");
    first
}

/// Verifies: ECSS 8.3.3b, 8.3.3b.2
#[test]
fn parallel_slaves_follow_the_first_message_on_the_other_bus() {
    for offset_us in [0, 13_000, 99_990] {
        let mut world = running(STANDARD, 3);
        world.run_for(Time::from_us(offset_us));
        let cut = world.now();
        cut_next_to_master(&mut world, Bus::Nominal);
        world.run_for(ms(1_000));

        let (switched, cause) = switched_at(&world, cut);
        assert_eq!(cause, SwitchCause::Isolated);
        // A heartbeat period and 5 ms.
        assert!(switched.since(cut) <= ms(105), "detected after {} us", switched.since(cut).as_us());
        let first = &world.frames(Bus::Redundant)[0];
        assert_eq!((first.id(), first.node), (Some(0x701), Some(MASTER)), "announced by its heartbeat");
        assert!(first.end.since(switched) < ms(1));
        for node in [TWO, THREE, FOUR] {
            let followed = told_once(&world, node, cut, changed_bus(Bus::Redundant, BusCause::Followed));
            assert!(followed.since(first.start) < ms(1));
            assert!(told(&world, node, cut, entered(NmtState::PreOperational)).is_empty());
        }
        let last = world.frames(Bus::Nominal).iter().rfind(|sent| sent.node == Some(MASTER));
        assert!(last.is_some_and(|sent| sent.end <= cut + ms(1)));
        assert!(world.all_operational());
    }
}

/// Verifies: ECSS 8.3.3b
#[test]
fn commands_flow_again_within_10_ms_of_the_detection() {
    let mut world = running(STANDARD, 3);
    let cut = world.now();
    cut_next_to_master(&mut world, Bus::Nominal);
    while switches(&world, cut) == 0 {
        world.run_for(ms(1));
    }
    let (switched, _) = switched_at(&world, cut);
    assert_eq!(world.command(THREE, Command::SetLed(true)), Ok(()));
    world.run_for(ms(10));
    let reactions = world.reactions(THREE);
    let executed =
        reactions.iter().find(|(_, reaction)| *reaction == Reaction::Executed(Command::SetLed(true)));
    assert!(executed.is_some_and(|(at, _)| at.since(switched) <= ms(10)));
    let sent = since(&world, Bus::Redundant, 0x303, cut);
    assert_eq!(sent.len(), 1);
}

/// Verifies: ECSS 8.3.3h, 8.3.3e.1, 8.3.3e.2, 8.3.3f, 8.3.3c
#[test]
fn selective_slave_toggles_after_ttoggle_and_is_started() {
    // 2 x 250 ms and 5 x 2.5 s after the last heartbeat.
    for (profile, consumer, toggle) in [(MIXED, 250, 500), (LIBRECUBE, 2_500, 12_500)] {
        let mut world = running(profile, 3);
        let cut = world.now();
        cut_next_to_master(&mut world, Bus::Nominal);
        world.run_for(ms(toggle + 2 * consumer));
        let last = last_heartbeat(&world);
        assert!(last <= cut + ms(1));

        let missed = told_once(&world, FOUR, cut, entered(NmtState::PreOperational)).since(last);
        assert!(
            missed.0.abs_diff(ms(consumer).0) < ms(consumer).0 / 20,
            "missed after {} us",
            missed.as_us()
        );
        let toggled = told_once(&world, FOUR, cut, changed_bus(Bus::Redundant, BusCause::Toggled));
        let after = toggled.since(last);
        assert!(after.0.abs_diff(ms(toggle).0) < ms(toggle).0 / 20, "toggled after {} us", after.as_us());
        // Its first heartbeat there, still Pre-operational, follows at once.
        let word = since(&world, Bus::Redundant, 0x704, cut).remove(0);
        assert!(word.end.since(toggled) < ms(2));
        assert_eq!(word.frame.payload(), [0x7F]);
        // The master starts it without a request.
        let started = told_once(&world, FOUR, cut, entered(NmtState::Operational));
        assert!(started.since(word.end) < ms(2));
        assert!(world.all_operational());
    }
}

/// Verifies: ECSS 8.3.3b, 8.3.3f
#[test]
fn a_cut_between_slaves_moves_everybody_to_the_whole_bus() {
    let mut world = running(STANDARD, 3);
    let cut = world.now();
    // Master and slave 2 on one side, 3 and 4 on the other.
    world.cut(Bus::Nominal, 5.0);
    world.run_for(ms(2_000));
    let (switched, cause) = switched_at(&world, cut);
    assert_eq!(cause, SwitchCause::SlavesSilent);
    assert!(switched.since(cut) <= ms(355), "the consumer time and a period");
    assert!(world.all_operational());
}

/// Verifies: ECSS 8.3.3b.1, 8.3.3b.2, 8.3.3b, 8.3.3d, 8.3.3f
#[test]
fn on_command_heartbeat_stops_on_one_bus_starts_on_the_other() {
    let mut world = running(MIXED, 3);
    for (from, to) in [(Bus::Nominal, Bus::Redundant), (Bus::Redundant, Bus::Nominal)] {
        let begin = world.now();
        world.request(MasterRequest::SwitchBus(to));
        world.run_for(ms(1_500));
        assert!(world.all_operational());
        assert_eq!(world.master_bus(), to);
        assert_eq!(switched_at(&world, begin), (begin, SwitchCause::Commanded));
        assert!(since(&world, from, 0x701, begin + ms(1)).is_empty());
        assert!(since(&world, to, 0x701, begin)[0].start.since(begin) < ms(1));
        // The selective slave came by itself. No slave is left on the old bus.
        let late = world.frames(from).iter().filter(|sent| sent.start > begin + ms(501)).count();
        assert_eq!(late, 0);
    }
}

/// Verifies: ECSS 8.3.3e.2, 8.3.3f, 8.3.3h
#[test]
fn drifting_clocks_fail_over_in_time() {
    for drift in [-100, 100] {
        let mut world = MissionWorld::of(MIXED, 3, |world| world.drift(FOUR, drift).drift(MASTER, -drift));
        world.run_until(ms(30_000));
        let cut = world.now();
        assert_eq!(switches(&world, Time::ZERO), 0);
        assert!(told(&world, FOUR, Time::ZERO, changed_bus(Bus::Redundant, BusCause::Toggled)).is_empty());
        cut_next_to_master(&mut world, Bus::Nominal);
        world.run_for(ms(1_000));
        assert!(world.all_operational());
        let toggled = told_once(&world, FOUR, cut, changed_bus(Bus::Redundant, BusCause::Toggled));
        let after = toggled.since(last_heartbeat(&world)).as_secs_f64();
        // 500 ms of its own clock.
        assert!((after - 0.5 / (1.0 + f64::from(drift) * 1e-6)).abs() < 200e-6, "{after}");
    }
}

/// Given a busy network of fourteen slaves, three of them with selective access, when the master is cut off from the nominal bus, then
/// eleven follow it at once and stay Operational, and three toggle by their own clocks and are started.
///
/// Verifies: ECSS 8.3.3e.1, 8.3.3e.2, 8.3.3h, 8.3.3f, 6.5.2b
#[test]
fn fourteen_slaves_fail_over_under_traffic() {
    const SELECTIVE: Profile =
        Profile { selective: &[FOUR, NodeId::of::<9>(), NodeId::of::<15>()], ..STANDARD };
    let mut world = MissionWorld::busy(SELECTIVE, 14, |world| world.seed(3));
    world.run_until(ms(2_000));
    let cut = world.now();
    cut_next_to_master(&mut world, Bus::Nominal);
    world.run_until(ms(4_000));
    assert!(world.all_operational());
    assert_eq!((world.master_bus(), switches(&world, Time::ZERO)), (Bus::Redundant, 1));
    let (switched, last) = (switched_at(&world, cut).0, last_heartbeat(&world));
    for node in world.slaves() {
        let left = told(&world, node, cut, entered(NmtState::PreOperational));
        if SELECTIVE.selective.contains(&node) {
            // Missed after 250 ms, on the other bus after 500 ms, started there.
            assert_eq!(left.len(), 1, "{node:?}");
            assert!(
                left[0].since(last).0.abs_diff(ms(250).0) < ms(5).0,
                "{node:?} after {} us",
                left[0].since(last).as_us()
            );
            let toggled = told_once(&world, node, cut, changed_bus(Bus::Redundant, BusCause::Toggled));
            let after = toggled.since(last);
            assert!(after.0.abs_diff(ms(500).0) < ms(5).0, "{node:?} toggled after {} us", after.as_us());
            let started = told_once(&world, node, cut, entered(NmtState::Operational));
            assert!(started > toggled && started.since(toggled) < ms(10), "{node:?}");
        } else {
            let followed = told_once(&world, node, cut, changed_bus(Bus::Redundant, BusCause::Followed));
            assert!(followed >= switched && followed.since(switched) < ms(2), "{node:?}");
            assert_eq!(left, [], "{node:?} stays Operational");
        }
    }
}
