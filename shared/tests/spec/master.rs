//! A master node on the bench, profile `standard`: heartbeat 100 ms, SYNC 100 ms, time 1 s, settling time 700 ms.

use ecss_can::emcy::{Emergency, ErrorCode, ErrorRegister};
use ecss_can::link::port::{ErrorState, Filter, Health, LastError};
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::extend::BusCommand;
use ecss_can::node::{FailCause, MasterEvent, MasterRequest, Refusal, Status};
use ecss_can::pdo::{CobIdOf, Pdo};
use ecss_can::profile::Profile;
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, CobId, NmtState, Scet};

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, frame, ms, node, pdos, span, stamp};
use crate::console;
use crate::instrument::STANDARD;

fn powered(profile: &Profile) -> Bench<Master> {
    Bench::new(console::master(profile))
}

/// The question who a node is: its device type, 1000h.
const WHO: [u8; 8] = [0x40, 0, 0x10, 0, 0, 0, 0, 0];
/// An answer.
const SOMEBODY: [u8; 8] = [0x43, 0, 0x10, 0, 0, 0, 0, 0];

/// Slaves 2 and 3 operational on the nominal bus, heard at 10 ms; everything the bus took was acknowledged, and they
/// answered who they are.
fn flying() -> Bench<Master> {
    let mut master = powered(&STANDARD);
    master.run_until(ms(10));
    master.transmitted(NOMINAL, frame(0x701, &[0x05]));
    master.receive(NOMINAL, 0x702, &[0x05]);
    master.receive(NOMINAL, 0x703, &[0x05]);
    for raw in [2, 3] {
        assert_eq!(master.frames().last(), Some(&(NOMINAL, frame(0x600 + raw, &WHO))));
        master.receive(NOMINAL, 0x580 + raw, &SOMEBODY);
    }
    master.clear();
    master
}

fn status(master: &mut Bench<Master>) -> Status {
    master.node.status(master.now)
}

fn command(master: &mut Bench<Master>, raw: u8) -> Result<(), Refusal> {
    master.touch(|master, now| console::command(master, node(raw), [1, 0, 0, 0, 0, 0, 0, 0], now))
}

/// Verifies: ECSS 8.3.2a, 8.3.3a, 6.5.3a, 8.2.1a.2, 8.2.2a
/// Notices: ECSS 6.5.3a: a master sends no boot-up message.
/// Notices: ECSS 8.2.2a: a master with parallel access joins the nominal bus alone.
#[test]
fn power_on_joins_boots_up_and_sends_heartbeat_on_default_bus() {
    let mut master = powered(&STANDARD);
    assert_eq!(master.controls, [(NOMINAL, BusCommand::Join), (REDUNDANT, BusCommand::Join)]);
    assert_eq!(master.frames(), [(NOMINAL, frame(0x701, &[0])), (NOMINAL, frame(0x701, &[0x05]))]);
    assert_eq!(master.sent[1].expires, ms(100));
    master.run_until(ms(250));
    assert_eq!(master.times(NOMINAL, 0x701), [0, 0, 100, 200]);
    assert!(master.sent.iter().all(|sent| sent.bus == NOMINAL));
}

#[test]
fn filters_are_function_codes_of_slaves_and_own_sdo_server() {
    let id = |raw| CobId::new(raw).unwrap();
    let mut expected = [0x701, 0x381, 0x181, 0x581, 0x080].map(|raw| Filter::function(id(raw))).to_vec();
    expected.push(Filter::exact(id(0x601)));
    let filters: Vec<Filter> = console::master(&STANDARD).filters().into_iter().collect();
    assert!(filters.iter().all(|filter| expected.contains(filter)), "{filters:?}");
    assert!(expected.iter().all(|filter| filters.contains(filter)), "{filters:?}");
}

