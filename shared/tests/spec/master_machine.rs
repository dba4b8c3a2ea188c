//! Redundancy of a master as one machine: the order of what it sends, and the role of its board.
//!
//! Heartbeat 40 ms, consumer time 100 ms. Slave 2 is assigned. Four frames may wait.

use ecss_can::link::access::BusAccess;
use ecss_can::link::machine::Outgoing;
use ecss_can::nmt::machine::Reaction;
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::profile::Profile;
use ecss_can::redundancy::machine::{
    Claim, MasterAction, MasterRedundancy, MasterSetup, MasterVerdict, Sending,
};
use ecss_can::redundancy::{RoleCause, Strap, SwitchCause, TwoBoards};
use ecss_can::types::NmtState::{Initialising, Operational, PreOperational, Stopped};
use ecss_can::types::{Bus, CobId, NmtState};

use crate::bench::{NOMINAL, REDUNDANT, frame, ms, node, span};
use crate::manager::{GRACE, PARAMETERS};

type Machine = MasterRedundancy<TwoBoards, 128, 4>;

fn machine(strap: Option<Strap>, access: BusAccess) -> Machine {
    let setup = MasterSetup {
        parameters: PARAMETERS,
        silent_share: 50,
        dwell: span(1_000),
        grace: GRACE,
        access,
        lifetime: span(40),
    };
    let boards = TwoBoards::new(strap.map(|_| Profile::PAIR), strap.unwrap_or(Strap::Prime));
    let mut machine = Machine::new(boards, &setup);
    machine.peers_mut().assign(node(2), true);
    machine
}

/// The only master board, at 0 ms, after its boot-up message.
fn alone() -> Machine {
    let mut machine = machine(None, BusAccess::Parallel);
    assert!(machine.start(ms(0)));
    let (boot_up, state) = machine.boot_up(ms(0));
    assert_eq!((boot_up.frame, boot_up.expires, state), (frame(0x701, &[0]), ms(40), Operational));
    machine
}

/// One of two boards, active since it heard no other one.
fn paired(access: BusAccess) -> (Machine, u64) {
    let mut machine = machine(Some(Strap::Second), access);
    assert!(!machine.start(ms(0)));
    assert!(!machine.is_active());
    let action = machine.poll(ms(1_000), ms(1_000)).unwrap();
    assert!(matches!(action, MasterAction::TookOver { bus: NOMINAL, .. }), "{action:?}");
    machine.boot_up(ms(1_000));
    (machine, 1_000)
}

fn poll(machine: &mut Machine, at: u64) -> Vec<MasterAction> {
    std::iter::from_fn(|| machine.poll(ms(at), ms(at))).collect()
}

fn left(bus: Bus, outgoing: Outgoing) -> MasterAction {
    MasterAction::Left { bus, frame: outgoing.frame }
}

fn heartbeat(bus: Bus, at: u64) -> MasterAction {
    MasterAction::Heartbeat { bus, frame: frame(0x701, &[5]), expires: ms(at + 40) }
}

fn command(data: u8, expires: u64) -> Outgoing {
    Outgoing { frame: frame(0x300, &[data]), expires: ms(expires) }
}

fn send(bus: Bus, outgoing: Outgoing) -> MasterAction {
    MasterAction::Send { bus, outgoing }
}

/// The claim of the second board, which hears no slave.
fn claim(bus: Bus, at: u64) -> MasterAction {
    send(bus, Outgoing { frame: frame(0x681, &[0, 1]), expires: ms(at + 40) })
}

fn acknowledge_heartbeat(machine: &mut Machine, bus: Bus, at: u64) {
    assert!(machine.on_sent(bus, CobId::new(0x701).unwrap(), ms(at)));
}

fn hear(machine: &mut Machine, state: NmtState, may_start: bool) -> Option<Command> {
    machine.on_frame(NOMINAL, Some(node(2)), ms(10));
    let heard = machine.on_heartbeat(NOMINAL, node(2), state, ms(10));
    let target = Target::Node(node(2));
    heard.command(node(2), state, may_start).map(|message| {
        assert_eq!(message, NmtMessage { command: message.command, target });
        message.command
    })
}

