//! The minimal slave (ECSS 9).

use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::link::{Stamp, port::Filter};
use ecss_can::node::extend::{BusCommand, LinkEvent};
use ecss_can::node::minimal::{
    MinimalDevice, MinimalEvent, MinimalPdos, MinimalRpdo, MinimalSlave, MinimalTpdo, PDOS, Payload, Trigger,
};
use ecss_can::node::{FailCause, Node};
use ecss_can::pdo::CobIdOf;
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::redundancy::BusCause;
use ecss_can::types::{Bus, CobId, Duration, Instant, NodeId};

use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, node, span};

/// Counts what it is told to do. A first byte of A5h asks for telemetry: the transmit PDO by the second byte, with the rest of
/// the request as its data. Any other one is a command.
#[derive(Default)]
pub struct Probe {
    commands: Vec<(usize, Vec<u8>, Instant)>,
}

const REQUEST: u8 = 0xA5;

impl Probe {
    fn take(&mut self, number: usize, data: &[u8], at: Instant) -> Option<(usize, Payload)> {
        if let [REQUEST, tpdo, rest @ ..] = data {
            return Some((usize::from(*tpdo), Payload::from_slice(rest).unwrap()));
        }
        self.commands.push((number, data.to_vec(), at));
        None
    }
}

impl MinimalDevice for Probe {
    const PDOS: MinimalPdos = MinimalPdos::DEFAULT;

    fn on_pdo(&mut self, number: usize, data: &[u8], at: Instant) -> Option<(usize, Payload)> {
        self.take(number, data, at)
    }

    fn on_sync(&mut self, _number: usize, _at: Instant) -> Option<Payload> {
        unreachable!("no PDO follows SYNC")
    }
}

/// Two bytes at least in PDO 1; telemetry 1 and 2 with every SYNC and every third one, 3 on request, no fourth.
#[derive(Default)]
struct Cyclic(Probe);

impl MinimalDevice for Cyclic {
    const PDOS: MinimalPdos = MinimalPdos {
        receive: [Some(MinimalRpdo { cob_id: CobIdOf::fixed(0x181), least: 2 }), None, None, None],
        transmit: [
            Some(MinimalTpdo { cob_id: CobIdOf::node(0x180), trigger: Trigger::Sync(1) }),
            Some(MinimalTpdo { cob_id: CobIdOf::node(0x280), trigger: Trigger::Sync(3) }),
            Some(MinimalTpdo { cob_id: CobIdOf::node(0x380), trigger: Trigger::Request }),
            None,
        ],
    };

    fn on_pdo(&mut self, number: usize, data: &[u8], at: Instant) -> Option<(usize, Payload)> {
        self.0.take(number, data, at)
    }

    fn on_sync(&mut self, number: usize, at: Instant) -> Option<Payload> {
        Some(Payload::from_slice(&[number as u8, (at.as_micros() / 1_000) as u8]).unwrap())
    }
}

/// Telemetry 1 on request, 3 with every SYNC.
#[derive(Default)]
struct Mixed(Probe);

impl MinimalDevice for Mixed {
    const PDOS: MinimalPdos = MinimalPdos {
        receive: [Some(MinimalRpdo { cob_id: CobIdOf::node(0x200), least: 0 }), None, None, None],
        transmit: [
            Some(MinimalTpdo { cob_id: CobIdOf::node(0x180), trigger: Trigger::Request }),
            None,
            Some(MinimalTpdo { cob_id: CobIdOf::node(0x380), trigger: Trigger::Sync(1) }),
            None,
        ],
    };

    fn on_pdo(&mut self, number: usize, data: &[u8], at: Instant) -> Option<(usize, Payload)> {
        self.0.take(number, data, at)
    }

    fn on_sync(&mut self, number: usize, _at: Instant) -> Option<Payload> {
        Some(Payload::from_slice(&[number as u8]).unwrap())
    }
}

/// Listens to SYNC, which brings no telemetry.
struct Listener;

impl MinimalDevice for Listener {
    const PDOS: MinimalPdos = MinimalPdos {
        receive: [Some(MinimalRpdo { cob_id: CobIdOf::node(0x200), least: 0 }), None, None, None],
        transmit: [None; PDOS],
    };
    const LISTENS_TO_SYNC: bool = true;

    fn on_pdo(&mut self, _: usize, _: &[u8], _: Instant) -> Option<(usize, Payload)> {
        None
    }

    fn on_sync(&mut self, _: usize, _: Instant) -> Option<Payload> {
        unreachable!("no PDO follows SYNC")
    }
}

/// Commands by four PDOs, telemetry with every SYNC.
struct Full;

impl MinimalDevice for Full {
    const PDOS: MinimalPdos =
        MinimalPdos { receive: MinimalPdos::DEFAULT.receive, transmit: [sync_pdo(0x180), None, None, None] };

    fn on_pdo(&mut self, _: usize, _: &[u8], _: Instant) -> Option<(usize, Payload)> {
        None
    }

    fn on_sync(&mut self, _: usize, _: Instant) -> Option<Payload> {
        None
    }
}

/// Node 5 has no heartbeat.
const SILENT: Profile =
    Profile { minimal: &[MinimalNode { node: NodeId::of::<5>(), has_heartbeat: false }], ..Profile::DEFAULT };

/// Node 5 with the default profile.
fn minimal<D: MinimalDevice>(device: D) -> MinimalSlave<D> {
    MinimalSlave::builder(node(5), &Profile::DEFAULT, device).build()
}

/// It follows the master and sends no heartbeat, so that what it sends is telemetry.
pub fn powered<D: MinimalDevice + Default>() -> Bench<MinimalSlave<D>> {
    let mut bench = Bench::new(MinimalSlave::builder(node(5), &SILENT, D::default()).build());
    bench.clear();
    bench
}