/// Verifies: ECSS 6.9c, 7.2.2b, 7.2.3d, 6.9d
/// Notices: ECSS 7.2.2b: a single master board withholds its time.
/// Notices: ECSS 7.2.3d: a master whose clock was not set produces no SYNC.
/// Notices: ECSS 6.9d: a master sends SYNC once.
#[test]
fn sync_and_spacecraft_time_are_periodic_and_expire_in_a_period() {
    let mut master = powered(&STANDARD);
    master.run_until(ms(2_000));
    assert_eq!(master.times(NOMINAL, 0x080).len(), 20);
    assert_eq!(master.times(NOMINAL, 0x181), [1_000, 2_000]);
    let time = master.sent.iter().find(|sent| sent.frame.id().raw() == 0x181).unwrap();
    assert_eq!(time.frame, frame(0x181, &[0, 0, 0, 1, 0, 0, 0]));
    for sent in &master.sent {
        // A spacecraft time that waited would set clocks late by that much.
        let lifetime = if sent.frame.id().raw() == 0x181 { span(5) } else { STANDARD.heartbeat };
        assert_eq!(sent.expires, sent.at + lifetime);
    }
}

/// Verifies: ECSS 7.2.2a, 7.1.1a, 7.1.2f, 7.2.2b
/// Notices: ECSS 7.2.2a: the Spacecraft Time PDO carries an older sample of Local SCET Get.
/// Notices: ECSS 7.1.2f: the Spacecraft Time PDO has the coarse time first.
/// Notices: ECSS 7.2.2b: the Spacecraft Time PDO conveys the time since power-on.
#[test]
fn the_time_set_by_the_application_is_the_one_conveyed() {
    let mut master = powered(&STANDARD);
    master.run_until(ms(500));
    master.request(MasterRequest::SetTime(Scet::new(1_000, 0).unwrap()));
    master.run_until(ms(1_000));
    let time = master.sent.iter().find(|sent| sent.frame.id().raw() == 0x181).unwrap();
    assert_eq!(time.frame, frame(0x181, &[0, 0, 0x80, 0xE8, 0x03, 0, 0]));
}

/// Verifies: ECSS 8.3.3f
#[test]
fn slaves_that_boot_up_or_wait_are_started_unasked() {
    let mut master = powered(&STANDARD);
    master.clear();
    master.run_until(ms(20));
    master.receive(NOMINAL, 0x703, &[0x00]);
    master.receive(NOMINAL, 0x704, &[0x7F]);
    let expected = [frame(0x000, &[1, 3]), frame(0x000, &[1, 4]), frame(0x604, &WHO)];
    assert_eq!(master.frames(), expected.map(|frame| (NOMINAL, frame)));
    assert_eq!(master.sent[0].expires, ms(120));
    master.receive(NOMINAL, 0x703, &[0x05]);
    assert_eq!(
        master.events,
        [
            MasterEvent::SlaveState { node: node(3), bus: NOMINAL, state: NmtState::Initialising },
            MasterEvent::SlaveState { node: node(4), bus: NOMINAL, state: NmtState::PreOperational },
            MasterEvent::SlaveState { node: node(3), bus: NOMINAL, state: NmtState::Operational },
        ]
    );
}

/// Verifies: ECSS 6.5.1a.3, 6.5.1a.5
/// Notices: ECSS 6.5.1a.3: a slave that the application put into Pre-operational is started again.
#[test]
fn slave_stopped_by_application_is_left_alone_until_started() {
    let mut master = flying();
    let nmt = |command| MasterRequest::Nmt(NmtMessage { command, target: Target::Node(node(2)) });
    master.request(nmt(Command::EnterPreOperational));
    assert_eq!(master.frames(), [(NOMINAL, frame(0x000, &[0x80, 2]))]);
    master.clear();
    master.receive(NOMINAL, 0x702, &[0x7F]);
    assert_eq!(master.frames(), []);
    master.request(nmt(Command::ResetCommunication));
    master.receive(NOMINAL, 0x702, &[0x00]);
    assert_eq!(master.frames(), [(NOMINAL, frame(0x000, &[0x82, 2])), (NOMINAL, frame(0x000, &[1, 2]))]);
}