/// Given a commanded change of the bus, When frames are sent before a node acknowledges the heartbeat there, Then they
/// follow it in their order, without those whose lifetime ended.
///
/// Verifies: ECSS 8.3.3b, 8.3.3b.2
/// Notices: ECSS 8.3.3b: a frame goes out on the new bus before the heartbeat is acknowledged.
#[test]
fn frames_wait_in_order_for_the_announcement_of_a_bus() {
    let mut machine = alone();
    assert_eq!(machine.send(command(0, 100)), Sending::Now(NOMINAL));
    machine.request(REDUNDANT);
    let (from, to, cause) = (NOMINAL, REDUNDANT, SwitchCause::Commanded);
    let switched = MasterAction::Switched { from, to, cause };
    assert_eq!(poll(&mut machine, 5), [switched, heartbeat(REDUNDANT, 5)]);

    assert_eq!(machine.send_time(), Sending::Held);
    for (data, expires) in [(1, 100), (2, 8), (3, 100)] {
        assert_eq!(machine.send(command(data, expires)), Sending::Held);
    }
    assert_eq!(poll(&mut machine, 7), []);
    acknowledge_heartbeat(&mut machine, REDUNDANT, 8);
    let released = [
        MasterAction::SendTime,
        send(REDUNDANT, command(1, 100)),
        MasterAction::Expired { bus: REDUNDANT, frame: command(2, 8).frame },
        send(REDUNDANT, command(3, 100)),
    ];
    assert_eq!(poll(&mut machine, 8), released);
    assert_eq!(machine.send(command(4, 100)), Sending::Now(REDUNDANT));
    assert_eq!(machine.send_time(), Sending::Now(REDUNDANT));
}

/// Verifies: ECSS 8.3.3b
#[test]
fn a_frame_above_the_places_of_held_ones_is_refused() {
    let mut machine = alone();
    machine.request(REDUNDANT);
    poll(&mut machine, 5);
    for data in 0..4 {
        assert!(machine.has_room());
        assert_eq!(machine.send(command(data, 100)), Sending::Held);
    }
    assert!(!machine.has_room());
    assert_eq!(machine.send(command(4, 100)), Sending::Refused(REDUNDANT));
    assert!(!machine.queue(command(4, 100)));
    acknowledge_heartbeat(&mut machine, REDUNDANT, 8);
    assert!(machine.has_room());
    assert_eq!(poll(&mut machine, 8), [0, 1, 2, 3].map(|data| send(REDUNDANT, command(data, 100))));
}

/// Verifies: ECSS 8.3.3b, 8.3.3b.2
/// Notices: ECSS 8.3.3b: a bus that is commanded before the announcement of another is not taken.
#[test]
fn frames_held_for_a_bus_that_is_left_are_never_sent() {
    let mut machine = alone();
    machine.request(REDUNDANT);
    poll(&mut machine, 5);
    assert_eq!(machine.send(command(1, 100)), Sending::Held);
    assert_eq!(machine.send(command(2, 100)), Sending::Held);
    machine.request(NOMINAL);
    let (from, to, cause) = (REDUNDANT, NOMINAL, SwitchCause::Commanded);
    let [first, second] = [1, 2].map(|data| left(REDUNDANT, command(data, 100)));
    let switched = MasterAction::Switched { from, to, cause };
    assert_eq!(poll(&mut machine, 6), [switched, first, second, heartbeat(NOMINAL, 6)]);
    acknowledge_heartbeat(&mut machine, NOMINAL, 7);
    assert_eq!(poll(&mut machine, 7), []);
}

/// A heartbeat that is not acknowledged within its lifetime ends the wait.
///
/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.3b: frames wait for an announcement that failed until the next change of the bus.
#[test]
fn a_failed_heartbeat_releases_the_held_frames() {
    let mut machine = alone();
    machine.request(REDUNDANT);
    poll(&mut machine, 5);
    assert_eq!(machine.send(command(1, 100)), Sending::Held);
    machine.on_failed(REDUNDANT, CobId::new(0x300).unwrap());
    assert_eq!(poll(&mut machine, 44), []);
    machine.on_failed(REDUNDANT, CobId::new(0x701).unwrap());
    assert_eq!(poll(&mut machine, 44), [send(REDUNDANT, command(1, 100))]);
}

