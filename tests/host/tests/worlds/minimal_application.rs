//! The application of the minimal slave image, on mock boards.

use ecss_can::node::minimal::MinimalSlave;
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::types::{Bus, NodeId};
use ecss_can_worlds::World;
use mission::minimal::MissionDevice;
use mission::minimal::{MinimalMission, prototype::PrototypeMission};
use mission::{LIBRECUBE, STANDARD};

use crate::indicators::IndicatorLog;
use crate::log_lines;
use crate::mission_world::minimal_application;
use crate::support::*;

const HEARD: NodeId = NodeId::of::<5>();
const SILENT: NodeId = NodeId::of::<6>();

const SPACECRAFT: Profile = Profile {
    minimal: &[
        MinimalNode { node: HEARD, has_heartbeat: true },
        MinimalNode { node: SILENT, has_heartbeat: false },
    ],
    ..STANDARD
};

/// Returns a world with node 2 and a foreign node, 100 ms after power-on.
fn alone<D: MissionDevice>(profile: &Profile, device: fn() -> D) -> (World, IndicatorLog) {
    let (indicators, profile) = (IndicatorLog::default(), *profile);
    let shown = indicators.clone();
    let mut world = World::builder()
        .board(
            TWO,
            move |_| MinimalSlave::builder(TWO, &profile, device()).build(),
            move |slave, events| minimal_application(slave, events, TWO, shown.clone()),
        )
        .build();
    world.run_until(ms(100));
    (world, indicators)
}

fn send(world: &mut World, id: u16, data: &[u8]) {
    world.inject(Bus::Nominal, standard(id, data));
    world.run_for(ms(20));
}

/// Given heartbeats, SYNCs and spacecraft times, then each of the first two toggles its LED. A device without clock shows no time.
#[test]
fn minimal_leds_toggle_with_heartbeat_and_sync() {
    let (mut world, indicators) = alone(&STANDARD, MinimalMission::new);
    for _ in 0..3 {
        send(&mut world, 0x701, &[5]);
        send(&mut world, 0x080, &[]);
        send(&mut world, 0x181, &[0, 0, 0, 1, 0, 0, 0]);
    }
    send(&mut world, 0x080, &[]);
    let shown = indicators.shown(TWO);
    assert_eq!((shown.heartbeats, shown.syncs, shown.times, shown.resets), (3, 4, 0, 0));
    assert_eq!(shown.states, [false; 0]);
}

/// Given commands for the LED, then it is set after each PDO to the state of the device; a repeat changes nothing.
///
/// Verifies: ECSS 9.4.1a, 9.4.2a
#[test]
fn minimal_led_follows_commands() {
    let (mut world, indicators) = alone(&STANDARD, MinimalMission::new);
    send(&mut world, 0x701, &[5]);
    send(&mut world, 0x302, &[1, 0, 1, 0, 0, 0, 0, 0]);
    send(&mut world, 0x302, &[1, 0, 0, 0, 0, 0, 0, 1]);
    send(&mut world, 0x302, &[1, 0, 0, 0, 0, 0, 0, 1]);
    send(&mut world, 0x302, &[1, 0, 1, 0, 0, 0, 0, 2]);
    assert_eq!(indicators.shown(TWO).states, [true, false, false, true]);
}

/// Given the device of profile `librecube`, when RPDO 1 brings the spacecraft time, then the LED for it toggles, and the command LED
/// is left alone. Another PDO sets the command LED.
#[test]
fn minimal_prototype_shows_the_spacecraft_time() {
    let (mut world, indicators) = alone(&LIBRECUBE, PrototypeMission::new);
    send(&mut world, 0x701, &[5]);
    send(&mut world, 0x181, &[0, 0, 0, 1, 0, 0, 0]);
    send(&mut world, 0x181, &[0, 0, 0, 2, 0, 0, 0]);
    assert_eq!((indicators.shown(TWO).times, indicators.shown(TWO).states), (2, vec![]));
    send(&mut world, 0x302, &[1, 0, 1, 0, 0, 0, 0, 0]);
    assert_eq!((indicators.shown(TWO).times, indicators.shown(TWO).states), (2, vec![true]));
}

/// Given a spacecraft with a minimal slave that sends a heartbeat and one that sends none, then the master commands both, and the LEDs
/// of both follow and toggle with each heartbeat of the master.
///
/// Verifies: ECSS 9.4.2a, 9.4.1a
#[test]
fn minimal_slaves_obey_with_and_without_heartbeat() {
    let mut world = MissionWorld::mixed(SPACECRAFT, 1, |world| world);
    world.run_until(ms(3_050));
    for (node, sends) in [(HEARD, true), (SILENT, false)] {
        let id = u16::from(node.get());
        let heartbeats = since(&world, Bus::Nominal, 0x700 + id, ms(0)).len();
        assert!(if sends { heartbeats >= 29 } else { heartbeats == 0 }, "{node:?}: {heartbeats}");
        let shown = world.indicators(node);
        let commands = since(&world, Bus::Nominal, 0x300 + id, ms(0));
        // Even turns switch it, starting with on. Each PDO sets it, including requests.
        let mut states = shown.states.clone();
        states.dedup();
        assert!((10..=20).contains(&states.len()) && states[0], "{node:?}: {states:?}");
        assert!(commands.len() >= 25, "{node:?}: {}", commands.len());
        let sent = since(&world, Bus::Nominal, 0x701, ms(0)).len() as u32;
        // At most the first one was sent before the slave listened.
        assert!((sent - 1..=sent).contains(&shown.heartbeats), "{node:?}: {} of {sent}", shown.heartbeats);
    }
}

/// Given a master that becomes silent, then the slave logs the loss, changes the bus and gives up.
#[test]
fn minimal_slave_logs_its_search() {
    log_lines::keep();
    let (mut world, _) = alone(&Profile { ntoggle: 4, ..STANDARD }, MinimalMission::new);
    send(&mut world, 0x701, &[5]);
    world.run_for(ms(20_000));
    let lines = log_lines::take();
    for expected in [
        "WARN master missed on Nominal",
        "INFO active bus: Redundant (Toggled)",
        "WARN search given up, listening on ",
        "INFO Nominal: error Passive, TEC 128, REC 0",
    ] {
        assert!(lines.iter().any(|line| line.starts_with(expected)), "{expected}: {lines:#?}");
    }
}
