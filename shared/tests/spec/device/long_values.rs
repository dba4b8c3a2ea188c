//! Strings and blocks that do not fit into one buffer: saved, restored, read.

use crate::instrument::STANDARD;
use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, DeviceNode, Slave};
use ecss_can::od::{Domain, Objects, OctetString, VisibleString};
use ecss_can::pdo::{PdoObjects, PdoSet};
use ecss_can::store::ParameterStore;

use super::fixture::{Memory, ask, done, download, errors, refused, write};
use crate::bench::{Bench, node};

/// An instrument with a name and a calibration.
#[derive(Debug, Objects)]
struct Instrument {
    /// Name
    #[object(0x2100, rw, default = VisibleString::new(b"none").unwrap_or_default())]
    name: VisibleString<100>,
    /// Calibration
    #[object(0x2101, rw)]
    calibration: OctetString<300>,
    /// Table
    #[object(0x2102, rw, keep, default = Domain::new([0; 200]))]
    table: Domain<[u8; 200]>,
    /// Image
    #[object(0x2103, rw, default = Domain::new([0; 200]))]
    image: Domain<[u8; 200]>,
    /// Mode
    #[object(0x2104, rw)]
    mode: u16,
    /// Exposures
    #[object(0x2105, rw, volatile, default = 7)]
    exposures: u16,
}

impl Device for Instrument {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PdoSet::NONE;
}

type TestDevice = Bench<Slave<Instrument>>;

fn powered(memory: &Memory) -> TestDevice {
    let slave = Slave::new(node(5), &STANDARD, Instrument::default());
    Bench::new(slave.with_store(Box::leak(Box::new(memory.clone()))))
}

fn calibration() -> Vec<u8> {
    (0..=255).cycle().take(300).collect()
}

/// Reads a value in segments.
fn upload(slave: &mut TestDevice, index: u16) -> Vec<u8> {
    let [low, high] = index.to_le_bytes();
    let answer = ask(slave, [0x40, low, high, 0, 0, 0, 0, 0]);
    assert_eq!(answer[0], 0x41, "{answer:02X?}");
    let (mut value, mut toggle) = (Vec::new(), 0);
    loop {
        let answer = ask(slave, [0x60 | toggle << 4, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(answer[0] & 0xF0, toggle << 4, "{answer:02X?}");
        value.extend(&answer[1..8 - usize::from(answer[0] >> 1 & 7)]);
        if answer[0] & 1 != 0 {
            assert_eq!(u16::from_le_bytes([low, high]), index);
            return value;
        }
        toggle ^= 1;
    }
}

fn calibrate(slave: &mut TestDevice) {
    slave.touch(|slave, now| {
        slave.change(now, |objects| objects.calibration = OctetString::new(&calibration()).unwrap());
    });
}

/// Verifies: ECSS 6.8a
#[test]
fn long_strings_are_saved_and_restored() {
    let memory = Memory::default();
    let mut slave = powered(&memory);
    assert_eq!(download(&mut slave, 0x2100, 0, b"Spectrometer 7")[0], 0x30);
    calibrate(&mut slave);
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
    let mut again = powered(&memory);
    assert_eq!(again.node.objects().application.name.as_bytes(), b"Spectrometer 7");
    assert_eq!(again.node.objects().application.calibration.as_bytes(), calibration());
    assert_eq!(errors(&mut again), (0, 0));
    // The others are saved: what was stored is kept.
    assert_eq!(write(&mut again, 0x1010, 2, b"save"), done(0x1010, 2));
    assert_eq!(powered(&memory).node.objects().application.calibration.as_bytes(), calibration());
    // Back to the defaults of the manufacturer's objects.
    assert_eq!(write(&mut again, 0x1011, 4, b"load"), done(0x1011, 4));
    let objects = &powered(&memory).node;
    assert_eq!(objects.objects().application.name.as_bytes(), b"none");
    assert_eq!(objects.objects().application.calibration.as_bytes(), b"");
}

/// Verifies: ECSS 6.8a
#[test]
fn a_domain_is_saved_where_it_is_declared_so() {
    let memory = Memory::default();
    let mut slave = powered(&memory);
    for index in [0x2102, 0x2103] {
        assert_eq!(download(&mut slave, index, 0, &calibration()[..150])[0] & 0xE0, 0x20);
    }
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
    let mut again = powered(&memory);
    assert_eq!(upload(&mut again, 0x2102), calibration()[..150]);
    assert_eq!(again.node.objects().application.image.as_bytes(), b"");
}

/// Verifies: ECSS 6.8a
#[test]
fn a_volatile_value_has_its_default_after_power_on() {
    let memory = Memory::default();
    let mut slave = powered(&memory);
    for index in [0x2104, 0x2105] {
        assert_eq!(write(&mut slave, index, 0, &[5, 0]), done(index, 0));
    }
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
    let again = powered(&memory);
    let instrument = &again.node.objects().application;
    assert_eq!((instrument.mode, instrument.exposures), (5, 7));
}

#[test]
fn a_string_longer_than_the_buffer_is_read_in_segments() {
    let mut slave = powered(&Memory::default());
    calibrate(&mut slave);
    assert_eq!(upload(&mut slave, 0x2101), calibration());
}

/// What has no room in the store is not saved, which the client hears; what was stored holds.
#[test]
fn a_set_without_room_is_refused_whole() {
    let memory = Memory::with_room(200);
    let mut slave = powered(&memory);
    assert_eq!(download(&mut slave, 0x2100, 0, b"Spectrometer")[0], 0x30);
    assert_eq!(write(&mut slave, 0x1010, 4, b"save"), done(0x1010, 4));
    let before = memory.stored_len();
    calibrate(&mut slave);
    assert_eq!(write(&mut slave, 0x1010, 4, b"save"), refused(0x1010, 4, 0x0800_0020));
    assert_eq!(memory.stored_len(), before);
    assert_eq!(powered(&memory).node.objects().application.name.as_bytes(), b"Spectrometer");
}

/// Smaller in new firmware: its default holds, and an emergency tells of it.
#[test]
fn a_long_value_that_does_not_fit_any_more_leaves_the_default() {
    #[derive(Debug, Objects)]
    struct Smaller {
        /// Calibration
        #[object(0x2101, rw, default = OctetString::new(b"unity").unwrap_or_default())]
        calibration: OctetString<100>,
    }
    impl Device for Smaller {
        type Pdos = PdoObjects;
        type Consumers = HeartbeatConsumers;

        const PDOS: PdoSet = PdoSet::NONE;
    }
    let memory = Memory::default();
    let mut slave = powered(&memory);
    calibrate(&mut slave);
    assert_eq!(write(&mut slave, 0x1010, 4, b"save"), done(0x1010, 4));
    let smaller = Slave::new(node(5), &STANDARD, Smaller::default());
    let mut smaller = Bench::new(smaller.with_store(Box::leak(Box::new(memory.clone()))));
    assert_eq!(smaller.node.objects().application.calibration.as_bytes(), b"unity");
    assert_eq!(errors(&mut smaller), (1, 1));
}