/// Verifies: ECSS 6.2a
#[test]
fn commands_and_requests_go_to_operational_slaves_only() {
    let mut master = flying();
    master.receive(NOMINAL, 0x703, &[0x04]);
    master.clear();
    assert_eq!(command(&mut master, 2), Ok(()));
    let request = |master: &mut Master, now| console::request(master, node(2), [1, 0, 0, 0, 0, 0, 0, 0], now);
    assert_eq!(master.touch(request), Ok(()));
    assert_eq!(
        master.frames(),
        [
            (NOMINAL, frame(0x302, &[1, 0, 0, 0, 0, 0, 0, 0])),
            (NOMINAL, frame(0x402, &[1, 0, 0, 0, 0, 0, 0, 0]))
        ]
    );
    assert_eq!(master.sent[0].expires, ms(110));
    master.clear();
    const COMMAND: Pdo<(), (u32,)> = Pdo::new(CobIdOf::node(0x300)).skip();
    for raw in [3, 9] {
        let sent = master.touch(|master, now| master.send_to(node(raw), COMMAND, (1,), now));
        assert_eq!(sent, Err(Refusal::NotOperational), "{raw}");
    }
    assert_eq!(master.frames(), []);
    assert_eq!(status(&mut master).counters.nominal.refused, 2);
}

/// Verifies: ECSS 6.2a, 8.1a
/// Notices: ECSS 8.1a: a master does not report another master on its bus.
#[test]
fn telemetry_and_local_time_of_active_bus_reach_application() {
    let mut master = flying();
    let time = Scet::new(0, 0x0080_0000).unwrap();
    master.receive(NOMINAL, 0x382, &[1, 0, 0, 0, 0, 0, 0, 0]);
    master.receive(NOMINAL, 0x182, &time.encode());
    // A SYNC that ended 50 ms after power-on is the reference of what follows.
    master.run_until(ms(50));
    master.clear();
    master.transmitted(NOMINAL, frame(0x080, &[]));
    master.receive(NOMINAL, 0x183, &time.encode());
    let reference = Scet::new(0, 838_861); // 0.05 x 2^24 = 838,860.8
    assert_eq!(master.events[0], MasterEvent::SyncSent { stamp: stamp(ms(50)) });
    assert_eq!(pdos(&master.events), [None, Some((NOMINAL, 1, [0, 0, 0x80, 0, 0, 0, 0, 0]))]);
    assert_eq!(master.node.objects().application.device.local_times[1].get(), 0x80_0000);
    assert_eq!(master.node.scet_at_sync(), reference);
    master.clear();
    master.receive(NOMINAL, 0x382, &[1]);
    master.receive(NOMINAL, 0x183, &[0; 6]);
    master.receive(NOMINAL, 0x703, &[0x33]);
    master.receive(REDUNDANT, 0x382, &[1, 0, 0, 0, 0, 0, 0, 0]);
    master.receive(NOMINAL, 0x701, &[0x05]);
    master.receive(NOMINAL, 0x082, &[0; 7]);
    assert_eq!(master.events, [MasterEvent::SecondMaster { bus: NOMINAL }]);
    let counters = status(&mut master).counters;
    assert_eq!((counters.nominal.malformed, counters.nominal.ignored, counters.redundant.ignored), (4, 1, 1));
}

/// Verifies: ECSS 6.4a
/// Notices: ECSS 6.4a: an emergency of a slave does not reach the application of the master.
#[test]
fn emergencies_of_slaves_reach_the_application() {
    let mut master = flying();
    master.receive(NOMINAL, 0x083, &[0x30, 0x81, 0x11, 1, 2, 3, 4, 5]);
    let emergency = Emergency {
        code: ErrorCode::HEARTBEAT,
        register: ErrorRegister::from_bits(0x11),
        info: [1, 2, 3, 4, 5],
    };
    assert_eq!(master.events, [MasterEvent::Emergency { node: node(3), bus: NOMINAL, emergency }]);
}

