//! PDOs that their defaults or their application declare and that cannot be; values that a PDO brings and that are refused.
//!
//! Verifies: ECSS 6.2a

use std::cell::Cell;

use crate::instrument::STANDARD;
use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::link::port::Filter;
use ecss_can::node::extend::BusCommand;
use ecss_can::node::{Device, Slave, SlaveEvent};
use ecss_can::od::{INVALID, NO_REMOTE, Objects};
use ecss_can::pdo::{Mapping, PdoObjects, PdoSet};
use ecss_can::profile::Profile;
use ecss_can::types::{AbortCode, Bus, CobId, NodeId};

use super::fixture::{NO_INHIBIT, done, errors, payloads, read, refused, write, write_all};
use crate::bench::{Bench, NOMINAL, node, pdos};

#[derive(Debug, Objects)]
#[objects(device)]
struct Probe {
    /// Not for PDOs
    #[object(0x6000, rw)]
    setting: u8,
    /// Measured
    #[object(0x6001, ro, pdo)]
    measured: u8,
    /// Level
    #[object(0x6002, rww, pdo, low = 10, high = 20, default = 10)]
    level: u8,
    /// Beside it
    #[object(0x6003, rww, pdo)]
    beside: u8,
}

thread_local! {
    /// What the present test has as defaults.
    static DEFAULTS: Cell<fn(NodeId) -> PdoObjects> = const { Cell::new(|_| PdoObjects::default()) };
}

impl Device for Probe {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PdoSet::NONE;

    fn pdos(id: NodeId) -> PdoObjects {
        DEFAULTS.get()(id)
    }
}

type TestDevice = Bench<Slave<Probe>>;

fn started(defaults: fn(NodeId) -> PdoObjects) -> TestDevice {
    DEFAULTS.set(defaults);
    let profile = Profile { autostart: true, ..STANDARD };
    Bench::new(Slave::builder(node(5), &profile, Probe::default()).build())
}

/// TPDO 2, by event, and RPDO 3, of these objects.
fn mapped(id: NodeId, sent: &[u32], received: &[u32]) -> PdoObjects {
    let mut objects: PdoObjects = PdoSet::NONE.at_power_on(id);
    objects.tpdos[1].cob_id = NO_REMOTE | 0x285;
    objects.tpdo_mappings[1].map(sent);
    objects.rpdos[2].cob_id = NO_REMOTE | 0x405;
    objects.rpdo_mappings[2].map(received);
    objects
}

/// 6300h: which PDO, its object, the low half of the abort code that a client would be told.
fn emergency(source: u8, index: u16, abort: u16) -> [u8; 8] {
    let ([low, high], [code_low, code_high]) = (index.to_le_bytes(), abort.to_le_bytes());
    [0x00, 0x63, 0x01, source, low, high, code_low, code_high]
}

fn mend_tpdo(slave: &mut TestDevice) {
    write_all(slave, &[(0x1A01, 0, &[0]), (0x1A01, 1, &[8, 0, 1, 0x60]), (0x1A01, 0, &[1])]);
    slave.clear();
    write_all(slave, &[(0x1801, 1, &[0x85, 2, 0, 0x40])]);
}

/// Given defaults that map an object which is not for PDOs. Then the PDO is not valid, which reads so, and an emergency
/// names it; a client who mends it ends the error.
///
/// Verifies: ECSS 6.4a.1
#[test]
fn a_default_tpdo_that_cannot_be_is_reported() {
    let mut slave = started(|id| mapped(id, &[0x6000_0008], &[0x6002_0008]));
    assert_eq!(payloads(&slave, 0x085), [emergency(130, 0x1801, 0x0041)]);
    assert_eq!(read(&mut slave, 0x1801, 1), [0x85, 2, 0, 0xC0]);
    assert_eq!(errors(&mut slave), (1, 1));
    assert_eq!(read(&mut slave, 0x1003, 1), [0x00, 0x63, 130, 0x01]);
    // Others go on.
    slave.receive(NOMINAL, 0x405, &[12]);
    assert_eq!(slave.node.objects().application.level, 12);
    write_all(&mut slave, &[NO_INHIBIT]);
    mend_tpdo(&mut slave);
    assert_eq!(payloads(&slave, 0x085), [[0, 0, 0, 0x00, 0x63, 130, 0, 0]]);
    assert_eq!(errors(&mut slave), (0, 1));
    slave.clear();
    slave.touch(|slave, now| slave.send_pdo(1, now));
    assert_eq!(payloads(&slave, 0x285), [[0]]);
}

