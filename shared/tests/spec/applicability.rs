//! The services of CiA 301 that Table 11-1 applies, leaves open or excludes, at a slave.

use ecss_can::node::{DeviceNode, SlaveEvent};
use ecss_can::od::U48;
use ecss_can::types::{Bus, NmtState};

use crate::bench::{NOMINAL, frame, ms, span};
use crate::device::fixture::{
    NO_INHIBIT, ask, done, download, initiate, operational, payloads, powered, read, refused, write,
    write_all,
};
use crate::instrument::{Outgoing, TELEMETRY_TPDO};

/// A block of bytes.
const STORE: u16 = 0x6300;
/// There is no such object.
const ABSENT: u32 = 0x0602_0000;

/// Given a slave, when it is powered and commanded, then it boots up, sends its heartbeat and obeys the five commands of NMT, also
/// straight from reset communication to Operational.
///
/// Verifies: ECSS 6.5.1a.1, 6.5.1a.2, 6.5.1a.3, 6.5.1a.4, 6.5.1a.5
/// Notices: ECSS 6.5.1a.1: Start is ignored until a heartbeat of the master is heard.
/// Notices: ECSS 6.5.1a.5: Reset communication sends no boot-up message.
/// Notices: ECSS 6.5.1a.3: Enter pre-operational is ignored in Stopped.
#[test]
fn nmt_services_that_apply_are_there() {
    let mut slave = powered();
    slave.run_until(ms(200));
    assert_eq!(payloads(&slave, 0x705), [[0x00], [0x7F], [0x7F]]);
    for (command, state) in [(0x01, 0x05), (0x02, 0x04), (0x80, 0x7F), (0x01, 0x05)] {
        slave.clear();
        slave.receive(NOMINAL, 0x000, &[command, 5]);
        assert_eq!(payloads(&slave, 0x705), [[state]], "{command:02X}h");
    }
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(payloads(&slave, 0x705)[0], [0x00]);
    slave.receive(NOMINAL, 0x000, &[0x01, 5]);
    assert!(slave.events.contains(&SlaveEvent::State(NmtState::Operational)));
    slave.receive(NOMINAL, 0x000, &[0x81, 5]);
    assert!(slave.events.contains(&SlaveEvent::ResetNode));
}

/// Given a slave in Operational, then a PDO brings it a command, an event and a SYNC make it send one, and expedited and segmented SDO
/// transfers state their sizes and can be aborted.
///
/// Verifies: ECSS 11.1a, 6.1a, 6.2a, 6.9b, 6.9e
/// Notices: ECSS 11.1a: an upload in segments does not state its size.
/// Notices: ECSS 6.1a: a segmented download goes on after an abort of its client.
/// Notices: ECSS 6.9b: SYNC triggers no PDO.
#[test]
fn pdo_and_sdo_services_that_apply_are_there() {
    let mut slave = operational();
    slave.receive(NOMINAL, 0x305, &[0x34, 0x12, 9, 0, 0, 0, 0, 0]);
    assert_eq!(slave.node.objects().application.telecommand.code, 0x1234);
    slave.clear();
    slave.touch(|slave, now| {
        slave.change(now, |objects| objects.telemetry = Outgoing { code: 0x0102, data: U48::new(3) });
        slave.send_pdo(TELEMETRY_TPDO, now);
    });
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x385, &[0x02, 0x01, 3, 0, 0, 0, 0, 0]))]);
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(payloads(&slave, 0x185).len(), 1);

    // Of four bytes two are data.
    assert_eq!(ask(&mut slave, [0x40, 0x17, 0x10, 0, 0, 0, 0, 0]), [0x4B, 0x17, 0x10, 0, 100, 0, 0, 0]);
    assert_eq!(write(&mut slave, 0x1017, 0, &[50, 0]), done(0x1017, 0));
    assert_eq!(write(&mut slave, 0x1017, 0, &[50]), refused(0x1017, 0, 0x0607_0013));
    assert_eq!(download(&mut slave, STORE, 0, &[7; 10])[0], 0x30);
    assert_eq!(ask(&mut slave, [0x40, 0x00, 0x63, 0, 0, 0, 0, 0]), [0x41, 0x00, 0x63, 0, 10, 0, 0, 0]);
    assert_eq!(ask(&mut slave, [0x60, 0, 0, 0, 0, 0, 0, 0]), [0x00, 7, 7, 7, 7, 7, 7, 7]);
    assert_eq!(ask(&mut slave, [0x70, 0, 0, 0, 0, 0, 0, 0]), [0x19, 7, 7, 7, 0, 0, 0, 0]);
    // Its size is 5, and 6 bytes come.
    assert_eq!(ask(&mut slave, initiate(STORE, 0, 5)), done(STORE, 0));
    assert_eq!(ask(&mut slave, [0x03, 1, 2, 3, 4, 5, 6, 0])[0], 0x80);
    assert_eq!(ask(&mut slave, initiate(STORE, 0, 5)), done(STORE, 0));
    slave.clear();
    slave.receive(NOMINAL, 0x605, &[0x80, 0x00, 0x63, 0, 0, 0, 0, 0x08]);
    assert_eq!(slave.frames(), []);
    assert_eq!(ask(&mut slave, [0x05, 1, 2, 3, 4, 5, 0, 0])[0], 0x80, "its transfer is over");
}