/// Given 1028h, whose entries are the COB-IDs of the pre-defined connection set, when the one of node 3 is set invalid, then its
/// emergencies are none of the master's any more, those of others are, until it is valid again. No other COB-ID fits.
///
/// Verifies: ECSS 6.4a, 6.8a
/// Notices: ECSS 6.8a: 1028h takes a COB-ID other than that of the node.
#[test]
fn emergencies_are_consumed_by_1028h() {
    const RANGE: [u8; 4] = [0x30, 0x00, 0x09, 0x06];
    let mut master = flying();
    for (sub, expected) in [(1, 0x8000_0081), (3, 0x83), (127, 0xFF)] {
        assert_eq!(crate::master_device::read(&mut master, 0x1028, sub), expected, "sub-index {sub}");
    }
    let mut write = |sub: u8, value: u32| {
        let [a, b, c, d] = value.to_le_bytes();
        master.clear();
        master.receive(NOMINAL, 0x601, &[0x23, 0x28, 0x10, sub, a, b, c, d]);
        let [(_, answer)] = master.frames()[..] else { panic!("{:?}", master.frames()) };
        master.clear();
        master.receive(NOMINAL, 0x083, &[0x30, 0x81, 0x11, 1, 2, 3, 4, 5]);
        let is_heard = master.events.iter().any(|event| matches!(event, MasterEvent::Emergency { .. }));
        (answer.data()[0] == 0x60, answer.data()[4..].to_vec(), is_heard)
    };
    assert_eq!(write(3, 0x8000_0083), (true, vec![0; 4], false));
    assert_eq!(write(2, 0x8000_0000), (true, vec![0; 4], false));
    assert_eq!(write(3, 0x0000_0083), (true, vec![0; 4], true));
    // Of another node, extended, reserved, and the master's own.
    for (sub, value) in [(3, 0x84), (3, 0x2000_0083), (3, 0x4000_0083), (1, 0x81)] {
        assert_eq!(write(sub, value), (false, RANGE.to_vec(), true), "{value:08X}h");
    }
}

/// Verifies: ECSS 8.1b, 8.3.3b, 8.3.3b.1, 8.3.3b.2
/// Notices: ECSS 8.3.3b.1: what waits for the old bus, such as a heartbeat, is not abandoned.
/// Notices: ECSS 8.1b: NMT commands go by the nominal bus, whichever is active.
#[test]
fn switch_abandons_old_bus_and_announces_new_one_before_use() {
    let mut master = flying();
    master.run_until(ms(95));
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    assert_eq!(master.controls, [(NOMINAL, BusCommand::Abandon)]);
    assert_eq!(
        master.events,
        [MasterEvent::BusSwitched { from: NOMINAL, to: REDUNDANT, cause: SwitchCause::Commanded }]
    );
    let heartbeat = frame(0x701, &[0x05]);
    assert_eq!(master.frames(), [(REDUNDANT, heartbeat)]);
    // Commands, NMT and SYNC wait for the heartbeat.
    master.clear();
    assert_eq!(command(&mut master, 2), Ok(()));
    master.receive(REDUNDANT, 0x704, &[0x7F]);
    master.run_until(ms(105));
    assert_eq!(master.frames(), []);
    master.transmitted(REDUNDANT, heartbeat);
    let command = frame(0x302, &[1, 0, 0, 0, 0, 0, 0, 0]);
    let expected = [command, frame(0x000, &[1, 4]), frame(0x604, &WHO), frame(0x080, &[])];
    assert_eq!(master.frames(), expected.map(|frame| (REDUNDANT, frame)));
    // With the lifetime they were given when they were asked for.
    assert_eq!(master.sent[0].expires, ms(195));
    // From now on at once.
    master.clear();
    master.request(MasterRequest::Nmt(NmtMessage { command: Command::Stop, target: Target::Node(node(2)) }));
    assert_eq!(master.frames(), [(REDUNDANT, frame(0x000, &[2, 2]))]);
}