/// Verifies: ECSS 6.4a.1
#[test]
fn a_default_rpdo_that_cannot_be_is_reported() {
    let mut slave = started(|id| mapped(id, &[0x6001_0008], &[0x6001_0008]));
    assert_eq!(payloads(&slave, 0x085), [emergency(3, 0x1402, 0x0041)]);
    assert_eq!(read(&mut slave, 0x1402, 1), [0x05, 4, 0, 0xC0]);
    slave.clear();
    slave.receive(NOMINAL, 0x405, &[12]);
    assert_eq!(slave.events, []);
}

/// Verifies: ECSS 11.1c, 6.10b
/// Notices: ECSS 11.1c: the defaults of a device may have types 252 and 253, remote requests.
/// Notices: ECSS 6.10b: the defaults of a device may give a PDO the COB-ID of EMCY.
#[test]
fn every_reason_for_which_a_default_cannot_be_is_reported() {
    type Defaults = fn(NodeId) -> PdoObjects;
    let table: [(Defaults, u16); 11] = [
        // No object, no sub-index, too long, nothing.
        (|id| mapped(id, &[0x6009_0008], &[0x6002_0008]), 0x0000),
        (|id| mapped(id, &[0x6001_0108], &[0x6002_0008]), 0x0011),
        (|id| mapped(id, &[0x2020_0520, 0x2020_0620, 0x6001_0008], &[0x6002_0008]), 0x0042),
        (|id| mapped(id, &[], &[0x6002_0008]), 0x0043),
        // An identifier that is restricted, of SYNC, of emergencies, of an extended frame; a transmission type that there is not.
        (|id| with(id, NO_REMOTE | 0x601, 254), 0x0030),
        (|id| with(id, NO_REMOTE | 0x080, 254), 0x0043),
        (|id| with(id, NO_REMOTE | 0x085, 254), 0x0043),
        (|id| with(id, NO_REMOTE | 1 << 29 | 0x285, 254), 0x0030),
        (|id| with(id, NO_REMOTE | 0x285, 245), 0x0030),
        // Remote requests.
        (|id| with(id, NO_REMOTE | 0x285, 252), 0x0030),
        (|id| with(id, NO_REMOTE | 0x285, 253), 0x0030),
    ];
    for (nth, (defaults, abort)) in table.into_iter().enumerate() {
        let mut slave = started(defaults);
        assert_eq!(payloads(&slave, 0x085), [emergency(130, 0x1801, abort)], "{nth}");
        assert_eq!(read(&mut slave, 0x1801, 1)[3] & 0x80, 0x80, "{nth}");
    }
}

fn with(id: NodeId, cob_id: u32, transmission: u8) -> PdoObjects {
    let mut objects = mapped(id, &[0x6001_0008], &[0x6002_0008]);
    (objects.tpdos[1].cob_id, objects.tpdos[1].transmission) = (cob_id, transmission);
    objects
}

/// Reset communication brings the same defaults: the error goes on and is not told again.
///
/// Verifies: ECSS 6.4a.1
/// Notices: ECSS 6.4a.1: each Reset communication reports an error again that goes on.
#[test]
fn a_default_that_cannot_be_is_told_once() {
    let mut slave = started(|id| mapped(id, &[0x6000_0008], &[0x6002_0008]));
    // The slave finds its master, announces the error once more, and hears that the master is still there.
    for _ in 0..2 {
        slave.receive(NOMINAL, 0x701, &[5]);
        slave.run_until(slave.now + crate::bench::span(110));
    }
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    slave.run_until(slave.now + crate::bench::span(200));
    assert_eq!(payloads(&slave, 0x085), [[0; 8]; 0]);
    assert_eq!(read(&mut slave, 0x1801, 1), [0x85, 2, 0, 0xC0]);
    assert_eq!(errors(&mut slave), (1, 1));
}

/// The rules for clients hold for the application: it hears what is wrong, and what was valid goes on.
#[test]
fn a_pdo_that_the_application_makes_impossible_is_refused() {
    let mut slave = started(|id| mapped(id, &[0x6001_0008], &[0x6002_0008]));
    let unmappable = 0x6000_0008_u32.to_le_bytes();
    slave.clear();
    assert_eq!(slave.write((0x1A01, 1), &unmappable), Err(AbortCode::UnsupportedAccess));
    let (invalid, valid) = ((INVALID | NO_REMOTE | 0x285).to_le_bytes(), (NO_REMOTE | 0x285).to_le_bytes());
    for (at, value) in [((0x1801, 1), &invalid[..]), ((0x1A01, 0), &[0])] {
        assert_eq!(slave.write(at, value), Ok(()));
    }
    assert_eq!(slave.write((0x1A01, 1), &unmappable), Err(AbortCode::NotMappable));
    assert_eq!(slave.write((0x1801, 1), &valid), Err(AbortCode::ParameterIncompatible), "nothing is mapped");
    assert_eq!(payloads(&slave, 0x085), [[0; 8]; 0]);
    for (at, value) in [((0x1A01, 1), &[8, 0, 1, 0x60][..]), ((0x1A01, 0), &[1]), ((0x1801, 1), &valid)] {
        assert_eq!(slave.write(at, value), Ok(()));
    }
    slave.clear();
    slave.touch(|slave, now| slave.send_pdo(1, now));
    assert_eq!(payloads(&slave, 0x285), [[0]]);
    // Its frames do not come through to a receive PDO that is not valid.
    slave.clear();
    assert_eq!(slave.write((0x1402, 1), &(INVALID | NO_REMOTE | 0x405).to_le_bytes()), Ok(()));
    let nothing = Filter::exact(CobId::NMT);
    assert_eq!(slave.controls, Bus::ALL.map(|bus| (bus, BusCommand::Filter { number: 14, filter: nothing })));
    slave.receive(NOMINAL, 0x405, &[12]);
    assert_eq!(slave.events, []);
}

