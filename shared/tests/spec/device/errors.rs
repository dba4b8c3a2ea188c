//! Errors of the network that a slave tells, once each.
//!
//! Verifies: ECSS 6.4a

use ecss_can::emcy::{DeviceError, ErrorCode};
use ecss_can::node::DeviceNode;
use ecss_can::node::SlaveEvent;
use ecss_can::node::extend::LinkEvent;
use ecss_can::types::{Bus, NmtState};

use super::fixture::{
    NO_INHIBIT, ask, errors, operational, payloads, powered, read, refused, run_with_master, write_all,
};
use crate::bench::{Bench, NOMINAL, REDUNDANT, ms, node, span};
use crate::slave::TestSlave;

const HEARTBEAT_OF_SEVEN: [u8; 8] = [0x30, 0x81, 0x11, 7, 0, 0, 0, 0];
/// An error is gone, and it was the last one: which it was follows.
const HEARTBEAT_OF_SEVEN_RESET: [u8; 8] = [0, 0, 0, 0x30, 0x81, 7, 0, 0];

/// Slave 7 is heard now, and not within the next 150 ms.
fn misses_seven(slave: &mut Bench<TestSlave>) {
    write_all(slave, &[(0x1016, 2, &[150, 0, 7, 0])]);
    slave.receive(NOMINAL, 0x707, &[0x7F]);
    slave.clear();
    let missed_at = slave.now + span(150);
    run_with_master(slave, missed_at);
    assert!(slave.events.contains(&SlaveEvent::PeerMissed { node: node(7) }));
}

/// Given a slave that monitors node 7, when that node loses its power, then the slave does what 1029h says. With 1 (no change) it stays
/// Operational and sends its telemetry.
///
/// Verifies: ECSS 5.3.3.2.2b, 5.3.3.2.2a, 6.5.2a, 6.5.4a
/// Notices: ECSS 5.3.3.2.2b: a slave whose 1029h is 1 leaves Operational when another node has no power.
/// Notices: ECSS 5.3.3.2.2a: a slave whose 1029h is 1 leaves Operational when another node is off the bus.
/// Notices: ECSS 6.5.4a: a missed heartbeat stops no slave whose 1029h is 2.
#[test]
fn slave_with_1029h_1_stays_operational_without_its_peer() {
    use NmtState::{Operational, PreOperational, Stopped};
    for (behaviour, state, sent) in [(0, PreOperational, 0), (1, Operational, 1), (2, Stopped, 0)] {
        let mut slave = operational();
        write_all(&mut slave, &[(0x1029, 1, &[behaviour])]);
        misses_seven(&mut slave);
        assert_eq!(slave.node.status(slave.now).state, state, "1029h is {behaviour}");
        slave.clear();
        slave.touch(|slave, now| slave.send_pdo(2, now));
        assert_eq!(payloads(&slave, 0x385).len(), sent, "1029h is {behaviour}");
    }
}

/// CiA 301, table of emergency error codes: 8210h for an RPDO that is too short, 8220h for one that is too long, 8250h for one that
/// is overdue. The byte after the error register is the number of the RPDO, from zero.
///
/// Verifies: ECSS 6.4a.1, 6.4a.2, 6.2a, 6.4b
/// Notices: ECSS 6.4a.2: an RPDO that is too long is reported with the error code of one that is too short.
/// Notices: ECSS 6.4b: the end of the event timer of an RPDO (8250h) is not reported.
#[test]
fn each_error_of_an_rpdo_has_the_code_of_canopen() {
    let mut slave = operational();
    // RPDO 5 is a word with an event timer of 20 ms, 250h.
    write_all(
        &mut slave,
        &[
            NO_INHIBIT,
            (0x1604, 1, &0x6210_0020_u32.to_le_bytes()),
            (0x1604, 0, &[1]),
            (0x1404, 5, &20_u16.to_le_bytes()),
            (0x1404, 1, &0x4000_0250_u32.to_le_bytes()),
        ],
    );
    slave.clear();
    slave.receive(NOMINAL, 0x250, &[1, 2, 3]);
    slave.receive(NOMINAL, 0x250, &[1, 2, 3, 4]);
    slave.receive(NOMINAL, 0x250, &[1, 2, 3, 4, 5]);
    slave.receive(NOMINAL, 0x250, &[1, 2, 3, 4]);
    slave.run_until(slave.now + span(20));
    let begins = |code: [u8; 2]| [code[0], code[1], 0x11, 4, 0, 0, 0, 0];
    let ends = |code: [u8; 2]| [0, 0, 0, code[0], code[1], 4, 0, 0];
    let (short, long) = ([0x10, 0x82], [0x20, 0x82]);
    let expected = [begins(short), ends(short), begins(long), ends(long), begins([0x50, 0x82])];
    assert_eq!(payloads(&slave, 0x085), expected);
}