/// Given a master whose controller is bus-off, when it leaves this bus, then it abandons what waits there. Else that would be sent after
/// the recovery.
///
/// Verifies: ECSS 8.3.3b.1, 8.3.3b, 8.3.3b.2
/// Notices: ECSS 8.3.3b.1: a heartbeat that waits on a bus in bus-off is not abandoned.
#[test]
fn a_bus_that_is_left_in_bus_off_is_abandoned() {
    let mut master = flying();
    master.health(NOMINAL, Health { state: ErrorState::BusOff, tec: 255, ..Health::default() });
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    assert_eq!(master.controls, [(NOMINAL, BusCommand::Abandon)]);
    assert_eq!(master.frames(), [(REDUNDANT, frame(0x701, &[0x05]))]);
}

/// Given a master that is stopped or Pre-operational itself, when its application commands slaves, or a slave comes back in
/// Pre-operational, then the master sends the commands: it stays the NMT master.
///
/// Verifies: ECSS 8.1b, 8.3.3f
/// Notices: ECSS 8.1b: a master that is stopped sends no NMT commands of its application.
/// Notices: ECSS 8.3.3f: a master that is not Operational starts no slave that changed the bus.
#[test]
fn master_commands_slaves_in_each_of_its_states() {
    for own in [Command::Stop, Command::EnterPreOperational] {
        let mut master = flying();
        master.request(MasterRequest::Nmt(NmtMessage { command: own, target: Target::Node(node(1)) }));
        master.clear();
        let stop = NmtMessage { command: Command::Stop, target: Target::Node(node(3)) };
        master.request(MasterRequest::Nmt(stop));
        master.receive(NOMINAL, 0x702, &[0x7F]);
        let commands = master.frames().into_iter().filter(|(_, sent)| sent.id() == CobId::NMT);
        let expected = [(NOMINAL, frame(0, &[0x02, 3])), (NOMINAL, frame(0, &[0x01, 2]))];
        assert_eq!(commands.collect::<Vec<_>>(), expected, "{own:?}");
    }
}

/// Given a master that is stopped or in Pre-operational, when its application chooses the other bus, then its heartbeat stops here and
/// starts there.
///
/// Verifies: ECSS 8.3.3b, 8.3.3b.1, 8.3.3b.2
/// Notices: ECSS 8.3.3b: a master that is stopped does not change the bus.
#[test]
fn master_changes_the_bus_in_each_of_its_states() {
    for (own, state) in [(Command::Stop, 0x04), (Command::EnterPreOperational, 0x7F)] {
        let mut master = flying();
        master.request(MasterRequest::Nmt(NmtMessage { command: own, target: Target::Node(node(1)) }));
        master.clear();
        master.request(MasterRequest::SwitchBus(REDUNDANT));
        assert_eq!(master.controls, [(NOMINAL, BusCommand::Abandon)]);
        master.transmitted(REDUNDANT, frame(0x701, &[state]));
        master.run_until(ms(250));
        let heartbeats = master.frames().into_iter().filter(|(_, sent)| sent.id().raw() == 0x701);
        assert_eq!(heartbeats.collect::<Vec<_>>(), [(REDUNDANT, frame(0x701, &[state])); 3], "{own:?}");
    }
}

