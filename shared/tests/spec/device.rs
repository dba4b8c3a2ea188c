//! The dictionary of a slave over its bus: SDO requests in, what the node does then.

use std::sync::{Arc, Mutex};

use ecss_can::link::port::{Filter, Health};
use ecss_can::link::{Bus, CobId};
use ecss_can::nmt::NmtState;
use ecss_can::node::{NodeObjects, SlaveEvent};
use ecss_can::od::spacecraft::SelfTest;
use ecss_can::od::{Address, Objects};
use ecss_can::profile::mission::MissionObjects;
use ecss_can::profile::{Profile, STANDARD, mission};
use ecss_can::runner::BusCommand;
use ecss_can::store::{ParameterStore, StoreError};
use ecss_can::time::Duration;
use ecss_can::time::Scet;

use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, node};
use crate::slave::TestSlave;

/// A store in RAM that outlives the nodes.
#[derive(Clone, Default)]
struct Memory {
    stored: Arc<Mutex<Vec<u8>>>,
    begun: Vec<u8>,
    is_full: bool,
}

impl ParameterStore for Memory {
    fn stored_len(&self) -> usize {
        self.stored.lock().unwrap().len()
    }

    fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<(), StoreError> {
        let stored = self.stored.lock().unwrap();
        into.copy_from_slice(stored.get(offset..offset + into.len()).ok_or(StoreError::Size)?);
        Ok(())
    }

    fn begin(&mut self, _len: usize) -> Result<(), StoreError> {
        self.begun.clear();
        if self.is_full { Err(StoreError::Full) } else { Ok(()) }
    }

    fn append(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        self.begun.extend(bytes);
        Ok(())
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        *self.stored.lock().unwrap() = std::mem::take(&mut self.begun);
        Ok(())
    }
}

fn powered() -> Bench<TestSlave> {
    Bench::new(mission::slave(node(5), &STANDARD, vec![0; 1024]))
}

fn powered_with(memory: &Memory) -> Bench<TestSlave> {
    let slave = mission::slave(node(5), &STANDARD, vec![]);
    Bench::new(slave.with_store(Box::leak(Box::new(memory.clone()))))
}

/// Answer to an SDO request on the nominal bus.
fn ask(slave: &mut Bench<TestSlave>, request: [u8; 8]) -> [u8; 8] {
    ask_on(slave, NOMINAL, request)
}

fn ask_on(slave: &mut Bench<TestSlave>, bus: Bus, request: [u8; 8]) -> [u8; 8] {
    slave.sent.clear();
    slave.receive(bus, 0x605, &request);
    let answers: Vec<_> = slave.sent.iter().filter(|sent| sent.frame.id().raw() == 0x585).collect();
    assert_eq!((answers.len(), answers[0].bus), (1, bus), "one answer to {request:02X?}");
    answers[0].frame.padded()
}

fn write(slave: &mut Bench<TestSlave>, index: u16, sub: u8, value: &[u8]) -> [u8; 8] {
    write_on(slave, NOMINAL, index, sub, value)
}

fn write_on(slave: &mut Bench<TestSlave>, bus: Bus, index: u16, sub: u8, value: &[u8]) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    let mut data = [0; 4];
    data[..value.len()].copy_from_slice(value);
    let command = 0x23 | ((4 - value.len() as u8) << 2);
    ask_on(slave, bus, [command, low, high, sub, data[0], data[1], data[2], data[3]])
}

fn done(index: u16, sub: u8) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    [0x60, low, high, sub, 0, 0, 0, 0]
}

fn refused(index: u16, sub: u8, code: u32) -> [u8; 8] {
    let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), code.to_le_bytes());
    [0x80, low, high, sub, a, b, c, d]
}

fn read(slave: &mut Bench<TestSlave>, index: u16, sub: u8) -> [u8; 4] {
    let [low, high] = index.to_le_bytes();
    let answer = ask(slave, [0x40, low, high, sub, 0, 0, 0, 0]);
    assert_eq!(answer[0] & 0xE3, 0x43, "an expedited answer: {answer:02X?}");
    answer[4..].try_into().unwrap()
}

