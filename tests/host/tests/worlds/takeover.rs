//! A second master that becomes active beside the first one, at any phase of its heartbeats.
//!
//! Equal frames that begin together are one frame on the wire. With equal clocks two active masters could send all of theirs so, and
//! never hear each other. Here the second board becomes active alone, without a wire, and is connected when its boot-up message
//! goes out. The first board is disconnected while that message is on the wire.

use can_wire::fault::Fault;
use can_wire::time::Time;
use ecss_can::link::bit_timing::BitRate;
use ecss_can::node::MasterEvent;
use ecss_can::profile::Profile;
use ecss_can::redundancy::{Pair, Role};
use ecss_can::types::{Bus, Duration};
use host_worlds::Seat;
use host_worlds::log::Happening;
use host_worlds::world::World;
use mission::TWO_MASTERS;

use crate::support::*;

const PRIME: Seat = Seat::MASTER;
const SECOND: Seat = Seat::SECOND_MASTER;

/// The second board listens for a short time: it is to be active beside the first one.
const LISTENS: Duration = Duration::from_millis(20);
const PAIR: Pair = Pair { second_listens: LISTENS, ..Profile::PAIR };
const PROFILE: Profile = Profile { standby: Some(PAIR), ..TWO_MASTERS };

const PERIOD: Time = Time::from_ms(100);
/// The second board is on the bus so long before it becomes active. What it hears meanwhile may keep it from that.
const BEFORE: Time = Time::from_us(10);
/// Nobody knows of the other master for longer.
const BOUND: Time = Time::from_ms(200);
/// Phases that are flown in one world: its log grows.
const ONE_WORLD: usize = 250;

/// What became of the phases of a sweep.
#[derive(Debug, Default)]
struct Sweep {
    /// Both masters were active.
    both_active: usize,
    /// The longest time for which they were.
    longest: Time,
}

impl Sweep {
    /// Flies these phases, microseconds after the beginning of the first master's heartbeat, on buses of this bit rate. Its clock is
    /// so many parts per million fast.
    fn fly(kbit: u32, ppm: i32, phases_us: impl Iterator<Item = u64>) -> Sweep {
        let mut sweep = Sweep::default();
        let phases: Vec<Time> = phases_us.map(Time::from_us).collect();
        for phases in phases.chunks(ONE_WORLD) {
            let mut world = flying(kbit, ppm);
            phases.iter().for_each(|phase| sweep.fly_phase(&mut world, *phase));
        }
        sweep
    }

    fn fly_phase(&mut self, world: &mut World, phase: Time) {
        // From the sixth period on from now: the second board gets power in between.
        let heartbeats = world.frames(Bus::Nominal).iter().filter(|sent| sent.id() == Some(0x701));
        let last = heartbeats.last().expect("the first master is active").start;
        let active = last + Time(2 * PERIOD.0) + phase;
        world.power_off(SECOND);
        strike(world, SECOND, Fault::Disconnect);
        world.run_until(active - Time::from_us(LISTENS.as_micros()));
        world.power_on(SECOND);
        world.run_until(active - BEFORE);
        strike(world, SECOND, Fault::Reconnect);
        world.run_until(active);
        let begins = world.now();
        // Its boot-up message is lost to the first master.
        strike(world, PRIME, Fault::Disconnect);
        while world.now() < begins + ms(3) && !has_booted(world, begins) {
            world.run_for(Time::from_us(5));
        }
        strike(world, PRIME, Fault::Reconnect);
        world.run_for(Time(3 * PERIOD.0));
        assert_eq!(world.active_masters(), [PRIME], "at {phase:?}");
        if let Some(lasted) = both_active(world, begins - BEFORE) {
            self.both_active += 1;
            self.longest = self.longest.max(lasted);
        }
    }
}

/// The first master is active and commands two slaves.
fn flying(kbit: u32, ppm: i32) -> Craft {
    let profile = PROFILE.at(if kbit == 125 { BitRate::KBIT_125 } else { BitRate::MBIT_1 });
    let mut world =
        Craft::pair(profile, 2, |world| world.kbit(kbit).drift(PRIME, ppm).powered_at(SECOND, Time::NEVER));
    world.run_until(ms(1_500));
    assert!(world.all_operational() && world.active_masters() == [PRIME]);
    world
}

fn strike(world: &mut World, seat: Seat, fault: fn(usize) -> Fault) {
    let index = world.index(seat);
    Bus::ALL.into_iter().for_each(|bus| world.strike(bus, fault(index)));
}

/// Whether the boot-up message of the second board has ended.
fn has_booted(world: &World, from: Time) -> bool {
    let mut recent = world.frames(Bus::Nominal).iter().rev().take_while(|sent| sent.end > from);
    recent.any(|sent| sent.seat == Some(SECOND) && sent.id() == Some(0x701) && sent.frame.payload() == [0])
}

/// For how long both were active. `None`: the second one heard the first one in time, and was its standby.
fn both_active(world: &World, from: Time) -> Option<Time> {
    let log = world.log();
    let recent = log.iter().rev().take_while(|entry| entry.at >= from);
    let mut roles: Vec<(Time, Role)> = recent
        .filter_map(|entry| match entry.what {
            Happening::Master(MasterEvent::Role(change)) => Some((entry.at, change.role)),
            _ => None,
        })
        .collect();
    roles.reverse();
    match roles[..] {
        [(_, Role::Standby)] => None,
        [(active, Role::Active), (yielded, Role::Standby)] => Some(yielded.since(active)),
        _ => panic!("roles {roles:?}"),
    }
}

/// Verifies: ECSS 8.1a
#[test]
fn a_takeover_at_any_phase_leaves_both_masters_active_for_two_heartbeat_periods_at_most() {
    for kbit in [1_000, 125] {
        for ppm in [0, 1, 50] {
            let sweep = Sweep::fly(kbit, ppm, (0..100_000).step_by(997));
            assert!(sweep.both_active > 90, "{kbit} kbit/s, {ppm} ppm: {sweep:?}");
            assert!(sweep.longest <= BOUND, "{kbit} kbit/s, {ppm} ppm: {sweep:?}");
        }
    }
}