/// Given slaves with the lowest, middle and the highest Node-ID, when they wait in Pre-operational or are stopped after a change of the
/// bus, then the master starts each.
///
/// Verifies: ECSS 8.3.3f
/// Notices: ECSS 8.3.3f: node 126 is not started.
#[test]
fn slaves_of_every_node_id_are_started() {
    for raw in [2, 63, 64, 126] {
        for state in [0x7F, 0x04] {
            let mut master = flying();
            master.request(MasterRequest::SwitchBus(REDUNDANT));
            master.transmitted(REDUNDANT, frame(0x701, &[0x05]));
            master.receive(REDUNDANT, 0x700 + u16::from(raw), &[state]);
            assert!(
                master.frames().contains(&(REDUNDANT, frame(0x000, &[0x01, raw]))),
                "{raw}, {state:02X}h"
            );
        }
    }
}

/// Given a master that works on the redundant bus, then it hears a slave on the nominal one. When it goes back, then nothing that waits
/// on the redundant bus may go out there.
///
/// Verifies: ECSS 8.2.1a.2, 8.2.2a, 8.3.3b, 8.3.3b.1, 8.3.3b.2
/// Notices: ECSS 8.2.2a: a master on the redundant bus hears nothing on the nominal one.
/// Notices: ECSS 8.3.3b: the nominal bus is abandoned, whichever is left.
/// Notices: ECSS 8.3.3b.1: the nominal bus is abandoned, whichever is left.
/// Notices: ECSS 8.2.1a.2: a master with parallel access listens on the active bus alone.
#[test]
fn master_on_the_redundant_bus_hears_both_and_abandons_it() {
    let mut master = flying();
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    let heartbeat = frame(0x701, &[0x05]);
    master.transmitted(REDUNDANT, heartbeat);
    master.clear();
    master.receive(NOMINAL, 0x702, &[0x7F]);
    let heard = MasterEvent::SlaveState { node: node(2), bus: NOMINAL, state: NmtState::PreOperational };
    assert_eq!(master.events, [heard]);
    master.clear();
    master.request(MasterRequest::SwitchBus(NOMINAL));
    assert_eq!(master.controls, [(REDUNDANT, BusCommand::Abandon)]);
    assert_eq!(master.frames(), [(NOMINAL, heartbeat)]);
}

/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.3b: a command that waits for a bus is kept when that bus is left.
#[test]
fn what_waits_for_the_announcement_dies_of_age_or_with_the_bus() {
    let mut master = flying();
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    assert_eq!(command(&mut master, 2), Ok(()));
    master.run_until(ms(50));
    assert_eq!(command(&mut master, 3), Ok(()));
    master.clear();
    // The heartbeat could not go out within its period: the first command is too old, the second is not.
    master.run_until(ms(110));
    master.failed(REDUNDANT, frame(0x701, &[0x05]), FailCause::Expired);
    assert!(master.frames().contains(&(REDUNDANT, frame(0x303, &[1, 0, 0, 0, 0, 0, 0, 0]))));
    assert!(!master.frames().contains(&(REDUNDANT, frame(0x302, &[1, 0, 0, 0, 0, 0, 0, 0]))));
    assert_eq!(status(&mut master).counters.redundant.expired, 2);
    assert!(master.events.contains(&not_sent(REDUNDANT, 0x302)));
    // Back before anything was announced: what waited is gone.
    master.request(MasterRequest::SwitchBus(NOMINAL));
    assert_eq!(command(&mut master, 2), Ok(()));
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    assert_eq!(status(&mut master).counters.nominal.bus_left, 1);
    assert!(master.events.contains(&not_sent(NOMINAL, 0x302)));
}

/// The command of [`command`] to the node of this COB-ID.
fn not_sent(bus: Bus, id: u16) -> MasterEvent {
    MasterEvent::NotSent { bus, id: CobId::new(id).unwrap(), data: [1, 0, 0, 0, 0, 0, 0, 0] }
}