/// Verifies: ECSS 6.1a, 6.8a
#[test]
fn objects_are_read_and_written_where_sdo_is_allowed() {
    let mut slave = powered();
    assert_eq!(read(&mut slave, 0x1017, 0), [100, 0, 0, 0]);
    assert_eq!(write(&mut slave, 0x1017, 0, &[50, 0]), done(0x1017, 0));
    // The heartbeat follows.
    slave.clear();
    slave.run_until(ms(200));
    assert_eq!(slave.times(NOMINAL, 0x705), [50, 100, 150, 200]);
    // Stopped: no SDO. On the bus that is not active: none either.
    slave.receive(NOMINAL, 0x000, &[2, 5]);
    slave.clear();
    slave.receive(NOMINAL, 0x605, &[0x40, 0x17, 0x10, 0, 0, 0, 0, 0]);
    slave.receive(REDUNDANT, 0x605, &[0x40, 0x17, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(slave.frames(), []);
}

#[test]
fn what_must_not_be_written_is_refused_with_the_right_code() {
    let mut slave = powered();
    let table: [(u16, u8, &[u8], u32); 24] = [
        (0x1000, 0, &[0; 4], 0x0601_0002),             // device type is read-only
        (0x1004, 0, &[0; 4], 0x0602_0000),             // no such object
        (0x1018, 9, &[0; 4], 0x0609_0011),             // no such sub-index
        (0x1017, 0, &[1], 0x0607_0013),                // too short
        (0x1017, 0, &[1, 0, 0, 0], 0x0607_0012),       // too long
        (0x1003, 0, &[1], 0x0609_0030),                // only zero forgets the errors
        (0x1005, 0, &[0x80, 0, 0, 0x40], 0x0609_0030), // a slave is no SYNC producer
        (0x1014, 0, &[0x86, 0, 0, 0], 0x0609_0030),    // another COB-ID while valid
        (0x1016, 2, &[10, 0, 1, 0], 0x0604_0043),      // node 1 is monitored already
        (0x1019, 0, &[1], 0x0609_0030),                // reserved
        (0x1029, 1, &[3], 0x0609_0030),                // reserved
        (0x1010, 1, &[0; 4], 0x0800_0020),             // not the signature
        (0x1010, 1, b"save", 0x0800_0020),             // nowhere to save to
        (0x1400, 1, &[0x82, 1, 0, 0x40], 0x0609_0030), // another COB-ID while valid
        (0x1600, 0, &[0], 0x0609_0030),                // mapping while valid
        (0x1603, 1, &[8, 1, 0, 0x20], 0x0604_0041),    // Bdefault is for transmit PDOs
        (0x1603, 1, &[8, 4, 0, 0x20], 0x0604_0041),    // Ctoggle as well
        (0x1803, 2, &[252], 0x0609_0030),              // remote requests
        (0x1A03, 1, &[0x20, 0, 0, 0x60], 0x0602_0000), // 6000h is no object
        (0x1A03, 1, &[0x10, 1, 0, 0x62], 0x0604_0041), // 6200h is for receive PDOs
        (0x2000, 1, &[2], 0x0609_0030),                // Bdefault is 0 or 1
        (0x2030, 0, &[2], 0x0609_0031),                // self-test is started with 1
        (0x6100, 1, &[0, 0], 0x0601_0002),             // telemetry is read-only
        (0x6400, 28, &[101, 0], 0x0609_0031),          // above its limit
    ];
    for (index, sub, value, code) in table {
        assert_eq!(
            write(&mut slave, index, sub, value),
            refused(index, sub, code),
            "{index:04X}h:{sub} {value:02X?}"
        );
    }
    assert_eq!(ask(&mut slave, [0x40, 0x30, 0x20, 0, 0, 0, 0, 0]), refused(0x2030, 0, 0x0601_0001));
    assert_eq!(ask(&mut slave, [0x40, 0x03, 0x10, 1, 0, 0, 0, 0]), refused(0x1003, 1, 0x0800_0024));
    assert_eq!(ask(&mut slave, [0xE0, 0, 0, 0, 0, 0, 0, 0]), refused(0, 0, 0x0504_0001));
}

/// Verifies: ECSS 6.5.2a
#[test]
fn the_heartbeat_of_another_slave_passes_the_filters_once_it_is_monitored() {
    let mut slave = powered();
    let filter = |raw| Filter::exact(CobId::new(raw).unwrap());
    for (value, raw) in [([250, 0, 7, 0], 0x707), ([0; 4], 0x000), ([250, 0, 8, 0], 0x708)] {
        slave.controls.clear();
        assert_eq!(write(&mut slave, 0x1016, 2, &value), done(0x1016, 2));
        let command = BusCommand::Filter { number: 5, filter: filter(raw) };
        assert_eq!(slave.controls, [(NOMINAL, command), (REDUNDANT, command)]);
    }
    slave.receive(NOMINAL, 0x708, &[5]);
    assert!(slave.events.contains(&SlaveEvent::PeerState { node: node(8), state: NmtState::Operational }));
    // Reset communication forgets it, and a SYNC that had moved.
    assert_eq!(write(&mut slave, 0x1005, 0, &[0x81, 0, 0, 0]), done(0x1005, 0));
    slave.controls.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    for (number, raw) in [(5, 0x000), (1, 0x080)] {
        let command = BusCommand::Filter { number, filter: filter(raw) };
        for bus in Bus::ALL {
            assert!(slave.controls.contains(&(bus, command)), "{command:?}: {:?}", slave.controls);
        }
    }
    assert_eq!(slave.controls.len(), 4);
}

/// Verifies: ECSS 6.10a, 6.10c
#[test]
fn a_pdo_takes_another_cob_id_and_the_filters_follow() {
    let mut slave = powered();
    write(&mut slave, 0x1401, 1, &[0x05, 3, 0, 0xC0]);
    assert_eq!(write(&mut slave, 0x1401, 1, &[0x45, 3, 0, 0x40]), done(0x1401, 1));
    let filter = Filter::exact(CobId::new(0x345).unwrap());
    for bus in Bus::ALL {
        assert!(slave.controls.contains(&(bus, BusCommand::Filter { number: 13, filter })));
    }
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    slave.clear();
    slave.receive(NOMINAL, 0x305, &[1; 8]);
    assert_eq!(slave.events, []);
    slave.receive(NOMINAL, 0x345, &[1; 8]);
    assert_eq!(slave.events, [SlaveEvent::Pdo { bus: NOMINAL, number: 1, data: [1; 8] }]);
    // Reset communication goes back to what it was.
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    let filter = Filter::exact(CobId::new(0x305).unwrap());
    assert!(slave.controls.contains(&(NOMINAL, BusCommand::Filter { number: 13, filter })));
    assert_eq!(read(&mut slave, 0x1401, 1), [0x05, 3, 0, 0x40]);
}

/// Verifies: ECSS 6.2a
#[test]
fn a_pdo_is_mapped_anew_and_sent() {
    let mut slave = powered();
    let steps: [(u16, u8, &[u8]); 6] = [
        (0x1A01, 0, &[0]),
        (0x1A01, 1, &[32, 0, 0x10, 0x62]),
        (0x1A01, 2, &[8, 1, 0x20, 0x20]),
        (0x1A01, 0, &[2]),
        (0x1801, 5, &[10, 0]),
        (0x1801, 1, &[0x85, 2, 0, 0x40]),
    ];
    for (index, sub, value) in steps {
        assert_eq!(write(&mut slave, index, sub, value), done(index, sub));
    }
    assert_eq!(write(&mut slave, 0x6210, 0, &[1, 2, 3, 4]), done(0x6210, 0));
    assert!(slave.events.contains(&SlaveEvent::Written(Address::new(0x6210, 0))));
    slave.health(NOMINAL, Health { tec: 9, ..Health::default() });
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    slave.clear();
    slave.run_until(ms(25));
    assert_eq!(slave.times(NOMINAL, 0x285), [10, 20]);
    assert_eq!(
        slave.sent.iter().find(|sent| sent.frame.id().raw() == 0x285).unwrap().frame,
        frame(0x285, &[1, 2, 3, 4, 0])
    );
}

/// A receive PDO changes a value; that a service has to follow, the node learns from an SDO. Objects that may come by PDO
/// are the application's, which hears of each, and the time, which sets the clock.
#[test]
fn what_a_service_has_to_follow_does_not_come_by_pdo() {
    let mut by_pdo = Vec::new();
    NodeObjects::<MissionObjects<Vec<u8>>>::each_object(&mut |object| {
        if object.entries.iter().any(|entry| entry.mappable && entry.access.is_for_rpdo()) {
            by_pdo.push(object.index);
        }
    });
    by_pdo.sort_unstable();
    assert_eq!(by_pdo, [0x2010, 0x6101, 0x6200, 0x6210, 0x6400]);
}

#[test]
fn the_default_bus_and_the_toggles_so_far_go_out_by_pdo() {
    let mut slave = powered();
    let steps: [(u16, u8, &[u8]); 5] = [
        (0x1A01, 0, &[0]),
        (0x1A01, 1, &[8, 1, 0, 0x20]),
        (0x1A01, 2, &[8, 4, 0, 0x20]),
        (0x1A01, 0, &[2]),
        (0x1801, 1, &[0x85, 2, 0, 0x40]),
    ];
    for (index, sub, value) in steps {
        assert_eq!(write(&mut slave, index, sub, value), done(index, sub));
    }
    // The master is lost and found on the other bus.
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    let send = |slave: &mut Bench<TestSlave>| {
        slave.sent.clear();
        slave.touch(|slave, now| slave.send_pdo(1, now));
        slave.frames()
    };
    assert_eq!(send(&mut slave), [(NOMINAL, frame(0x285, &[0, 0]))]);
    slave.run_until(ms(600));
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT);
    slave.receive(REDUNDANT, 0x000, &[1, 5]);
    assert_eq!(send(&mut slave), [(REDUNDANT, frame(0x285, &[1, 0]))]);
    assert_eq!(write_on(&mut slave, REDUNDANT, 0x2000, 4, &[3]), done(0x2000, 4));
    assert_eq!(send(&mut slave), [(REDUNDANT, frame(0x285, &[1, 3]))]);
}

/// Verifies: ECSS 8.3.1c
#[test]
fn redundancy_parameters_are_written_and_obeyed() {
    let mut slave = powered();
    assert_eq!(write(&mut slave, 0x2000, 2, &[4]), done(0x2000, 2));
    assert_eq!(write(&mut slave, 0x1016, 1, &[100, 0, 1, 0]), done(0x1016, 1));
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.clear();
    slave.run_until(ms(99));
    assert_eq!(slave.events, []);
    slave.run_until(ms(100));
    assert_eq!(slave.events[0], SlaveEvent::MasterMissed { bus: NOMINAL });
    // EMCY 8130h names the master, and 1003h remembers.
    assert!(slave.frames().contains(&(NOMINAL, frame(0x085, &[0x30, 0x81, 0x11, 1, 0, 0, 0, 0]))));
    slave.clear();
    slave.run_until(ms(399));
    assert_eq!(slave.events, []);
    slave.run_until(ms(400));
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT);
    assert_eq!(slave.node.objects().spacecraft.redundancy.ctoggle, 1);
    assert_eq!(slave.node.objects().communication.errors.errors[0], 0x0001_8130);
}

