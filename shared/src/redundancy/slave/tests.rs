//! Order of the decisions of a slave's redundancy.

extern crate std;

use std::vec::Vec;

use super::action::MOST;
use super::{
    BusCause, Retained, SlaveAction as Action, SlaveActions, SlaveRedundancy, SlaveStep,
    SlaveVerdict as Verdict,
};
use crate::emcy::ErrorCode;
use crate::heartbeat;
use crate::heartbeat::machine::NodeControl;
use crate::link::access::BusAccess;
use crate::nmt::machine::Reaction;
use crate::nmt::{Command, NmtMessage, Target};
use crate::redundancy::Parameters;
use crate::types::{Bus, Canonical, CobId, Duration, Frame, Instant, NmtState, NodeId, PerBus};

const ID: NodeId = NodeId::of::<5>();
/// Consumer time 250 ms. Ttoggle 1: the first change of the bus is due with the miss. Ntoggle 1: a search ends after 500 ms.
const PARAMETERS: Parameters = Parameters {
    consumer: Duration::from_millis(250),
    producer: Duration::from_millis(100),
    bdefault: Bus::Nominal,
    ttoggle: 1,
    ntoggle: 1,
    ctoggle: 0,
};
const WARNING_TIME: Duration = Duration::from_millis(2);
const MISSED: Action = Action::Raise { code: ErrorCode::HEARTBEAT, source: 1 };
const FOUND: Action = Action::Clear { code: ErrorCode::HEARTBEAT, source: 1 };

fn ms(ms: u64) -> Instant {
    Instant::ZERO + Duration::from_millis(ms)
}

fn of_master() -> Frame {
    heartbeat::encode(NodeId::MASTER, NmtState::Operational)
}

fn command(command: Command) -> Frame {
    NmtMessage { command, target: Target::All }.encode()
}

/// A slave and its node, which records the actions that it carries out.
struct Bench {
    slave: SlaveRedundancy,
    control: NodeControl,
    actions: Vec<Action>,
    /// Most actions of one step.
    most: usize,
}

impl Bench {
    /// A slave that booted at 0 ms on the nominal bus.
    fn new(access: BusAccess) -> Bench {
        let mut bench = Bench {
            slave: SlaveRedundancy::new(access, PARAMETERS, Retained::default(), WARNING_TIME),
            control: NodeControl::new(ID, PARAMETERS.producer, Duration::ZERO, false),
            actions: Vec::new(),
            most: 0,
        };
        assert_eq!(bench.boot(0), Bus::Nominal);
        bench
    }

    /// Returns the bus of the boot-up message.
    fn boot(&mut self, at: u64) -> Bus {
        self.control.boot(ms(at));
        self.slave.boot(PARAMETERS, ms(at))
    }

    /// A slave in Operational that heard its master at 10 ms.
    fn operational() -> Bench {
        let mut bench = Bench::new(BusAccess::Parallel);
        bench.receive(Bus::Nominal, &of_master(), 10);
        bench.receive(Bus::Nominal, &command(Command::Start), 10);
        assert_eq!(bench.control.state(), NmtState::Operational);
        bench.actions.clear();
        bench
    }

    fn poll(&mut self, at: u64) -> Vec<Action> {
        while self.decide(at, |slave, step| slave.poll(ms(at), step)) {}
        self.actions()
    }

    fn receive(&mut self, bus: Bus, frame: &Frame, at: u64) -> Verdict {
        let verdict = self.slave.on_usual_frame(bus, frame, ms(at), &self.control);
        verdict
            .unwrap_or_else(|| self.decide(at, |slave, step| slave.on_rare_frame(bus, frame, ms(at), step)))
    }

    fn decide<R>(&mut self, at: u64, decide: impl FnOnce(&mut SlaveRedundancy, &mut SlaveStep) -> R) -> R {
        let mut actions = SlaveActions::new();
        let mut step = SlaveStep::new(ms(at), &self.control, PerBus::default(), &mut actions);
        let result = decide(&mut self.slave, &mut step);
        self.most = self.most.max(actions.len());
        for action in actions {
            self.carry_out(&action, at);
            self.actions.push(action);
        }
        result
    }