/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.3b: a heartbeat that was abandoned announces the bus.
#[test]
fn an_abandoned_heartbeat_of_an_earlier_stay_announces_nothing() {
    let mut master = flying();
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    master.request(MasterRequest::SwitchBus(NOMINAL));
    master.clear();
    master.failed(NOMINAL, frame(0x701, &[0x05]), FailCause::BusLeft);
    assert_eq!(command(&mut master, 2), Ok(()));
    assert_eq!(master.frames(), []);
}

#[test]
fn no_more_than_a_few_frames_wait_for_the_announcement() {
    let mut master = flying();
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    master.clear();
    for _ in 0..16 {
        assert_eq!(command(&mut master, 2), Ok(()));
    }
    assert_eq!(command(&mut master, 2), Err(Refusal::Busy));
    assert_eq!(status(&mut master).counters.redundant.refused, 1);
}

/// Given a slave that is lost, when it is heard again in the state that it had, then the master reports its return and its state.
///
/// Verifies: ECSS 5.3.3.2.3k.2, 6.5.2a
/// Notices: ECSS 5.3.3.2.3k.2: a slave that returns in the state that it had stays missing for the master.
/// Notices: ECSS 6.5.2a: a slave that is silent for its consumer time is not lost.
#[test]
fn a_lost_slave_is_refused_and_returns() {
    let mut master = flying();
    for at in [100, 200] {
        master.run_until(ms(at));
        for id in [0x703, 0x704, 0x705] {
            master.receive(NOMINAL, id, &[0x05]);
        }
        for raw in [4, 5] {
            master.receive(NOMINAL, 0x580 + raw, &SOMEBODY);
        }
    }
    master.clear();
    master.run_until(ms(260));
    assert_eq!(master.events, [MasterEvent::SlaveLost { node: node(2) }]);
    master.clear();
    assert_eq!(command(&mut master, 2), Err(Refusal::NotOperational));
    master.clear();
    master.receive(NOMINAL, 0x702, &[0x05]);
    // Its state too, though it is the old one: the application has forgotten it.
    let (slave, bus, state) = (node(2), NOMINAL, NmtState::Operational);
    assert_eq!(
        master.events,
        [
            MasterEvent::SlaveReturned { node: slave, bus },
            MasterEvent::SlaveState { node: slave, bus, state }
        ]
    );
}

/// Verifies: ECSS 5.6.2b, 8.3.3b, 8.3.3b.2
/// Notices: ECSS 5.6.2b: the application does not learn that a controller is error passive.
/// Notices: ECSS 8.3.3b.2: an isolated master sends its heartbeat on the new bus a period later.
#[test]
fn cut_off_it_goes_to_the_other_bus_within_milliseconds() {
    let mut master = flying();
    let health = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };
    master.run_until(ms(102));
    master.health(NOMINAL, health);
    master.run_until(ms(105));
    assert_eq!(
        master.events,
        [
            MasterEvent::Health { bus: NOMINAL, health },
            MasterEvent::BusSwitched { from: NOMINAL, to: REDUNDANT, cause: SwitchCause::Isolated },
        ]
    );
    assert_eq!(master.times(REDUNDANT, 0x701), [104]);
}

/// Verifies: ECSS 5.3.3.2.3e, 5.6.2a, 8.3.3b
/// Notices: ECSS 5.3.3.2.3e: a master never leaves a bus that failed.
/// Notices: ECSS 5.6.2a: a master does not recover a controller that is bus-off.
/// Notices: ECSS 8.3.3b: a master stays on a bus that failed.
#[test]
fn bus_off_is_recovered_and_too_much_of_it_makes_the_bus_failed() {
    let mut master = flying();
    let off = Health { state: ErrorState::BusOff, tec: 255, ..Health::default() };
    master.health(NOMINAL, off);
    master.run_until(ms(20));
    assert_eq!(master.controls, [(NOMINAL, BusCommand::Recover)]);
    for _ in 0..3 {
        master.health(NOMINAL, Health::default());
        master.health(NOMINAL, off);
    }
    assert!(master.events.contains(&MasterEvent::BusFailed { bus: NOMINAL }));
    assert!(master.events.contains(&MasterEvent::BusSwitched {
        from: NOMINAL,
        to: REDUNDANT,
        cause: SwitchCause::BusOff
    }));
}

