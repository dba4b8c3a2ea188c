//! The handles of nodes on a mock spacecraft, as applications use them.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::task::{Context, Wake, Waker};

use ecss_can::emcy::{ActiveError, Emergency};
use ecss_can::mock::{MockBoard, MockSpacecraft, SentFrame, poll_once};
use ecss_can::node::minimal::{MinimalDevice, MinimalPdos, MinimalSlave, Payload};
use ecss_can::prelude::*;
use ecss_can::runner::extend::WholeNode;

/// A heater whose power goes out when it changes (280h + node).
#[derive(Debug, Objects)]
#[objects(device)]
struct Heater {
    /// Power in percent
    #[object(0x6000, rw, pdo, high = 100)]
    power: u8,
}

impl Device for Heater {
    type Pdos = PdoObjects<1, 2>;
    type Consumers = HeartbeatConsumers<3>;
    const PDOS: PdoSet = PdoSet::new(&[], &[CHANGE.transmit(2)]);
}

type HeaterMaster = Handle<MockBoard, Master<Heater>>;
/// A command by name.
type Command = fn(HeaterMaster, Target);
type HeaterSlave = Handle<MockBoard, Slave<Heater>>;

const TWO: NodeId = NodeId::of::<2>();
const THREE: NodeId = NodeId::of::<3>();
/// Its power.
const CHANGE: Pdo<Heater, (u8,)> = Pdo::new(CobIdOf::node(0x280)).map(Heater::POWER);
/// A PDO that no heater lists.
const UNLISTED: Pdo<Heater, (u8,)> = Pdo::new(CobIdOf::node(0x480)).map(Heater::POWER);
/// A command to a heater.
const COMMAND: Pdo<Heater, (u8,)> = Pdo::new(CobIdOf::node(0x200)).map(Heater::POWER);
/// An error of a heater.
const BROKEN: DeviceError = DeviceError::new(ErrorCode::HARDWARE, 0x48);

fn at(ms: u64) -> Instant {
    Instant::ZERO + Duration::from_millis(ms)
}

/// A master, and slave 2 in Operational.
fn flying() -> (MockSpacecraft, HeaterMaster, HeaterSlave) {
    let mut spacecraft = MockSpacecraft::new();
    let (master, _) = spacecraft.power_on(|| Master::builder(&Profile::DEFAULT, Heater::default()).build());
    let slave = slave(&mut spacecraft, TWO);
    spacecraft.run_until(at(1_000));
    assert_eq!(master.slave_state(TWO), Some(NmtState::Operational));
    (spacecraft, master, slave)
}

fn slave(spacecraft: &mut MockSpacecraft, node: NodeId) -> HeaterSlave {
    spacecraft.power_on(|| Slave::builder(node, &Profile::DEFAULT, Heater::default()).build()).0
}

/// Runs for some milliseconds.
fn run(spacecraft: &mut MockSpacecraft, ms: u64) -> Vec<SentFrame> {
    spacecraft.run_until(spacecraft.now() + Duration::from_millis(ms))
}

fn data(sent: &[SentFrame], id: u16) -> Vec<Vec<u8>> {
    let sent = sent.iter().filter(|sent| sent.frame.id().raw() == id);
    sent.map(|sent| sent.frame.data().to_vec()).collect()
}

/// Given an update of an object, then its PDO goes out in that step, once, and the same value sends none. A read returns the value and
/// sends none.
#[test]
fn update_sends_the_pdo_whose_content_changed() {
    let (mut spacecraft, _, slave) = flying();
    slave.update(|heater| heater.power = 40);
    assert_eq!(data(&spacecraft.step(at(1_000)), 0x282), [[40]]);
    slave.update(|heater| heater.power = 40);
    assert_eq!(slave.read(|heater| heater.power), 40);
    assert!(data(&run(&mut spacecraft, 50), 0x282).is_empty());
}

/// Given an update that sends a PDO, then it goes out once whether its content has changed or not.
#[test]
fn send_with_sends_the_pdo_once() {
    let (mut spacecraft, _, slave) = flying();
    for power in [40, 40, 50] {
        slave.send_with(CHANGE, |heater| heater.power = power);
        assert_eq!(data(&run(&mut spacecraft, 10), 0x282), [[power]]);
    }
    slave.send(CHANGE);
    assert_eq!(data(&run(&mut spacecraft, 10), 0x282), [[50]]);
    slave.send(UNLISTED);
    assert!(data(&run(&mut spacecraft, 10), 0x482).is_empty());
    assert_eq!(slave.status().counters.nominal.refused, 1);
}

