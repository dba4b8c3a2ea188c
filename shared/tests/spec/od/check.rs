//! What an application decides itself of a value that a client writes.

use std::cell::RefCell;

use crate::instrument::STANDARD;
use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, Slave, SlaveBuilder, SlaveEvent};
use ecss_can::od::{Objects, VisibleString, checked};
use ecss_can::pdo::{Mapping, PdoObjects, PdoSet};
use ecss_can::types::AbortCode::{ParameterIncompatible, ReadOnly, TooLong, ValueRange, ValueTooHigh};
use ecss_can::types::{AbortCode, Address, NodeId};

use super::{at, read};
use crate::bench::{Bench, NOMINAL, frame, node};
use crate::device::fixture::{Memory, ask, done, download, errors, refused, write};

/// What the function of the camera was asked for.
#[derive(Debug, Default)]
struct Asked(RefCell<Vec<Address>>);

impl Asked {
    /// Since the last time.
    fn take(&self) -> Vec<Address> {
        self.0.take()
    }
}

/// A camera.
#[derive(Debug, Objects)]
#[objects(device, check = Camera::in_order)]
struct Camera {
    /// Begin of the window
    #[object(0x6000, rw, high = 1_000)]
    begin: u16,
    /// End of the window
    #[object(0x6001, rw, high = 1_000, default = 100)]
    end: u16,
    /// Serial number
    #[object(0x6002, ro)]
    serial: u16,
    /// Lens
    #[objects]
    lens: Lens,
    /// Shutter
    #[objects]
    shutter: Shutter,
    #[skip]
    asked: Asked,
}

impl Camera {
    /// The window ends behind its begin.
    fn in_order(&self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        self.asked.0.borrow_mut().push(at);
        let (begin, end) = match (at.index, value) {
            (0x6000, &[low, high]) => (u16::from_le_bytes([low, high]), self.end),
            (0x6001, &[low, high]) => (self.begin, u16::from_le_bytes([low, high])),
            _ => return Ok(()),
        };
        if begin < end { Ok(()) } else { Err(ParameterIncompatible) }
    }
}

/// A group without a function, and one with it in it.
#[derive(Debug, Objects)]
struct Lens {
    /// Focus
    #[object(0x6010, rw)]
    focus: u32,
    /// Label
    #[objects]
    label: Label,
}

#[derive(Debug, Objects)]
#[objects(check = named)]
struct Label {
    /// Name
    #[object(0x6020, rw, default = VisibleString::new(b"Wide").unwrap_or_default())]
    name: VisibleString<16>,
}

/// A name begins with a capital.
fn named(_: &Label, at: Address, value: &[u8]) -> Result<(), AbortCode> {
    let is_named = value.first().is_some_and(u8::is_ascii_uppercase);
    if at.index != 0x6020 || is_named { Ok(()) } else { Err(ValueRange) }
}

#[derive(Debug, Objects)]
#[objects(check = odd)]
struct Shutter {
    /// Blades
    #[object(0x6030, array, rw, default = [3; 2])]
    blades: [u8; 2],
}

fn odd(_: &Shutter, at: Address, value: &[u8]) -> Result<(), AbortCode> {
    match (at.index, value) {
        (0x6030, [blades]) if blades % 2 == 0 => Err(AbortCode::CannotTransfer),
        _ => Ok(()),
    }
}