/// Given a master with selective access, when its bus fails, then it leaves that bus and joins the other one. When a command brings
/// it back, then it joins the first bus again, and begins with a heartbeat.
///
/// Verifies: ECSS 8.2.1a, 8.2.1a.1, 8.3.3b.2, 8.2.3a, 8.3.3b
/// Notices: ECSS 8.2.1a: a master with selective access stays on the redundant bus when it returns to the nominal one.
/// Notices: ECSS 8.2.1a.1: a bus that failed is not left.
/// Notices: ECSS 8.3.3b.2: a bus that was left in bus-off is not joined again, so no heartbeat starts there.
#[test]
fn selective_master_leaves_a_failed_bus_and_can_return() {
    let mut master = powered(&Profile { selective: &[ecss_can::types::NodeId::MASTER], ..STANDARD });
    master.clear();
    let off = Health { state: ErrorState::BusOff, tec: 255, ..Health::default() };
    for _ in 0..3 {
        master.health(NOMINAL, off);
        master.health(NOMINAL, Health::default());
    }
    master.health(NOMINAL, off);
    assert!(master.events.contains(&MasterEvent::BusFailed { bus: NOMINAL }));
    assert_eq!(master.controls, [(NOMINAL, BusCommand::Leave), (REDUNDANT, BusCommand::Join)]);
    master.transmitted(REDUNDANT, frame(0x701, &[0x05]));
    master.clear();
    master.request(MasterRequest::SwitchBus(NOMINAL));
    assert_eq!(master.controls, [(REDUNDANT, BusCommand::Leave), (NOMINAL, BusCommand::Join)]);
    assert_eq!(master.frames()[0], (NOMINAL, frame(0x701, &[0x05])));
}

/// Verifies: ECSS 8.2.1a.1, 8.2.3a, 8.2.1a, 8.3.3b, 8.3.3b.1
/// Notices: ECSS 8.3.3b.1: a master with selective access does not leave the nominal bus.
/// Notices: ECSS 8.2.1a.1: a master joins the other bus before it leaves its own.
/// Notices: ECSS 8.2.3a: a master with selective access ignores the bus that its application chooses.
/// Notices: ECSS 8.2.1a: a master with selective access joins both buses.
#[test]
fn a_master_with_selective_access_leaves_and_joins() {
    let mut master = powered(&Profile { selective: &[ecss_can::types::NodeId::MASTER], ..STANDARD });
    assert_eq!(master.controls, [(Bus::Nominal, BusCommand::Join)]);
    master.clear();
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    assert_eq!(master.controls, [(NOMINAL, BusCommand::Leave), (REDUNDANT, BusCommand::Join)]);
    master.clear();
    master.receive(NOMINAL, 0x702, &[0x05]);
    assert_eq!(master.events, []);
}

/// Given a master with selective access and Ntoggle 0, when its application chooses the other bus, then the master goes there.
///
/// Verifies: ECSS 8.2.3a, 8.3.3b, 8.2.1a.1
/// Notices: ECSS 8.2.3a: the application of a master cannot choose the bus while Ntoggle is 0.
/// Notices: ECSS 8.3.3b: with Ntoggle 0 a commanded switch is ignored.
#[test]
fn a_master_that_changes_no_bus_by_itself_goes_to_the_chosen_one() {
    let selective = &[ecss_can::types::NodeId::MASTER];
    let mut master = powered(&Profile { selective, master_ntoggle: 0, ..STANDARD });
    master.clear();
    master.request(MasterRequest::SwitchBus(REDUNDANT));
    assert_eq!(master.controls, [(NOMINAL, BusCommand::Leave), (REDUNDANT, BusCommand::Join)]);
}
