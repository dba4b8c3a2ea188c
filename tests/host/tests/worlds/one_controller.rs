//! Slaves with one controller and two transceivers (ECSS Figure A-6) beside others: cuts, searches, resets, frames on
//! the wire.
//!
//! Verifies: ECSS 8.2.1a.1

use can_twin::wire::time::Time;
use ecss_can::nmt::{Command as NmtCommand, Target};
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::redundancy::BusCause;
use ecss_can::runner::extend::WholeNode;
use ecss_can::types::{Bus, NmtState, NodeId};
use ecss_can_worlds::{Builder, World};
use mission::STANDARD;

use crate::support::*;

/// Minimal slave with two controllers. The next one has one.
const FIVE: NodeId = NodeId::of::<5>();
const SIX: NodeId = NodeId::of::<6>();

/// The mission with full slaves 2 and 3.
const SPACECRAFT: Profile = Profile {
    minimal: &[
        MinimalNode { node: FIVE, has_heartbeat: true },
        MinimalNode { node: SIX, has_heartbeat: false },
    ],
    selective: &[SIX],
    ..STANDARD
};

const CUT: Time = Time::from_ms(1_035);
const END: Time = Time::from_ms(4_050);
/// Ttoggle consumer times.
const TOGGLING: Time = Time::from_ms(500);

/// Returns a world whose master sends commands and requests to all slaves ten times a second.
fn flown(plan: impl FnOnce(Builder) -> Builder) -> MissionWorld {
    let mut world = MissionWorld::mixed(SPACECRAFT, 2, |world| plan(world.seed(7)));
    world.run_until(CUT);
    assert!(world.all_operational());
    cut_next_to_master(&mut world, Bus::Nominal);
    world.run_until(END);
    world
}

fn mixed() -> MissionWorld {
    flown(|world| world.one_controller(SIX))
}

/// Answers to SYNC.
fn answers(world: &World, node: NodeId, bus: Bus) -> Vec<ecss_can_worlds::world::Sent> {
    since(world, bus, 0x280 + u16::from(node.get()), Time::ZERO)
}

fn commands(world: &World, node: NodeId, bus: Bus, from: Time, to: Time) -> usize {
    between(world, bus, 0x300 + u16::from(node.get()), from, to).len()
}

/// Verifies: ECSS 8.3.3b, 8.3.3e.2, 8.3.3h
#[test]
fn minimal_one_controller_slave_follows_the_cut_by_its_search() {
    let world = mixed();
    assert!(world.all_operational());
    assert_eq!((world.master_bus(), switches(&world, Time::ZERO)), (Bus::Redundant, 1));
    let (nominal, redundant) = (answers(&world, SIX, Bus::Nominal), answers(&world, SIX, Bus::Redundant));
    assert!(nominal.len() >= 8 && redundant.len() >= 20, "{} {}", nominal.len(), redundant.len());
    assert!(nominal.iter().all(|sent| sent.end < CUT));
    // The last heartbeat came up to 100 ms before the cut, the next SYNC up to 100 ms after the switch.
    let first = redundant[0].start;
    assert!((CUT + TOGGLING - ms(100)..CUT + TOGGLING + ms(105)).contains(&first), "{} us", first.as_us());
    assert!(answers(&world, FIVE, Bus::Redundant)[0].start < CUT + ms(210));
}

/// Given a slave with one controller, then each command that reached it was executed once, on either bus.
///
/// Verifies: ECSS 9.4.1a, 9.4.2a
#[test]
fn minimal_slave_with_one_controller_executes_each_command_once() {
    let world = mixed();
    let answers = answers(&world, SIX, Bus::Redundant);
    let (first, last) = (answers[0].start, answers.last().unwrap());
    let [a, b, c, d, _] = last.frame.payload().try_into().unwrap();
    let executed = u32::from_le_bytes([a, b, c, d]) as usize;
    let nominal = commands(&world, SIX, Bus::Nominal, Time::ZERO, CUT);
    let here = commands(&world, SIX, Bus::Redundant, first, last.start);
    assert!(nominal >= 8 && here >= 20, "{nominal}, {here}");
    // It may have changed the bus up to one SYNC, and thus one command, before its first answer.
    assert!((nominal + here..=nominal + here + 1).contains(&executed), "{executed}, {nominal}, {here}");
}

/// Given the same slaves with one controller and with two, then all frames of both buses are equal.
#[test]
fn one_controller_or_two_make_no_difference_on_the_buses() {
    let (one, two) = (mixed(), flown(|world| world));
    for bus in Bus::ALL {
        assert!(one.frames(bus).len() > 100);
        assert_eq!(one.frames(bus), two.frames(bus), "{bus:?}");
    }
}