#[test]
fn a_value_that_a_function_refuses_stays_in_all_groups() {
    let mut camera = Camera::default();
    let table: [(u16, u8, &[u8], Option<AbortCode>); 10] = [
        (0x6000, 0, &[99, 0], None),
        (0x6000, 0, &[100, 0], Some(ParameterIncompatible)),
        (0x6001, 0, &[99, 0], Some(ParameterIncompatible)),
        (0x6001, 0, &[200, 0], None),
        (0x6000, 0, &[100, 0], None),
        (0x6010, 0, &[0; 4], None),
        (0x6020, 0, b"narrow", Some(ValueRange)),
        (0x6020, 0, b"Narrow", None),
        (0x6030, 2, &[4], Some(AbortCode::CannotTransfer)),
        (0x6030, 1, &[5], None),
    ];
    for (index, sub, value, code) in table {
        let before = read(&mut camera, index, sub).unwrap();
        assert_eq!(checked::write(&mut camera, at(index, sub), value).err(), code, "{index:04X}h {value:?}");
        let after = if code.is_none() { value.to_vec() } else { before };
        assert_eq!(read(&mut camera, index, sub), Ok(after));
    }
    assert_eq!((camera.begin, camera.end, camera.shutter.blades), (100, 200, [5, 3]));
    assert_eq!(camera.lens.label.name.as_bytes(), b"Narrow");
}

/// Verifies: ECSS 6.8a
#[test]
fn a_function_is_asked_for_values_that_keep_type_and_limits() {
    let mut camera = Camera::default();
    let table: [(u16, u8, &[u8], AbortCode); 5] = [
        (0x6000, 0, &[0xE9, 3], ValueTooHigh),
        (0x6000, 0, &[1], AbortCode::TooShort),
        (0x6020, 0, &[b'A'; 17], TooLong),
        (0x6002, 0, &[1, 0], ReadOnly),
        (0x6040, 0, &[1], AbortCode::NoObject),
    ];
    for (index, sub, value, code) in table {
        assert_eq!(checked::write(&mut camera, at(index, sub), value), Err(code));
        assert_eq!(camera.asked.take(), [], "{index:04X}h");
    }
    assert_eq!(checked::write(&mut camera, at(0x6000, 0), &[1, 0]), Ok(()));
    assert_eq!(camera.asked.take(), [at(0x6000, 0)], "once");
}

impl Device for Camera {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PdoSet::NONE;
}

fn slave(application: Camera) -> SlaveBuilder<'static, Camera> {
    Slave::builder(node(5), &STANDARD, application)
}

/// Verifies: ECSS 6.1a
#[test]
fn a_client_is_told_why_whatever_transfer_it_chose() {
    let mut slave = Bench::new(slave(Camera::default()).build());
    // Expedited: a number with limits, one without, an entry of an array.
    for (index, sub, good, bad, code) in [
        (0x6000, 0, &[50, 0][..], &[100, 0][..], 0x0604_0043),
        (0x6030, 2, &[7], &[8], 0x0800_0020),
        (0x6020, 0, b"Tele", b"tele", 0x0609_0030),
    ] {
        slave.clear_events();
        assert_eq!(write(&mut slave, index, sub, bad), refused(index, sub, code));
        assert_eq!(slave.events, []);
        assert_eq!(write(&mut slave, index, sub, good), done(index, sub));
        assert_eq!(slave.events, [SlaveEvent::Written(at(index, sub))]);
    }
    // Beyond its limit the function is not asked.
    slave.node.objects().application.asked.take();
    assert_eq!(write(&mut slave, 0x6000, 0, &[0xE9, 3]), refused(0x6000, 0, 0x0609_0031));
    assert_eq!(slave.node.objects().application.asked.take(), []);
    // Segmented: the answer to the last one.
    assert_eq!(download(&mut slave, 0x6020, 0, b"panorama"), refused(0x6020, 0, 0x0609_0030));
    assert_eq!(slave.node.objects().application.lens.label.name.as_bytes(), b"Tele");
    assert_eq!(download(&mut slave, 0x6020, 0, b"Panorama")[0], 0x30);
    // Segmented, though it would have fitted into one frame.
    assert_eq!(download(&mut slave, 0x6000, 0, &[100, 0]), refused(0x6000, 0, 0x0604_0043));
    // A block: refused at its end, when all of it is there.
    assert_eq!(ask(&mut slave, [0xC2, 0x20, 0x60, 0, 8, 0, 0, 0])[0], 0xA0);
    slave.receive(NOMINAL, 0x605, b"\x01fisheye");
    assert_eq!(ask(&mut slave, [0x82, b'!', 0, 0, 0, 0, 0, 0])[..2], [0xA2, 2]);
    assert_eq!(ask(&mut slave, [0xD9, 0, 0, 0, 0, 0, 0, 0]), refused(0x6020, 0, 0x0609_0030));
    let camera = &slave.node.objects().application;
    assert_eq!(camera.lens.label.name.as_bytes(), b"Panorama");
    assert_eq!((camera.begin, camera.end, camera.shutter.blades), (50, 100, [3, 7]));
}