/// The time of a synchronous PDO holds from its SYNC on, as its other values do.
///
/// Verifies: ECSS 6.9e, 7.2.2c
#[test]
fn a_synchronous_time_pdo_sets_the_clock_at_the_sync() {
    let mut slave = powered();
    let valid = [0x81, 1, 0, 0x40];
    let steps: [(u16, u8, &[u8]); 3] =
        [(0x1400, 1, &[0x81, 1, 0, 0xC0]), (0x1400, 2, &[1]), (0x1400, 1, &valid)];
    for (index, sub, value) in steps {
        assert_eq!(write(&mut slave, index, sub, value), done(index, sub));
    }
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    // 1000 s and a half, fine time first.
    slave.receive(NOMINAL, 0x181, &[0, 0, 0x80, 0xE8, 3, 0, 0]);
    slave.run_until(ms(20));
    assert_ne!(slave.node.scet(slave.now).coarse(), 1_000);
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    let scet = Scet::new(1_000, 0x80_0000).unwrap();
    assert_eq!(slave.node.scet(slave.now), scet);
    assert!(slave.events.contains(&SlaveEvent::Time(scet)), "{:?}", slave.events);
}

/// Verifies: ECSS 6.7b, 6.7c
#[test]
fn the_self_test_is_started_and_its_result_read() {
    let mut slave = powered();
    assert_eq!(read(&mut slave, 0x2031, 1), [0, 0, 0, 0]);
    assert_eq!(write(&mut slave, 0x2030, 0, &[1]), done(0x2030, 0));
    assert!(slave.events.contains(&SlaveEvent::SelfTest));
    assert_eq!(read(&mut slave, 0x2031, 1), [1, 0, 0, 0]);
    slave.touch(|slave, _| {
        slave.objects_mut().spacecraft.self_test = SelfTest { progress: SelfTest::PASSED, failures: 0 }
    });
    assert_eq!(read(&mut slave, 0x2031, 1), [2, 0, 0, 0]);
}

