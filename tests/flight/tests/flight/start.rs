//! Power-on of the boards in every order, and a board that must stay silent.

use can_twin::bxcan::Side;
use can_twin::spacecraft::Bus;
use can_twin::wire::frame::WireFrame;
use flight::*;

fn setup(node: u8, power_on_ms: u64) -> BoardSetup {
    let setup = MASTER_AND_THREE.into_iter().find(|setup| setup.node == node).unwrap();
    BoardSetup { power_on_ms, ..setup }
}

/// Verifies: ECSS 6.10f
/// Verifies: ECSS 6.10k
#[test]
fn slave_with_wrong_strap_parity_is_silent_and_logs_it() {
    let mute = BoardSetup { parity: false, ..setup(3, 20) };
    let mut flight = Flight::new(&[setup(1, 40), mute, setup(2, 600)]);
    flight.fly_to(590);
    flight.assert_said(3, "staying silent", ms(20));
    assert_eq!(flight.frames, [], "nobody acknowledges the master");
    assert!(flight.attempts(1, Bus::Nominal).count() > 1000, "though it tries");
    flight.assert_said(1, "Nominal: error Passive", ms(40));

    flight.fly_to(1000);
    flight.assert_operational([2], Bus::Nominal);
    flight.assert_absent(3, ms(0));
    for side in [Side::Can1, Side::Can2] {
        assert_eq!(flight.emulated(3).can_stats(side).stored, [0, 0]);
    }
    flight.assert_sound();
}

/// Given a slave alone on its buses for three seconds, when a master comes, then the first frame of the slave is its boot-up
/// message.
///
/// Verifies: ECSS 6.5.3a
#[test]
fn a_lone_slave_waits_for_its_master() {
    let mut flight = Flight::new(&[setup(1, 3000), setup(3, 20)]);
    flight.fly_to(2990);
    assert_eq!(flight.frames, []);
    flight.assert_said(3, "Nominal: error Passive", ms(20));
    flight.fly_to(3300);
    let operational = flight.heartbeats(3, Bus::Nominal).into_iter().find(|(_, state)| *state == OPERATIONAL);
    let (at, _) = operational.unwrap();
    assert!(at < ms(3035), "{} us", at.as_us());
    flight.assert_operational([3], Bus::Nominal);
    let heartbeats = flight.heartbeats(3, Bus::Nominal);
    // One of the pending messages is left.
    assert_eq!(heartbeats.iter().filter(|(_, state)| *state == BOOT_UP).count(), 1, "{heartbeats:?}");
    assert!(heartbeats.iter().all(|(_, state)| *state != PRE_OPERATIONAL), "{heartbeats:?}");
    let first = flight.of(3).find(|seen| seen.bus == Bus::Nominal).unwrap();
    assert_eq!((first.id(), first.data()), (Some(0x703), &[BOOT_UP][..]));
    flight.assert_nothing_lost();
}

/// A slave alone on the bus counts up to 128 and becomes error passive. Each frame acknowledged counts down by 1 (ISO
/// 11898-1 12.1.4.2 h); after 14 heartbeats and replies a second for 12 s the counter is 0, which telemetry shows.
///
/// Verifies: ECSS 5.6.2c
#[test]
fn telemetry_tells_the_error_counters_as_they_are() {
    let mut flight = Flight::new(&[setup(1, 500), setup(3, 20)]);
    flight.fly_to(2_000);
    let [state, tec, rec, ..] = telemetry(&flight, 3, 0x0130)[..] else { panic!("6 octets") };
    assert_eq!((state, rec), (0, 0));
    assert!((90..127).contains(&tec), "some 30 frames after 128: {tec}");
    flight.fly_to(13_000);
    assert_eq!(telemetry(&flight, 3, 0x0130), [0; 6]);
    flight.assert_nothing_lost();
}