    fn carry_out(&mut self, action: &Action, at: u64) {
        match *action {
            Action::Obey(command) => {
                let reaction = self.control.on_command(command, ms(at));
                if reaction == Reaction::ResetCommunication {
                    self.boot(at);
                }
            }
            Action::EnterPreOperational => _ = self.control.on_master_missed(),
            Action::FallSilent { .. } => _ = self.control.fall_silent(),
            Action::Announce => self.control.announce(ms(at)),
            _ => {}
        }
    }

    /// The actions since the last call, but those that show the parameters.
    fn actions(&mut self) -> Vec<Action> {
        self.actions.drain(..).filter(|action| *action != Action::ShowParameters).collect()
    }
}

/// Given a slave in Operational, when the master is missed, then the slave reports it, enters Pre-operational and
/// changes the bus only when the EMCY was sent.
///
/// Verifies: ECSS 8.3.3e, 8.3.3e.1, 8.3.3e.2
/// Notices: ECSS 8.3.3e.1: a slave enters Pre-operational with the change of the bus, not with the miss.
#[test]
fn first_change_of_the_bus_waits_for_the_warning() {
    let toggled = Action::ActiveBus { bus: Bus::Redundant, cause: BusCause::Toggled, is_new: true };
    let missed = [Action::MasterMissed { bus: Bus::Nominal }, MISSED, Action::EnterPreOperational];
    let [low, high] = ErrorCode::HEARTBEAT.get().to_le_bytes();
    let warning = Frame::of(CobId::emcy(ID), [low, high, 0x11, 1, 0, 0, 0, 0]);
    for end in ["sent", "failed", "none"] {
        let mut bench = Bench::operational();
        assert_eq!(bench.poll(260), missed);
        assert_eq!((bench.poll(261), bench.slave.deadline()), (Vec::new(), Some(ms(262))), "{end}");
        match end {
            "sent" => bench.slave.on_sent(&warning, ms(261), ID),
            "failed" => bench.slave.on_end(&warning),
            _ => assert_eq!(bench.poll(261), []),
        }
        let expected = [Action::EnterPreOperational, Action::Announce, toggled];
        assert_eq!(bench.poll(if end == "none" { 262 } else { 261 }), expected, "{end}");
    }
}

/// Given a slave in Operational that has worked for a while, when it hears another node with its Node-ID and then misses the
/// master while that clash lasts, then it enters Pre-operational and changes the bus as without a clash.
///
/// Verifies: ECSS 8.3.3e, 8.3.3e.1, 8.3.3e.2
/// Notices: ECSS 8.3.3e: the elder of a clash stays Operational when it misses the master.
#[test]
fn elder_of_a_clash_that_misses_the_master_is_pre_operational() {
    let mut bench = Bench::operational();
    bench.receive(Bus::Nominal, &of_master(), 200);
    // After its probation of a consumer time.
    bench.receive(Bus::Nominal, &heartbeat::encode(ID, NmtState::Operational), 300);
    let clash = Action::Raise { code: ErrorCode::CAN_ID_COLLISION, source: 5 };
    assert_eq!(bench.actions(), [Action::Clash { bus: Bus::Nominal, yields: false }, clash]);
    assert_eq!(bench.poll(449), []);
    let missed = [Action::MasterMissed { bus: Bus::Nominal }, MISSED, Action::EnterPreOperational];
    assert_eq!(bench.poll(450), missed);
    assert_eq!(bench.control.state(), NmtState::PreOperational);
    let toggled = Action::ActiveBus { bus: Bus::Redundant, cause: BusCause::Toggled, is_new: true };
    assert_eq!(bench.poll(452), [Action::EnterPreOperational, Action::Announce, toggled]);
}

#[test]
fn other_frames_do_not_end_the_warning() {
    let mut bench = Bench::operational();
    bench.poll(260);
    bench.slave.on_sent(&heartbeat::encode(ID, NmtState::PreOperational), ms(261), ID);
    bench.slave.on_end(&Frame::of(CobId::emcy(ID), [0, 0, 0, 0, 0, 0, 0, 0]));
    assert_eq!(bench.poll(261), []);
}