/// Verifies: ECSS 9.4.7.1a, 9.4.9.2a, 8.2.1a.2, 8.3.2a, 8.3.3d
/// Notices: ECSS 9.4.7.1a: the slave sends a time stamp at power-on.
/// Notices: ECSS 9.4.9.2a: the slave sends a boot-up message at power-on.
/// Notices: ECSS 8.2.1a.2: a minimal slave with parallel access joins one bus.
#[test]
fn power_on_joins_both_buses_and_sends_no_boot_up_message() {
    let mut slave = Bench::new(minimal(Probe::default()));
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Join), (REDUNDANT, BusCommand::Join)]);
    assert_eq!(slave.events, [MinimalEvent::ActiveBus { bus: NOMINAL, cause: BusCause::PowerOn }]);
    slave.run_until(ms(250));
    let heartbeat = (NOMINAL, frame(0x705, &[0x05]));
    assert_eq!(slave.frames(), [heartbeat; 3]);
}

/// Any of the four, any length.
///
/// Verifies: ECSS 9.4.1c, 9.4.2a, 9.3a, 9.4.1a
/// Notices: ECSS 9.4.1c: a command without an answer brings an empty telemetry PDO.
/// Notices: ECSS 9.4.2a: the device gets 7 bytes of a command at most.
/// Notices: ECSS 9.3a: RPDO 4 is not received.
/// Notices: ECSS 9.4.1a: a command of no bytes does not reach the device.
#[test]
fn a_command_reaches_the_device_and_is_not_answered() {
    let mut slave = powered::<Probe>();
    slave.run_until(ms(10));
    let data = [0x11, 2, 3, 4, 5, 6, 7, 8];
    let mut expected = vec![];
    for (number, id) in [0x205, 0x305, 0x405, 0x505].into_iter().enumerate() {
        for length in 0..=8 {
            slave.receive(NOMINAL, id, &data[..length]);
            expected.push((number, data[..length].to_vec(), ms(10)));
        }
    }
    assert_eq!(slave.node.device().commands, expected);
    assert_eq!(slave.frames(), []);
    assert_eq!(slave.events.len(), 36);
}

/// Verifies: ECSS 9.4.2b, 9.4.3a, 9.4.3b.1, 9.4.1a, 9.4.4a
/// Notices: ECSS 9.4.2b: telemetry goes by the TPDO with the number of the RPDO.
/// Notices: ECSS 9.4.2b: the device gets only as many bytes of a request as its RPDO must have.
/// Notices: ECSS 9.4.3a: telemetry has 4 bytes at most.
/// Notices: ECSS 9.4.3b.1: telemetry goes to the bus that is not active.
/// Notices: ECSS 9.4.4a: telemetry is sent 10 ms after its request.
#[test]
fn a_request_brings_the_telemetry_that_it_names_at_once() {
    let mut slave = powered::<Probe>();
    slave.run_until(ms(10));
    for (tpdo, id) in [0x185, 0x285, 0x385, 0x485].into_iter().enumerate() {
        for rest in [&[][..], &[1, 2, 3, 4, 5, 6]] {
            slave.clear();
            let request = [&[REQUEST, tpdo as u8][..], rest].concat();
            slave.receive(NOMINAL, 0x305, &request);
            let [sent] = slave.sent[..] else { panic!("one") };
            assert_eq!((sent.at, sent.bus, sent.frame), (ms(10), NOMINAL, frame(id, rest)));
            assert_eq!(sent.expires, ms(10) + Profile::DEFAULT.event);
        }
    }
    assert_eq!(slave.node.device().commands, []);
}

/// Verifies: ECSS 9.4.3b.2, 9.4.3b, 9.4.7.1a, 6.9b, 9.4.1a
/// Notices: ECSS 9.4.3b.2: telemetry comes one SYNC later than its type says.
/// Notices: ECSS 9.4.3b: SYNC brings telemetry that is sent on request.
/// Notices: ECSS 9.4.7.1a: the slave sends a time stamp with each SYNC.
/// Notices: ECSS 6.9b: after its first telemetry a minimal slave sends with each SYNC.
#[test]
fn sync_brings_telemetry_of_its_type_only() {
    let mut slave = powered::<Cyclic>();
    let mut sent = vec![];
    for at in 1..=7 {
        slave.run_until(ms(at));
        slave.clear();
        slave.receive(NOMINAL, 0x080, &[]);
        assert_eq!(slave.events, [MinimalEvent::Sync { bus: NOMINAL }]);
        sent.extend(slave.frames().into_iter().map(|(_, frame)| (frame.id().raw(), frame.data().to_vec())));
    }
    let every: Vec<_> = sent.iter().filter(|(id, _)| *id == 0x185).map(|(_, data)| data[1]).collect();
    assert_eq!(every, [1, 2, 3, 4, 5, 6, 7]);
    let third: Vec<_> = sent.iter().filter(|(id, _)| *id == 0x285).map(|(_, data)| data.clone()).collect();
    assert_eq!(third, [[1, 3], [1, 6]]);
    assert_eq!(sent.len(), 9);
}

/// Telemetry 1 with every third SYNC, 2 with every one.
#[derive(Default)]
struct SlowFirst;

impl MinimalDevice for SlowFirst {
    const PDOS: MinimalPdos = MinimalPdos {
        receive: [None; PDOS],
        transmit: [
            Some(MinimalTpdo { cob_id: CobIdOf::node(0x180), trigger: Trigger::Sync(3) }),
            sync_pdo(0x280),
            None,
            None,
        ],
    };

    fn on_pdo(&mut self, _: usize, _: &[u8], _: Instant) -> Option<(usize, Payload)> {
        unreachable!("it receives no PDO")
    }

    fn on_sync(&mut self, _: usize, _: Instant) -> Option<Payload> {
        Some(Payload::new())
    }
}

/// Given telemetry with every third SYNC before telemetry with every one, then each SYNC brings the latter.
///
/// Verifies: ECSS 9.4.3b, 9.4.3b.2, 6.9b
/// Notices: ECSS 9.4.3b: a PDO that waits for a later SYNC ends the list for this one.
/// Notices: ECSS 9.4.3b.2: a PDO that waits for a later SYNC holds back those behind it.
#[test]
fn sync_brings_telemetry_behind_one_that_waits() {
    let mut slave = powered::<SlowFirst>();
    for at in 1..=6 {
        slave.run_until(ms(at));
        slave.receive(NOMINAL, 0x080, &[]);
    }
    assert_eq!(slave.times(NOMINAL, 0x185), [3, 6]);
    assert_eq!(slave.times(NOMINAL, 0x285), [1, 2, 3, 4, 5, 6]);
}

