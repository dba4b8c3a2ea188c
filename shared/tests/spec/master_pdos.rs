//! The master as a device of its own: PDOs, NMT state, parameter store.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::link::port::Filter;
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::extend::BusCommand;
use ecss_can::node::{Device, MasterEvent, MasterRequest, Node as _, Refusal};
use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, Mapping, Pdo, PdoObjects, PdoSet};
use ecss_can::types::{CobId, NmtState, NodeId, Scet};

use crate::bench::{Bench, Master, NOMINAL, frame, ms, node, pdos, span};
use crate::console::{self, Console};
use crate::device::fixture::Memory;
use crate::instrument::{SLOW, STANDARD};
use crate::master_device::{powered, read, write};

/// PDOs of slave 2: telecommand, and telemetry.
const TELECOMMAND: u16 = console::COMMANDS as u16;
const TELEMETRY: u16 = console::TELEMETRY as u16;

/// Slave 2 is operational, the master announced.
fn flying() -> Bench<Master> {
    let mut master = powered(&STANDARD);
    master.transmitted(NOMINAL, frame(0x701, &[5]));
    master.receive(NOMINAL, 0x702, &[5]);
    master.receive(NOMINAL, 0x582, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    master.clear();
    master
}

fn command(master: &mut Bench<Master>) -> Result<(), Refusal> {
    master.touch(|master, now| console::command(master, node(2), [7, 0, 1, 2, 0, 0, 0, 0], now))
}

/// Until then, with the heartbeats of slave 2.
fn with_slave(master: &mut Bench<Master>, until: u64) {
    while master.now < ms(until) {
        master.run_until((master.now + span(50)).min(ms(until)));
        master.receive(NOMINAL, 0x702, &[5]);
    }
}

/// COB-IDs of the frames sent since the last clear.
fn ids(master: &Bench<Master>) -> Vec<u16> {
    master.frames().iter().map(|(_, frame)| frame.id().raw()).collect()
}

fn own(command: Command) -> MasterRequest {
    MasterRequest::Nmt(NmtMessage { command, target: Target::Node(NodeId::MASTER) })
}

/// Verifies: ECSS 7.2.2a, 11.1c, 7.1.2f, 7.2.2b, 7.2.3a
/// Notices: ECSS 7.2.2a: after "reset communication" the Spacecraft Time PDO is not valid.
/// Notices: ECSS 11.1c: PDOs allow remote requests at power-on.
/// Notices: ECSS 7.1.2f: the mapping of the Spacecraft Time PDO has the coarse time first.
/// Notices: ECSS 7.2.2b: a written period of the Spacecraft Time PDO has no effect.
/// Notices: ECSS 7.2.2b: after reset communication the Spacecraft Time PDO has no period.
#[test]
fn the_spacecraft_time_is_its_first_transmit_pdo() {
    let mut master = powered(&STANDARD);
    assert_eq!(read(&mut master, 0x1800, 1), 0x4000_0181);
    assert_eq!(read(&mut master, 0x1800, 5), 1_000, "ms");
    assert_eq!(read(&mut master, 0x1A00, 0), 2);
    assert_eq!([1, 2].map(|sub| read(&mut master, 0x1A00, sub)), [0x2011_0218, 0x2011_0120]);
    // Another period, from now on: 1 ms.
    assert_eq!(write(&mut master, 0x1800, 5, 300, 2), Ok(()));
    master.transmitted(NOMINAL, frame(0x701, &[5]));
    master.clear();
    master.run_until(ms(700));
    assert_eq!(master.times(NOMINAL, 0x181), [301, 601]);
    // As at power-on.
    master.request(own(Command::ResetCommunication));
    let pdos = &master.node.objects().pdos;
    assert_eq!(pdos.tpdos[0].cob_id, 0x4000_0181);
    assert_eq!(pdos.tpdo_mappings[0].objects(), [0x2011_0218, 0x2011_0120]);
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    master.clear();
    master.run_until(ms(2_900));
    assert_eq!(master.times(NOMINAL, 0x181), [1_700, 2_700]);
}

/// While a new bus is not announced nothing may be sent there. The time waits, and is that of its departure.
///
/// Verifies: ECSS 7.2.2b, 8.3.3b
/// Notices: ECSS 7.2.2b: a Spacecraft Time PDO that waited conveys the time at which it was due.
/// Notices: ECSS 8.3.3b: the time goes out on the new bus before its announcement.
#[test]
fn a_time_that_was_due_before_the_announcement_follows_it() {
    let mut master = flying();
    master.run_until(ms(990));
    master.request(MasterRequest::SwitchBus(NOMINAL.other()));
    let heartbeat = frame(0x701, &[5]);
    master.clear();
    master.run_until(ms(1_250));
    assert!(!ids(&master).contains(&0x181));
    master.transmitted(NOMINAL.other(), heartbeat);
    let time = master.sent.iter().find(|sent| sent.frame.id().raw() == 0x181).expect("the time");
    assert_eq!(time.at, ms(1_250));
    // 1.25 s: a quarter of 2^24.
    assert_eq!(Scet::decode(time.frame.data()), Scet::new(1, 0x40_0000));
    assert_eq!(time.expires, ms(1_255));
}

/// Verifies: ECSS 6.2a, 6.10a, 6.10c
/// Notices: ECSS 6.10c: a PDO of the master keeps its COB-ID.
#[test]
fn a_slave_with_other_cob_ids_is_commanded_and_heard_there() {
    let mut master = flying();
    let (tpdo, rpdo) = (0x1800 + TELECOMMAND, 0x1400 + TELEMETRY);
    assert_eq!(read(&mut master, tpdo, 1), 0x4000_0302);
    assert_eq!(read(&mut master, rpdo, 1) & 0x7FF, 0x382);
    for (index, id) in [(tpdo, 0x4000_0342), (rpdo, 0x4000_04C2)] {
        let present = read(&mut master, index, 1);
        assert_eq!(write(&mut master, index, 1, present | 1 << 31, 4), Ok(()));
        assert_eq!(write(&mut master, index, 1, id, 4), Ok(()));
    }
    // All nodes of that function code pass now.
    let filter = Filter::function(CobId::new(0x4C2).unwrap());
    let heartbeats = Filter::function(CobId::new(0x701).unwrap());
    let admitted = |(_, command): &(_, BusCommand)| *command == BusCommand::Filter { number: 9, filter };
    assert!(master.controls.iter().any(admitted), "{:?}", master.controls);
    assert_eq!([8, 9, 17].map(|number| master.node.filter(number)), [Some(heartbeats), Some(filter), None]);
    master.clear();
    assert_eq!(command(&mut master), Ok(()));
    assert_eq!(master.frames(), [(NOMINAL, frame(0x342, &[7, 0, 1, 2, 0, 0, 0, 0]))]);
    master.receive(NOMINAL, 0x382, &[1, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(master.events, []);
    master.receive(NOMINAL, 0x4C2, &[3, 0, 9, 0, 0, 0, 0, 0]);
    let data = [3, 0, 9, 0, 0, 0, 0, 0];
    assert_eq!(pdos(&master.events), [Some((NOMINAL, TELEMETRY, data))]);
    assert_eq!(master.node.objects().application.device.telemetry[0], u64::from_le_bytes(data));
}

/// The same content twice is two frames, also to a slave that is not there. A PDO that is not valid is refused and counted.
///
/// Verifies: ECSS 6.2a
/// Notices: ECSS 6.2a: a PDO with the same content is sent once.
#[test]
fn a_pdo_goes_out_whenever_the_application_sends_it() {
    let mut master = flying();
    let send = |master: &mut Bench<Master>, number| master.touch(|master, now| master.send_pdo(number, now));
    let to_nine = TELECOMMAND as usize + 7;
    assert_eq!([send(&mut master, to_nine), send(&mut master, to_nine)], [Ok(()), Ok(())]);
    assert_eq!(ids(&master), [0x309, 0x309]);
    assert_eq!(send(&mut master, 29), Err(Refusal::NotValid));
    assert_eq!(master.node.status(master.now).counters.nominal.refused, 1);
}

/// A master sends values to a slave without objects for them. To a slave that is not Operational it sends nothing, and counts
/// that.
///
/// Verifies: ECSS 6.2a
#[test]
fn values_go_to_a_slave_by_a_pdo_of_that_slave() {
    const COMMAND: Pdo<Console, (u64,)> = Pdo::new(CobIdOf::node(0x300)).map(Console::COMMANDS.sub(1));
    let send = |master: &mut Bench<Master>| {
        master.touch(|master, now| master.send_to(node(2), COMMAND, (0x0807_0605_0403_0201,), now))
    };
    let mut master = powered(&STANDARD);
    master.clear();
    assert_eq!(send(&mut master), Err(Refusal::NotOperational));
    assert_eq!((ids(&master), master.node.status(master.now).counters.nominal.refused), (vec![], 1));
    let mut master = flying();
    assert_eq!(send(&mut master), Ok(()));
    assert_eq!(master.frames(), [(NOMINAL, frame(0x302, &[1, 2, 3, 4, 5, 6, 7, 8]))]);
}

/// Its own SYNC is the one that its synchronous PDOs follow.
///
/// Verifies: ECSS 6.9b, 6.9e, 6.2a, 6.9a
/// Notices: ECSS 6.9a: a TPDO of type 2 is sent with each SYNC.
#[test]
fn synchronous_pdos_follow_its_own_sync() {
    let mut master = flying();
    for (index, id) in [(0x1800 + TELECOMMAND, 0x4000_0302), (0x1400 + TELEMETRY, 0x4000_0382)] {
        assert_eq!(write(&mut master, index, 1, 1 << 31 | id, 4), Ok(()));
        assert_eq!(write(&mut master, index, 2, 2, 1), Ok(()));
        assert_eq!(write(&mut master, index, 1, id, 4), Ok(()));
    }
    master.clear();
    master.receive(NOMINAL, 0x382, &[3, 0, 9, 0, 0, 0, 0, 0]);
    assert_eq!((master.events.as_slice(), ids(&master)), (&[][..], vec![]));
    let telemetry = |master: &Bench<Master>| master.node.objects().application.device.telemetry[0] as u16;
    assert_eq!(telemetry(&master), 0);
    master.transmitted(NOMINAL, frame(0x080, &[]));
    let is_it = |event: &_| matches!(event, MasterEvent::Synchronised(pdo) if pdo.number() == TELEMETRY);
    assert!(master.events.iter().any(is_it));
    assert_eq!((telemetry(&master), ids(&master)), (3, vec![]));
    // Every second one.
    master.transmitted(NOMINAL, frame(0x080, &[]));
    assert_eq!(ids(&master), [0x302]);
}

/// Given a master that produces SYNC every 100 ms, when another node sends SYNC, then no synchronous PDO of the master follows it, the
/// master counts it as ignored, and its own SYNC goes on in its period.
///
/// Verifies: ECSS 6.9d, 6.9b
/// Notices: ECSS 6.9d: the master exchanges its PDOs with the SYNC of another node.
#[test]
fn a_sync_of_another_node_changes_nothing() {
    let mut master = flying();
    let command = 0x1800 + TELECOMMAND;
    for (sub, value, len) in [(1, 0xC000_0302, 4), (2, 1, 1), (1, 0x4000_0302, 4)] {
        assert_eq!(write(&mut master, command, sub, value, len), Ok(()));
    }
    let ignored = |master: &Bench<Master>| master.node.status(master.now).counters[NOMINAL].ignored;
    master.clear();
    let before = ignored(&master);
    for nth in 1..=20 {
        with_slave(&mut master, 30 * nth);
        let sent = master.sent.len();
        master.receive(NOMINAL, 0x080, &[]);
        assert_eq!(master.sent.len(), sent, "nothing follows");
    }
    assert_eq!(ignored(&master) - before, 20);
    assert_eq!(master.times(NOMINAL, 0x302), []);
    let syncs = master.times(NOMINAL, 0x080);
    assert!(syncs.len() >= 5 && syncs.windows(2).all(|pair| pair[1] - pair[0] == 100), "{syncs:?}");
    master.transmitted(NOMINAL, frame(0x080, &[]));
    assert_eq!(master.times(NOMINAL, 0x302), [600], "with its own");
}

/// Verifies: ECSS 8.3.1b
/// Notices: ECSS 8.3.1b: the last entry of 1016h names no slave.
#[test]
fn it_consumes_the_heartbeat_of_every_slave_of_its_dictionary() {
    for profile in [&STANDARD, &SLOW] {
        let mut master = powered(profile);
        assert_eq!(read(&mut master, 0x1016, 0), 8);
        let time = profile.consumer.as_millis() as u32;
        for sub in 1..=8 {
            assert_eq!(read(&mut master, 0x1016, sub), (u32::from(sub) + 1) << 16 | time);
        }
    }
}

/// Verifies: ECSS 6.5.4a, 8.3.3a, 6.9d, 6.5.1a.2, 6.5.2a
/// Notices: ECSS 8.3.3a: the master sends no heartbeat while it is stopped.
/// Notices: ECSS 6.9d: SYNC pauses while its producer is in Pre-operational.
/// Notices: ECSS 6.5.1a.2: a stopped master sends SYNC.
/// Notices: ECSS 6.5.2a: the heartbeat of a master always reports Operational.
#[test]
fn its_own_state_is_commanded_and_told_like_that_of_a_slave() {
    let mut master = flying();
    assert_eq!(read(&mut master, 0x1F82, 1), 5);
    // Pre-operational: SYNC goes on, PDOs do not.
    assert_eq!(write(&mut master, 0x1F82, 1, 127, 1), Ok(()));
    assert_eq!(read(&mut master, 0x1F82, 1), 127);
    assert_eq!(command(&mut master), Err(Refusal::NotValid));
    master.clear();
    with_slave(&mut master, 1_150);
    let beats = master.frames().iter().filter(|(_, beat)| *beat == frame(0x701, &[0x7F])).count();
    assert_eq!((beats, master.times(NOMINAL, 0x080).len()), (11, 11));
    assert_eq!(master.times(NOMINAL, 0x181), []);
    // Stopped: heartbeats alone.
    master.request(own(Command::Stop));
    master.clear();
    master.receive(NOMINAL, 0x601, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    with_slave(&mut master, 1_450);
    assert_eq!(master.frames(), [(NOMINAL, frame(0x701, &[0x04])); 3]);
    master.request(own(Command::Start));
    assert_eq!(master.events.last(), Some(&MasterEvent::State(NmtState::Operational)));
}

/// Verifies: ECSS 6.5.1a.4
/// Notices: ECSS 6.5.1a.4: a request to reset the master itself (1F82h) is ignored.
#[test]
fn a_reset_of_the_chip_is_its_applications_part() {
    let mut master = flying();
    assert_eq!(write(&mut master, 0x1F82, 1, 6, 1), Ok(()));
    assert!(master.events.contains(&MasterEvent::ResetNode));
    master.clear();
    master.run_until(ms(150));
    assert!(ids(&master).contains(&0x701), "it goes on until then");
}

/// Verifies: ECSS 6.5.1a.5, 6.5.4a, 7.2.3a, 6.5.3a, 8.3.1b
/// Notices: ECSS 6.5.1a.5: reset communication of the master keeps 1016h.
/// Notices: ECSS 7.2.3a: reset communication of the master does not restore its Spacecraft Time PDO.
/// Notices: ECSS 6.5.3a: reset communication of the master sends no boot-up message.
#[test]
fn reset_communication_brings_its_parameters_back() {
    let mut master = flying();
    assert_eq!(write(&mut master, 0x1800, 5, 300, 2), Ok(()));
    assert_eq!(write(&mut master, 0x1016, 3, 0, 4), Ok(()));
    master.clear();
    master.request(own(Command::ResetCommunication));
    assert_eq!(master.frames()[0], (NOMINAL, frame(0x701, &[0])));
    assert_eq!(master.events.last(), Some(&MasterEvent::State(NmtState::Operational)));
    assert_eq!(read(&mut master, 0x1800, 5), 1_000);
    assert_eq!(read(&mut master, 0x1016, 3), 4 << 16 | 250);
}

/// Verifies: ECSS 6.8a, 8.3.1c, 8.3.2a
/// Notices: ECSS 8.3.2a: the boot-up message of a master goes out on the nominal bus, not on the stored Bdefault.
/// Notices: ECSS 8.3.1c: a stored 1016h of a master is not followed.
#[test]
fn what_it_stores_holds_after_the_next_start() {
    let memory = Memory::default();
    let start = || {
        let store: &'static mut Memory = Box::leak(Box::new(memory.clone()));
        let mut master = Bench::new(console::master_with(&STANDARD, store));
        master.run_until(ms(1));
        master.transmitted(NOMINAL, frame(0x701, &[5]));
        master
    };
    let mut master = start();
    for (index, sub, value, len) in
        [(0x1016, 1, 2 << 16 | 400, 4), (0x1F81, 9, 0b101, 4), (0x1800, 5, 300, 2), (0x2000, 1, 1, 1)]
    {
        assert_eq!(write(&mut master, index, sub, value, len), Ok(()), "{index:04X}h");
    }
    assert_eq!(write(&mut master, 0x1010, 1, u32::from_le_bytes(*b"save"), 4), Ok(()));
    let mut master = Bench::new(console::master_with(&STANDARD, Box::leak(Box::new(memory.clone()))));
    let redundant = NOMINAL.other();
    assert_eq!(master.frames()[0], (redundant, frame(0x701, &[0])), "the stored Bdefault");
    assert_eq!(master.node.status(master.now).redundancy.consumer.as_millis(), 400);
    master.transmitted(redundant, frame(0x701, &[5]));
    master.clear();
    master.run_until(ms(650));
    assert_eq!(master.times(redundant, 0x181), [300, 600]);
    // Assigned: it is asked as soon as it is heard.
    master.clear();
    master.receive(redundant, 0x709, &[0]);
    assert!(ids(&master).contains(&0x609));
}

/// Its slaves send images in frames of their own, 6A0h, which it asks for by 6A1h. It names a heartbeat too.
#[derive(Debug, Objects)]
#[objects(device)]
struct Viewer {}

const IMAGE: CobId = CobIdOf::fixed(0x6A0).of(NodeId::MASTER);

impl Device for Viewer {
    type Pdos = PdoObjects<0, 0>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::NONE;
    const RAW_FRAMES: &'static [CobId] = &[IMAGE, CobId::heartbeat(NodeId::of::<3>())];
}

/// Verifies: ECSS 6.10b, 9.5a
/// Notices: ECSS 6.10b: the application sends raw frames with any COB-ID but that of NMT.
/// Notices: ECSS 9.5a: an application of the master may send 781h to 7FFh.
#[test]
fn frames_that_no_pdo_covers_pass_both_ways() {
    let viewer = ecss_can::node::Master::builder(&STANDARD, Viewer::default()).build();
    assert!(viewer.filters().contains(&Filter::function(IMAGE)));
    let mut master = Bench::new(viewer);
    let send = |master: &mut Bench<ecss_can::node::Master<Viewer>>, frame| {
        master.touch(|master, now| master.send_frame(frame, now))
    };
    master.clear();
    assert_eq!(send(&mut master, frame(0x6A1, &[1])), Ok(()));
    assert_eq!(master.frames(), [(NOMINAL, frame(0x6A1, &[1]))]);
    assert_eq!(master.sent[0].expires, ms(100));
    for raw in [0x000, 0x001, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x701, 0x7FF] {
        assert_eq!(send(&mut master, frame(raw, &[1, 0])), Err(Refusal::NotValid), "{raw:03X} is restricted");
    }
    let image = frame(0x6A0, &[1, 2, 3]);
    master.clear();
    master.receive(NOMINAL, 0x6A0, &[1, 2, 3]);
    master.receive(NOMINAL, 0x6A2, &[1, 2, 3]);
    master.receive(NOMINAL.other(), 0x6A0, &[1, 2, 3]);
    assert_eq!(master.events, [MasterEvent::Frame { bus: NOMINAL, frame: image }]);
}

/// Given a master that wants the heartbeats of node 3 as raw frames, when one comes, then the redundancy takes it all the same.
///
/// Verifies: ECSS 6.5.2a
/// Notices: ECSS 6.5.2a: a heartbeat that the application wants as a raw frame is not consumed.
#[test]
fn raw_frames_do_not_hide_a_heartbeat() {
    let mut master = Bench::new(ecss_can::node::Master::builder(&STANDARD, Viewer::default()).build());
    let node = NodeId::of::<3>();
    master.clear();
    master.receive(NOMINAL, 0x703, &[5]);
    let state = MasterEvent::SlaveState { node, bus: NOMINAL, state: NmtState::Operational };
    assert_eq!(master.events, [state]);
}