/// Given a slave that missed the master, when the master is heard again on the same bus, then search and error end.
///
/// Verifies: ECSS 5.3.3.2.3j, 5.3.3.2.3k.2, 8.3.3k
/// Notices: ECSS 5.3.3.2.3j: a slave never ends its report that it missed the master.
/// Notices: ECSS 5.3.3.2.3k.2: the error of the missed master stays when it is heard again on the same bus.
#[test]
fn heartbeat_of_the_master_ends_warning_and_search() {
    let mut bench = Bench::operational();
    bench.poll(260);
    assert_eq!(bench.receive(Bus::Nominal, &of_master(), 261), Verdict::Heard);
    let found = Action::ActiveBus { bus: Bus::Nominal, cause: BusCause::Found, is_new: false };
    assert_eq!(bench.actions(), [FOUND, found]);
    assert_eq!((bench.poll(262), bench.slave.deadline()), (Vec::new(), Some(ms(511))));
}

/// Given a searching slave, when "reset communication" arrives on the other bus, then the slave changes the bus first, so
/// that its boot-up message is on the bus of the master.
///
/// Verifies: ECSS 6.5.3a, 8.3.3g, 6.5.1a.5
/// Notices: ECSS 6.5.3a: the boot-up message after a reset is sent on Bdefault.
#[test]
fn bus_of_a_reset_is_changed_to_before_it_is_obeyed() {
    let mut bench = Bench::new(BusAccess::Parallel);
    assert_eq!(bench.receive(Bus::Redundant, &command(Command::ResetCommunication), 20), Verdict::Taken);
    let expected = [
        Action::Announce,
        Action::ActiveBus { bus: Bus::Redundant, cause: BusCause::Found, is_new: true },
        Action::Retain(Retained { resets: 1, ..Retained::default() }),
        Action::Obey(Command::ResetCommunication),
    ];
    assert_eq!(bench.actions(), expected);
    assert_eq!(bench.boot(20), Bus::Redundant);
}

/// Verifies: ECSS 6.5.1a.4
#[test]
fn a_reset_of_the_chip_is_counted_before_it_happens() {
    let mut bench = Bench::new(BusAccess::Parallel);
    assert_eq!(bench.receive(Bus::Nominal, &command(Command::ResetNode), 20), Verdict::Taken);
    let counted = Action::Retain(Retained { resets: 1, ..Retained::default() });
    assert_eq!(bench.actions()[1..], [counted, Action::Obey(Command::ResetNode)]);
    // The event may be lost: it is repeated until the chip is reset.
    assert_eq!(bench.receive(Bus::Nominal, &of_master(), 30), Verdict::Ignored);
    assert_eq!(bench.actions(), [Action::WaitForReset]);
}

/// Given three resets in a row that were obeyed, when a fourth arrives on the other bus, then it neither resets the slave
/// nor ends its search there.
///
/// Verifies: ECSS 6.5.1a.5
#[test]
fn an_ignored_reset_does_not_move_the_slave() {
    let mut bench = Bench::new(BusAccess::Parallel);
    for at in [20, 40, 60] {
        assert_eq!(bench.receive(Bus::Nominal, &command(Command::ResetCommunication), at), Verdict::Taken);
    }
    bench.actions();
    let reset = Command::ResetCommunication;
    assert_eq!(bench.receive(Bus::Redundant, &command(reset), 80), Verdict::Ignored);
    let reported = [
        Action::Raise { code: ErrorCode::COMMUNICATION, source: reset as u8 },
        Action::ResetIgnored { bus: Bus::Redundant, command: reset },
    ];
    assert_eq!((bench.actions(), bench.slave.selected()), (reported.to_vec(), Bus::Nominal));
}