/// Telemetry with every 240th SYNC, the largest number that there is.
#[derive(Default)]
struct Seldom;

impl MinimalDevice for Seldom {
    const PDOS: MinimalPdos = MinimalPdos {
        receive: [None; PDOS],
        transmit: [
            Some(MinimalTpdo { cob_id: CobIdOf::node(0x180), trigger: Trigger::Sync(240) }),
            None,
            None,
            None,
        ],
    };

    fn on_pdo(&mut self, _: usize, _: &[u8], _: Instant) -> Option<(usize, Payload)> {
        unreachable!("it receives no PDO")
    }

    fn on_sync(&mut self, _: usize, _: Instant) -> Option<Payload> {
        Some(Payload::new())
    }
}

/// Given telemetry with every 240th SYNC, when 480 SYNCs come, then the 240th and the 480th bring it.
///
/// Verifies: ECSS 9.4.3b.2, 6.9b
/// Notices: ECSS 9.4.3b.2: telemetry of the 240th SYNC comes with the 128th.
#[test]
fn the_240th_sync_brings_its_telemetry() {
    let mut slave = powered::<Seldom>();
    for nth in 1..=480 {
        slave.run_until(ms(10 * nth));
        slave.receive(NOMINAL, 0x701, &[0x05]);
        slave.receive(NOMINAL, 0x080, &[]);
    }
    assert_eq!(slave.times(NOMINAL, 0x185), [2_400, 4_800]);
}

/// Four PDOs with every SYNC.
#[derive(Default)]
struct Talkative;

impl MinimalDevice for Talkative {
    const PDOS: MinimalPdos = MinimalPdos {
        receive: [None; PDOS],
        transmit: [sync_pdo(0x180), sync_pdo(0x280), sync_pdo(0x380), sync_pdo(0x480)],
    };

    fn on_pdo(&mut self, _: usize, _: &[u8], _: Instant) -> Option<(usize, Payload)> {
        unreachable!("it receives no PDO")
    }

    fn on_sync(&mut self, number: usize, _: Instant) -> Option<Payload> {
        Some(Payload::from_slice(&[number as u8; 8]).unwrap())
    }
}

const fn sync_pdo(base: u16) -> Option<MinimalTpdo> {
    Some(MinimalTpdo { cob_id: CobIdOf::node(base), trigger: Trigger::Sync(1) })
}

/// The most that one step brings: a heartbeat that is due, then a SYNC for all four PDOs. Its small queues take it.
///
/// Verifies: ECSS 8.3.3d, 9.4.1a, 9.4.3b.2
/// Notices: ECSS 9.4.3b.2: SYNC brings three PDOs at most.
#[test]
fn heartbeat_and_four_pdos_of_one_step_are_all_sent() {
    let mut slave = Bench::new(minimal(Talkative));
    slave.run_until(ms(150));
    slave.clear();
    slave.now = ms(200);
    slave.receive(NOMINAL, 0x080, &[]);
    let ids: Vec<u16> = slave.frames().into_iter().map(|(_, frame)| frame.id().raw()).collect();
    assert_eq!(ids, [0x705, 0x185, 0x285, 0x385, 0x485]);
}

/// Verifies: ECSS 9.4.1b, 9.4.3b, 9.4.3c, 9.4.6.1a
/// Notices: ECSS 9.4.1b: a heartbeat of the master makes the slave send TPDO 1.
/// Notices: ECSS 9.4.3b: a heartbeat of the master triggers a TPDO.
/// Notices: ECSS 9.4.3b: a SYNC on the bus that is not active brings telemetry.
/// Notices: ECSS 9.4.3b: the boot-up message of the master brings telemetry.
/// Notices: ECSS 9.4.6.1a: a slave that hears its master sends telemetry by itself.
#[test]
fn nothing_is_sent_unasked() {
    let mut slave = powered::<Cyclic>();
    for (at, state) in (50..10_000).step_by(50).zip([0x00, 0x7F, 0x05, 0x04].into_iter().cycle()) {
        slave.run_until(ms(at));
        slave.receive(NOMINAL, 0x701, &[state]);
    }
    // Nor by a SYNC on the bus that is not active.
    slave.receive(REDUNDANT, 0x080, &[]);
    assert_eq!(slave.frames(), []);
    // Nor is what SYNC alone brings sent on request, or a PDO that there is not.
    for tpdo in [0, 1, 3, 4, 255] {
        slave.receive(NOMINAL, 0x181, &[REQUEST, tpdo]);
    }
    assert_eq!(slave.frames(), []);
    assert_eq!(slave.node.counters()[NOMINAL].refused, 5);
}

/// Given telemetry on request and telemetry with SYNC, when 600 SYNCs and no request come, then only the latter is sent. Transmission
/// type 254 is no number of SYNCs.
///
/// Verifies: ECSS 9.4.3c, 9.4.3b.2
/// Notices: ECSS 9.4.3c: telemetry on request goes also with the 254th SYNC.
/// Notices: ECSS 9.4.3b.2: telemetry of a SYNC goes with the first SYNC only.
#[test]
fn no_number_of_syncs_brings_telemetry_on_request() {
    let mut slave = powered::<Mixed>();
    for nth in 1..=600 {
        slave.run_until(ms(10 * nth));
        slave.receive(NOMINAL, 0x701, &[0x05]);
        slave.receive(NOMINAL, 0x080, &[]);
        assert_eq!(slave.frames(), [(NOMINAL, frame(0x385, &[2]))], "SYNC {nth}");
        slave.clear();
    }
}

