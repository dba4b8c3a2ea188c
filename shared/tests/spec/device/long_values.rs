//! Strings and blocks that do not fit into one buffer: saved, restored, read.

use crate::instrument::STANDARD;
use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, DeviceNode, Slave};
use ecss_can::od::{Domain, Enumeration, Number, Objects, OctetString, VisibleString};
use ecss_can::pdo::{PdoObjects, PdoSet};
use ecss_can::store::ParameterStore;
use ecss_can::types::{AbortCode, Address};

use super::fixture::{Memory, ask, done, download, errors, refused, write};
use crate::bench::{Bench, NOMINAL, node};

/// An instrument with a name and a calibration.
#[derive(Debug, Objects)]
#[objects(device, check = Instrument::has_an_end)]
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
    /// Remark
    #[object(0x2106, rw, default = VisibleString::new(b"None.").unwrap_or_default())]
    remark: VisibleString<200>,
}

impl Instrument {
    /// A remark ends with a full stop.
    fn has_an_end(&self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        if at.index == 0x2106 && !value.ends_with(b".") { Err(AbortCode::ValueRange) } else { Ok(()) }
    }
}

impl Device for Instrument {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PdoSet::NONE;
}

type TestDevice = Bench<Slave<Instrument>>;

fn powered(memory: &Memory) -> TestDevice {
    let slave = Slave::builder(node(5), &STANDARD, Instrument::default());
    Bench::new(slave.store(Box::leak(Box::new(memory.clone()))).build())
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

/// 200 characters, the last one as given.
fn remark(last: char) -> Vec<u8> {
    (b' '..=b'~').cycle().take(199).chain([last as u8]).collect()
}

/// Writes a value in one block; the last answer.
fn download_block(slave: &mut TestDevice, index: u16, value: &[u8]) -> [u8; 8] {
    let ([low, high], [a, b, ..]) = (index.to_le_bytes(), value.len().to_le_bytes());
    assert_eq!(ask(slave, [0xC2, low, high, 0, a, b, 0, 0])[0], 0xA0);
    let segments = value.chunks(7).count();
    for (n, part) in (1..).zip(value.chunks(7)) {
        let mut segment = [0; 8];
        segment[0] = if n == segments { 0x80 | n as u8 } else { n as u8 };
        segment[1..][..part.len()].copy_from_slice(part);
        slave.receive(NOMINAL, 0x605, &segment);
    }
    let unused = (segments * 7 - value.len()) as u8;
    ask(slave, [0xC1 | unused << 2, 0, 0, 0, 0, 0, 0, 0])
}

/// A client writes it in segments or in a block, its owner is asked, "save" keeps it.
///
/// Verifies: ECSS 6.1a, 6.8a
#[test]
fn a_string_of_200_bytes_is_written_checked_and_kept() {
    for is_block in [false, true] {
        let memory = Memory::default();
        let mut slave = powered(&memory);
        let write_it = |slave: &mut TestDevice, value: &[u8]| match is_block {
            true => download_block(slave, 0x2106, value),
            false => download(slave, 0x2106, 0, value),
        };
        assert_eq!(write_it(&mut slave, &remark('!')), refused(0x2106, 0, 0x0609_0030), "{is_block}");
        assert_eq!(slave.node.objects().application.remark.as_bytes(), b"None.");
        assert_eq!(write_it(&mut slave, &remark('.'))[0] & !0x10, if is_block { 0xA1 } else { 0x20 });
        assert_eq!(upload(&mut slave, 0x2106), remark('.'));
        assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
        let mut again = powered(&memory);
        assert_eq!(again.node.objects().application.remark.as_bytes(), remark('.'));
        assert_eq!(errors(&mut again), (0, 0));
    }
}

/// What was stored by firmware without the check.
///
/// Verifies: ECSS 6.8a
#[test]
fn refused_stored_string_of_200_bytes_leaves_the_default() {
    let memory = Memory::default();
    let mut slave = powered(&memory);
    slave.touch(|slave, now| {
        slave.change(now, |objects| objects.remark = VisibleString::new(&remark('!')).unwrap());
    });
    assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
    let mut again = powered(&memory);
    assert_eq!(again.node.objects().application.remark.as_bytes(), b"None.");
    assert_eq!(errors(&mut again), (1, 1));
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

/// Verifies: ECSS 6.1a
/// Notices: ECSS 6.1a: an upload ends with the first buffer.
#[test]
fn a_string_longer_than_the_buffer_is_read_in_segments() {
    let mut slave = powered(&Memory::default());
    calibrate(&mut slave);
    assert_eq!(upload(&mut slave, 0x2101), calibration());
}

/// What has no room in the store is not saved, which the client hears; what was stored holds.
///
/// Verifies: ECSS 6.8a
/// Notices: ECSS 6.8a: a save without room is answered as done.
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
///
/// Verifies: ECSS 6.8a
/// Notices: ECSS 6.8a: a stored string that is too long is cut off.
#[test]
fn a_long_value_that_does_not_fit_any_more_leaves_the_default() {
    #[derive(Debug, Objects)]
    #[objects(device)]
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
    let smaller = Slave::builder(node(5), &STANDARD, Smaller::default());
    let mut smaller = Bench::new(smaller.store(Box::leak(Box::new(memory.clone()))).build());
    assert_eq!(smaller.node.objects().application.calibration.as_bytes(), b"unity");
    assert_eq!(errors(&mut smaller), (1, 1));
}

/// A number of old firmware that is no variant in new firmware.
///
/// Verifies: ECSS 6.8a
#[test]
fn a_stored_number_without_a_variant_leaves_the_default() {
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
    #[repr(u16)]
    enum Mode {
        #[default]
        Idle = 1,
        Active = 2,
    }
    #[derive(Debug, Objects)]
    #[objects(device)]
    struct Moded<T: Number + core::fmt::Debug + Send + 'static> {
        /// Mode
        #[object(0x2104, rw)]
        mode: T,
    }
    impl<T: Number + core::fmt::Debug + Send> Device for Moded<T> {
        type Pdos = PdoObjects;
        type Consumers = HeartbeatConsumers;

        const PDOS: PdoSet = PdoSet::NONE;
    }
    fn powered<T: Number + core::fmt::Debug + Send>(memory: &Memory) -> Bench<Slave<Moded<T>>> {
        let slave = Slave::builder(node(5), &STANDARD, Moded::default());
        Bench::new(slave.store(Box::leak(Box::new(memory.clone()))).build())
    }
    for (stored, mode, reported) in [(2, Mode::Active, (0, 0)), (5, Mode::Idle, (1, 1))] {
        let memory = Memory::default();
        let mut older = powered::<u16>(&memory);
        assert_eq!(write(&mut older, 0x2104, 0, &[stored, 0]), done(0x2104, 0));
        assert_eq!(write(&mut older, 0x1010, 1, b"save"), done(0x1010, 1));
        let mut newer = powered::<Mode>(&memory);
        assert_eq!(newer.node.objects().application.mode, mode);
        assert_eq!(errors(&mut newer), reported);
    }
}