/// Given a slave in each state, When its heartbeat is heard, Then it gets the command that it needs by the answer of the
/// boot-up process.
///
/// Verifies: ECSS 8.3.3f
#[test]
fn a_waiting_slave_starts_when_the_boot_process_allows_it() {
    let cases = [
        (PreOperational, true, Some(Command::Start)),
        (Stopped, true, Some(Command::Start)),
        (Stopped, false, Some(Command::EnterPreOperational)),
        (PreOperational, false, None),
        (Initialising, true, Some(Command::Start)),
        (Operational, true, None),
    ];
    for (state, may_start, expected) in cases {
        assert_eq!(hear(&mut alone(), state, may_start), expected, "{state:?} {may_start}");
    }
}

/// Verifies: ECSS 6.5.1a.2
/// Notices: ECSS 6.5.1a.2: the master starts a slave that the application stopped.
#[test]
fn a_slave_that_the_application_stopped_gets_no_command() {
    let mut machine = alone();
    assert!(machine.on_command(Command::Stop, Target::Node(node(2))));
    assert_eq!(hear(&mut machine, Stopped, true), None);
    assert!(!machine.on_command(Command::Start, Target::All));
    assert_eq!(hear(&mut machine, Stopped, true), Some(Command::Start));
}

/// Verifies: ECSS 6.5.1a.3, 6.5.2a, 6.5.1a.5, 6.5.4a
/// Notices: ECSS 6.5.1a.3: a master in Pre-operational still reports Operational.
/// Notices: ECSS 6.5.2a: a master in Pre-operational still reports Operational.
/// Notices: ECSS 6.5.4a: a master boots up in Pre-operational after Reset communication.
#[test]
fn heartbeats_report_the_own_state_of_the_master() {
    let mut machine = alone();
    assert_eq!(machine.on_own_command(Command::EnterPreOperational), Reaction::Entered(PreOperational));
    let at = machine.deadline().unwrap();
    let Some(MasterAction::Heartbeat { frame: sent, .. }) = machine.poll(at, at) else {
        panic!("a heartbeat")
    };
    assert_eq!(sent, frame(0x701, &[0x7F]));
    assert_eq!(machine.on_own_command(Command::ResetCommunication), Reaction::ResetCommunication);
    assert_eq!(machine.boot_up(at).1, Operational);
}

/// 701h of another node is reported when it begins, and when no bus has it for Ttoggle consumer times, 300 ms.
///
/// Verifies: ECSS 8.1a
/// Notices: ECSS 8.1a: a second master on the other bus is not reported.
#[test]
fn a_rival_is_reported_at_its_begin_and_its_end_on_each_bus() {
    let mut machine = alone();
    assert_eq!(hear_master(&mut machine, NOMINAL, 10), Some(MasterAction::RivalHeard(NOMINAL)));
    assert_eq!(hear_master(&mut machine, NOMINAL, 20), None);
    assert_eq!(hear_master(&mut machine, REDUNDANT, 30), Some(MasterAction::RivalHeard(REDUNDANT)));
    let is_silent = |action: &MasterAction| matches!(action, MasterAction::RivalSilent(_));
    let mut silent = |at| poll(&mut machine, at).into_iter().filter(is_silent).collect::<Vec<_>>();
    assert_eq!(silent(319), []);
    assert_eq!(silent(320), [MasterAction::RivalSilent(NOMINAL)]);
    assert_eq!(silent(330), [MasterAction::RivalSilent(REDUNDANT)]);
}

/// Given an active board of two, When its heartbeat is due, Then its claim goes to both buses, on the active one after
/// the heartbeat is acknowledged if that announces the bus.
///
/// Verifies: ECSS 8.1a
/// Notices: ECSS 8.1a: an active board claims on its active bus alone.
#[test]
fn claims_follow_the_heartbeat_on_both_buses() {
    let (mut machine, at) = paired(BusAccess::Parallel);
    assert_eq!(poll(&mut machine, at), [heartbeat(NOMINAL, at), claim(REDUNDANT, at)]);
    acknowledge_heartbeat(&mut machine, NOMINAL, at);
    assert_eq!(poll(&mut machine, at), [claim(NOMINAL, at)]);
    let next = at + 40;
    assert_eq!(
        poll(&mut machine, next),
        [heartbeat(NOMINAL, next), claim(REDUNDANT, next), claim(NOMINAL, next)]
    );
}