/// The errors that a master knows.
fn known(master: HeaterMaster) -> Vec<ActiveError> {
    let mut errors = Vec::new();
    master.active_errors(|error| errors.push(error));
    errors
}

/// Given an error that a slave raises and clears, then an emergency with its code and its source reports each, and the master knows of
/// the error in between. Raised again while it is active it sends nothing.
///
/// Verifies: ECSS 6.4a
#[test]
fn raised_error_of_a_slave_is_reported_until_it_is_cleared() {
    let (mut spacecraft, master, slave) = flying();
    slave.raise(BROKEN, [1, 2, 3, 4]);
    assert_eq!(data(&run(&mut spacecraft, 200), 0x082), [[0x00, 0x50, 0x01, 0x48, 1, 2, 3, 4]]);
    assert_eq!(known(master), [ActiveError { node: TWO, code: BROKEN.code, source: BROKEN.source }]);
    slave.raise(BROKEN, [0; 4]);
    slave.clear(DeviceError::new(ErrorCode::HARDWARE, 0x49));
    assert!(data(&run(&mut spacecraft, 200), 0x082).is_empty());
    slave.clear(BROKEN);
    let sent = run(&mut spacecraft, 200);
    let ended = sent.iter().find_map(|sent| Emergency::decode(&sent.frame)).map(|(_, end)| end.ended());
    assert_eq!(ended, Some(Some((BROKEN.code, BROKEN.source))));
    assert_eq!(known(master), []);
}

/// Given an error that a master raises and clears, then its emergencies (081h) and its error register report it.
///
/// Verifies: ECSS 6.4a
#[test]
fn raised_error_of_a_master_is_reported_until_it_is_cleared() {
    let (mut spacecraft, master, _) = flying();
    let register = || master.inspect(|master| master.objects().communication.emcy.register);
    master.raise(BROKEN, [1, 2, 3, 4]);
    assert_eq!(data(&run(&mut spacecraft, 200), 0x081), [[0x00, 0x50, 0x01, 0x48, 1, 2, 3, 4]]);
    assert_eq!(register(), 1);
    master.clear(BROKEN);
    assert_eq!(data(&run(&mut spacecraft, 200), 0x081), [[0x00, 0x00, 0x00, 0x00, 0x50, 0x48, 0, 0]]);
    assert_eq!(register(), 0);
}

/// Given commands by name to one slave and to all, then the NMT frames of CiA 301 go out.
///
/// Verifies: ECSS 6.5.1a.2
#[test]
fn commands_by_name_are_nmt_frames() {
    let (mut spacecraft, master, _) = flying();
    let commands: [(Command, u8); 5] = [
        (|master, slaves| master.stop(slaves), 0x02),
        (|master, slaves| master.enter_pre_operational(slaves), 0x80),
        (|master, slaves| master.start(slaves), 0x01),
        (|master, slaves| master.reset_communication(slaves), 0x82),
        (|master, slaves| master.reset(slaves), 0x81),
    ];
    for (command, byte) in commands {
        for (slaves, id) in [(TWO.into(), 2), (Target::All, 0)] {
            command(master, slaves);
            let sent = data(&run(&mut spacecraft, 1), 0x000);
            assert_eq!(sent.first(), Some(&vec![byte, id]), "{byte:02X}h");
        }
    }
    master.reset(TWO);
    assert_eq!(data(&run(&mut spacecraft, 1), 0x000)[0], [0x81, 2]);
}

/// Given a slave that its application stopped, then it stays there until it is started. A slave booted by name is configured again.
#[test]
fn stopped_slave_is_not_started_before_the_application_does() {
    let (mut spacecraft, master, _) = flying();
    master.stop(TWO);
    run(&mut spacecraft, 1_000);
    assert_eq!((master.slave_state(TWO), master.may_command(TWO)), (Some(NmtState::Stopped), false));
    assert_eq!(master.send_to(TWO, COMMAND, (1,)), Err(Refusal::NotOperational));
    master.start(TWO);
    run(&mut spacecraft, 1_000);
    assert!(master.may_command(TWO));
    assert_eq!(master.send_to(TWO, COMMAND, (1,)), Ok(()));
    assert_eq!(data(&run(&mut spacecraft, 10), 0x202), [[1]]);
    master.update(|heater| heater.power = 1);
    assert_eq!(data(&run(&mut spacecraft, 10), 0x281), [[1]]);
    assert_eq!(master.send(CHANGE), Ok(()));
    assert_eq!(data(&run(&mut spacecraft, 10), 0x281), [[1]]);
    assert_eq!(master.send(UNLISTED), Err(Refusal::NotValid));
}

