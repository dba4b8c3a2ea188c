//! One of two master boards on the bench, profile `standard` with a standby: it takes over 400 ms after the last heartbeat of
//! the active one. The board strapped prime listens for 700 ms, the other one for 1 s.
//!
//! Verifies: ECSS 8.1a

pub mod time;

use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::extend::{BusCommand, ClientNode};
use ecss_can::node::{FailCause, Master, MasterEvent, MasterRequest, Refusal, SpacecraftDevice};
use ecss_can::profile::Profile;
use ecss_can::redundancy::{Role, RoleCause, RoleChange, Strap, SwitchCause, TwoBoards};
use ecss_can::types::{Bus, Frame, NmtState};

use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, node};
use crate::console::{self, Console};
use crate::instrument::STANDARD;
use crate::manager::ALONE;
use crate::master_device::{BOOTS_TWO, TWO, has_no_cob_ids};

pub type Board = Bench<Master<Console, TwoBoards>>;

const PROFILE: Profile = Profile { standby: Some(Profile::PAIR), ..STANDARD };

const LISTENS: [(Bus, BusCommand); 2] = [(NOMINAL, BusCommand::Listen), (REDUNDANT, BusCommand::Listen)];
const JOINS: [(Bus, BusCommand); 2] = [(NOMINAL, BusCommand::Join), (REDUNDANT, BusCommand::Join)];

fn role(role: Role, cause: RoleCause) -> MasterEvent {
    MasterEvent::Role(RoleChange { role, cause })
}

pub fn powered(strap: Strap) -> Board {
    Bench::new(Master::builder(&PROFILE, Console::default()).one_of_two(strap).build())
}

fn heartbeat() -> Frame {
    frame(0x701, &[0x05])
}

/// The first frames of the board strapped prime that becomes active on this bus: on the other one it claims that it is. Here the
/// claim waits for the heartbeat.
fn begins(bus: Bus) -> [(Bus, Frame); 3] {
    [(bus, frame(0x701, &[0])), (bus, heartbeat()), (bus.other(), frame(0x680, &[0, 0]))]
}

/// Standby of a master that was heard at 100, 200 .. 1000 ms on the redundant bus; slaves 2 and 3 answered it and run.
fn standing_by() -> Board {
    standing_by_with(Console::default())
}

/// With another device.
fn standing_by_with<D: SpacecraftDevice>(device: D) -> Bench<Master<D, TwoBoards>> {
    let mut board = Bench::new(Master::builder(&PROFILE, device).one_of_two(Strap::Prime).build());
    stand_by(&mut board);
    board
}