#[test]
fn a_transfer_under_way_ends_when_the_bus_changes() {
    let mut slave = powered();
    slave.receive(NOMINAL, 0x701, &[5]);
    // A segmented upload of the device name has begun.
    assert_eq!(ask(&mut slave, [0x40, 0x08, 0x10, 0, 0, 0, 0, 0])[0], 0x41);
    slave.clear();
    slave.receive(REDUNDANT, 0x701, &[5]);
    let abort = frame(0x585, &refused(0x1008, 0, 0x0800_0022));
    assert!(slave.frames().contains(&(REDUNDANT, abort)), "{:?}", slave.frames());
    slave.clear();
    slave.run_until(ms(2_000));
    assert!(slave.frames().iter().all(|(_, frame)| frame.id().raw() != 0x585));
}

#[test]
fn what_is_stored_is_there_after_a_reset_and_defaults_come_back_on_command() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    write(&mut slave, 0x1017, 0, &[50, 0]);
    write(&mut slave, 0x2000, 1, &[1]);
    write(&mut slave, 0x6210, 0, &[7, 0, 0, 0]);
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
    // Written after the save: gone with the power.
    write(&mut slave, 0x2000, 3, &[99]);
    let mut slave = powered_with(&memory);
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT, "Bdefault was stored");
    let objects = slave.node.objects();
    assert_eq!((objects.communication.producer_heartbeat, objects.spacecraft.redundancy.ntoggle), (50, 10));
    assert_eq!(objects.application.value, 7);
    slave.clear();
    slave.run_until(ms(100));
    assert_eq!(slave.times(REDUNDANT, 0x705), [50, 100]);
    // Defaults of the communication profile only, from the next reset on.
    slave.receive(REDUNDANT, 0x605, &[0x23, 0x11, 0x10, 2, b'l', b'o', b'a', b'd']);
    assert!(slave.frames().contains(&(REDUNDANT, frame(0x585, &done(0x1011, 2)))));
    assert_eq!(slave.node.objects().communication.producer_heartbeat, 50);
    let slave = powered_with(&memory);
    assert_eq!(slave.node.objects().communication.producer_heartbeat, 100);
    assert_eq!(slave.node.objects().application.value, 7);
}