/// Given a slave that just booted, when it hears another node with its Node-ID, then it reports that while its state still
/// allows an EMCY, is stopped, and no command but a reset changes that until the other node was silent.
#[test]
fn a_newcomer_reports_the_clash_before_it_is_stopped() {
    let mut bench = Bench::new(BusAccess::Parallel);
    bench.slave.on_sent(&heartbeat::encode(ID, NmtState::Initialising), ms(0), ID);
    assert_eq!(
        bench.receive(Bus::Nominal, &heartbeat::encode(ID, NmtState::Operational), 50),
        Verdict::Taken
    );
    let clash = Action::Raise { code: ErrorCode::CAN_ID_COLLISION, source: 5 };
    assert_eq!(bench.slave.deadline(), Some(Instant::ZERO));
    let expected =
        [Action::Clash { bus: Bus::Nominal, yields: true }, clash, Action::FallSilent { bus: Bus::Nominal }];
    assert_eq!(bench.poll(50), expected);
    assert_eq!(bench.control.state(), NmtState::Stopped);
    assert_eq!(bench.control.deadline(), None, "no heartbeat");
    bench.receive(Bus::Nominal, &of_master(), 60);
    assert_eq!(bench.receive(Bus::Nominal, &command(Command::Start), 60), Verdict::Ignored);
    bench.actions();
    let over = [
        Action::Clear { code: ErrorCode::CAN_ID_COLLISION, source: 5 },
        Action::ClashOver,
        Action::EnterPreOperational,
        Action::Announce,
    ];
    assert_eq!(bench.poll(300), over);
    assert_eq!(bench.control.deadline(), Some(ms(300)));
}

/// Given a slave whose boot-up message waits for an acknowledgement, when it hears another node with its Node-ID, then it continues to
/// send the boot-up message. Once that was sent, it reports the clash and is silent.
#[test]
fn a_newcomer_is_silent_after_its_boot_up_message() {
    let heard = |state| (state, heartbeat::encode(ID, state));
    for (state, frame) in [heard(NmtState::Operational), heard(NmtState::Initialising)] {
        let mut bench = Bench::new(BusAccess::Parallel);
        bench.receive(Bus::Nominal, &frame, 1);
        let clash = Action::Raise { code: ErrorCode::CAN_ID_COLLISION, source: 5 };
        assert_eq!(bench.poll(1), [Action::Clash { bus: Bus::Nominal, yields: true }, clash], "{state:?}");
        assert_eq!(
            bench.control.poll(bench.control.deadline().unwrap()),
            Some(heartbeat::encode(ID, NmtState::Initialising))
        );
        bench.control.on_sent(&heartbeat::encode(ID, NmtState::Initialising));
        bench.slave.on_sent(&heartbeat::encode(ID, NmtState::Initialising), ms(51), ID);
        assert_eq!(bench.slave.deadline(), Some(Instant::ZERO));
        assert_eq!(bench.poll(51), [Action::FallSilent { bus: Bus::Nominal }], "{state:?}");
        assert_eq!((bench.control.state(), bench.control.deadline()), (NmtState::Stopped, None));
    }
}

/// Given a slave above its budget, when the master starts it, then the slave stays in Pre-operational until the silence
/// ends with a boot-up.
///
/// Verifies: ECSS 5.3.3.1b, 6.5.1a.1
#[test]
fn a_silenced_slave_is_not_started() {
    let mut bench = Bench::operational();
    bench.decide(15, |slave, step| slave.silence(step));
    assert_eq!(bench.actions(), [Action::EnterPreOperational]);
    assert_eq!(bench.receive(Bus::Nominal, &command(Command::Start), 20), Verdict::Ignored);
    bench.slave.resume();
    assert_eq!((bench.boot(30), bench.actions()), (Bus::Nominal, Vec::new()));
    assert_eq!(bench.receive(Bus::Nominal, &command(Command::Start), 40), Verdict::Taken);
    assert_eq!(bench.control.state(), NmtState::Operational);
}

/// Verifies: ECSS 8.2.3a
#[test]
fn a_chosen_bus_is_searched_first_in_pre_operational() {
    let mut bench = Bench::new(BusAccess::Selective);
    bench.receive(Bus::Nominal, &of_master(), 10);
    bench.receive(Bus::Nominal, &command(Command::Start), 10);
    bench.actions();
    assert!(bench.slave.choose(Bus::Redundant));
    let expected = [
        Action::EnterPreOperational,
        Action::Announce,
        Action::ActiveBus { bus: Bus::Redundant, cause: BusCause::Selected, is_new: true },
    ];
    assert_eq!(bench.poll(20), expected);
    assert_eq!(bench.slave.deadline(), Some(ms(270)));
}