fn refused_so_far(slave: &TestDevice) -> u16 {
    slave.node.status(slave.now).counters[NOMINAL].malformed
}

/// The application hears of values that took effect; one that was refused is an emergency, and counted.
///
/// Verifies: ECSS 6.4a.1
#[test]
fn a_refused_value_is_no_event_of_its_rpdo() {
    let mut slave = started(|id| mapped(id, &[0x6001_0008], &[0x6002_0008, 0x6003_0008]));
    slave.clear();
    for (nth, value) in [(1, 21), (2, 9)] {
        slave.receive(NOMINAL, 0x405, &[value, nth as u8]);
        assert_eq!(slave.events, [], "{value}");
        assert_eq!(refused_so_far(&slave), nth);
        let application = &slave.node.objects().application;
        assert_eq!((application.level, application.beside), (10, nth as u8), "the other value is written");
    }
    assert_eq!(payloads(&slave, 0x085), [[0x00, 0x82, 0x11, 2, 0, 0, 0, 0]], "once");
    slave.receive(NOMINAL, 0x405, &[20, 7]);
    let data = [20, 7, 0, 0, 0, 0, 0, 0];
    assert_eq!(pdos(&slave.events), [Some((NOMINAL, 2, data))]);
    assert_eq!(refused_so_far(&slave), 2);
}

/// Verifies: ECSS 6.9e, 6.4a.1, 6.9b
#[test]
fn a_refused_value_is_no_event_of_its_synchronous_rpdo() {
    let mut slave = started(|id| {
        let mut objects = mapped(id, &[0x6001_0008], &[0x6002_0008, 0x6003_0008]);
        objects.rpdos[2].transmission = 1;
        objects
    });
    let synchronised = |slave: &TestDevice| {
        let of_pdo = |event: &&SlaveEvent| matches!(event, SlaveEvent::Synchronised(_));
        slave.events.iter().filter(of_pdo).count()
    };
    slave.clear();
    slave.receive(NOMINAL, 0x405, &[21, 1]);
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!((synchronised(&slave), refused_so_far(&slave)), (0, 1));
    assert_eq!(payloads(&slave, 0x085), [[0x00, 0x82, 0x11, 2, 0, 0, 0, 0]]);
    slave.receive(NOMINAL, 0x405, &[20, 1]);
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!((synchronised(&slave), refused_so_far(&slave)), (1, 1));
    assert_eq!(slave.node.objects().application.level, 20);
}

/// What an application wants sent of a PDO that is not valid is counted, like what it wants in another state.
#[test]
fn an_event_of_a_pdo_that_is_not_valid_is_counted() {
    let mut slave = started(|id| mapped(id, &[0x6000_0008], &[0x6002_0008]));
    let count = |slave: &TestDevice| slave.node.status(slave.now).counters[NOMINAL].refused;
    let before = count(&slave);
    for number in [1, 6, 99] {
        slave.touch(|slave, now| slave.send_pdo(number, now));
    }
    assert_eq!(count(&slave), before + 3);
    mend_tpdo(&mut slave);
    slave.touch(|slave, now| slave.send_pdo(1, now));
    assert_eq!(count(&slave), before + 3);
}