/// Given what the table leaves to the implementer, then the choice is: all services of SDO, block transfers among them, records for
/// complex data types, and the objects of each state but TIME.
///
/// Verifies: ECSS 11.1a, 11.1b, 6.1a, 6.5.4a, 6.8a
/// Notices: ECSS 11.1b: a block upload that a client begins sends no segments.
/// Notices: ECSS 11.1a: a block upload does not state its size.
/// Notices: ECSS 6.5.4a: a slave answers SDO requests in Stopped.
#[test]
fn optional_services_are_those_that_were_chosen() {
    let mut slave = operational();
    assert_eq!(download(&mut slave, STORE, 0, &[7; 10])[0], 0x30);
    // Block upload: ten bytes in two segments, five bytes of the last one are none.
    assert_eq!(ask(&mut slave, [0xA0, 0x00, 0x63, 0, 127, 0, 0, 0])[..5], [0xC2, 0x00, 0x63, 0, 10]);
    slave.clear();
    slave.receive(NOMINAL, 0x605, &[0xA3, 0, 0, 0, 0, 0, 0, 0]);
    let segments = [[0x01, 7, 7, 7, 7, 7, 7, 7], [0x82, 7, 7, 7, 0, 0, 0, 0]];
    assert_eq!(payloads(&slave, 0x585), segments);
    assert_eq!(ask(&mut slave, [0xA2, 2, 127, 0, 0, 0, 0, 0])[0], 0xC1 | 4 << 2);
    slave.receive(NOMINAL, 0x605, &[0xA1, 0, 0, 0, 0, 0, 0, 0]);
    // Records: identity with four entries, parameters of a PDO.
    assert_eq!(read(&mut slave, 0x1018, 0)[0], 4);
    assert!(read(&mut slave, 0x1400, 0)[0] >= 2);
    // A PDO is of Operational, SDO and SYNC of Pre-operational as well, and nothing but NMT of Stopped.
    for (command, pdos, answers) in [(0x01, 1, 1), (0x80, 0, 1), (0x02, 0, 0)] {
        slave.receive(NOMINAL, 0x000, &[command, 5]);
        slave.clear();
        slave.receive(NOMINAL, 0x080, &[]);
        slave.receive(NOMINAL, 0x605, &[0x40, 0x17, 0x10, 0, 0, 0, 0, 0]);
        let sent = (payloads(&slave, 0x185).len(), payloads(&slave, 0x585).len());
        assert_eq!(sent, (pdos, answers), "{command:02X}h");
    }
}