/// Verifies: ECSS 8.1a, 8.2.1a.1
/// Notices: ECSS 8.2.1a.1: a board with selective access sends its claim on the other bus.
#[test]
fn a_board_with_selective_access_claims_on_its_bus_only() {
    let (mut machine, at) = paired(BusAccess::Selective);
    assert!(machine.is_joined(NOMINAL) && !machine.is_joined(REDUNDANT));
    assert_eq!(poll(&mut machine, at), [heartbeat(NOMINAL, at)]);
    acknowledge_heartbeat(&mut machine, NOMINAL, at);
    assert_eq!(poll(&mut machine, at), [claim(NOMINAL, at)]);
}

/// Given an active board with a frame that waits and a rival, When it becomes the standby, Then it drops the frame, is
/// Initialising, and reports no end of the rival.
///
/// Verifies: ECSS 8.1a
/// Notices: ECSS 8.1a: a board that stands by sends what waited.
#[test]
fn a_board_that_stands_by_forgets_what_it_began() {
    let (mut machine, at) = paired(BusAccess::Parallel);
    poll(&mut machine, at);
    hear_master(&mut machine, NOMINAL, at);
    assert_eq!(machine.send_time(), Sending::Held);
    // A claim is held, too.
    assert_eq!(machine.send(command(1, at + 1_000)), Sending::Held);
    let Some(MasterAction::StoodBy { bus: NOMINAL, change }) = machine.stand_by_commanded(ms(at)) else {
        panic!("the standby")
    };
    let MasterAction::Send { outgoing: claimed, .. } = claim(NOMINAL, at) else { panic!("a claim") };
    let held = [claimed, command(1, at + 1_000)];
    assert_eq!(poll(&mut machine, at), held.map(|outgoing| left(NOMINAL, outgoing)));
    assert_eq!(change.cause, RoleCause::Commanded);
    assert_eq!((machine.is_active(), machine.state()), (false, Initialising));
    assert_eq!(machine.stand_by_commanded(ms(at)), None);
    assert_eq!(poll(&mut machine, at + 399), []);
    let taken = poll(&mut machine, at + 400);
    assert!(matches!(taken[0], MasterAction::TookOver { bus: NOMINAL, .. }), "{taken:?}");
    assert!(taken.iter().all(|action| !matches!(action, MasterAction::RivalSilent(_))));
    machine.boot_up(ms(at + 400));
    acknowledge_heartbeat(&mut machine, NOMINAL, at + 401);
    assert_eq!(poll(&mut machine, at + 401), [claim(NOMINAL, at + 400)]);
}

/// Given a heartbeat whose claim is not sent yet, When the board stands by and takes over again, Then that claim is never sent.
///
/// Verifies: ECSS 8.1a
#[test]
fn a_claim_that_was_due_ends_with_the_active_role() {
    let (mut machine, at) = paired(BusAccess::Parallel);
    let first = machine.poll(ms(at), ms(at));
    assert_eq!(first, Some(heartbeat(NOMINAL, at)));
    machine.stand_by_commanded(ms(at));
    let taken = machine.poll(ms(at + 400), ms(at + 400));
    assert!(matches!(taken, Some(MasterAction::TookOver { .. })), "{taken:?}");
    machine.boot_up(ms(at + 400));
    assert_eq!(machine.poll(ms(at + 400), ms(at + 400)), Some(heartbeat(NOMINAL, at + 400)));
}

/// Given a board that listens, When it hears another master and later nothing, Then it takes over on the bus of that
/// master.
///
/// Verifies: ECSS 8.1a
/// Notices: ECSS 8.1a: a listening board takes over beside a master on the redundant bus.
#[test]
fn a_listening_board_follows_the_master_that_it_hears() {
    let mut machine = machine(Some(Strap::Prime), BusAccess::Parallel);
    machine.start(ms(0));
    let heard = hear_master(&mut machine, REDUNDANT, 100);
    assert!(
        matches!(heard, Some(MasterAction::HeardMaster(change)) if change.cause == RoleCause::MasterHeard)
    );
    assert_eq!((machine.active(), machine.deadline()), (REDUNDANT, Some(ms(500))));
    // Without slaves a SYNC may be sent in place of the heartbeat.
    assert_eq!(machine.on_sync_or_time(NOMINAL, ms(200), ms(200)), None);
    assert_eq!((machine.active(), machine.deadline()), (NOMINAL, Some(ms(600))));
    hear_master(&mut machine, REDUNDANT, 300);
    let taken = machine.poll(ms(700), ms(700));
    assert!(matches!(taken, Some(MasterAction::TookOver { bus: REDUNDANT, .. })), "{taken:?}");
}