/// A board that got power becomes this standby.
fn stand_by<D: SpacecraftDevice>(board: &mut Bench<Master<D, TwoBoards>>) {
    for beat in 1..=10 {
        board.run_until(ms(100 * beat));
        board.receive(REDUNDANT, 0x701, &[0x05]);
        for raw in [2, 3] {
            board.receive(REDUNDANT, 0x700 + raw, &[0x05]);
            board.receive(REDUNDANT, 0x580 + raw, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
        }
    }
    assert_eq!(board.frames(), []);
}

/// Heartbeats of slaves 2 and 3 every 100 ms until then.
fn fly_until(board: &mut Board, until: u64) {
    let first = board.now.as_micros() / 1_000;
    for at in (first..until).step_by(100) {
        board.run_until(ms(at));
        board.receive(REDUNDANT, 0x702, &[0x05]);
        board.receive(REDUNDANT, 0x703, &[0x05]);
    }
    board.run_until(ms(until));
}

/// Heartbeats of slave 2 every 100 ms until then.
fn fly_alone_until(board: &mut Board, until: u64) {
    let first = board.now.as_micros() / 1_000;
    for at in (first..until).step_by(100) {
        board.run_until(ms(at));
        board.receive(REDUNDANT, 0x702, &[0x05]);
    }
    board.run_until(ms(until));
}

/// As [`standing_by`], taken over at 1400 ms, its heartbeat acknowledged.
fn taken_over() -> Board {
    let mut board = standing_by();
    board.clear();
    fly_until(&mut board, 1_400);
    board.transmitted(REDUNDANT, heartbeat());
    board
}

/// Verifies: ECSS 6.5.2a, 6.5.3a, 8.2.1a.2, 8.3.2a, 8.3.3a
/// Notices: ECSS 8.3.2a: a board that hears no master begins on the bus other than Bdefault.
/// Notices: ECSS 8.3.2a: a board that hears no master begins on the nominal bus whatever Bdefault is.
#[test]
fn a_board_alone_listens_silently_then_boots_on_the_default_bus() {
    for bus in Bus::ALL {
        let profile = Profile { bdefault: bus, ..PROFILE };
        let mut board =
            Bench::new(Master::builder(&profile, Console::default()).one_of_two(Strap::Prime).build());
        assert_eq!(board.controls, LISTENS);
        assert_eq!(board.write((0x1017, 0), &[50, 0]), Ok(()));
        board.run_until(ms(699));
        assert_eq!((board.frames(), &board.events), (vec![], &vec![]));
        board.run_until(ms(700));
        assert_eq!(board.controls[2..], JOINS);
        assert_eq!(board.frames(), begins(bus));
        let expected = [MasterEvent::State(NmtState::Operational), role(Role::Active, RoleCause::Alone)];
        assert_eq!(board.events, expected);
        board.run_until(ms(800));
        assert_eq!(board.times(bus, 0x701), [700, 700, 750, 800], "1017h as it was written");
        assert_eq!(board.times(bus.other(), 0x701), [0; 0]);
    }
}

/// Given a profile without a standby, when a board gets power, then it is active at once.
///
/// Verifies: ECSS 6.5.3a, 8.2.1a.2, 8.3.2a
#[test]
fn a_board_of_a_mission_without_a_standby_is_active_at_power_on() {
    let mut board =
        Bench::new(Master::builder(&STANDARD, Console::default()).one_of_two(Strap::Second).build());
    board.run_until(ms(0));
    assert_eq!(board.controls, JOINS);
    assert_eq!(board.frames(), [(NOMINAL, frame(0x701, &[0])), (NOMINAL, heartbeat())]);
    board.request(MasterRequest::StandBy);
    assert_eq!(board.controls.len(), 2);
}

/// Given a standby, when its own application writes a command to 1F82h, then nothing is sent, and the command is refused.
///
/// Verifies: ECSS 8.1b
#[test]
fn a_standby_sends_no_command_that_is_written_to_1f82h() {
    for (sub, value, named) in [(2, 4, 2), (128, 5, 1), (128, 6, 1)] {
        let mut board = standing_by();
        board.clear();
        assert_eq!(board.write((0x1F82, sub), &[value]), Ok(()));
        let refused = MasterEvent::Refused { node: node(named) };
        assert_eq!((board.frames(), board.events), (vec![], vec![refused]), "sub-index {sub}: {value}");
    }
}

/// Given a standby, when everything is asked of it that a master does, commands to one slave or to all of them too, then it sends no
/// frame.
///
/// Verifies: ECSS 8.1b
/// Notices: ECSS 8.1b: a standby sends the NMT commands of its application, also to all nodes.
#[test]
fn a_standby_sends_nothing_whatever_is_asked_of_it() {
    let mut board = standing_by();
    let operational =
        |raw| MasterEvent::SlaveState { node: node(raw), bus: REDUNDANT, state: NmtState::Operational };
    let expected = [role(Role::Standby, RoleCause::MasterHeard), operational(2), operational(3)];
    assert_eq!(board.events, expected);
    board.clear_events();
    board.request(MasterRequest::Nmt(NmtMessage { command: Command::Stop, target: Target::Node(node(2)) }));
    board.request(MasterRequest::Nmt(NmtMessage { command: Command::Start, target: Target::All }));
    board.request(MasterRequest::Boot(node(3)));
    board.request(MasterRequest::SwitchBus(NOMINAL));
    board.request(MasterRequest::StandBy);
    let refused = |raw| MasterEvent::Refused { node: node(raw) };
    assert_eq!(board.events, [refused(2), refused(1), refused(3), refused(1)]);
    let refusal = board.touch(|master, now| console::command(master, node(2), [0; 8], now));
    assert_eq!(refusal, Err(Refusal::NotValid));
    let frame = frame(0x3FF, &[1]);
    assert_eq!(board.touch(|master, now| master.send_frame(frame, now)), Err(Refusal::NotValid));
    let claimed = board.touch(|master, _| master.claim_sdo(node(2), core::task::Waker::noop()).is_some());
    assert!(!claimed, "the SDO client waits until this master is active");
    board.receive(REDUNDANT, 0x601, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    board.receive(NOMINAL, 0x702, &[0x7F]);
    board.receive(REDUNDANT, 0x703, &[0]);
    board.receive(REDUNDANT, 0x680, &[9, 0]);
    board.receive(REDUNDANT, 0x701, &[0x05]);
    board.run_until(ms(1_399));
    assert_eq!((board.frames(), board.controls), (vec![], LISTENS.to_vec()));
}

/// Given a board that still listens after power-on, when its application commands slaves, then it sends nothing and refuses.
///
/// Verifies: ECSS 8.1b
/// Notices: ECSS 8.1b: a board that listens sends the NMT commands of its application.
#[test]
fn a_listening_board_sends_no_nmt_command() {
    let mut board = powered(Strap::Prime);
    board.run_until(ms(300));
    board.clear();
    board.request(MasterRequest::Nmt(NmtMessage { command: Command::Stop, target: Target::Node(node(2)) }));
    board.request(MasterRequest::Nmt(NmtMessage { command: Command::Start, target: Target::All }));
    let refused = |raw| MasterEvent::Refused { node: node(raw) };
    assert_eq!((board.frames(), &board.events[..]), (vec![], &[refused(2), refused(1)][..]));
    board.run_until(ms(699));
    assert_eq!(board.frames(), []);
}

/// Given a standby that heard a slave Operational and never heard it answer, When it takes over, Then the slave counts: its silence
/// makes the new master leave the bus.
///
/// Verifies: ECSS 8.3.3b
/// Notices: ECSS 8.3.3b: a new master stays on a bus where slaves fall silent that it overheard.
#[test]
fn a_slave_that_a_standby_overheard_counts_when_it_takes_over() {
    let mut board = powered(Strap::Second);
    for beat in 1..=10 {
        board.run_until(ms(100 * beat));
        board.receive(REDUNDANT, 0x701, &[0x05]);
        board.receive(REDUNDANT, 0x680, &[2, 0]);
        board.receive(REDUNDANT, 0x702, &[0x05]);
        board.receive(REDUNDANT, 0x703, &[0x05]);
    }
    board.run_until(ms(1_400));
    board.transmitted(REDUNDANT, frame(0x701, &[0]));
    board.transmitted(REDUNDANT, heartbeat());
    board.clear();
    // Slave 3 is cut off, and slave 2 has not been asked yet.
    board.receive(REDUNDANT, 0x702, &[0x05]);
    fly_alone_until(&mut board, 2_300);
    let switched = board.events.iter().find_map(|event| match event {
        MasterEvent::BusSwitched { cause, .. } => Some(*cause),
        _ => None,
    });
    assert_eq!(switched, Some(SwitchCause::SlavesSilent), "{:?}", board.events);
}

/// Verifies: ECSS 5.3.3.2.2b, 8.3.3a, 6.5.3a, 8.2.1a.2
/// Notices: ECSS 5.3.3.2.2b: slaves that still send keep the standby from taking over.
/// Notices: ECSS 8.3.3a: the master sends its heartbeat on Bdefault, not on the active bus.
#[test]
fn a_standby_takes_over_where_the_master_was_heard_last() {
    let mut board = standing_by();
    board.clear();
    fly_until(&mut board, 1_399);
    assert_eq!((board.frames(), &board.events, &board.controls), (vec![], &vec![], &vec![]));
    board.run_until(ms(1_400));
    assert_eq!(board.controls, JOINS);
    assert_eq!(board.frames(), begins(REDUNDANT));
    let expected = [MasterEvent::State(NmtState::Operational), role(Role::Active, RoleCause::MasterSilent)];
    assert_eq!(board.events, expected);
    let status = board.node.status(board.now);
    assert_eq!((status.active, status.state), (REDUNDANT, NmtState::Operational));
    fly_until(&mut board, 5_000);
    let elsewhere: Vec<_> = board.sent.iter().filter(|sent| sent.bus == NOMINAL).collect();
    assert!(elsewhere.iter().all(|sent| sent.frame.id().raw() == 0x680), "{elsewhere:?}");
}

/// Given a board that told of no acknowledgement while it was the standby, when it takes over, then that counts no more: the bus
/// is left after 2 ms without one, not at once.
///
/// Verifies: ECSS 5.6.2b
/// Notices: ECSS 5.6.2b: a standby master does not report its error states.
#[test]
fn what_a_standby_knew_of_its_controllers_moves_no_bus() {
    let mut board = standing_by();
    board.health(REDUNDANT, ALONE);
    assert_eq!(board.events.last(), Some(&MasterEvent::Health { bus: REDUNDANT, health: ALONE }));
    board.clear();
    fly_until(&mut board, 1_400);
    assert_eq!(board.frames(), begins(REDUNDANT));
    board.clear();
    board.transmitted(REDUNDANT, heartbeat());
    board.run_until(ms(1_450));
    assert_eq!(board.controls, []);
}

/// Given an active master that nobody acknowledges, when its SYNC is repeated and its heartbeat does not get out, then the
/// standby stays silent until SYNCs, times and claims have ended as well.
#[test]
fn any_frame_of_a_master_without_slaves_is_a_sign_of_its_life() {
    for repeated in [frame(0x080, &[]), frame(0x181, &[0, 0, 0, 9, 0, 0, 0]), frame(0x681, &[0, 1])] {
        let mut board = powered(Strap::Prime);
        // Listening: such a frame is enough as well.
        for at in (600..5_000).step_by(10) {
            board.run_until(ms(at));
            board.receive(REDUNDANT, repeated.id().raw(), repeated.data());
        }
        assert_eq!((board.frames(), &board.controls[..]), (vec![], &LISTENS[..]), "{repeated:?}");
        assert_eq!(board.events[0], role(Role::Standby, RoleCause::MasterHeard));
        board.run_until(ms(5_389));
        assert_eq!(board.frames(), []);
        board.run_until(ms(5_390));
        assert_eq!(board.frames()[0], (REDUNDANT, frame(0x701, &[0])), "{repeated:?}");
    }
}

/// Given slaves, which acknowledge, when SYNCs come without a heartbeat, then these are of somebody else: the standby takes over.
#[test]
fn a_foreign_sync_keeps_no_standby_from_taking_over() {
    let mut board = standing_by();
    board.clear();
    for at in (1_000..1_400).step_by(10) {
        if at % 100 == 0 {
            fly_until(&mut board, at);
            board.receive(REDUNDANT, 0x702, &[0x05]);
        }
        board.run_until(ms(at));
        board.receive(REDUNDANT, 0x080, &[]);
    }
    assert_eq!(board.frames(), []);
    board.run_until(ms(1_400));
    assert_eq!(board.frames()[0], (REDUNDANT, frame(0x701, &[0])));
}

/// Given slaves that all fall silent, when the master is acknowledged no more, then its SYNC counts before the standby is due.
#[test]
fn a_master_that_loses_its_slaves_is_not_replaced() {
    // Its last heartbeat is of 1000 ms, the last ones of the slaves of 1090 ms.
    let mut board = standing_by();
    board.clear();
    for at in (1_000..3_000).step_by(10) {
        board.run_until(ms(at));
        if at <= 1_090 {
            board.receive(REDUNDANT, 0x702, &[0x05]);
            board.receive(REDUNDANT, 0x703, &[0x05]);
        } else {
            board.receive(REDUNDANT, 0x080, &[]);
        }
    }
    assert_eq!((board.frames(), &board.controls), (vec![], &vec![]));
}

/// Verifies: ECSS 5.3.3.2.3e, 8.3.3a
/// Notices: ECSS 5.3.3.2.3e: the standby takes over on the bus that its master has left.
#[test]
fn a_master_that_changed_the_bus_is_replaced_where_it_is_now() {
    let mut board = standing_by();
    board.receive(NOMINAL, 0x701, &[0x05]);
    board.clear();
    board.run_until(ms(1_400));
    assert_eq!(board.frames()[0], (NOMINAL, frame(0x701, &[0])));
}

/// Given slaves that run, when the standby has taken over, then it asks who they are, and neither starts nor resets one.
///
/// Verifies: ECSS 6.9c, 6.9d
/// Notices: ECSS 6.9d: a master that took over sends no SYNC.
#[test]
fn running_slaves_go_on_after_a_takeover() {
    let mut board = taken_over();
    assert!(!board.events.contains(&MasterEvent::SlaveLost { node: node(2) }));
    board.clear();
    for raw in [2, 3] {
        board.receive(REDUNDANT, 0x700 + raw, &[0x05]);
        board.receive(REDUNDANT, 0x580 + raw, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    }
    assert_eq!(board.touch(|master, now| console::command(master, node(3), [7; 8], now)), Ok(()));
    assert_eq!(board.times(REDUNDANT, 0x303), [1_400]);
    board.run_until(ms(1_550));
    let of_slaves = board.sent.iter().filter(|sent| sent.frame.id().raw() == 0x000);
    assert_eq!(of_slaves.count(), 0);
    assert_eq!(board.times(REDUNDANT, 0x080), [1_500]);
}

/// Given a board that is strapped second and became active, when a slave waits in Pre-operational, then this board starts it, and sends
/// the NMT commands of its application.
///
/// Verifies: ECSS 8.1b, 6.5.1a.1, 6.5.1a.2, 8.3.3f
/// Notices: ECSS 8.1b: only the board that is strapped prime starts slaves.
#[test]
fn the_second_board_is_the_nmt_master_when_it_is_active() {
    let mut board = powered(Strap::Second);
    board.run_until(ms(1_000));
    board.transmitted(NOMINAL, heartbeat());
    board.clear();
    board.receive(NOMINAL, 0x702, &[0x7F]);
    let commands = |board: &Board| {
        let frames = board.frames().into_iter();
        frames.filter(|(_, sent)| sent.id().raw() == 0x000).collect::<Vec<_>>()
    };
    assert_eq!(commands(&board), [(NOMINAL, frame(0x000, &[1, 2]))]);
    board.clear();
    let message = NmtMessage { command: Command::Stop, target: Target::Node(node(2)) };
    board.request(MasterRequest::Nmt(message));
    assert_eq!(commands(&board), [(NOMINAL, frame(0x000, &[2, 2]))]);
}

/// Given a board that is strapped second and became active, when an assigned slave boots up and has what the board expects, then this
/// board starts it.
///
/// Verifies: ECSS 8.1b, 6.5.1a.1
/// Notices: ECSS 8.1b: the second board starts no slave that it has checked.
#[test]
fn the_second_board_checks_and_starts_an_assigned_slave() {
    const PAIR: Profile = Profile { standby: Some(Profile::PAIR), ..BOOTS_TWO };
    let mut board = Bench::new(Master::builder(&PAIR, Console::default()).one_of_two(Strap::Second).build());
    board.run_until(ms(1_000));
    board.transmitted(NOMINAL, heartbeat());
    board.receive(NOMINAL, 0x702, &[0]);
    board.receive(NOMINAL, 0x582, &[0x43, 0x00, 0x10, 0, 0, 0, 0, 0]);
    board.receive(NOMINAL, 0x582, &[0x43, 0x18, 0x10, 2, 0x15, 0x50, 0, 0]);
    has_no_cob_ids(&mut board);
    assert!(board.frames().contains(&(NOMINAL, frame(0x000, &[1, 2]))));
}

/// Given a board that is strapped second and became active at 1 s, when a mandatory slave is silent, then the board reports it after
/// the boot time, 5 s.
#[test]
fn the_second_board_reports_a_silent_slave_after_boot_time() {
    const PAIR: Profile = Profile { standby: Some(Profile::PAIR), ..BOOTS_TWO };
    let mut board = Bench::new(Master::builder(&PAIR, Console::default()).one_of_two(Strap::Second).build());
    let is_told = |board: &Board| {
        board.events.iter().any(|event| matches!(event, MasterEvent::BootFailed { node: TWO, .. }))
    };
    board.run_until(ms(5_999));
    assert!(!is_told(&board));
    board.run_until(ms(6_000));
    assert!(is_told(&board));
}

/// Given two active masters on one bus, when the other one hears more slaves, then this one yields: silent, and whatever
/// waited is gone.
///
/// Verifies: ECSS 6.4a.2
/// Notices: ECSS 6.4a.2: a second master is reported with a code other than 8150h.
#[test]
fn of_two_active_masters_the_one_with_fewer_slaves_yields() {
    let mut board = taken_over();
    board.receive(REDUNDANT, 0x702, &[0x05]);
    board.run_until(ms(1_500));
    board.clear();
    board.receive(NOMINAL, 0x701, &[0x05]);
    // The collision of the nominal bus is reported on the active bus.
    let collision = frame(0x081, &[0x50, 0x81, 0x11, 0, 0, 0, 0, 0]);
    assert_eq!(board.frames(), [(REDUNDANT, collision)]);
    assert!(board.events.contains(&MasterEvent::SecondMaster { bus: NOMINAL }));
    board.clear();
    board.receive(NOMINAL, 0x681, &[1, 1]);
    assert_eq!(board.controls, [], "a tie: this one is strapped prime");
    // Slave 2 is heard, slave 3 is not since the takeover.
    assert_eq!(board.frames(), [(NOMINAL, frame(0x680, &[1, 0]))]);
    board.receive(NOMINAL, 0x681, &[2, 1]);
    assert_eq!(board.controls, LISTENS);
    assert!(board.events.contains(&role(Role::Standby, RoleCause::Yielded)), "{:?}", board.events);
    assert_eq!(board.node.status(board.now).state, NmtState::Initialising);
    board.clear();
    for beat in 5..20 {
        board.failed(REDUNDANT, heartbeat(), FailCause::BusLeft);
        board.run_until(ms(1_000 + 100 * beat));
        board.receive(NOMINAL, 0x701, &[0x05]);
    }
    assert_eq!((board.frames(), &board.controls), (vec![], &vec![]));
    board.run_until(ms(3_300));
    assert_eq!(board.frames()[0], (NOMINAL, frame(0x701, &[0])), "it takes over again");
}

#[test]
fn the_master_that_hears_more_slaves_claims_and_stays() {
    let mut board = taken_over();
    board.receive(REDUNDANT, 0x702, &[0x05]);
    board.receive(REDUNDANT, 0x703, &[0x05]);
    board.run_until(ms(1_500));
    board.clear();
    board.receive(NOMINAL, 0x681, &[1, 1]);
    assert_eq!(board.frames(), [(NOMINAL, frame(0x680, &[2, 0]))], "where the other master is");
    board.run_until(ms(1_600));
    assert!(board.times(REDUNDANT, 0x701).contains(&1_600));
}

/// Given an active master, then it claims with each heartbeat on both buses that it is active: the other board may be cut off from
/// either. A foreign 701h there changes nothing.
///
/// Verifies: ECSS 8.3.3a
/// Notices: ECSS 8.3.3a: an active master sends its heartbeat on both buses.
#[test]
fn an_active_master_says_so_on_both_buses_with_each_heartbeat() {
    let mut board = taken_over();
    board.clear();
    for beat in 15..20 {
        board.receive(Bus::ALL[beat as usize % 2], 0x701, &[0x05]);
        board.receive(REDUNDANT, 0x702, &[0x05]);
        board.run_until(ms(100 * beat));
    }
    let expected = [1_500, 1_600, 1_700, 1_800, 1_900];
    assert_eq!(board.times(NOMINAL, 0x680), expected);
    assert_eq!(board.times(REDUNDANT, 0x680), expected);
    assert_eq!(board.times(REDUNDANT, 0x701), expected);
    assert_eq!(board.times(NOMINAL, 0x701), []);
}

/// Given two master boards, then neither claims by the time stamp object (100h), the active one sends none, and no controller admits it.
///
/// Verifies: ECSS 9.4.7.1b, 7.2.3f, 11.1c
/// Notices: ECSS 9.4.7.1b: the claims of the prime master board have COB-ID 100h.
/// Notices: ECSS 11.1c: a controller of a master board admits time stamps.
#[test]
fn no_board_of_two_takes_or_sends_time_stamps() {
    assert!(Profile::PAIR.both_claims().iter().all(|claims| claims.raw() != 0x100));
    let mut board = taken_over();
    board.run_until(ms(2_000));
    for bus in Bus::ALL {
        assert_eq!(board.times(bus, 0x100), []);
        assert!(!board.admits(bus, 0x100));
    }
}

/// Given an active master, when another one sends heartbeats on the active bus and claims nothing, then the collision is reported with
/// the number of that bus, once.
///
/// Verifies: ECSS 6.4a.2, 6.10m
/// Notices: ECSS 6.10m: the collision on the redundant bus is reported for the nominal bus.
#[test]
fn heartbeats_without_a_claim_are_a_collision_and_move_no_board() {
    let mut board = taken_over();
    board.clear();
    for beat in 0..5 {
        board.receive(REDUNDANT, 0x701, &[0x05]);
        board.run_until(ms(1_450 + 100 * beat));
    }
    assert!(board.events.contains(&MasterEvent::SecondMaster { bus: REDUNDANT }));
    let emergencies: Vec<_> =
        board.frames().into_iter().filter(|(_, sent)| sent.id().raw() == 0x081).collect();
    let collision = frame(0x081, &[0x50, 0x81, 0x11, 1, 0, 0, 0, 0]);
    assert_eq!(emergencies, [(REDUNDANT, collision)]);
    assert_eq!(board.controls, []);
    assert_eq!(board.times(REDUNDANT, 0x680), [1_500, 1_600, 1_700, 1_800], "with its heartbeat alone");
}

/// Verifies: ECSS 8.1b
/// Notices: ECSS 8.1b: commands that wait when a master becomes the standby are sent all the same.
#[test]
fn commanded_standby_is_silent_then_takes_over_if_no_other_does() {
    let mut board = taken_over();
    board.clear();
    board.request(MasterRequest::StandBy);
    assert_eq!((board.frames(), &board.controls[..]), (vec![], &LISTENS[..]));
    board.run_until(ms(1_799));
    assert_eq!(board.frames(), []);
    board.run_until(ms(1_800));
    assert_eq!(board.frames()[0], (REDUNDANT, frame(0x701, &[0])));
}

/// Given an active board with a Ctoggle of 3, when it stood by and takes over again, then its search is a new one, and 2000h shows a
/// Ctoggle of zero.
///
/// Verifies: ECSS 8.3.1b
/// Notices: ECSS 8.3.1b: 2000h of a board that takes over shows the Ctoggle of its search before.
#[test]
fn ctoggle_of_a_board_that_takes_over_again_reads_zero() {
    let mut board = taken_over();
    assert_eq!(board.write((0x2000, 4), &[3]), Ok(()));
    let ctoggle = |board: &Board| board.node.objects().extension.redundancy.parameters.ctoggle;
    assert_eq!(ctoggle(&board), 3);
    board.request(MasterRequest::StandBy);
    board.run_until(ms(1_800));
    assert_eq!((ctoggle(&board), board.node.status(board.now).redundancy.ctoggle), (0, 0));
}

#[test]
fn the_role_stands_in_2045h() {
    let read = |board: &Board| {
        let role = board.node.objects().application.network.role;
        (role.role, role.strap, role.taken)
    };
    assert_eq!(read(&powered(Strap::Second)), (0, 1, 0));
    assert_eq!(read(&standing_by()), (1, 0, 0));
    let mut board = taken_over();
    assert_eq!(read(&board), (2, 0, 1));
    board.request(MasterRequest::StandBy);
    board.run_until(ms(1_800));
    assert_eq!(read(&board), (2, 0, 2));
    assert_eq!(console::master(&STANDARD).objects().application.network.role.role, 2);
}

#[test]
fn filters_admit_what_another_master_sends() {
    let board = powered(Strap::Prime);
    let filters = board.node.filters();
    for raw in [0x680, 0x681, 0x701, 0x181, 0x080] {
        let id = ecss_can::types::CobId::new(raw).unwrap();
        assert!(filters.iter().any(|filter| filter.admits(id)), "{raw:03X}h");
    }
}