/// Verifies: ECSS 8.3.3f
#[test]
fn slaves_waiting_together_are_started_when_the_master_comes() {
    let mut flight = Flight::new(&[setup(1, 3000), setup(2, 20), setup(3, 60), setup(4, 110)]);
    flight.fly_to(2990);
    for node in [2, 3, 4] {
        let heartbeats = flight.heartbeats(node, Bus::Nominal);
        assert!(heartbeats.len() >= 11, "node {node}: {heartbeats:?}");
        assert!(heartbeats[1..].iter().all(|(_, state)| *state == PRE_OPERATIONAL), "node {node}");
    }
    flight.fly_to(3600);
    for node in [2, 3, 4] {
        let operational = flight.heartbeats(node, Bus::Nominal).into_iter().find(|(_, s)| *s == OPERATIONAL);
        // Its next heartbeat shows its state to the master.
        assert!(operational.unwrap().0 < ms(3265), "node {node}");
    }
    flight.assert_operational([2, 3, 4], Bus::Nominal);
    assert_eq!(flight.on(Bus::Redundant).count(), 0);
    flight.assert_nothing_lost();
}

/// Given slaves that search from power-on, when the master starts after their first change of the bus, then they find
/// it.
///
/// Verifies: ECSS 8.3.2b
/// Verifies: ECSS 8.3.3g
/// Verifies: ECSS 8.3.3h
/// Verifies: ECSS 8.3.3k
/// Verifies: ECSS 8.3.3f
#[test]
fn slaves_that_search_already_find_a_late_master() {
    let mut flight = Flight::new(&[setup(1, 13_000), setup(2, 20), setup(4, 60)]);
    flight.fly_to(13_600);
    for (node, since) in [(2, 20), (4, 60)] {
        let moved = flight.said(node, "Redundant (Toggled)", ms(0)).unwrap();
        // Ttoggle x consumer time after Pre-operational was entered, by its crystal: after the check of its program.
        assert!(about(ms(since + 12_508), ms(12)).contains(&moved), "node {node}: {} us", moved.as_us());
        let (first, state) = flight.heartbeats(node, Bus::Redundant)[0];
        assert!(first > moved && first < ms(12_581), "acknowledged as soon as both are there");
        assert_eq!(state, PRE_OPERATIONAL);
    }
    // Parallel access.
    flight.assert_operational([2], Bus::Nominal);
    let joined = flight.heartbeats(2, Bus::Nominal).into_iter().find(|(at, _)| *at > ms(13_000)).unwrap();
    assert!(joined.0 < ms(13_027), "{} us", joined.0.as_us());
    assert!(!flight.is_operational(4, Bus::Nominal), "selective access, on the other bus");

    flight.fly_to(25_400);
    flight.assert_operational([4], Bus::Nominal);
    let returned = flight.heartbeats(4, Bus::Nominal).into_iter().find(|(at, _)| *at > ms(13_000)).unwrap();
    assert!(about(ms(25_068), ms(12)).contains(&returned.0), "{} us", returned.0.as_us());
    assert!(!flight.of(MASTER).any(|seen| seen.bus == Bus::Redundant));
    flight.assert_nothing_lost();
}

/// Verifies: ECSS 8.3.2a, 6.5.3a
#[test]
fn a_master_that_waits_for_its_slaves_stays_on_the_default_bus() {
    let mut flight = Flight::new(&[setup(1, 20), setup(2, 5020), setup(3, 5080), setup(4, 5150)]);
    flight.fly_to(6000);
    for node in [2, 3, 4] {
        let heartbeats = flight.heartbeats(node, Bus::Nominal);
        assert_eq!((heartbeats[0].1, heartbeats[1].1), (BOOT_UP, OPERATIONAL), "node {node}");
        assert!(heartbeats[1].0 < ms(5178), "node {node}: {} us", heartbeats[1].0.as_us());
    }
    flight.assert_operational([2, 3, 4], Bus::Nominal);
    assert_eq!(flight.on(Bus::Redundant).count(), 0);
    assert_eq!(flight.attempts(1, Bus::Redundant).count(), 0);
    assert!(flight.said(1, "active bus", ms(0)).is_none(), "{}", flight.log(1));
    // Frames that were pending for 5 s: one heartbeat, no boot-up message.
    let first: Vec<&WireFrame> = flight.frames.iter().take(4).map(|seen| &seen.frame).collect();
    assert!(!first.contains(&&WireFrame::standard(0x701, &[BOOT_UP])), "{first:?}");
    flight.assert_nothing_lost();
}