/// Given what the table excludes, then a slave has none of it: PDOs on remote request, multiplex PDOs, TIME and node guarding. The
/// CRC of a block transfer is for clients that offer it, and EMCY ends with 1014h.
///
/// Verifies: ECSS 11.1c, 6.1a, 6.2a, 6.4a, 7.2.3f
/// Notices: ECSS 11.1c: transmission types 252 and 253 are taken.
/// Notices: ECSS 11.1c: a valid TPDO may be changed to one that allows remote frames.
/// Notices: ECSS 11.1c: heartbeats of a stopped slave have the toggle bit of node guarding.
/// Notices: ECSS 6.4a: emergencies are sent while 1014h is not valid.
/// Notices: ECSS 7.2.3f: the filters of a slave admit the time object of CiA 301 (100h).
#[test]
fn excluded_services_are_not_used() {
    let mut slave = operational();
    // Remote requests: transmission types 252 and 253, and a TPDO that allows them (bit 30 clear).
    for transmission in [252, 253] {
        assert_eq!(write(&mut slave, 0x1803, 2, &[transmission]), refused(0x1803, 2, 0x0609_0030));
        assert_eq!(write(&mut slave, 0x1403, 2, &[transmission]), refused(0x1403, 2, 0x0609_0030));
    }
    assert_eq!(write(&mut slave, 0x1803, 1, &[0x85, 4, 0, 0]), refused(0x1803, 1, 0x0609_0030));
    // Also of a TPDO that is valid, with the identifier that it has.
    assert_eq!(read(&mut slave, 0x1802, 1), [0x85, 3, 0, 0x40]);
    assert_eq!(write(&mut slave, 0x1802, 1, &[0x85, 3, 0, 0]), refused(0x1802, 1, 0x0609_0030));
    // A mapping of 254 or 255 objects is that of a multiplex PDO.
    for mapping in [0x1603, 0x1A03] {
        for count in [0xFE, 0xFF] {
            assert_eq!(write(&mut slave, mapping, 0, &[count])[0], 0x80, "{mapping:04X}h, {count}");
        }
    }
    // TIME, and node guarding.
    for index in [0x1012_u16, 0x1013, 0x100C, 0x100D] {
        let [low, high] = index.to_le_bytes();
        assert_eq!(ask(&mut slave, [0x40, low, high, 0, 0, 0, 0, 0]), refused(index, 0, ABSENT));
    }
    slave.clear();
    for bus in Bus::ALL {
        assert!(!slave.admits(bus, 0x100));
        slave.receive(bus, 0x100, &[0, 0, 0, 0, 0x10, 0x27]);
    }
    assert_eq!((slave.frames(), slave.events.len()), (vec![], 0));
    // A block of a client that offers no CRC (bit 2 of the first byte is clear).
    assert_eq!(ask(&mut slave, [0xC2, 0x00, 0x63, 0, 3, 0, 0, 0])[0] & 0xFB, 0xA0);
    assert_eq!(ask(&mut slave, [0x81, 1, 2, 3, 0, 0, 0, 0])[..2], [0xA2, 1]);
    assert_eq!(ask(&mut slave, [0xC1 | 4 << 2, 0, 0, 0, 0, 0, 0, 0])[0], 0xA1);
    assert_eq!(slave.node.objects().application.store.as_bytes(), [1, 2, 3]);
    // A PDO that is too short raises an emergency, until 1014h is not valid.
    write_all(&mut slave, &[NO_INHIBIT]);
    slave.clear();
    slave.receive(NOMINAL, 0x305, &[1]);
    assert_eq!(payloads(&slave, 0x085).len(), 1);
    write_all(&mut slave, &[(0x1014, 0, &[0x85, 0, 0, 0x80])]);
    slave.clear();
    slave.receive(NOMINAL, 0x405, &[1]);
    assert_eq!(payloads(&slave, 0x085), [[0; 8]; 0]);
    // Bit 7 of a heartbeat is the toggle bit of node guarding.
    for (command, state) in [(0x80, 0x7F), (0x01, 0x05), (0x02, 0x04)] {
        slave.receive(NOMINAL, 0x701, &[0x05]);
        slave.receive(NOMINAL, 0x000, &[command, 5]);
        slave.clear();
        slave.run_until(slave.now + span(200));
        assert_eq!(payloads(&slave, 0x705), [[state]; 2]);
    }
}