/// Given a master, when its application changes the bus and the time, then its state shows both.
#[test]
fn bus_and_time_are_set_by_name() {
    let (mut spacecraft, master, slave) = flying();
    assert!(master.is_active());
    master.stand_by(); // there is no other board
    master.switch_to(Bus::Redundant);
    master.set_time(Scet::new(1_000, 0).unwrap());
    run(&mut spacecraft, 500);
    assert!(master.is_active());
    assert_eq!((master.status().active, slave.status().active), (Bus::Redundant, Bus::Redundant));
    assert_eq!(master.status().scet.coarse(), 1_000);
    assert!(master.scet_at_sync().is_some_and(|scet| scet.coarse() == 1_000));
}

/// Given a self-test, then its result is in object 2031h of slave and master; counters of a slave are reset by name.
///
/// Verifies: ECSS 6.7b
#[test]
fn result_of_a_self_test_is_reported_by_name() {
    let (_, master, slave) = flying();
    let result = SelfTest { progress: SelfTest::PASSED, failures: 0 };
    master.report_self_test(result);
    slave.report_self_test(result);
    let shown = master.inspect(|master| master.objects().extension.self_test.progress);
    assert_eq!(shown, SelfTest::PASSED);
    assert_eq!(slave.inspect(|slave| slave.objects().extension.self_test.progress), SelfTest::PASSED);
    assert!(slave.status().counters.nominal.received > 0);
    slave.reset_counters();
    assert_eq!(slave.status().counters.nominal.received, 0);
    assert!(slave.select_bus(Bus::Redundant).is_err());
}

/// Tasks that wait for a slave, in the order in which they end.
fn waiting(spacecraft: &mut MockSpacecraft, master: HeaterMaster, tasks: usize) -> Rc<RefCell<Vec<Instant>>> {
    let ended = Rc::new(RefCell::new(Vec::new()));
    for _ in 0..tasks {
        let ended = ended.clone();
        spacecraft.spawn(async move {
            master.wait_operational(THREE).await;
            ended.borrow_mut().push(master.now());
        });
    }
    ended
}

/// Instant at which a master learns that slave 3 is Operational, when the slave is powered on at 1 s.
fn operational_at() -> Instant {
    let (mut spacecraft, master, _) = flying();
    slave(&mut spacecraft, THREE);
    while master.slave_state(THREE) != Some(NmtState::Operational) {
        spacecraft.step(at(3_000));
        assert!(spacecraft.now() < at(3_000));
    }
    spacecraft.now()
}

/// Given more tasks than there are places, when a slave becomes Operational, then four end at once and the others within 100 ms. A task
/// that waits for a slave which is Operational ends at once.
#[test]
fn waiting_tasks_end_when_the_slave_is_operational() {
    let expected = operational_at();
    let (mut spacecraft, master, _) = flying();
    let ended = waiting(&mut spacecraft, master, 6);
    run(&mut spacecraft, 0);
    slave(&mut spacecraft, THREE);
    spacecraft.run_until(expected + Duration::from_millis(101));
    let ended = ended.borrow();
    assert_eq!(ended.len(), 6);
    assert_eq!(ended[..4], [expected; 4]);
    assert!(ended[4..].iter().all(|at| (expected..=expected + Duration::from_millis(100)).contains(at)));
    assert!(poll_once(master.wait_operational(THREE)).is_some());
}

/// Given four tasks that wait, when their futures are dropped, then their places are free: the next ones end with the slave.
#[test]
fn dropped_wait_gives_its_place_back() {
    let expected = operational_at();
    let (mut spacecraft, master, _) = flying();
    for _ in 0..4 {
        assert!(poll_once(master.wait_operational(THREE)).is_none());
    }
    let ended = waiting(&mut spacecraft, master, 4);
    run(&mut spacecraft, 0);
    slave(&mut spacecraft, THREE);
    spacecraft.run_until(expected + Duration::from_millis(1));
    assert_eq!(ended.borrow()[..], [expected; 4]);
}