/// Given no master, when a full slave with one controller searches from either bus, then it does so as one with two.
///
/// Verifies: ECSS 8.3.2a, 8.3.3h, 8.3.2b, 8.3.3d
#[test]
fn search_of_a_slave_with_one_controller_begins_on_bdefault() {
    for bdefault in Bus::ALL {
        let profile = Profile { bdefault, ntoggle: 5, ..MIXED };
        let fly = |one: bool| {
            let mut world = MissionWorld::of(profile, 3, |world| {
                let world = world.powered_at(MASTER, ms(1_800));
                if one { world.one_controller(FOUR) } else { world }
            });
            world.run_until(ms(4_000));
            world
        };
        let (one, two) = (fly(true), fly(false));
        let heard = |bus, from, to| between(&one, bus, 0x704, from, to).len();
        assert!(heard(bdefault, ms(0), ms(499)) >= 4);
        assert_eq!(heard(bdefault.other(), ms(0), ms(499)), 0);
        assert!(heard(bdefault.other(), ms(501), ms(999)) >= 4);
        assert_eq!(heard(bdefault, ms(501), ms(999)), 0);
        assert!(one.all_operational());
        assert_eq!(one.active(FOUR), Some(bdefault));
        for bus in Bus::ALL {
            assert_eq!(one.frames(bus), two.frames(bus), "{bus:?}");
        }
    }
}

/// Given a slave with one controller on the redundant bus, when its master resets it there, then it starts again on Bdefault,
/// which is the redundant bus since it found its master there.
///
/// Verifies: ECSS 6.5.1a.4, 6.5.3a, 8.3.2a, 8.3.3l
#[test]
fn slave_with_one_controller_comes_back_after_a_reset() {
    let mut world = MissionWorld::of(MIXED, 3, |world| world.one_controller(FOUR));
    world.run_until(ms(1_000));
    cut_next_to_master(&mut world, Bus::Nominal);
    world.run_until(ms(3_000));
    assert_eq!(world.active(FOUR), Some(Bus::Redundant));
    world.nmt(NmtCommand::ResetNode, Target::Node(FOUR));
    world.run_until(ms(5_000));
    assert!(world.all_operational());
    assert_eq!(world.active(FOUR), Some(Bus::Redundant));
    assert_eq!(since(&world, Bus::Nominal, 0x704, ms(1_700)).len(), 0);
    let boot_up = |sent: &&ecss_can_worlds::world::Sent| sent.frame.payload() == [0];
    assert_eq!(since(&world, Bus::Redundant, 0x704, ms(3_000)).iter().filter(boot_up).count(), 1);
    // After a loss of power, Bdefault of its dictionary is the nominal bus again, and it searches.
    world.reset(FOUR);
    world.run_until(ms(7_000));
    assert_eq!(world.active(FOUR), Some(Bus::Redundant));
    assert_eq!(world.state(FOUR), Some(NmtState::Operational));
}

/// Given a slave whose frame is on the wire, when its application chooses the other bus, then the frame ends first. No
/// part of it is on the other bus, and after its search the slave is back on the bus of its master.
///
/// Verifies: ECSS 8.2.3a, 8.3.3e.2
#[test]
fn switch_tears_no_frame() {
    let plan = |world: Builder| world.one_controller(FOUR);
    let mut world = MissionWorld::busy(MIXED, 3, plan);
    world.run_until(ms(1_200));
    let telemetry = since(&world, Bus::Nominal, 0x384, ms(1_000)).remove(0);
    let length = telemetry.end.since(telemetry.start);
    for eighth in 0..8 {
        let mut world = MissionWorld::busy(MIXED, 3, plan);
        world.run_until(telemetry.start + Time(length.0 * eighth / 8 + 1));
        let begun = world.now();
        world.on_slave(FOUR, |slave| async move {
            assert!(slave.with(|slave, _| slave.select_bus(Bus::Redundant)).is_ok());
        });
        world.run_until(begun + ms(400));
        assert_eq!(world.active(FOUR), Some(Bus::Redundant));
        let ended = since(&world, Bus::Nominal, 0x384, ms(1_000));
        assert_eq!(ended[0], telemetry, "{eighth}");
        assert!(ended.len() == 1 && !since(&world, Bus::Redundant, 0x704, begun).is_empty());
        world.run_until(begun + ms(1_000));
        told_once(&world, FOUR, begun, changed_bus(Bus::Nominal, BusCause::Toggled));
        assert!(world.all_operational());
        for bus in Bus::ALL {
            assert_eq!((world.torn_frames(bus), world.misread_frames(bus)), (0, 0), "{bus:?} {eighth}");
        }
    }
}
