//! Minimal slaves with one controller and two transceivers (ECSS Figure A-6) fly with the shipped master, full slaves and a
//! minimal one with two controllers.
//!
//! Profile `standard`: heartbeat 100 ms, consumer time 250 ms, Ttoggle 2.

use std::sync::{Arc, LazyLock};

use can_twin::board::{BoardConfig, Fittings};
use can_twin::image::Image;
use can_twin::pin::Pin;
use can_twin::spacecraft::Bus;
use can_twin::wire::fault::Fault;
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;
use flight::minimal::minimal_image;
use flight::*;

const TWO_CONTROLLERS: u8 = 5;
/// Slaves with one controller, on a pyboard and on a NUCLEO.
const ONE_CONTROLLER: [u8; 2] = [6, 7];
/// The pin that selects the transceiver, on both boards (docs/wiring.md).
const SWITCH: Pin = Pin::new('B', 13);

static MINIMAL: LazyLock<Arc<Image>> = LazyLock::new(|| minimal_image(PYBOARD_V11, "standard"));
static PYBOARD: LazyLock<Arc<Image>> =
    LazyLock::new(|| minimal_image(PYBOARD_V11, "standard+one-controller"));
static NUCLEO: LazyLock<Arc<Image>> =
    LazyLock::new(|| minimal_image(NUCLEO_F446RE, "standard+one-controller"));

/// A master, two full slaves, a minimal one, and those with one controller.
const SETUPS: [BoardSetup; 6] = [
    MASTER_AND_THREE[0],
    MASTER_AND_THREE[1],
    MASTER_AND_THREE[2],
    BoardSetup { node: TWO_CONTROLLERS, position_m: 15.0, power_on_ms: 170, ..MASTER_AND_THREE[2] },
    BoardSetup { node: ONE_CONTROLLER[0], ..MASTER_AND_THREE[3] },
    BoardSetup {
        node: ONE_CONTROLLER[1],
        board: NUCLEO_F446RE,
        position_m: 27.0,
        ppm: 33.0,
        ..MASTER_AND_THREE[3]
    },
];

fn flight() -> Flight {
    Flight::of(&SETUPS, |setup| {
        let config = setup.with(&STANDARD);
        match setup.node {
            TWO_CONTROLLERS => BoardConfig { image: MINIMAL.clone(), ..config },
            node if ONE_CONTROLLER.contains(&node) => BoardConfig {
                image: Arc::clone(if setup.board == PYBOARD_V11 { &PYBOARD } else { &NUCLEO }),
                fittings: Fittings { transceiver_switch: Some(SWITCH), ..config.fittings },
                ..config
            },
            _ => config,
        }
    })
}

/// Time at which the nominal bus breaks next to the master.
const CUT: Time = Time::from_ms(2_013);
/// Ttoggle consumer times.
const TOGGLING: Time = Time::from_ms(500);

static FLIGHT: LazyLock<Recording> = LazyLock::new(|| flight().cut_next_to_master(CUT, 5_000));

/// Returns the time from the master's last heartbeat on the nominal bus to the first one of a slave on the redundant
/// bus.
fn search(recording: &Recording, node: u8) -> Time {
    let last = recording.heartbeats(MASTER, Bus::Nominal).last().unwrap().0;
    let (found, state) = recording.heartbeats(node, Bus::Redundant)[0];
    assert_eq!(state, OPERATIONAL);
    found.since(last)
}

/// Verifies: ECSS 8.2.1a.1
#[test]
fn slave_with_one_controller_follows_by_its_search() {
    for node in ONE_CONTROLLER {
        let taken = search(&FLIGHT, node);
        assert!(about(TOGGLING, ms(25)).contains(&taken), "node {node}: {} us", taken.as_us());
        assert!(FLIGHT.heartbeats(node, Bus::Nominal).len() >= 15);
    }
    assert!(search(&FLIGHT, TWO_CONTROLLERS) < ms(300));
    FLIGHT.assert_operational(SETUPS.map(|setup| setup.node), Bus::Redundant);
}

/// Given a slave with one controller, then it receives and sends on one bus at a time.
#[test]
fn slave_with_one_controller_is_on_one_bus_at_a_time() {
    for node in ONE_CONTROLLER {
        let left = FLIGHT.of(node).find(|seen| seen.bus == Bus::Redundant).unwrap().start;
        let reached = |bus| FLIGHT.on(bus).filter(move |seen| seen.reached.contains(&node));
        assert!(reached(Bus::Redundant).all(|seen| seen.end > left - ms(2)), "node {node}");
        let sent = FLIGHT.of(node).filter(|seen| seen.bus == Bus::Nominal);
        assert!(sent.chain(reached(Bus::Nominal)).all(|seen| seen.end < left), "node {node}");
    }
}

/// Given a slave with one controller, then each command that reached it was executed once, before and after the cut.
/// 286h has their number after each SYNC.
#[test]
fn slave_with_one_controller_executes_each_command_once() {
    for node in ONE_CONTROLLER {
        let id = u16::from(node);
        let told = FLIGHT.sent(node, Bus::Redundant, 0x280 + id).last().unwrap();
        let sync = FLIGHT.with_id(0x080).rfind(|seen| seen.end < told.start).unwrap();
        let [a, b, c, d, _] = told.data().try_into().unwrap();
        let commands = |bus| {
            let all = FLIGHT.sent(MASTER, bus, 0x300 + id);
            all.filter(|seen| seen.end < sync.end && seen.reached.contains(&node)).count()
        };
        let (before, after) = (commands(Bus::Nominal), commands(Bus::Redundant));
        assert!(before >= 10 && after >= 15, "{before}, {after}");
        assert_eq!(u32::from_le_bytes([a, b, c, d]) as usize, before + after, "node {node}");
    }
}

/// Given a change of the bus, then no frame was interrupted on either bus, and only nodes next to the cut detected
/// errors.
#[test]
fn switch_disturbs_neither_bus() {
    let is_error =
        |record: &Observation| matches!(record, Observation::Destroyed { .. } | Observation::Error { .. });
    let mut later = FLIGHT.records.iter().filter(|record| record.at > CUT + ms(300));
    assert_eq!(later.find(|record| is_error(&record.record)), None);
}

/// Given a nominal bus that is permanently dominant, so that no controller can leave it, then a slave with one
/// controller still finds its master on the redundant bus, some 50 ms later than after a cut. The driver waits that
/// long.
#[test]
fn always_dominant_bus_does_not_keep_one_controller_slave() {
    let mut flight = flight();
    flight.fly(CUT);
    let short = Fault::Short { position_m: 20.0, level: false };
    flight.twin.wire_mut(Bus::Nominal).schedule(CUT, short).unwrap();
    flight.fly_to(6_000);
    flight.assert_sound();
    for node in ONE_CONTROLLER {
        let taken = search(&flight, node);
        let is_late = (TOGGLING + ms(50)..TOGGLING + ms(80)).contains(&taken);
        assert!(is_late, "node {node}: {} us\n{}", taken.as_us(), flight.log(node));
    }
    flight.assert_operational(ONE_CONTROLLER, Bus::Redundant);
}