/// Module control, time stamps, SDO and emergencies are no part of the minimal set.
///
/// Verifies: ECSS 9.4.7.1a, 9.4.7.2a, 9.4.8a, 9.4.10c, 9.4.6.1a
/// Notices: ECSS 9.4.6.1a: a module control command starts the slave again.
/// Notices: ECSS 9.4.7.1a: 100h is handled as a SYNC.
/// Notices: ECSS 9.4.7.2a: an emergency of the master is handled as its heartbeat.
/// Notices: ECSS 9.4.10c: the slave answers node guarding with its heartbeat.
#[test]
fn services_that_are_forbidden_are_not_answered() {
    let mut slave = powered::<Probe>();
    slave.run_until(ms(10));
    for command in [1, 2, 0x80, 0x81, 0x82] {
        slave.receive(NOMINAL, 0x000, &[command, 5]);
    }
    slave.receive(NOMINAL, 0x100, &[0; 6]);
    slave.receive(NOMINAL, 0x605, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    slave.receive(NOMINAL, 0x605, &[0xFF; 8]);
    // Node guarding, whose 100Ch and 100Dh are forbidden.
    slave.receive(NOMINAL, 0x705, &[]);
    // Emergencies of the master, its own and of another slave.
    for id in [0x081, 0x085, 0x086] {
        slave.receive(NOMINAL, id, &[0x00, 0x10, 1, 0, 0, 0, 0, 0]);
    }
    assert_eq!((slave.frames(), slave.events.len()), (vec![], 0));
    assert_eq!(slave.node.counters()[NOMINAL].ignored, 12);
    // It is there as before.
    slave.receive(NOMINAL, 0x205, &[7]);
    assert_eq!(slave.node.device().commands.len(), 1);
}

/// Verifies: ECSS 9.4.8a, 9.4.7.2a, 6.3b
/// Notices: ECSS 6.3b: a minimal slave takes a SYNC with a byte.
/// Notices: ECSS 9.4.8a: a command that is one byte too short is taken.
/// Notices: ECSS 9.4.7.2a: a command that is too short brings an emergency.
#[test]
fn frame_against_the_protocol_is_dropped_and_counted() {
    let mut slave = powered::<Cyclic>();
    slave.receive(NOMINAL, 0x181, &[]);
    slave.receive(NOMINAL, 0x181, &[9]);
    slave.receive(NOMINAL, 0x080, &[1]);
    slave.receive(NOMINAL, 0x701, &[]);
    slave.receive(NOMINAL, 0x701, &[0x33]);
    assert_eq!((slave.frames(), slave.events.len()), (vec![], 0));
    assert_eq!(slave.node.counters()[NOMINAL].malformed, 5);
    assert_eq!(slave.node.device().0.commands, []);
    slave.receive(NOMINAL, 0x181, &[9, 9]);
    assert_eq!(slave.node.device().0.commands.len(), 1);
}

/// Verifies: ECSS 9.4.7.2b, 5.6.2a, 9.4.7.2a
/// Notices: ECSS 9.4.7.2b: a controller that is error passive makes a minimal slave send an EMCY.
/// Notices: ECSS 5.6.2a: a minimal slave does not recover a controller that is bus-off.
#[test]
fn no_error_makes_it_send_an_emergency() {
    let mut slave = Bench::new(minimal(Probe::default()));
    let health = |state, tec| Health { state, tec, rec: 0, last_error: LastError::Ack };
    slave.health(NOMINAL, health(ErrorState::Passive, 128));
    slave.health(NOMINAL, health(ErrorState::BusOff, 255));
    slave.link(NOMINAL, LinkEvent::Overrun { lost: 3 });
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.run_until(ms(60_000));
    assert!(slave.events.contains(&MinimalEvent::MasterMissed { bus: NOMINAL }));
    assert!(slave.controls.contains(&(NOMINAL, BusCommand::Recover)));
    assert!(!slave.sent.is_empty());
    assert!(slave.sent.iter().all(|sent| sent.frame.id().raw() == 0x705));
}

/// Given a slave with heartbeat, when two masters contradict each other, frames break the protocol, an answer names no telemetry,
/// a bus fails for good, a controller does not obey and the search is in vain, then it sends heartbeats and nothing else.
///
/// Verifies: ECSS 9.4.1b, 9.4.3c, 9.4.7.2b, 9.4.9.2a, 9.4.7.2a
/// Notices: ECSS 9.4.7.2b: a slave that goes back after a contradiction sends an EMCY.
/// Notices: ECSS 9.4.7.2a: a slave whose controller failed sends an EMCY.
#[test]
fn no_condition_that_it_tells_makes_it_send_an_emergency() {
    let mut slave = Bench::new(minimal(Cyclic::default()));
    for (at, bus) in [(50, NOMINAL), (150, NOMINAL), (170, REDUNDANT), (250, NOMINAL), (255, REDUNDANT)] {
        slave.run_until(ms(at));
        slave.receive(bus, 0x701, &[0x05]);
    }
    let bus = slave.node.active();
    for (id, data) in [(0x080, &[1][..]), (0x181, &[9]), (0x701, &[0x33]), (0x181, &[REQUEST, 9])] {
        slave.receive(bus, id, data);
    }
    slave.link(bus, LinkEvent::Stalled);
    let off = Health { state: ErrorState::BusOff, tec: 255, rec: 0, last_error: LastError::Ack };
    for at in 0..=u64::from(Profile::DEFAULT.bus_off.attempts) {
        slave.run_until(ms(260 + 10 * at));
        slave.health(bus, off);
        slave.health(bus, Health::default());
    }
    slave.run_until(ms(600_000));
    let taken_back = MinimalEvent::ActiveBus { bus: NOMINAL, cause: BusCause::TakenBack };
    for event in [taken_back, MinimalEvent::BusStalled { bus }, MinimalEvent::BusFailed { bus }] {
        assert!(slave.events.contains(&event), "{event:?}");
    }
    assert!(slave.events.iter().any(|event| matches!(event, MinimalEvent::GaveUp { .. })));
    let counters = slave.node.counters()[bus];
    assert_eq!((counters.malformed, counters.refused), (3, 1));
    assert!(slave.sent.len() > 100);
    assert!(slave.sent.iter().all(|sent| sent.frame == frame(0x705, &[0x05])));
}

/// Given three requests in one instant and three SYNCs in the next one, then each brings its telemetry at once, and none comes by
/// itself in the ten minutes after them.
///
/// Verifies: ECSS 9.4.1d, 9.4.4b, 9.4.3c, 9.4.6.1a, 9.4.9.2a
/// Notices: ECSS 9.4.1d: a second request in one instant is refused.
/// Notices: ECSS 9.4.4b: telemetry of SYNC goes also with each heartbeat of the slave.
/// Notices: ECSS 9.4.4b: the last telemetry on request goes again with each heartbeat of the slave.
/// Notices: ECSS 9.4.1d: telemetry of SYNC goes with the heartbeat when no SYNC came for a second.
/// Notices: ECSS 9.4.9.2a: the first heartbeat of a minimal slave reports Initialising.
#[test]
fn telemetry_has_neither_an_inhibit_time_nor_an_event_timer() {
    let mut slave = powered::<Cyclic>();
    slave.run_until(ms(10));
    for nth in 0..3 {
        slave.receive(NOMINAL, 0x181, &[REQUEST, 2, nth]);
    }
    slave.run_until(ms(11));
    for _ in 0..3 {
        slave.receive(NOMINAL, 0x080, &[]);
    }
    assert_eq!((slave.times(NOMINAL, 0x385), slave.times(NOMINAL, 0x185)), (vec![10; 3], vec![11; 3]));
    slave.clear();
    for second in 1..=600 {
        slave.run_until(ms(1_000 * second));
        slave.receive(NOMINAL, 0x701, &[0x05]);
    }
    assert_eq!(slave.frames(), []);
    // The heartbeat is no event timer, neither of telemetry that was asked for nor of that of SYNC.
    let mut heard = Bench::new(minimal(Cyclic::default()));
    heard.receive(NOMINAL, 0x181, &[REQUEST, 2, 7]);
    heard.receive(NOMINAL, 0x080, &[]);
    assert_eq!(heard.frames().len(), 3);
    heard.clear();
    for at in (50..60_000).step_by(100) {
        heard.run_until(ms(at));
        heard.receive(NOMINAL, 0x701, &[0x05]);
    }
    assert_eq!(heard.frames(), [(NOMINAL, frame(0x705, &[0x05])); 599]);
}

/// Given a SYNC that is handled 200 ms after its end, then its telemetry is sent as of that end, and waits for its bus as long as
/// other telemetry: no window closes before.
///
/// Verifies: ECSS 9.4.7.3d, 9.4.10c, 9.4.3b.2
/// Notices: ECSS 9.4.7.3d: a SYNC older than 100 ms is dropped.
/// Notices: ECSS 9.4.7.3d: telemetry by SYNC is dropped 10 ms after the SYNC.
/// Notices: ECSS 9.4.10c: a synchronous window of 1 ms (1007h) is in use.
#[test]
fn late_sync_brings_its_telemetry() {
    let mut slave = powered::<Cyclic>();
    slave.run_until(ms(10));
    slave.now = ms(210);
    slave.link(NOMINAL, LinkEvent::Received { frame: frame(0x080, &[]), stamp: Stamp::interrupt(ms(10)) });
    let [sent] = slave.sent[..] else { panic!("one") };
    assert_eq!((sent.bus, sent.frame), (NOMINAL, frame(0x185, &[0, 10])));
    assert_eq!(sent.expires, ms(210) + Profile::DEFAULT.event);
}

/// Consumer time 250 ms, Ttoggle 2.
///
/// Verifies: ECSS 9.4.9.1.1a, 8.3.3d, 6.5.2b, 8.2.1a.1, 8.3.3h
/// Notices: ECSS 9.4.9.1.1a: a search goes on on the bus that it left.
/// Notices: ECSS 8.3.3d: a minimal slave sends its heartbeat on Bdefault.
/// Notices: ECSS 8.3.3h: a minimal slave toggles with the first consumer time that it misses.
/// Notices: ECSS 6.5.2b: a minimal slave does not miss its master.
/// Notices: ECSS 8.2.1a.1: a minimal slave joins the other bus before it leaves its own.
#[test]
fn it_looks_for_the_masters_heartbeat_by_itself() {
    const SELECTIVE: Profile = Profile { selective: &[NodeId::of::<5>()], ..Profile::DEFAULT };
    let mut slave = Bench::new(MinimalSlave::builder(node(5), &SELECTIVE, Probe::default()).build());
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Join)]);
    slave.run_until(ms(50));
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.clear();
    slave.run_until(ms(300));
    assert_eq!(slave.events, [MinimalEvent::MasterMissed { bus: NOMINAL }]);
    slave.clear();
    slave.run_until(ms(549));
    assert!(slave.controls.is_empty());
    slave.run_until(ms(550));
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Leave), (REDUNDANT, BusCommand::Join)]);
    assert_eq!(slave.events, [MinimalEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Toggled }]);
    // Its heartbeat goes on there at once.
    assert_eq!(slave.sent.last().map(|sent| (sent.at, sent.bus)), Some((ms(550), REDUNDANT)));
    slave.clear();
    slave.receive(REDUNDANT, 0x701, &[0x05]);
    let found = MinimalEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Found };
    assert_eq!(slave.events, [found, MinimalEvent::Heartbeat { bus: REDUNDANT }]);
}

