//! The mock board and the mock spacecraft: ports, clock, tasks, both buses.

use std::cell::Cell;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use ecss_can::heartbeat::HeartbeatProducer;
use ecss_can::link::Stamp;
use ecss_can::link::port::{Busy, CanPort, ErrorState, Filter, Health, LastError, Mailbox, PortEvent};
use ecss_can::mock::{LoopbackPort, ManualClock, MockSpacecraft, SentFrame, Tasks};
use ecss_can::prelude::*;
use ecss_can::runner::Clock;
use ecss_can::types::FineInstant;

#[derive(Debug, Objects)]
#[objects(device)]
struct Bare {}

impl Device for Bare {
    type Pdos = PdoObjects<0, 0>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::NONE;
}

const TWO: NodeId = NodeId::of::<2>();
const THREE: NodeId = NodeId::of::<3>();

fn at(ms: u64) -> Instant {
    Instant::ZERO + Duration::from_millis(ms)
}

fn frame(id: u16) -> Frame {
    Frame::of(CobId::new(id).unwrap(), [id as u8])
}

fn joined() -> LoopbackPort {
    let mut port = LoopbackPort::new(&ManualClock::new());
    port.set_filters(&[Filter::exact(CobId::SYNC)]);
    port.join();
    port
}

fn events(port: &mut LoopbackPort) -> Vec<PortEvent> {
    let mut context = Context::from_waker(Waker::noop());
    std::iter::from_fn(|| match port.poll_event(&mut context) {
        Poll::Ready(event) => Some(event),
        Poll::Pending => None,
    })
    .collect()
}

fn transmitted(number: u8) -> PortEvent {
    PortEvent::Transmitted { mailbox: Mailbox(number), stamp: Stamp::captured(FineInstant::from_units(0)) }
}

fn ids(sent: &[SentFrame]) -> Vec<(Bus, u16)> {
    sent.iter().map(|one| (one.bus, one.frame.id().raw())).collect()
}

fn slave(node: NodeId) -> Slave<Bare> {
    Slave::builder(node, &Profile::DEFAULT, Bare::default()).build()
}

fn master() -> Master<Bare> {
    Master::builder(&Profile::DEFAULT, Bare::default()).build()
}

/// Given a port, when frames follow each other before the node has taken an event, then each has a mailbox of its own, and the last
/// mailbox takes an urgent frame only. A mailbox is free again when its end was taken.
#[test]
fn a_mailbox_is_in_use_until_its_end_is_taken() {
    let mut port = joined();
    assert_eq!(port.send(&frame(0x382)), Ok(Mailbox(0)));
    assert_eq!(port.send(&frame(0x383)), Ok(Mailbox(1)));
    assert_eq!(port.send(&frame(0x384)), Err(Busy));
    assert_eq!(port.send(&frame(0x080)), Ok(Mailbox(2)));
    assert_eq!(port.send(&frame(0x080)), Err(Busy));
    assert_eq!(events(&mut port), [transmitted(0), transmitted(1), transmitted(2)]);
    assert_eq!(port.send(&frame(0x384)), Ok(Mailbox(0)));
    assert_eq!(port.sent(), [frame(0x382), frame(0x383), frame(0x080), frame(0x384)]);
}

#[test]
fn a_port_off_its_bus_neither_sends_nor_receives() {
    let mut port = joined();
    port.leave();
    assert_eq!(port.send(&frame(0x080)), Err(Busy));
    assert!(!port.receive(frame(0x080)));
    port.listen();
    assert_eq!(port.send(&frame(0x080)), Err(Busy));
    assert!(port.receive(frame(0x080)));
}

/// Given a cut bus, when the node sends, then the frame waits, and the controller is error passive without an acknowledgement. It
/// receives nothing. When the bus is mended, the frames go out in their order.
#[test]
fn frames_on_a_cut_bus_wait_until_it_is_mended() {
    let mut port = joined();
    port.cut();
    assert_eq!(port.health(), Health::default());
    assert_eq!(port.send(&frame(0x382)), Ok(Mailbox(0)));
    assert_eq!(port.send(&frame(0x080)), Ok(Mailbox(1)));
    let isolated = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };
    assert_eq!(events(&mut port), [PortEvent::Health(isolated)]);
    assert_eq!(port.health(), isolated);
    assert_eq!(port.sent(), []);
    assert!(!port.receive(frame(0x080)));

    port.mend();
    let active = PortEvent::Health(Health::default());
    assert_eq!(events(&mut port), [transmitted(0), transmitted(1), active]);
    assert_eq!(port.sent(), [frame(0x382), frame(0x080)]);
}