#[test]
fn with_parallel_access_no_bus_is_chosen() {
    let mut bench = Bench::operational();
    assert!(!bench.slave.choose(Bus::Redundant));
    assert_eq!((bench.poll(20), bench.slave.selected()), (Vec::new(), Bus::Nominal));
}

/// Verifies: ECSS 8.2.1a.1
/// Notices: ECSS 8.2.1a.1: a slave with selective access hears its master on the bus that it is not on.
#[test]
fn a_slave_with_selective_access_ignores_the_bus_it_left() {
    let mut bench = Bench::new(BusAccess::Selective);
    assert_eq!(bench.receive(Bus::Redundant, &of_master(), 20), Verdict::Ignored);
    assert_eq!((bench.actions(), bench.slave.selected()), (Vec::new(), Bus::Nominal));
}

/// Given any sequence of frames and polls, when an input causes no action, then nothing is due earlier than
/// before: a node that computes its next deadline after actions alone misses none.
#[test]
fn nothing_becomes_due_earlier_without_an_action() {
    let frames = [
        of_master(),
        heartbeat::encode(ID, NmtState::Operational),
        heartbeat::encode(NodeId::of::<6>(), NmtState::Operational),
        command(Command::Start),
        command(Command::Stop),
        command(Command::EnterPreOperational),
        command(Command::ResetCommunication),
        Frame::of(CobId::NMT, [1, 9]),
        Frame::of(CobId::NMT, [2, 9]),
    ];
    let mut random: u32 = 1;
    let mut below = |end: u32| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 8) % end
    };
    for _ in 0..500 {
        let (mut bench, mut at) = (Bench::new(BusAccess::Parallel), 0);
        for step in 0..100 {
            at += u64::from(if below(8) == 0 { 600 } else { below(60) });
            bench.poll(at);
            let due = bench.slave.deadline().unwrap_or(Instant::NEVER);
            let bus = if below(4) == 0 { Bus::Redundant } else { Bus::Nominal };
            let frame = frames[below(frames.len() as u32) as usize];
            bench.receive(bus, &frame, at);
            if bench.actions().is_empty() {
                let after = bench.slave.deadline().unwrap_or(Instant::NEVER);
                assert!(after >= due, "step {step}: {frame:?} on {bus:?} at {at} ms");
            }
        }
        assert!(bench.most < MOST, "{} actions in one step", bench.most);
    }
}

impl Bench {
    /// The canonical form at `now`. `received`: frames received on each bus.
    fn canonical(&self, now: u64, received: PerBus<u32>) -> SlaveRedundancy {
        let mut slave = self.slave.clone();
        slave.canonical(ms(now), &received);
        slave
    }
}

/// Given slaves that booted at 0 and at 100 ms, when the second one is no newcomer any more, after the consumer time, then
/// they are alike.
#[test]
fn a_canonical_slave_forgets_its_boot_after_the_probation() {
    let (mut first, mut second) = (Bench::new(BusAccess::Parallel), Bench::new(BusAccess::Parallel));
    second.boot(100);
    for bench in [&mut first, &mut second] {
        bench.receive(Bus::Nominal, &of_master(), 200);
    }
    let forms = |now| [&first, &second].map(|bench| bench.canonical(now, PerBus::default()));
    let [one, other] = forms(349);
    assert_ne!(one, other);
    let [one, other] = forms(350);
    assert_eq!(one, other);
}

/// Given contradicting heartbeats of a master, then it counts whether frames of its services came since, not how many.
#[test]
fn a_canonical_slave_keeps_where_the_master_worked() {
    let mut bench = Bench::new(BusAccess::Parallel);
    for (bus, at) in [(Bus::Nominal, 10), (Bus::Redundant, 20), (Bus::Nominal, 40)] {
        bench.receive(bus, &of_master(), at);
    }
    // The node received none until now.
    let received = |redundant| bench.canonical(50, PerBus { nominal: 0, redundant });
    assert_eq!(received(5), received(8));
    assert_ne!(received(5), received(0));
}