/// Given a minimal slave that never heard a master, then it changes the bus every 500 ms from power-on on.
///
/// Verifies: ECSS 8.3.2b, 8.3.3h, 9.4.9.1.1a
/// Notices: ECSS 8.3.2b: a minimal slave does not toggle before the first heartbeat of the master.
/// Notices: ECSS 8.3.3h: the first toggling time of a minimal slave is one consumer time.
#[test]
fn search_of_a_minimal_slave_begins_at_power_on() {
    let mut slave = powered::<Probe>();
    for (until, bus) in [(499, NOMINAL), (500, REDUNDANT), (999, REDUNDANT), (1_000, NOMINAL)] {
        slave.run_until(ms(until));
        assert_eq!(slave.node.active(), bus, "{until} ms");
    }
}

/// Given a minimal slave with Ntoggle 1 or 2, when it never hears the master, then it changes the bus once or twice and listens on
/// the bus that it has reached.
///
/// Verifies: ECSS 8.3.3i, 8.3.3j, 9.4.9.1.1a
/// Notices: ECSS 8.3.3i: a minimal slave that gave up begins another search.
/// Notices: ECSS 8.3.3j: a minimal slave that gave up begins another search.
#[test]
fn minimal_slave_that_gave_up_stays_and_listens() {
    for (ntoggle, end, stays) in [(1, 1_000, REDUNDANT), (2, 1_500, NOMINAL)] {
        let few = Profile { ntoggle, ..SILENT };
        let mut slave = Bench::new(MinimalSlave::builder(node(5), &few, Probe::default()).build());
        slave.run_until(ms(end));
        assert_eq!(slave.events.last(), Some(&MinimalEvent::GaveUp { bus: stays }));
        slave.clear();
        slave.run_until(ms(60_000));
        assert_eq!((slave.events.as_slice(), slave.node.active()), (&[][..], stays));
        slave.receive(stays, 0x701, &[0x05]);
        let found = MinimalEvent::ActiveBus { bus: stays, cause: BusCause::Found };
        assert_eq!(slave.events[0], found);
    }
}