/// Verifies: ECSS 6.4a.1, 6.4a.2, 6.5.1a.5
/// Notices: ECSS 6.5.1a.5: a missed heartbeat stays in 1001h after Reset communication.
#[test]
fn reset_communication_clears_missed_heartbeat_until_next_miss() {
    let mut slave = powered();
    slave.receive(NOMINAL, 0x701, &[5]);
    misses_seven(&mut slave);
    assert_eq!(payloads(&slave, 0x085), [HEARTBEAT_OF_SEVEN]);
    assert_eq!(errors(&mut slave), (0x11, 1));
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    slave.run_until(slave.now + span(100)); // the inhibit time
    assert_eq!(payloads(&slave, 0x085), [HEARTBEAT_OF_SEVEN_RESET]);
    assert_eq!(errors(&mut slave), (0, 0), "as after power-on");
    slave.receive(NOMINAL, 0x701, &[5]);
    misses_seven(&mut slave);
    slave.run_until(slave.now + span(100));
    // The end is announced to the master that the slave finds after its boot-up.
    assert_eq!(payloads(&slave, 0x085), [HEARTBEAT_OF_SEVEN_RESET, HEARTBEAT_OF_SEVEN]);
    assert_eq!(errors(&mut slave), (0x11, 1));
}

/// Reset communication: 1001h and 1003h hold what is still wrong, both of them (CiA 301: the communication profile returns to
/// its power-on values). What the application has raised is still there, each once, the newest first.
///
/// Verifies: ECSS 6.4a.1, 6.5.1a.5, 6.8a
/// Notices: ECSS 6.8a: 1003h keeps errors that are over after Reset communication.
#[test]
fn register_and_history_agree_after_reset_communication() {
    let mut slave = powered();
    write_all(&mut slave, &[NO_INHIBIT]);
    slave.receive(NOMINAL, 0x701, &[5]);
    misses_seven(&mut slave);
    slave.touch(|slave, _| {
        for code in [ErrorCode::TEMPERATURE, ErrorCode::VOLTAGE, ErrorCode::CURRENT] {
            slave.raise(DeviceError::new(code, 3), [1, 0, 0, 0]);
        }
        slave.clear(DeviceError::new(ErrorCode::VOLTAGE, 3));
        slave.clear(DeviceError::new(ErrorCode::TEMPERATURE, 3));
        slave.raise(DeviceError::new(ErrorCode::TEMPERATURE, 3), [2, 0, 0, 0]);
    });
    assert_eq!(errors(&mut slave), (0x1B, 4), "communication, temperature, current");
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(errors(&mut slave), (0x0B, 2));
    assert_eq!(read(&mut slave, 0x1003, 1), [0x00, 0x40, 3, 2]);
    assert_eq!(read(&mut slave, 0x1003, 2), [0x00, 0x20, 3, 1]);
    let gone = payloads(&slave, 0x085);
    assert!(gone.iter().all(|data| data[..2] == [0, 0]), "nothing is reported anew: {gone:02X?}");
}

/// Verifies: ECSS 6.4a.1, 6.5.2a
#[test]
fn a_missed_heartbeat_ends_when_nobody_monitors_it_any_more() {
    for value in [[0; 4], [150, 0, 8, 0], [150, 0, 7, 0]] {
        let mut slave = powered();
        slave.receive(NOMINAL, 0x701, &[5]);
        misses_seven(&mut slave);
        write_all(&mut slave, &[NO_INHIBIT, (0x1016, 2, &value)]);
        assert_eq!(payloads(&slave, 0x085), [HEARTBEAT_OF_SEVEN_RESET], "{value:?}");
        assert_eq!(errors(&mut slave), (0, 1));
    }
}

