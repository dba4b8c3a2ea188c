//! Two slave boards with one Node-ID that boot together with equal clocks.
//!
//! Profile `standard`: heartbeat 100 ms. Their heartbeats are equal and start in the same bit, so they are one frame on
//! the wire. The patterns of late heartbeats separate the boards.
//!
//! Verifies: ECSS 6.10h

use can_twin::wire::time::Time;
use ecss_can::node::SlaveEvent;
use ecss_can::types::{Bus, NmtState};
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::{MockBoard, NodeKey, World, idle, plain_master};
use mission::STANDARD;
use proptest::prelude::*;

use crate::mission_world::MissionSlave;
use crate::random::cases;
use crate::support::{THREE, ms};

/// Heartbeats until each bit of the pattern was used: 32, after the first one.
const ALL_BITS: u64 = 33;
/// The two boards.
const BOTH: [NodeKey; 2] = [NodeKey::of(THREE), NodeKey::double(THREE)];

/// Returns a world with a master and two boards with Node-ID 3 and these patterns, 3.5 s (35 heartbeats) after
/// power-on.
fn flown(patterns: Option<[u32; 2]>) -> World {
    let slave = |board: MockBoard| -> MissionSlave {
        let slave = mission::slave(board.node_id, &STANDARD, vec![0; 64].leak());
        slave.late_heartbeats(board.hardware.late_heartbeats).build()
    };
    let world = World::builder().master(|_| plain_master(&STANDARD), idle);
    let mut world = world.slave(THREE, slave, idle).board(NodeKey::double(THREE), slave, idle);
    if let Some(patterns) = patterns {
        for (key, pattern) in BOTH.into_iter().zip(patterns) {
            world = world.late_heartbeats(key, pattern);
        }
    }
    let mut world = world.build();
    world.run_until(ms(3_500));
    world
}

/// Returns the time at which a board yielded first.
fn yielded(world: &World, key: NodeKey) -> Option<Time> {
    let clash = NodeEvent::Slave(SlaveEvent::Clash { bus: Bus::Nominal, yields: true });
    world.log_of(key).into_iter().find(|(_, what)| *what == clash).map(|(at, _)| at)
}

/// Returns the number of heartbeats of a board that ended after `from`.
fn heartbeats(world: &World, key: NodeKey, from: Time) -> usize {
    let all = world.frames(Bus::Nominal).iter();
    all.filter(|sent| sent.id() == Some(0x703) && sent.key == Some(key) && sent.end > from).count()
}

/// Asserts that one board yields within 33 heartbeats and is silent, and that the other one stays Operational with a
/// period of 100 ms.
fn assert_one_yields(world: &World, what: &str) {
    let times = BOTH.map(|key| yielded(world, key));
    let (silent, other, at) = match times {
        [Some(at), None] => (BOTH[0], BOTH[1], at),
        [None, Some(at)] => (BOTH[1], BOTH[0], at),
        _ => panic!("one of them yields, not {times:?}, {what}"),
    };
    assert!(at < ms(10 + 100 * ALL_BITS), "{} us, {what}", at.as_us());
    assert_eq!(heartbeats(world, silent, at), 0, "{what}");
    assert_eq!(world.status(silent).state, NmtState::Stopped, "{what}");
    // The heartbeat that was on time, and one every 100 ms after it.
    let rest = ms(3_500).since(at).as_us() / 100_000;
    let sent = heartbeats(world, other, at) as u64;
    assert!((rest.max(1) - 1..=rest + 1).contains(&sent), "{sent} of {rest}, {what}");
    assert_eq!(world.status(other).state, NmtState::Operational, "{what}");
}

/// Given two boards with one Node-ID, equal clocks and one instant of power-on, when they fly, then one hears the
/// other, reports it and is silent. The other one continues.
#[test]
fn one_of_two_equal_boards_yields() {
    assert_one_yields(&flown(None), "patterns of their boards");
}

/// Given patterns that differ in a single bit, when that bit is used, then one of the boards yields.
#[test]
fn a_single_bit_of_the_pattern_parts_two_boards() {
    for bit in 0..32 {
        for others in [0, 0xA5C3_0F69] {
            let patterns = [others, others ^ 1 << bit];
            assert_one_yields(&flown(Some(patterns)), &format!("{patterns:08X?}"));
        }
    }
}

/// Given equal patterns, when the boards fly, then neither hears the other: only the pattern separates them.
#[test]
fn equal_patterns_part_nobody() {
    for pattern in [0, 0x1234_5678] {
        let world = flown(Some([pattern; 2]));
        assert_eq!(BOTH.map(|key| yielded(&world, key)), [None, None], "{pattern:08X}");
    }
}

proptest! {
    #![proptest_config(cases(32))]

    /// Given any two different patterns, then one of the boards yields.
    #[test]
    fn any_two_patterns_part_two_boards(first: u32, difference in 1_u32..) {
        let patterns = [first, first ^ difference];
        assert_one_yields(&flown(Some(patterns)), &format!("{patterns:08X?}"));
    }
}
