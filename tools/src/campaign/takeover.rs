//! A second master that becomes active in addition to the first one, at any phase of its heartbeats.
//!
//! Equal frames that begin together are one frame on the wire. With equal clocks two active masters could send all
//! frames like that, and never receive each other. In this scenario the second board becomes active alone, without a
//! wire, and is connected when it sends its boot-up message. The first board is disconnected while that message is on
//! the wire.

use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;
use ecss_can::link::bit_timing::BitRate;
use ecss_can::node::MasterEvent;
use ecss_can::profile::Profile;
use ecss_can::redundancy::{Pair, Role, Strap};
use ecss_can::types::{Bus, Duration, NodeId};
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::{NodeKey, World, idle};
use mission::TWO_MASTERS;

const PRIME: NodeKey = NodeKey::MASTER;
const SECOND: NodeKey = NodeKey::SECOND_MASTER;
const SLAVES: [NodeId; 2] = [NodeId::of::<2>(), NodeId::of::<3>()];

/// Time for which the second board listens: short, so that it becomes active in addition to the first one.
const LISTENS: Duration = Duration::from_millis(20);
const PAIR: Pair = Pair { second_listens: LISTENS, ..Profile::PAIR };
const PROFILE: Profile = Profile { slaves: &[], settings: &[], standby: Some(PAIR), ..TWO_MASTERS };

/// Heartbeat period.
pub const PERIOD: Time = Time::from_ms(100);
/// Begin of the scenario: all nodes are operational.
const BEGIN: Time = Time::from_ms(1_500);
/// Time for which the second board is on the bus before it becomes active. Frames received meanwhile may prevent that.
const BEFORE: Time = Time::from_us(10);
/// Duration of a boot-up message at 125 kbit/s, including a frame before it on the bus.
const BOOT_UP: Time = Time::from_ms(3);
const GLANCE: Time = Time::from_us(5);
/// Number of phases in one world, limited because its log grows.
const ONE_WORLD: usize = 250;

/// A pair of masters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// Bit rate of both buses: 1000 or 125 kbit/s.
    pub kbit: u32,
    /// Error of the first master's clock in parts per million; positive: fast. All others are exact.
    pub ppm: i32,
}

/// Results of the phases of a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sweep {
    /// Number of phases in which both masters were active. In the others the second one heard the first one in time,
    /// and became its standby.
    pub both_active: u64,
    /// Longest time for which both were active.
    pub longest: Time,
    /// Number of phases in which the first master was not the only active one three heartbeat periods later.
    pub undecided: u64,
}

/// Runs these phases: microseconds after the beginning of a heartbeat of the first master.
pub fn sweep(case: Case, phases_us: impl Iterator<Item = u64>) -> Sweep {
    let mut sweep = Sweep::default();
    let phases: Vec<Time> = phases_us.map(Time::from_us).collect();
    for phases in phases.chunks(ONE_WORLD) {
        let mut world = world(case);
        world.run_until(BEGIN);
        for phase in phases {
            let began = take_over(&mut world, *phase);
            if world.active_masters() != [PRIME] {
                sweep.undecided += 1;
            }
            if let Some(lasted) = both_active(&world, began) {
                sweep.both_active += 1;
                sweep.longest = sweep.longest.max(lasted);
            }
        }
    }
    sweep
}

/// Makes a world of two masters without applications, and slaves that are not assigned.
fn world(Case { kbit, ppm }: Case) -> World {
    let profile =
        Box::leak(Box::new(PROFILE.at(if kbit == 125 { BitRate::KBIT_125 } else { BitRate::MBIT_1 })));
    let profile: &'static Profile = profile;
    let of_two = move |strap| mission::master(profile).one_of_two(strap).build();
    let both = World::builder().master(move |_| of_two(Strap::Prime), idle);
    let both = both.board(NodeKey::SECOND_MASTER, move |_| of_two(Strap::Second), idle);
    let all = SLAVES.into_iter().fold(both, |world, id| {
        world.slave(id, move |board| mission::slave(board.node_id, profile, Vec::new()).build(), idle)
    });
    all.kbit(kbit).drift(PRIME, ppm).powered_at(SECOND, Time::NEVER).build()
}

/// Makes the second board active at this phase. Returns when it was connected.
fn take_over(world: &mut World, phase: Time) -> Time {
    let mut heartbeats = world.frames(Bus::Nominal).iter().rev().filter(|sent| sent.key == Some(PRIME));
    let last = heartbeats.find(|sent| sent.id() == Some(0x701)).map_or(Time::ZERO, |sent| sent.start);
    let active = last + Time(2 * PERIOD.0) + phase;
    world.power_off(SECOND);
    strike(world, SECOND, Fault::Disconnect);
    world.run_until(active - Time::from_us(LISTENS.as_micros()));
    world.power_on(SECOND);
    world.run_until(active - BEFORE);
    let connected = world.now();
    strike(world, SECOND, Fault::Reconnect);
    world.run_until(active);
    strike(world, PRIME, Fault::Disconnect);
    while world.now() < active + BOOT_UP && !has_booted(world, active) {
        world.run_for(GLANCE);
    }
    strike(world, PRIME, Fault::Reconnect);
    world.run_for(Time(3 * PERIOD.0));
    connected
}

fn strike(world: &mut World, key: NodeKey, fault: fn(usize) -> Fault) {
    let index = world.index(key);
    Bus::ALL.into_iter().for_each(|bus| world.strike(bus, fault(index)));
}

/// Returns whether the boot-up message of the second board has ended.
fn has_booted(world: &World, from: Time) -> bool {
    let mut recent = world.frames(Bus::Nominal).iter().rev().take_while(|sent| sent.end > from);
    recent.any(|sent| sent.key == Some(SECOND) && sent.id() == Some(0x701) && sent.frame.payload() == [0])
}

/// Returns how long both were active since then, if they were; until now, if they still are.
fn both_active(world: &World, from: Time) -> Option<Time> {
    let log = world.log();
    let recent: Vec<(Time, Role)> = log
        .iter()
        .filter(|entry| entry.at >= from)
        .filter_map(|entry| match entry.what {
            NodeEvent::Master(MasterEvent::Role(change)) => Some((entry.at, change.role)),
            _ => None,
        })
        .collect();
    let (begin, _) = recent.iter().find(|(_, role)| *role == Role::Active)?;
    let end = recent.iter().find(|(at, role)| at > begin && *role == Role::Standby);
    Some(end.map_or(world.now(), |(at, _)| *at).since(*begin))
}