/// Given frames that wait on a cut bus, when one is aborted and the node leaves the bus, then each fails once, and none goes out when
/// the bus is mended.
#[test]
fn frames_that_are_aborted_fail_once() {
    let mut port = joined();
    port.cut();
    port.send(&frame(0x382)).unwrap();
    port.send(&frame(0x383)).unwrap();
    events(&mut port);
    port.abort(Mailbox(0));
    port.abort(Mailbox(0));
    assert_eq!(events(&mut port), [PortEvent::Failed { mailbox: Mailbox(0) }]);
    port.leave();
    assert_eq!(events(&mut port), [PortEvent::Failed { mailbox: Mailbox(1) }]);
    port.mend();
    assert_eq!((port.sent(), events(&mut port)), (vec![], vec![]));
}

/// Given two tasks with deadlines, when the first one comes, then the other task still waits, and is woken at its own.
#[test]
fn clock_wakes_each_task_at_its_deadline() {
    let (clock, done) = (ManualClock::new(), Rc::new(Cell::new(0)));
    let mut tasks = Tasks::default();
    for ms in [10, 30] {
        let (clock, done) = (clock.clone(), done.clone());
        tasks.spawn(async move {
            clock.at(at(ms)).await;
            done.set(ms);
        });
    }
    tasks.run();
    let mut steps = vec![];
    while let Some(deadline) = clock.deadline() {
        clock.advance(deadline.since(clock.now()));
        tasks.run();
        steps.push((deadline, done.get()));
    }
    assert_eq!(steps, [(at(10), 10), (at(30), 30)]);
}

/// Given two slaves with heartbeats each 100 ms, when a step has nothing to send, then time is at the next deadline, never beyond the
/// end. Each heartbeat is at its instant.
#[test]
fn time_advances_to_the_next_deadline() {
    let mut spacecraft = MockSpacecraft::new();
    spacecraft.power_on(|| slave(TWO));
    spacecraft.power_on(|| slave(THREE));
    let boot = [(Bus::Nominal, 0x702), (Bus::Nominal, 0x703)];
    assert_eq!(ids(&spacecraft.run_until(at(99))), boot);
    assert_eq!(spacecraft.now(), at(99));
    let heartbeats = spacecraft.run_until(at(150));
    assert_eq!(ids(&heartbeats), boot);
    assert!(heartbeats.iter().all(|sent| sent.at == at(100)));
}

/// Given a master on both buses, when it changes the bus by command, then its controllers are independent: what it gives up on the
/// bus that it leaves takes no frame from the queue of the other one, where its heartbeat goes out at that instant.
///
/// Verifies: ECSS 8.2.2a
/// Notices: ECSS 8.2.2a: what is given up on one bus is dropped from the queue of the other one too.
#[test]
fn frames_for_one_bus_outlive_those_that_the_other_gives_up() {
    let mut spacecraft = MockSpacecraft::new();
    let (master, _) = spacecraft.power_on(master);
    spacecraft.power_on(|| slave(TWO));
    spacecraft.run_until(at(1_050));
    for bus in [Bus::Redundant, Bus::Nominal] {
        let begin = spacecraft.now();
        master.switch_to(bus);
        let sent = spacecraft.run_until(begin + Duration::from_millis(50));
        let mut heartbeats = sent.iter().filter(|sent| sent.frame.id() == CobId::heartbeat(NodeId::MASTER));
        assert_eq!(heartbeats.next().map(|first| (first.bus, first.at)), Some((bus, begin)));
    }
}

/// Given a master and two slaves, when the master starts them, then its frames reach both, and theirs reach the master, but a slave
/// hears no frame of its own.
#[test]
fn a_frame_reaches_the_other_nodes_on_its_bus() {
    let mut spacecraft = MockSpacecraft::new();
    let (master, _) = spacecraft.power_on(master);
    let slaves = [TWO, THREE].map(|node| spacecraft.power_on(|| slave(node)).0);
    spacecraft.run_until(at(1_000));
    for (node, slave) in [TWO, THREE].into_iter().zip(slaves) {
        assert!(master.may_command(node));
        let counters = slave.status().counters;
        assert!(counters.nominal.received > 0);
        assert_eq!(counters.redundant.received, 0);
        assert_eq!(slave.status().health.nominal, Health::default());
    }
}

