//! Cuts that heal, resets in mid-flight, slaves that come and go.

use can_twin::wire::time::Time;
use ecss_can::link::port::{CanPort, ErrorState, Health};
use ecss_can::node::{MasterEvent, MasterRequest, SlaveEvent};
use ecss_can::types::{Bus, NmtState, PerBus};
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::world::{Sent, World};
use mission::Command;
use mission::STANDARD;

use crate::support::*;

fn of_master(world: &World, bus: Bus, from: Time) -> Vec<Sent> {
    let frames = world.frames(bus).iter().map(|sent| Sent::clone(sent));
    frames.filter(|sent| sent.node == Some(MASTER) && sent.end > from).collect()
}

/// Verifies: ECSS 5.3.3.2.3k.2, 8.3.3f
/// Notices: ECSS 5.3.3.2.3k.2: the master starts slaves at their boot-up alone.
#[test]
fn both_buses_cut_and_restored() {
    for outage in [ms(50), ms(300), ms(700), ms(3_000)] {
        let mut world = running(MIXED, 3);
        Bus::ALL.into_iter().for_each(|bus| cut_next_to_master(&mut world, bus));
        world.run_for(outage);
        Bus::ALL.into_iter().for_each(|bus| world.heal(bus));
        world.run_for(ms(3_000));
        assert!(world.all_operational(), "after an outage of {} us", outage.as_us());
    }
}

/// Verifies: ECSS 8.3.2a
#[test]
fn a_master_reset_in_mid_flight_is_back_before_it_is_missed() {
    let mut world = running(MIXED, 3);
    let from = world.now();
    // SYNC takes 48 us and the heartbeat some 58 us; each comes 100 ms after its last.
    for (torn, (id, us)) in (1..).zip([(0x080, 10), (0x080, 35), (0x701, 20), (0x701, 30), (0x701, 40)]) {
        let last = since(&world, Bus::Nominal, id, Time::ZERO).pop().expect("they come all the time").start;
        world.run_until(last + ms(100) + Time::from_us(us));
        world.reset(MASTER);
        world.run_for(ms(250));
        assert_eq!(world.torn_frames(Bus::Nominal), torn, "{id:03X} was on the wire after {us} us");
        assert!(world.all_operational(), "reset at {us} us");
        assert_eq!(world.master_bus(), Bus::Nominal);
    }
    for node in world.slaves() {
        assert!(told(&world, node, from, entered(NmtState::PreOperational)).is_empty());
    }
    assert_eq!(world.frames(Bus::Redundant), []);
}

/// Verifies: ECSS 8.3.2a
#[test]
fn master_reset_on_redundant_bus_comes_back_on_default_bus() {
    let mut world = running(MIXED, 3);
    world.request(MasterRequest::SwitchBus(Bus::Redundant));
    world.run_for(ms(1_000));
    assert!(world.all_operational());
    world.reset(MASTER);
    world.run_for(ms(1_500));
    assert_eq!(world.master_bus(), Bus::Nominal);
    assert!(world.all_operational());
}

/// Verifies: ECSS 8.3.3b.1, 8.3.3b, 8.3.3d
#[test]
fn cut_healed_while_frames_are_pending_lets_nothing_stale_out() {
    for healed_after in [ms(120), ms(200), ms(777), ms(2_000)] {
        let mut world = MissionWorld::busy(MIXED, 3, |world| world);
        world.run_until(ms(2_030));
        let cut = world.now();
        cut_next_to_master(&mut world, Bus::Nominal);
        world.run_for(healed_after);
        assert_eq!(world.master_bus(), Bus::Redundant);
        let healed = world.now();
        world.heal(Bus::Nominal);
        world.run_for(ms(2_000));
        assert_eq!(
            of_master(&world, Bus::Nominal, cut + ms(1)),
            [],
            "healed after {} us",
            healed_after.as_us()
        );
        assert_eq!(switches(&world, cut), 1);
        assert!(world.all_operational());
        // No node changed back, and the slaves' heartbeats for the nominal bus expired with their period.
        let stragglers = [0x702, 0x703].map(|id| since(&world, Bus::Nominal, id, healed).len());
        assert_eq!(stragglers, [0, 0]);
    }
}

/// Given a command that is pending on a cut wire, then it never arrives later, on either bus.
///
/// Verifies: ECSS 8.3.3b
#[test]
fn a_command_pending_on_a_cut_bus_dies_with_it() {
    let mut world = running(STANDARD, 3);
    let cut = world.now();
    cut_next_to_master(&mut world, Bus::Nominal);
    world.run_for(Time::from_us(500));
    assert_eq!(world.command(TWO, Command::SetValue(0x0BAD_F00D)), Ok(()));
    world.run_for(ms(300));
    assert_eq!(world.master_bus(), Bus::Redundant);
    world.heal(Bus::Nominal);
    world.run_for(ms(1_000));
    let sent = PerBus::from_fn(|bus| since(&world, bus, 0x302, cut).len());
    assert_eq!(sent, PerBus { nominal: 0, redundant: 0 });
    assert!(!world.reactions(TWO).iter().any(|(_, reaction)| matches!(reaction, Reaction::Executed(_))));
}

/// Verifies: ECSS 6.5.2a
#[test]
fn a_slave_that_loses_power_is_lost_and_returns() {
    let mut world = running(MIXED, 3);
    let off = world.now();
    world.power_off(TWO);
    world.run_for(ms(1_000));
    assert!(master_told(&world, off).contains(&MasterEvent::SlaveLost { node: TWO }));
    let on = world.now();
    world.power_on(TWO);
    world.run_for(ms(500));
    assert!(master_told(&world, on).contains(&MasterEvent::SlaveReturned { node: TWO, bus: Bus::Nominal }));
    assert!(world.all_operational());
    assert_eq!(switches(&world, off), 0);
}

/// Given all slaves without power, then the master stays on its bus, and all slaves are found again.
#[test]
fn all_slaves_off_and_on_again() {
    let mut world = running(MIXED, 3);
    world.slaves().into_iter().for_each(|node| world.power_off(node));
    world.run_for(ms(5_000));
    world.slaves().into_iter().for_each(|node| world.power_on(node));
    world.run_for(ms(3_000));
    assert!(world.all_operational());
}

/// Verifies: ECSS 5.6.2a, 5.6.2b
#[test]
fn a_slave_driven_to_bus_off_recovers_and_goes_on() {
    let mut world = running(STANDARD, 3);
    let from = deafen_two(&mut world);
    world.run_for(ms(120));
    let states: Vec<ErrorState> = world
        .log_of(TWO)
        .into_iter()
        .filter_map(|(at, what)| match what {
            NodeEvent::Slave(SlaveEvent::Health { bus: Bus::Nominal, health }) if at >= from => {
                Some(health.state)
            }
            _ => None,
        })
        .collect();
    assert_eq!(states.iter().filter(|state| **state == ErrorState::BusOff).count(), 1, "{states:?}");
    assert_eq!(states.last(), Some(&ErrorState::Active));
    world.run_for(ms(1_000));
    assert!(world.all_operational());
    assert_eq!(world.port(TWO, Bus::Nominal).health(), Health::default());
    assert!(!since(&world, Bus::Nominal, 0x702, world.now() - ms(150)).is_empty());
    assert_eq!(switches(&world, from), 0);
}