#[test]
fn reset_communication_returns_to_what_is_stored_of_the_communication_profile() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    write(&mut slave, 0x1017, 0, &[50, 0]);
    assert_eq!(write(&mut slave, 0x1010, 2, b"save"), done(0x1010, 2));
    write(&mut slave, 0x1017, 0, &[20, 0]);
    write(&mut slave, 0x6210, 0, &[9, 0, 0, 0]);
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    let objects = slave.node.objects();
    assert_eq!((objects.communication.producer_heartbeat, objects.application.value), (50, 9));
    assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational);
}

/// Verifies: ECSS 6.4a.1
#[test]
fn what_is_stored_but_does_not_hold_here_is_told_until_parameters_are_saved() {
    let memory = Memory::default();
    let mut other = Bench::new(
        mission::slave(node(6), &STANDARD, vec![]).with_store(Box::leak(Box::new(memory.clone()))),
    );
    other.receive(NOMINAL, 0x606, &[0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e']);
    assert_ne!(memory.stored_len(), 0);
    // The board is in another place now.
    let mut slave = powered_with(&memory);
    let told: Vec<_> = slave.sent.iter().filter(|sent| sent.frame.id().raw() == 0x085).collect();
    assert_eq!(told.len(), 1);
    assert_eq!(told[0].frame.data()[..2], [0x00, 0x63]);
    assert_eq!(read(&mut slave, 0x1003, 1), [0x00, 0x63, 0, 0]);
    assert_ne!(read(&mut slave, 0x1001, 0)[0] & 1, 0, "a generic error");
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
    assert_eq!(read(&mut slave, 0x1001, 0), [0; 4]);
    // The set is its own from now on.
    let mut again = powered_with(&memory);
    assert_eq!(read(&mut again, 0x1001, 0), [0; 4]);
}

#[test]
fn a_full_store_says_so_and_keeps_what_it_has() {
    let memory = Memory { is_full: true, ..Memory::default() };
    let mut slave = powered_with(&memory);
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), refused(0x1010, 1, 0x0800_0022));
    assert_eq!(memory.stored_len(), 0);
    assert_eq!(read(&mut slave, 0x1010, 1), [1, 0, 0, 0]);
}

