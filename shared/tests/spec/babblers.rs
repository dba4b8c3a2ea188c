//! Slaves that send too much, as the master sees them.
//!
//! Verifies: ECSS 5.3.3.1b

use ecss_can::link::budget::{BudgetPolicy, Rate};
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::{MasterEvent, MasterRequest};
use ecss_can::profile::Profile;
use ecss_can::redundancy::BabblingStep;
use ecss_can::redundancy::machine::Babblers;
use ecss_can::types::{Bus, Instant, NmtState};

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, frame, ms, node, span};
use crate::instrument::STANDARD;
use crate::master_device;

/// Four frames at once, a new one each 10 ms.
const RATE: Rate = Rate::new(4, 100);

/// A frame each millisecond from `from` to `until`; what was done, and when.
fn babble(babblers: &mut Babblers, from: u64, until: u64) -> Vec<(u64, BabblingStep)> {
    let steps = (from..until).map(|at| (at, babblers.on_frame(node(5), false, ms(at))));
    steps.filter_map(|(at, step)| Some((at, step?))).collect()
}

/// Notices: ECSS 5.3.3.1b: a slave that babbles on is stopped again and never reset.
#[test]
fn a_slave_that_babbles_on_is_stopped_reset_and_left() {
    let mut babblers = Babblers::new(RATE, span(20_000));
    assert_eq!(babblers.deadline(), None);
    let steps = babble(&mut babblers, 0, 3_000);
    assert_eq!(
        steps.iter().map(|(_, step)| *step).collect::<Vec<_>>(),
        [BabblingStep::Stopped, BabblingStep::Reset, BabblingStep::BusLeft]
    );
    // The fifth frame. Closed for 40 ms of each 44 from then on.
    assert_eq!(steps[0].0, 4);
    assert!((504..=510).contains(&steps[1].0) && (1_004..=1_020).contains(&steps[2].0), "{steps:?}");
    // Quiet.
    let last = babblers.deadline().unwrap() - span(10_000);
    assert!(last <= ms(2_999) && last > ms(2_990));
    assert_eq!(babblers.poll(last + span(9_999)), None);
    assert_eq!(babblers.poll(last + span(10_000)), Some((node(5), false)));
    assert_eq!((babblers.poll(last + span(10_000)), babblers.deadline()), (None, None));
    // Again: the bus was left 13 s ago, which is less than a dwell.
    let again: Vec<_> = babble(&mut babblers, 13_000, 16_000).into_iter().map(|(_, step)| step).collect();
    assert_eq!(again, [BabblingStep::Stopped, BabblingStep::Reset]);
    assert!(
        (21_000..21_050).contains(&babble(&mut babblers, 20_000, 23_000)[0].0),
        "a dwell after the last time"
    );
}

#[test]
fn slaves_within_their_rate_are_left_alone() {
    let mut babblers = Babblers::new(RATE, span(20_000));
    for at in 0..1_000 {
        for other in 2..=127 {
            assert_eq!(babblers.on_frame(node(other), false, ms(10 * at)), None);
        }
    }
}

/// The application knows what it does: a slave that babbles after a command of it is stopped anew.
#[test]
fn a_command_of_the_application_ends_a_case() {
    let mut babblers = Babblers::new(RATE, span(20_000));
    babble(&mut babblers, 0, 100);
    assert_eq!(babblers.on_commanded(Target::Node(node(6))), None);
    assert_eq!(babblers.on_commanded(Target::All), Some(node(5)));
    assert_eq!((babblers.on_commanded(Target::All), babblers.deadline()), (None, None));
    assert_eq!(babble(&mut babblers, 200, 300)[0].1, BabblingStep::Stopped);
}

/// Four at the same time: the fifth has its turn when one of them is quiet.
#[test]
fn the_fifth_babbler_waits() {
    let mut babblers = Babblers::new(RATE, span(20_000));
    let mut at_once = |raw, at| (0..5).filter_map(|_| babblers.on_frame(node(raw), raw == 3, at)).count();
    assert_eq!((2..=7).map(|raw| at_once(raw, ms(0))).collect::<Vec<_>>(), [1, 1, 1, 1, 0, 0]);
    let mut quiet: Vec<_> = std::iter::from_fn(|| babblers.poll(ms(10_000))).collect();
    quiet.sort_unstable();
    assert_eq!(quiet, [(node(2), false), (node(3), true), (node(4), false), (node(5), false)]);
    assert!((0..5).any(|_| babblers.on_frame(node(6), false, ms(10_000)) == Some(BabblingStep::Stopped)));
}

const HEARD: Profile = Profile { budget: BudgetPolicy { heard: RATE, ..STANDARD.budget }, ..STANDARD };