/// CiA 301 7.5.2.35 to 7.5.2.38; the conformance test takes 06010000h, 06040041h and 08000000h (PDO 23, PDO 24).
#[test]
fn a_mapping_is_written_while_the_pdo_is_invalid_and_empty() {
    let mut slave = started(|id| mapped(id, &[0x6001_0008], &[0x6002_0008]));
    for (cob_id, mapping, base, object) in [(0x1801, 0x1A01, 0x285, 0x6001), (0x1402, 0x1602, 0x405, 0x6002)]
    {
        let entry = (u32::from(object as u16) << 16 | 8_u32).to_le_bytes();
        let valid = (NO_REMOTE | base).to_le_bytes();
        let invalid = (INVALID | NO_REMOTE | base).to_le_bytes();
        for (sub, value) in [(0, &[0][..]), (1, &entry)] {
            assert_eq!(write(&mut slave, mapping, sub, value), refused(mapping, sub, 0x0601_0000));
        }
        assert_eq!(write(&mut slave, cob_id, 1, &invalid), done(cob_id, 1));
        assert_eq!(write(&mut slave, mapping, 1, &entry), refused(mapping, 1, 0x0601_0000), "not empty");
        write_all(
            &mut slave,
            &[(mapping, 0, &[0]), (mapping, 1, &entry), (mapping, 0, &[1]), (cob_id, 1, &valid)],
        );
    }
}

/// CiA 301 7.5.2.35: bits 0 to 29 stay while the PDO is valid. The write that makes it invalid may move it, as the tools of
/// others do; that of 1014h may not.
///
/// Verifies: ECSS 6.10a, 6.10c
/// Notices: ECSS 6.10a: the COB-ID of a valid PDO can be changed.
/// Notices: ECSS 6.10c: the COB-ID of a PDO cannot be changed.
#[test]
fn a_valid_pdo_is_moved_by_the_write_that_ends_it() {
    let mut slave = started(|id| mapped(id, &[0x6001_0008], &[0x6002_0008]));
    for (index, id) in [(0x1801, 0x285), (0x1402, 0x405)] {
        let other = NO_REMOTE | (id + 1);
        assert_eq!(write(&mut slave, index, 1, &other.to_le_bytes()), refused(index, 1, 0x0601_0000));
        assert_eq!(read(&mut slave, index, 1), (NO_REMOTE | id).to_le_bytes());
        for value in [INVALID | NO_REMOTE | (id + 1), NO_REMOTE | (id + 1)] {
            assert_eq!(write(&mut slave, index, 1, &value.to_le_bytes()), done(index, 1));
        }
    }
    for other in [0x86, INVALID | 0x86] {
        assert_eq!(write(&mut slave, 0x1014, 0, &other.to_le_bytes()), refused(0x1014, 0, 0x0609_0030));
    }
    for value in [INVALID | 0x85, INVALID | 0x86, 0x86] {
        assert_eq!(write(&mut slave, 0x1014, 0, &value.to_le_bytes()), done(0x1014, 0));
    }
}

/// What is sent under one identifier comes of one service: SYNC, an emergency or a TPDO.
///
/// Verifies: ECSS 6.10b, 6.10a
/// Notices: ECSS 6.10b: a TPDO takes the COB-ID of SYNC.
#[test]
fn no_two_services_share_an_identifier_in_use() {
    let mut slave = started(|id| mapped(id, &[0x6001_0008], &[0x6002_0008]));
    write_all(
        &mut slave,
        &[
            (0x1801, 1, &[0x85, 2, 0, 0xC0]),
            (0x1402, 1, &[0x05, 4, 0, 0xC0]),
            (0x1005, 0, &[0x82, 0, 0, 0]),
            (0x1801, 1, &[0x82, 0, 0, 0xC0]),
            (0x1402, 1, &[0x82, 0, 0, 0xC0]),
        ],
    );
    // PDOs on the identifier of SYNC; a TPDO on that of the emergencies.
    let table: [(u16, u32, Option<u32>); 10] = [
        (0x1801, NO_REMOTE | 0x82, Some(0x0604_0043)),
        (0x1402, NO_REMOTE | 0x82, Some(0x0604_0043)),
        (0x1801, NO_REMOTE | 0x85, Some(0x0604_0043)),
        (0x1801, NO_REMOTE | 0x80, None),
        (0x1402, NO_REMOTE | 0x83, None),
        // SYNC on that of a TPDO, an RPDO, the emergencies.
        (0x1005, 0x80, Some(0x0604_0043)),
        (0x1005, 0x83, Some(0x0604_0043)),
        (0x1005, 0x85, Some(0x0604_0043)),
        (0x1014, INVALID | 0x85, None),
        (0x1005, 0x85, None),
    ];
    for (index, value, code) in table {
        let sub = u8::from(index != 0x1005 && index != 0x1014);
        let expected = code.map_or(done(index, sub), |code| refused(index, sub, code));
        assert_eq!(write(&mut slave, index, sub, &value.to_le_bytes()), expected, "{index:04X}h {value:X}h");
    }
    // Emergencies on that of SYNC and of a TPDO.
    for value in [0x85_u32, 0x80] {
        write_all(&mut slave, &[(0x1014, 0, &(INVALID | value).to_le_bytes())]);
        assert_eq!(write(&mut slave, 0x1014, 0, &value.to_le_bytes()), refused(0x1014, 0, 0x0604_0043));
    }
}