/// Verifies: ECSS 6.3b
#[test]
fn with_a_counter_announced_a_sync_must_have_it() {
    let mut slave = Bench::new(mission::slave(node(5), &Profile { autostart: true, ..STANDARD }, vec![]));
    assert_eq!(write(&mut slave, 0x1019, 0, &[10]), done(0x1019, 0));
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[1]);
    assert_eq!(slave.frames().len(), 1, "the Local Time PDO");
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert!(slave.frames().iter().all(|(_, frame)| frame.id().raw() == 0x085), "{:?}", slave.frames());
}

/// Verifies: ECSS 6.9e
#[test]
fn a_synchronous_pdo_that_has_not_left_at_the_end_of_the_window_is_stale() {
    let mut slave = Bench::new(mission::slave(node(5), &Profile { autostart: true, ..STANDARD }, vec![]));
    let expires = |slave: &mut Bench<TestSlave>| {
        slave.clear();
        slave.receive(NOMINAL, 0x080, &[]);
        assert_eq!(slave.sent.len(), 1, "the Local Time PDO");
        slave.sent[0].expires.since(slave.now)
    };
    let without = expires(&mut slave);
    assert!(without > Duration::from_millis(50), "{without:?}");
    // 2 ms.
    assert_eq!(write(&mut slave, 0x1007, 0, &2_000_u32.to_le_bytes()), done(0x1007, 0));
    assert_eq!(expires(&mut slave), Duration::from_millis(2));
    assert_eq!(write(&mut slave, 0x1007, 0, &[0; 4]), done(0x1007, 0));
    assert_eq!(expires(&mut slave), without);
}

/// Verifies: ECSS 6.9e
#[test]
fn a_synchronous_rpdo_is_taken_again_after_operational_was_left() {
    let mut slave = Bench::new(mission::slave(node(5), &Profile { autostart: true, ..STANDARD }, vec![]));
    write(&mut slave, 0x1007, 0, &2_000_u32.to_le_bytes());
    slave.receive(NOMINAL, 0x080, &[]);
    // RPDO 5 takes a synchronous word, long after the window of the only SYNC.
    let value = slave.node.objects().application.value;
    for (index, sub, bytes) in [
        (0x1604, 1, 0x6210_0020_u32.to_le_bytes().to_vec()),
        (0x1604, 0, vec![1]),
        (0x1404, 2, vec![1]),
        (0x1404, 1, 0x4000_0250_u32.to_le_bytes().to_vec()),
    ] {
        assert_eq!(write(&mut slave, index, sub, &bytes), done(index, sub));
    }
    slave.run_until(ms(100));
    let ignored = |slave: &Bench<TestSlave>| slave.node.status(slave.now).counters[NOMINAL].ignored;
    let before = ignored(&slave);
    slave.receive(NOMINAL, 0x250, &[9, 0, 0, 0]);
    assert_eq!(ignored(&slave), before + 1, "after the window");
    slave.receive(NOMINAL, 0x000, &[0x80, 5]);
    slave.receive(NOMINAL, 0x000, &[0x01, 5]);
    slave.receive(NOMINAL, 0x250, &[9, 0, 0, 0]);
    assert_eq!(ignored(&slave), before + 1);
    assert_eq!(slave.node.objects().application.value, value);
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(slave.node.objects().application.value, 9);
}