/// Slave 5 is Operational.
fn flying() -> Bench<Master> {
    let mut master = master_device::powered(&HEARD);
    master.transmitted(NOMINAL, frame(0x701, &[5]));
    master.receive(NOMINAL, 0x705, &[5]);
    master.receive(NOMINAL, 0x585, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    master.clear();
    master
}

fn emergency(master: &mut Bench<Master>) {
    master.receive(NOMINAL, 0x085, &[0, 0x10, 1, 0, 0, 0, 0, 0]);
}

/// NMT commands that were sent.
fn commands(master: &Bench<Master>) -> Vec<Vec<u8>> {
    let all = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0);
    all.map(|sent| sent.frame.data().to_vec()).collect()
}

/// Time passes with the heartbeats of slave 5, in this state.
fn with_slave(master: &mut Bench<Master>, until: Instant, state: NmtState) {
    while master.now < until {
        master.run_until((master.now + span(100)).min(until));
        master.receive(NOMINAL, 0x705, &[state.byte()]);
    }
}

fn babbling(step: BabblingStep) -> MasterEvent {
    MasterEvent::Babbling { node: node(5), step }
}

/// Given a slave that babbles until it is stopped, then it stays so, though it says so with each heartbeat, until it was quiet
/// for 10 s. Then it is started as any other.
#[test]
fn a_slave_that_was_stopped_because_it_babbled_is_held() {
    let mut master = flying();
    (0..6).for_each(|_| emergency(&mut master));
    assert_eq!(commands(&master), [[2, 5]]);
    assert!(master.events.contains(&babbling(BabblingStep::Stopped)));
    assert_eq!(master_device::read(&mut master, 0x1003, 1), 0x0005_8000, "EMCY 8000h, node 5");
    let last = master.now;
    master.clear();
    with_slave(&mut master, last + span(9_900), NmtState::Stopped);
    assert!(commands(&master).is_empty(), "not started unasked");
    master.run_until(last + span(10_000));
    assert!(master.events.contains(&babbling(BabblingStep::Quiet)));
    master.receive(NOMINAL, 0x705, &[NmtState::Stopped.byte()]);
    assert_eq!(commands(&master), [[1, 5]]);
    assert_eq!(master_device::read(&mut master, 0x1001, 0) & 0xFF, 0);
}

#[test]
fn the_application_may_start_a_babbler() {
    let mut master = flying();
    (0..6).for_each(|_| emergency(&mut master));
    let start = NmtMessage { command: Command::Start, target: Target::Node(node(5)) };
    master.request(MasterRequest::Nmt(start));
    assert_eq!(commands(&master), [[2, 5], [1, 5]]);
    assert!(master.events.contains(&babbling(BabblingStep::Quiet)));
    master.run_until(master.now + span(40));
    master.receive(NOMINAL, 0x705, &[NmtState::PreOperational.byte()]);
    assert_eq!(commands(&master)[2..], [[1, 5]], "and it is not held");
}

/// Given a network on either bus, when a slave babbles on that bus, then the master stops it there.
///
/// Notices: ECSS 5.3.3.1b: slaves are not watched while the redundant bus is the active one.
#[test]
fn a_babbler_is_stopped_on_whichever_bus_is_active() {
    for bus in Bus::ALL {
        let mut master = master_device::powered(&Profile { bdefault: bus, ..HEARD });
        master.transmitted(bus, frame(0x701, &[5]));
        master.receive(bus, 0x705, &[5]);
        master.receive(bus, 0x585, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
        master.clear();
        (0..6).for_each(|_| master.receive(bus, 0x085, &[0, 0x10, 1, 0, 0, 0, 0, 0]));
        assert_eq!(commands(&master), [[2, 5]], "{bus:?}");
        assert!(master.events.contains(&babbling(BabblingStep::Stopped)), "{bus:?}");
    }
}

/// One foreign sender must not move a network.
#[test]
fn a_foreign_node_that_babbles_decides_nothing() {
    let mut master = flying();
    (0..50).for_each(|_| master.receive(NOMINAL, 0x7F0, &[5]));
    assert!(commands(&master).is_empty());
}

/// What it does on the other bus disturbs nobody, and SDO may be another client's.
#[test]
fn the_other_bus_and_sdo_do_not_count() {
    let mut master = flying();
    for _ in 0..20 {
        master.receive(REDUNDANT, 0x085, &[0, 0x10, 1, 0, 0, 0, 0, 0]);
        master.receive(NOMINAL, 0x585, &[0x43, 0, 0x10, 0, 0, 0, 0, 0]);
    }
    assert!(commands(&master).is_empty());
    (0..6).for_each(|_| emergency(&mut master));
    assert_eq!(commands(&master), [[2, 5]]);
}