/// Counts how often a task is woken.
#[derive(Default)]
struct Count(std::sync::atomic::AtomicU32);

impl Wake for Count {
    fn wake(self: std::sync::Arc<Self>) {
        self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    }
}

/// Given a task that waits for an event, when objects are read, then it is not woken.
#[test]
fn read_wakes_no_task() {
    let mut spacecraft = MockSpacecraft::new();
    let (slave, mut events) =
        spacecraft.power_on(|| Slave::builder(TWO, &Profile::DEFAULT, Heater::default()).build());
    while poll_once(events.next()).is_some() {}
    let count = std::sync::Arc::new(Count::default());
    let waker = Waker::from(count.clone());
    let mut next = std::pin::pin!(events.next());
    assert!(next.as_mut().poll(&mut Context::from_waker(&waker)).is_pending());
    assert_eq!(slave.read(|heater| heater.power), 0);
    assert_eq!(slave.status().state, NmtState::PreOperational);
    assert_eq!(count.0.load(std::sync::atomic::Ordering::Relaxed), 0);
}

/// Answers each request with its first byte.
struct Echo(u8);

impl MinimalDevice for Echo {
    const PDOS: MinimalPdos = MinimalPdos::DEFAULT;

    fn on_pdo(&mut self, number: usize, data: &[u8], _: Instant) -> Option<(usize, Payload)> {
        self.0 = *data.first()?;
        Some((number, Payload::from_slice(&[self.0]).ok()?))
    }

    fn on_sync(&mut self, _: usize, _: Instant) -> Option<Payload> {
        None
    }
}

/// Given a minimal slave, when the master sends it a command by name, then its application reads its device.
///
/// Verifies: ECSS 9.4.2c
#[test]
fn minimal_slave_is_commanded_and_read_by_name() {
    let (mut spacecraft, master, _) = flying();
    let minimal = MinimalSlave::builder(THREE, &Profile::DEFAULT, Echo(0));
    let (minimal, _) = spacecraft.power_on(|| minimal.build());
    run(&mut spacecraft, 1_000);
    assert!(poll_once(master.wait_operational(THREE)).is_some());
    assert_eq!(master.send_to_minimal(THREE, 0, &[7]), Ok(()));
    run(&mut spacecraft, 10);
    let seen = Cell::new(0);
    seen.set(minimal.read(|echo| echo.0));
    assert_eq!((seen.get(), minimal.active()), (7, Bus::Nominal));
    assert!(minimal.counters().nominal.received > 0);
    assert_eq!(minimal.health().nominal.tec, 0);
    assert_eq!(master.send_frame(Frame::of(CobId::new(0x000).unwrap(), [1, 0])), Err(Refusal::NotValid));
}

/// Given two equal heaters, then the master knows the sender and the power of each change, without an object for it.
#[test]
fn a_master_reads_the_values_of_a_pdo_from_its_event() {
    /// A master without objects.
    #[derive(Debug, Objects)]
    #[objects(device)]
    struct Ground {}

    impl Device for Ground {
        type Pdos = PdoObjects<2, 0>;
        type Consumers = HeartbeatConsumers<3>;
        const PDOS: PdoSet = PdoSet::new(&[CHANGE.of(TWO).receive(1), CHANGE.of(THREE).receive(2)], &[]);
    }

    let mut spacecraft = MockSpacecraft::new();
    let (master, mut events) =
        spacecraft.power_on(|| Master::builder(&Profile::DEFAULT, Ground::default()).build());
    let [two, three] = [TWO, THREE].map(|node| slave(&mut spacecraft, node));
    spacecraft.run_until(at(1_000));
    two.update(|heater| heater.power = 20);
    run(&mut spacecraft, 10);
    three.update(|heater| heater.power = 30);
    run(&mut spacecraft, 10);
    let mut heard = Vec::new();
    while let Some(event) = poll_once(events.next()) {
        if let MasterEvent::Pdo(pdo) = event {
            assert_eq!(pdo.get(CHANGE.of(THREE)).is_some(), pdo.from(CHANGE).unwrap().0 == THREE);
            heard.push((pdo.from(CHANGE), pdo.age(master.now()).as_micros() / 1_000));
        }
    }
    assert_eq!(heard, [(Some((TWO, (20,))), 20), (Some((THREE, (30,))), 10)]);
}