/// Given a minimal slave with heartbeat whose search was in vain, then it goes on to send its heartbeat on the bus where it stays.
///
/// Verifies: ECSS 8.3.3d, 8.3.3j
/// Notices: ECSS 8.3.3d: a minimal slave that gave up its search sends no heartbeat.
#[test]
fn minimal_slave_that_gave_up_keeps_its_heartbeat() {
    for (ntoggle, stays) in [(1, REDUNDANT), (2, NOMINAL)] {
        let few = Profile { ntoggle, ..Profile::DEFAULT };
        let mut slave = Bench::new(MinimalSlave::builder(node(5), &few, Probe::default()).build());
        slave.run_until(ms(1_500));
        assert_eq!(slave.events.last(), Some(&MinimalEvent::GaveUp { bus: stays }));
        slave.clear();
        slave.run_until(ms(1_900));
        assert_eq!(slave.frames(), [(stays, frame(0x705, &[0x05])); 4]);
    }
}

/// Given a minimal slave without heartbeat that changes the bus for every reason, the last one a master that contradicts the heartbeat
/// which it followed, then it sends nothing, not even a time stamp, and obeys where its master was before.
///
/// Verifies: ECSS 9.4.7.1a, 9.4.9.1.1a, 9.4.6.1a
/// Notices: ECSS 9.4.7.1a: a minimal slave that changes the bus sends a time stamp there.
/// Notices: ECSS 9.4.9.1.1a: a minimal slave stays on a bus that the heartbeat of its master contradicts.
#[test]
fn changes_of_the_bus_send_nothing() {
    let mut slave = powered::<Probe>();
    for (at, bus) in [(550, REDUNDANT), (650, REDUNDANT), (670, NOMINAL), (750, REDUNDANT)] {
        slave.run_until(ms(at));
        slave.receive(bus, 0x701, &[0x05]);
    }
    let causes = slave.events.iter().filter_map(|event| match event {
        MinimalEvent::ActiveBus { bus, cause } => Some((*bus, *cause)),
        _ => None,
    });
    let expected = [
        (REDUNDANT, BusCause::Toggled),
        (REDUNDANT, BusCause::Found),
        (NOMINAL, BusCause::Followed),
        (REDUNDANT, BusCause::TakenBack),
    ];
    assert_eq!(causes.collect::<Vec<_>>(), expected);
    slave.receive(REDUNDANT, 0x205, &[1]);
    assert_eq!((slave.node.device().commands.len(), slave.frames()), (1, vec![]));
}

/// Given telemetry that was asked for on the nominal bus, when the slave follows the master before the telemetry is sent, then it does
/// not send it on the other bus, where the master has not requested it.
///
/// Verifies: ECSS 9.4.3c
/// Notices: ECSS 9.4.3c: telemetry that was lost with the old bus is sent again on the new one.
#[test]
fn telemetry_lost_with_its_bus_is_not_repeated() {
    let mut slave = powered::<Probe>();
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.receive(NOMINAL, 0x205, &[REQUEST, 1, 0x42]);
    let telemetry = frame(0x285, &[0x42]);
    assert_eq!(slave.frames(), [(NOMINAL, telemetry)]);
    slave.run_until(ms(20));
    slave.clear();
    slave.receive(REDUNDANT, 0x701, &[0x05]);
    slave.failed(NOMINAL, telemetry, FailCause::BusLeft);
    slave.run_until(ms(200));
    assert_eq!(slave.frames(), []);
}

/// Given a slave that lost the master, when the master boots up on the other bus before the slave changes to it, then that bus is the
/// active one.
///
/// Verifies: ECSS 8.3.3g, 8.3.3k, 9.4.9.1.1a
/// Notices: ECSS 8.3.3g: a minimal slave ignores the boot-up message of the master.
/// Notices: ECSS 8.3.3k: the search of a minimal slave ends on its selected bus alone.
#[test]
fn boot_up_message_of_the_master_ends_the_search() {
    let mut slave = powered::<Probe>();
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.run_until(ms(300));
    assert_eq!(slave.events.last(), Some(&MinimalEvent::MasterMissed { bus: NOMINAL }));
    slave.clear();
    slave.receive(REDUNDANT, 0x701, &[0x00]);
    let found = MinimalEvent::ActiveBus { bus: REDUNDANT, cause: BusCause::Found };
    assert_eq!(slave.events, [found, MinimalEvent::Heartbeat { bus: REDUNDANT }]);
    // No change of the bus is due 500 ms after the last heartbeat.
    slave.run_until(ms(549));
    assert_eq!(slave.node.active(), REDUNDANT);
}

/// Verifies: ECSS 9.4.9.1.1a, 8.2.1a.2, 8.3.3d, 5.3.3.2.3i, 8.3.3g
/// Notices: ECSS 9.4.9.1.1a: heartbeats on the bus that is not selected are ignored.
/// Notices: ECSS 8.2.1a.2: a minimal slave with parallel access does not hear the other bus.
/// Notices: ECSS 8.3.3d: a heartbeat of a minimal slave that waits on the old bus is not abandoned.
/// Notices: ECSS 5.3.3.2.3i: a minimal slave does not hear the master on the redundant bus.
/// Notices: ECSS 8.3.3g: a minimal slave obeys commands on the bus that is not active.
#[test]
fn parallel_slave_follows_at_once_and_obeys_active_bus_only() {
    let mut slave = powered::<Probe>();
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.run_until(ms(20));
    slave.receive(REDUNDANT, 0x205, &[1]);
    assert_eq!(slave.node.device().commands, []);
    slave.receive(REDUNDANT, 0x701, &[0x05]);
    assert_eq!(slave.node.active(), REDUNDANT);
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Abandon)]);
    slave.receive(NOMINAL, 0x205, &[2]);
    slave.receive(REDUNDANT, 0x205, &[3]);
    slave.receive(REDUNDANT, 0x205, &[REQUEST, 1, 0x42]);
    assert_eq!(slave.node.device().commands, [(0, vec![3], ms(20))]);
    assert_eq!(slave.frames(), [(REDUNDANT, frame(0x285, &[0x42]))]);
    assert_eq!(slave.node.counters()[NOMINAL].ignored, 1);
}