/// Given a master with a slave, when the nominal bus is cut, then no frame passes there any more, and both go on with the redundant
/// one within half a second. A node that is powered on later finds them there.
#[test]
fn nodes_go_on_with_the_redundant_bus_after_a_cut() {
    let mut spacecraft = MockSpacecraft::new();
    let (master, _) = spacecraft.power_on(master);
    let (two, _) = spacecraft.power_on(|| slave(TWO));
    let before = spacecraft.run_until(at(2_000));
    assert!(before.iter().any(|sent| (sent.bus, sent.frame.id().raw()) == (Bus::Nominal, 0x701)));
    assert!(before.iter().all(|sent| (sent.bus, sent.frame.id().raw()) != (Bus::Redundant, 0x701)));

    spacecraft.cut(Bus::Nominal);
    let after = spacecraft.run_until(at(2_500));
    assert!(after.iter().all(|sent| sent.bus == Bus::Redundant));
    assert!(after.iter().any(|sent| sent.frame.id().raw() == 0x701));
    assert_eq!(master.status().active, Bus::Redundant);
    assert_eq!(two.status().active, Bus::Redundant);

    let (three, _) = spacecraft.power_on(|| slave(THREE));
    let late = spacecraft.run_until(at(4_000));
    assert!(late.iter().all(|sent| sent.bus == Bus::Redundant));
    assert_eq!(three.status().active, Bus::Redundant);
    assert!(master.may_command(THREE));
}

/// Given a bus that was cut and mended before the master has left it, then heartbeats pass on it again.
#[test]
fn a_mended_bus_carries_frames_again() {
    let mut spacecraft = MockSpacecraft::new();
    let (master, _) = spacecraft.power_on(master);
    spacecraft.power_on(|| slave(TWO));
    spacecraft.run_until(at(2_000));
    spacecraft.cut(Bus::Nominal);
    spacecraft.run_until(at(2_001));
    spacecraft.mend(Bus::Nominal);
    let after = spacecraft.run_until(at(3_000));
    assert_eq!(master.status().active, Bus::Nominal);
    let heartbeats = after.iter().filter(|sent| sent.frame.id().raw() == 0x701);
    assert_eq!(heartbeats.map(|sent| sent.bus).collect::<Vec<_>>(), [Bus::Nominal; 10]);
}

/// An application that never waits would keep the test in one step.
#[test]
#[should_panic(expected = "tasks wake each other without end")]
fn tasks_that_wake_themselves_for_ever_are_a_panic() {
    let mut tasks = Tasks::default();
    tasks.spawn(std::future::poll_fn(|context| {
        context.waker().wake_by_ref();
        Poll::<()>::Pending
    }));
    tasks.run();
}

/// Given an application that reads an object of a slave, then it waits for the answer, and has it.
#[test]
fn an_application_reads_a_slave_by_sdo() {
    let mut spacecraft = MockSpacecraft::new();
    let (one, _) = spacecraft.power_on(master);
    spacecraft.power_on(|| slave(TWO));
    spacecraft.run_until(at(1_000));
    let read = Rc::new(Cell::new(None));
    let place = read.clone();
    spacecraft.spawn(async move {
        place.set(Some(one.sdo(TWO).read(HeartbeatProducer::TIME).await));
    });
    spacecraft.run_until(at(1_100));
    assert_eq!(read.take(), Some(Ok(100)));
}

/// Given an application that reads without a pause, then the test ends: frames take no time.
#[test]
#[should_panic(expected = "time stands still")]
fn an_application_that_never_waits_for_time_is_a_panic() {
    let mut spacecraft = MockSpacecraft::new();
    let (one, _) = spacecraft.power_on(master);
    spacecraft.power_on(|| slave(TWO));
    spacecraft.run_until(at(1_000));
    spacecraft.spawn(async move { while one.sdo(TWO).read(HeartbeatProducer::TIME).await.is_ok() {} });
    spacecraft.run_until(at(2_000));
}