/// Verifies: ECSS 6.4a.1, 6.4a.2, 6.5.4a
/// Notices: ECSS 6.5.4a: a stopped slave sends emergencies.
/// Notices: ECSS 6.4a.1: each lost frame is an emergency.
#[test]
fn burst_of_losses_is_one_error_per_bus_while_messages_wait() {
    let overrun = |source| [0x10, 0x81, 0x11, source, 0, 0, 0, 0];
    let no_error = |source| [0, 0, 0, 0x10, 0x81, source, 0, 0];
    let mut slave = operational();
    write_all(&mut slave, &[NO_INHIBIT]);
    // Emergencies wait in Stopped.
    slave.receive(NOMINAL, 0x000, &[2, 5]);
    slave.clear();
    for bus in [NOMINAL, REDUNDANT] {
        for _ in 0..10 {
            slave.link(bus, LinkEvent::Overrun { lost: 1 });
            slave.link(bus, LinkEvent::Unsent { frames: 1 });
        }
    }
    assert_eq!(payloads(&slave, 0x085), [[0; 8]; 0]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    assert_eq!(payloads(&slave, 0x085), [overrun(0), overrun(1), no_error(0), no_error(1)]);
    assert_eq!(errors(&mut slave), (0, 2));
    for bus in Bus::ALL {
        assert_eq!(slave.node.status(slave.now).counters[bus].lost, 10, "each is counted");
    }
    // They have left: the next one is another error.
    slave.clear();
    slave.link(NOMINAL, LinkEvent::Overrun { lost: 1 });
    assert_eq!(payloads(&slave, 0x085), [overrun(0), no_error(0)]);
    assert_eq!(errors(&mut slave), (0, 2));
}

/// Verifies: ECSS 6.4a.1, 6.4a.2
/// Notices: ECSS 6.4a.2: lost frames have another code than 8110h.
#[test]
fn a_loss_of_frames_either_way_is_an_error() {
    for event in [LinkEvent::Overrun { lost: 1 }, LinkEvent::Unsent { frames: 1 }] {
        let mut slave = operational();
        write_all(&mut slave, &[NO_INHIBIT]);
        slave.clear();
        slave.link(REDUNDANT, event);
        assert_eq!(payloads(&slave, 0x085)[0], [0x10, 0x81, 0x11, 1, 0, 0, 0, 0]);
        assert_eq!(errors(&mut slave), (0, 1));
    }
}

/// Verifies: ECSS 6.4a.1
#[test]
fn burst_of_losses_in_inhibit_time_displaces_no_other_error() {
    let mut slave = operational();
    // 50 ms.
    write_all(&mut slave, &[(0x1015, 0, &500_u16.to_le_bytes())]);
    write_all(&mut slave, &[(0x1016, 2, &[150, 0, 7, 0])]);
    slave.receive(NOMINAL, 0x707, &[5]);
    slave.run_until(ms(100));
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.clear();
    slave.run_until(ms(149));
    (0..20).for_each(|_| slave.link(NOMINAL, LinkEvent::Overrun { lost: 1 }));
    run_with_master(&mut slave, ms(1_000));
    let told = payloads(&slave, 0x085);
    assert!(told.contains(&HEARTBEAT_OF_SEVEN.to_vec()), "{told:02X?}");
    // Each is part of the first: its end waited.
    assert_eq!(told.iter().filter(|data| data[..2] == [0x10, 0x81]).count(), 1, "{told:02X?}");
}

/// Given a slave with two errors, when a client writes zero to sub-index 0 of 1003h, then the list is empty, and the register 1001h still
/// has what is wrong. The next error is the first of the list.
///
/// Verifies: ECSS 6.4a.2, 6.8a
/// Notices: ECSS 6.8a: zero in 1003h leaves the list as it is.
#[test]
fn zero_in_1003h_clears_the_list_of_errors() {
    let mut slave = operational();
    slave.touch(|slave, _| {
        slave.raise(DeviceError::new(ErrorCode::CURRENT, 7), [0; 4]);
        slave.raise(DeviceError::new(ErrorCode::TEMPERATURE, 8), [0; 4]);
    });
    assert_eq!(errors(&mut slave), (0x0B, 2));
    write_all(&mut slave, &[(0x1003, 0, &[0])]);
    assert_eq!(errors(&mut slave), (0x0B, 0));
    // No data available.
    assert_eq!(ask(&mut slave, [0x40, 0x03, 0x10, 1, 0, 0, 0, 0]), refused(0x1003, 1, 0x0800_0024));
    slave.touch(|slave, _| slave.raise(DeviceError::new(ErrorCode::VOLTAGE, 9), [0; 4]));
    assert_eq!(errors(&mut slave), (0x0F, 1));
    assert_eq!(read(&mut slave, 0x1003, 1)[..2], [0x00, 0x30]);
}

/// Given an inhibit time of emergencies (1015h) that a client wrote, in 100 us, then the second of two errors is reported that long after
/// the first one.
///
/// Verifies: ECSS 6.8a
/// Notices: ECSS 6.8a: 1015h is in milliseconds.
#[test]
fn emergencies_keep_the_inhibit_time_that_1015h_has() {
    // By default 100 ms.
    for (written, delay) in [(None, 100), (Some(0_u16), 0), (Some(200), 20), (Some(1_500), 150)] {
        let mut slave = operational();
        if let Some(written) = written {
            write_all(&mut slave, &[(0x1015, 0, &written.to_le_bytes())]);
            assert_eq!(read(&mut slave, 0x1015, 0)[..2], written.to_le_bytes());
        }
        run_with_master(&mut slave, ms(200));
        slave.clear();
        slave.touch(|slave, _| {
            slave.raise(DeviceError::new(ErrorCode::CURRENT, 7), [0; 4]);
            slave.raise(DeviceError::new(ErrorCode::TEMPERATURE, 8), [0; 4]);
        });
        run_with_master(&mut slave, ms(400));
        assert_eq!(slave.times(NOMINAL, 0x085), [200, 200 + delay], "1015h is {written:?}");
    }
}
/// Error codes of CiA 301, table of emergency error codes, but 0000h.
const CODES: [u16; 34] = [
    0x1000, 0x2000, 0x2100, 0x2200, 0x2300, 0x3000, 0x3100, 0x3200, 0x3300, 0x4000, 0x4100, 0x4200, 0x5000,
    0x6000, 0x6100, 0x6200, 0x6300, 0x7000, 0x8000, 0x8100, 0x8110, 0x8120, 0x8130, 0x8140, 0x8150, 0x8200,
    0x8210, 0x8220, 0x8230, 0x8240, 0x8250, 0x9000, 0xF000, 0xFF00,
];

/// Given a slave, when its application raises and clears an error of each code, then the slave sends an EMCY with this code, one with
/// 0000h and this code after it, and 1003h has the code. In Stopped it sends none, and remembers the error all the same.
///
/// Verifies: ECSS 6.4b, 6.4a.1, 6.4a.2
/// Notices: ECSS 6.4b: codes from 9000h on are sent as 1000h.
#[test]
fn slave_sends_and_remembers_each_error_code_of_its_application() {
    for code in CODES {
        for is_stopped in [false, true] {
            let mut slave = operational();
            write_all(&mut slave, &[NO_INHIBIT]);
            if is_stopped {
                slave.receive(NOMINAL, 0x000, &[2, 5]);
            }
            slave.clear();
            slave.touch(|slave, _| slave.raise(DeviceError::new(ErrorCode::new(code), 7), [1, 2, 3, 4]));
            slave.touch(|slave, _| slave.clear(DeviceError::new(ErrorCode::new(code), 7)));
            let sent: Vec<_> = payloads(&slave, 0x085);
            if is_stopped {
                assert_eq!(sent, [[0; 8]; 0], "{code:04X}h");
                slave.receive(NOMINAL, 0x000, &[0x80, 5]);
            } else {
                let [low, high] = code.to_le_bytes();
                let [begin, end] = &sent[..] else { panic!("{code:04X}h: {sent:02X?}") };
                assert_eq!(
                    (&begin[..2], &begin[3..]),
                    (&[low, high][..], &[7, 1, 2, 3, 4][..]),
                    "{code:04X}h"
                );
                assert_eq!(end[..], [0, 0, 0, low, high, 7, 0, 0], "{code:04X}h");
            }
            let [low, high, ..] = read(&mut slave, 0x1003, 1);
            assert_eq!(u16::from_le_bytes([low, high]), code);
        }
    }
}