/// Verifies: ECSS 8.1a
/// Notices: ECSS 8.1a: an active board does not yield to a claim on the other bus.
#[test]
fn an_active_board_yields_to_a_claim_with_more_slaves() {
    let (mut machine, at) = paired(BusAccess::Parallel);
    poll(&mut machine, at);
    let more = Claim { slaves: 1, strap: Strap::Prime };
    let Some(MasterAction::StoodBy { change, .. }) = hear_claim(&mut machine, REDUNDANT, more, at) else {
        panic!("it yields")
    };
    assert_eq!(change.cause, RoleCause::Yielded);
    // A board that hears more slaves answers with its own claim.
    let (mut machine, at) = paired(BusAccess::Parallel);
    poll(&mut machine, at);
    assert_eq!(hear_slave(&mut machine, at), None);
    let fewer = Claim { slaves: 0, strap: Strap::Prime };
    poll(&mut machine, at + 40);
    let answer = hear_claim(&mut machine, REDUNDANT, fewer, at + 41);
    let expected = Outgoing { frame: frame(0x681, &[1, 1]), expires: ms(at + 81) };
    assert_eq!(answer, Some(send(REDUNDANT, expected)));
}

/// 701h of another node.
fn hear_master(machine: &mut Machine, bus: Bus, at: u64) -> Option<MasterAction> {
    match machine.on_received(bus, &frame(0x701, &[5]), ms(at), ms(at)) {
        MasterVerdict::OtherMaster(action) => action,
        verdict => panic!("{verdict:?}"),
    }
}

fn hear_claim(machine: &mut Machine, bus: Bus, claim: Claim, at: u64) -> Option<MasterAction> {
    match machine.on_received(bus, &Profile::PAIR.frame(claim), ms(at), ms(at)) {
        MasterVerdict::Claim(action) => action,
        verdict => panic!("{verdict:?}"),
    }
}

/// Given a master on the nominal bus. Then heartbeats count on both buses, answers by SDO on the active one only, and a claim means nothing
/// where there is one master board.
///
/// Verifies: ECSS 8.2.1a.2
/// Notices: ECSS 8.2.1a.2: heartbeats on the bus that is not active are ignored.
#[test]
fn each_frame_has_one_meaning() {
    let mut machine = alone();
    let mut verdict = |bus, id, data: &[u8]| machine.on_received(bus, &frame(id, data), ms(10), ms(10));
    for bus in [NOMINAL, REDUNDANT] {
        let (node, state) = (node(2), PreOperational);
        assert_eq!(verdict(bus, 0x702, &[0x7F]), MasterVerdict::Heartbeat { node, state });
        assert_eq!(verdict(bus, 0x702, &[0x7E]), MasterVerdict::Malformed);
        assert_eq!(verdict(bus, 0x702, &[0x7F, 0]), MasterVerdict::Malformed);
        // NMT, SYNC, EMCY, a PDO, a request by SDO, a claim.
        for id in [0x000, 0x080, 0x082, 0x182, 0x602, 0x681] {
            assert_eq!(verdict(bus, id, &[0, 1]), MasterVerdict::Other, "{id:X}");
        }
    }
    assert_eq!(verdict(NOMINAL, 0x582, &[0; 8]), MasterVerdict::Response(node(2)));
    assert_eq!(verdict(REDUNDANT, 0x582, &[0; 8]), MasterVerdict::Other);
    assert_eq!(verdict(NOMINAL, 0x581, &[0; 8]), MasterVerdict::Other);
}

fn hear_slave(machine: &mut Machine, at: u64) -> Option<NmtMessage> {
    machine.on_frame(NOMINAL, Some(node(2)), ms(at));
    machine.on_heartbeat(NOMINAL, node(2), Operational, ms(at)).command(node(2), Operational, true)
}