/// A device whose telemetry keeps its COB-ID. A function is asked for all objects of its node.
#[derive(Debug, Objects)]
#[objects(device, check = keeps_cob_id)]
struct Fixed {
    /// Value
    #[object(0x6000, ro, pdo)]
    value: u8,
}

impl Device for Fixed {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PdoSet::NONE;

    fn pdos(id: NodeId) -> PdoObjects {
        let mut objects: PdoObjects = Self::PDOS.at_power_on(id);
        objects.tpdo_mappings[2].map(&[0x6000_0008]);
        objects
    }
}

fn keeps_cob_id(_: &Fixed, at: Address, value: &[u8]) -> Result<(), AbortCode> {
    let is_another = !value.starts_with(&[0x85, 3, 0]);
    if at == Address::new(0x1802, 1) && is_another { Err(ParameterIncompatible) } else { Ok(()) }
}

/// Verifies: ECSS 6.2a
#[test]
fn what_a_function_refuses_of_a_pdo_its_service_does_not_take() {
    let application = Fixed::default();
    let mut slave = Bench::new(Slave::builder(node(5), &STANDARD, application).build());
    let event = |slave: &mut Bench<Slave<Fixed>>| {
        slave.clear();
        slave.touch(|slave, now| slave.send_pdo(2, now));
        slave.frames()
    };
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    assert_eq!(write(&mut slave, 0x1802, 1, &[0x86, 3, 0, 0x40]), refused(0x1802, 1, 0x0604_0043));
    assert_eq!(event(&mut slave), []);
    assert_eq!(write(&mut slave, 0x1802, 1, &[0x85, 3, 0, 0x40]), done(0x1802, 1));
    assert_eq!(event(&mut slave), [(NOMINAL, frame(0x385, &[0]))]);
    assert_eq!(write(&mut slave, 0x1802, 1, &[0x86, 3, 0, 0xC0]), refused(0x1802, 1, 0x0604_0043));
    assert_eq!(event(&mut slave), [(NOMINAL, frame(0x385, &[0]))]);
}

/// A camera of before, whose names could be anything.
#[derive(Debug, Objects)]
#[objects(device)]
struct OldCamera {
    /// Name
    #[object(0x6020, rw)]
    name: VisibleString<16>,
    /// Blades
    #[object(0x6030, array, rw)]
    blades: [u8; 2],
}

impl Device for OldCamera {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PdoSet::NONE;
}

/// Verifies: ECSS 6.4a.1, 6.8a
#[test]
fn refused_stored_value_is_not_applied_and_raises_an_emcy() {
    let memory = Memory::default();
    let store = || -> &'static mut Memory { Box::leak(Box::new(memory.clone())) };
    let old = OldCamera { name: VisibleString::new(b"fisheye").unwrap(), blades: [9, 4] };
    let mut old = Bench::new(Slave::<OldCamera>::builder(node(5), &STANDARD, old).store(store()).build());
    assert_eq!(write(&mut old, 0x1010, 1, b"save"), done(0x1010, 1));
    let mut new = Bench::new(slave(Camera::default()).store(store()).build());
    let camera = &new.node.objects().application;
    assert_eq!(camera.lens.label.name.as_bytes(), b"Wide");
    assert_eq!(camera.shutter.blades, [9, 3], "each by itself");
    assert_eq!(errors(&mut new), (1, 1));
    assert_eq!(new.node.objects().communication.emcy.errors.errors[0], 0x6300);
}