/// A master that sends no heartbeat commands it all the same.
///
/// Verifies: ECSS 8.3.2a
/// Notices: ECSS 8.3.2a: a minimal slave starts on the nominal bus.
#[test]
fn without_a_consumer_time_it_stays_where_it_is() {
    let alone = Profile { consumer: Duration::ZERO, bdefault: Bus::Redundant, ..SILENT };
    let mut slave = Bench::new(MinimalSlave::builder(node(5), &alone, Probe::default()).build());
    assert_eq!(slave.node.deadline(), None);
    slave.run_until(ms(100_000));
    slave.receive(NOMINAL, 0x701, &[0x05]);
    assert_eq!(slave.node.active(), REDUNDANT);
    slave.receive(REDUNDANT, 0x505, &[1]);
    assert_eq!(slave.node.device().commands.len(), 1);
    assert_eq!(slave.frames(), []);
}

/// Given a slave that consumes no heartbeat, when its controller is bus-off, then it recovers the controller after 10 ms.
///
/// Verifies: ECSS 5.3.3.2.3j, 5.6.2a, 5.3.3.2.3d, 5.3.3.2.3g, 5.3.3.2.3h
/// Notices: ECSS 5.3.3.2.3j: a minimal slave that consumes no heartbeat stays off the bus when the short is over.
/// Notices: ECSS 5.6.2a: a minimal slave that consumes no heartbeat does not recover from bus-off.
/// Notices: ECSS 5.3.3.2.3h: a minimal slave that consumes no heartbeat stays off the bus when the short is over.
#[test]
fn without_a_consumer_time_bus_off_is_recovered() {
    let alone = Profile { consumer: Duration::ZERO, ..SILENT };
    for bus in Bus::ALL {
        let mut slave = Bench::new(MinimalSlave::builder(node(5), &alone, Probe::default()).build());
        slave.clear();
        slave.health(bus, Health { state: ErrorState::BusOff, tec: 255, ..Health::default() });
        slave.run_until(ms(9));
        assert_eq!(slave.controls, []);
        slave.run_until(ms(10));
        assert_eq!(slave.controls, [(bus, BusCommand::Recover)]);
    }
}

/// Given a slave on one bus at a time, then its filters admit the heartbeat of the master, as with parallel access; without a consumer time
/// they do not.
///
/// Verifies: ECSS 6.5.2b
/// Notices: ECSS 6.5.2b: a minimal slave on one bus at a time has no filter for the heartbeat of the master.
#[test]
fn filters_admit_the_heartbeat_of_the_master_with_either_access() {
    let master = Filter::exact(CobId::new(0x701).unwrap());
    let alone = Profile { consumer: Duration::ZERO, ..Profile::DEFAULT };
    let builder = |profile| MinimalSlave::builder(node(5), profile, Probe::default());
    assert!(builder(&Profile::DEFAULT).build().filters().contains(&master));
    assert!(builder(&Profile::DEFAULT).on_one_bus().build().filters().contains(&master));
    assert!(!builder(&alone).build().filters().contains(&master));
}

/// Verifies: ECSS 6.3a, 9.3a, 9.4.6.1a, 9.4.7.1a, 9.4.7.2a
/// Notices: ECSS 6.3a: the filters accept SYNC only if the device listens to it as well.
/// Notices: ECSS 9.3a: the filters of a slave whose TPDOs follow SYNC do not accept it.
/// Notices: ECSS 9.3a: the filters accept SYNC only if it brings the first TPDO that is in use.
/// Notices: ECSS 9.3a: the filters do not accept SYNC for a device that only listens to it.
/// Notices: ECSS 9.3a: with four RPDOs and SYNC no filter is left for the heartbeat of the master.
/// Notices: ECSS 9.4.6.1a: the filters of a minimal slave admit NMT commands.
/// Notices: ECSS 9.4.7.1a: the filters of a minimal slave admit 100h.
/// Notices: ECSS 9.4.7.2a: the filters of a minimal slave admit emergencies.
#[test]
fn its_filters_are_exact() {
    let exact = |ids: &[u16]| -> Vec<Filter> {
        ids.iter().map(|id| Filter::exact(CobId::new(*id).unwrap())).collect()
    };
    let probe = minimal(Probe::default());
    assert_eq!(probe.filters()[..], exact(&[0x205, 0x305, 0x405, 0x505, 0x701]));
    let cyclic = minimal(Cyclic::default());
    assert_eq!(cyclic.filters()[..], exact(&[0x181, 0x080, 0x701]));
    assert!(!cyclic.is_stamped(NOMINAL, &frame(0x080, &[])));
    let mixed = minimal(Mixed::default());
    assert_eq!(mixed.filters()[..], exact(&[0x205, 0x080, 0x701]));
    let listener = minimal(Listener);
    assert_eq!(listener.filters()[..], exact(&[0x205, 0x080, 0x701]));
    let full = minimal(Full);
    assert_eq!(full.filters()[..], exact(&[0x205, 0x305, 0x405, 0x505, 0x080, 0x701]));
}

/// One that is late still answers, on the bus that is active then.
///
/// Verifies: ECSS 6.5.2b, 8.3.3e
/// Notices: ECSS 8.3.3e: a heartbeat that is handled late is missed although it came in time.
#[test]
fn a_frame_is_judged_as_of_its_end() {
    let mut slave = powered::<Probe>();
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.run_until(ms(240));
    slave.now = ms(260);
    let stamp = Stamp::interrupt(ms(245));
    slave.link(NOMINAL, LinkEvent::Received { frame: frame(0x701, &[0x05]), stamp });
    assert!(!slave.events.contains(&MinimalEvent::MasterMissed { bus: NOMINAL }), "it came in time");
    assert_eq!(slave.node.deadline(), Some(ms(245) + span(250)));
}

/// The application learns of each controller what ECSS 5.6.2 asks for, also when recovery is given up and when a controller does
/// not obey.
///
/// Verifies: ECSS 5.6.2b, 5.6.2c
/// Notices: ECSS 5.6.2b: a minimal slave tells no change of its controllers but bus-off.
/// Notices: ECSS 5.6.2c: a minimal slave keeps the counters of one controller for both.
#[test]
fn the_state_of_its_controllers_is_told() {
    let mut slave = powered::<Probe>();
    let health = |state, tec| Health { state, tec, rec: 3, last_error: LastError::Stuff };
    let passive = health(ErrorState::Passive, 130);
    slave.health(REDUNDANT, passive);
    assert_eq!(slave.events, [MinimalEvent::Health { bus: REDUNDANT, health: passive }]);
    assert_eq!((slave.node.health()[REDUNDANT], slave.node.health()[NOMINAL]), (passive, Health::default()));
    slave.clear();
    slave.link(NOMINAL, LinkEvent::Stalled);
    assert_eq!(slave.events, [MinimalEvent::BusStalled { bus: NOMINAL }]);
    slave.clear();
    let off = health(ErrorState::BusOff, 255);
    for at in 1..=u64::from(Profile::DEFAULT.bus_off.attempts) {
        slave.run_until(ms(10 * at));
        slave.health(NOMINAL, off);
        slave.health(NOMINAL, Health::default());
    }
    assert!(slave.events.iter().all(|event| matches!(event, MinimalEvent::Health { bus: NOMINAL, .. })));
    slave.clear();
    slave.health(NOMINAL, off);
    let told = MinimalEvent::Health { bus: NOMINAL, health: off };
    assert_eq!(slave.events, [told, MinimalEvent::BusFailed { bus: NOMINAL }]);
}

/// Given a slave on one of two buses whose controller is switched, then it obeys there alone. That bus is Bdefault.
///
/// Verifies: ECSS 8.2.1a.1, 8.3.2a
/// Notices: ECSS 8.2.1a.1: a minimal slave with one controller takes heartbeats of the bus that it is not on.
/// Notices: ECSS 8.3.2a: a minimal slave with one controller starts on the nominal bus.
#[test]
fn slave_with_one_controller_has_selective_access() {
    let one = |profile| MinimalSlave::builder(node(5), profile, Probe::default()).on_one_bus().build();
    let mut slave = Bench::new(one(&SILENT));
    assert_eq!(slave.controls, [(NOMINAL, BusCommand::Join)]);
    slave.receive(REDUNDANT, 0x205, &[1]);
    slave.receive(REDUNDANT, 0x701, &[5]);
    assert_eq!((slave.node.device().commands.len(), slave.node.counters()[REDUNDANT].ignored), (0, 2));
    assert_eq!(slave.node.active(), NOMINAL);
    let profile = Profile { bdefault: REDUNDANT, ..Profile::DEFAULT };
    let slave = Bench::new(one(&profile));
    assert_eq!(slave.controls, [(REDUNDANT, BusCommand::Join)]);
}

/// Given a profile that names node 5 for selective access, then a minimal slave with this Node-ID joins one bus; node 6 joins both.
///
/// Verifies: ECSS 8.2.1a, 8.2.1a.1, 8.2.1a.2
/// Notices: ECSS 8.2.1a: a minimal slave has parallel access whatever the profile says.
#[test]
fn its_access_is_that_of_the_profile() {
    const PROFILE: Profile = Profile { selective: &[NodeId::of::<5>()], ..Profile::DEFAULT };
    let joined = |raw| {
        let id = node(raw);
        Bench::new(MinimalSlave::builder(id, &PROFILE, Probe::default()).build()).controls
    };
    assert_eq!(joined(5), [(NOMINAL, BusCommand::Join)]);
    assert_eq!(joined(6), [(NOMINAL, BusCommand::Join), (REDUNDANT, BusCommand::Join)]);
}

/// The answer of a device names a telemetry that follows SYNC, one that is not in use, and one that no node has.
///
/// Verifies: ECSS 9.4.3b
/// Notices: ECSS 9.4.3b: telemetry that follows SYNC is sent on request as well.
#[test]
fn answers_that_name_a_telemetry_that_is_not_there_are_counted() {
    let mut slave = powered::<Cyclic>();
    for number in [1, 3, 9] {
        slave.receive(NOMINAL, 0x181, &[REQUEST, number]);
    }
    assert_eq!((slave.frames(), slave.node.counters()[NOMINAL].refused), (vec![], 3));
}

/// The minimal slave has no budget: whatever it receives, it sends at most one frame for a PDO and one for each of its
/// PDOs that follow SYNC.
///
/// Verifies: ECSS 5.3.3.1b, 9.4.3c, 9.4.6.1a
/// Notices: ECSS 9.4.3c: a minimal slave sends telemetry by itself.
#[test]
fn a_minimal_slave_sends_no_more_than_it_is_asked_for() {
    let mut slave = powered::<Cyclic>();
    // Nothing but time: nothing is sent.
    slave.run_until(ms(60_000));
    assert_eq!(slave.frames(), []);
    let ids = [0x000, 0x080, 0x085, 0x181, 0x205, 0x305, 0x385, 0x605, 0x701, 0x705, 0x77F];
    for (nth, id) in ids.iter().cycle().take(22_000).enumerate() {
        slave.clear();
        let data = [REQUEST, (nth / 7 % 5) as u8, 1, 2, 3, 4, 5, 6];
        slave.receive(Bus::ALL[nth / 3 % 2], *id, &data[..nth % 9]);
        let most = if *id == 0x080 { 2 } else { 1 };
        assert!(slave.frames().len() <= most, "{id:03X}: {:?}", slave.frames());
    }
}
