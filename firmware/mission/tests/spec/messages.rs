//! Commands and telemetry: the message layout and the codes.

use ecss_can::link::StampSource;
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::node::{Counters, Status};
use ecss_can::pdo::CobIdOf;
use ecss_can::types::{Bus, NmtState, PerBus, Scet};
use mission::{Command, Declined, Message, Request, STANDARD, SlaveRecord, Telemetry};

use crate::{frame, ms, node, span};

#[test]
fn a_message_is_a_code_and_six_bytes() {
    let message = Message::of(0x1234, [1, 2, 3]);
    assert_eq!(
        message.encode(CobIdOf::node(0x300).of(node(2))),
        frame(0x302, &[0x34, 0x12, 1, 2, 3, 0, 0, 0])
    );
    assert_eq!(Message::decode(&frame(0x302, &[0x34, 0x12, 1, 2, 3, 0, 0, 0])), Some(message));
    assert_eq!(Message::new(0x1234, [1, 2, 3, 0, 0, 0]), message);
}

#[test]
fn a_message_that_is_shorter_is_malformed() {
    assert_eq!(Message::decode(&frame(0x302, &[])), None);
    assert_eq!(Message::decode(&frame(0x302, &[1, 2, 3, 4, 5, 6, 7])), None);
}

/// Pads data bytes with zeros.
fn padded<const N: usize>(data: &[u8]) -> [u8; N] {
    let mut all = [0; N];
    all[..data.len()].copy_from_slice(data);
    all
}

/// Verifies: ECSS 9.4.2a
#[test]
fn commands_on_the_wire() {
    let wire = [
        (Command::SetLed(true), &[0x01, 0x00, 1][..]),
        (Command::SetLed(false), &[0x01, 0x00, 0]),
        (Command::SetValue(0xDEAD_BEEF), &[0x02, 0x00, 0xEF, 0xBE, 0xAD, 0xDE]),
        (Command::ResetCounters, &[0x03, 0x00]),
        (Command::SelectBus(Bus::Nominal), &[0x04, 0x00, 0]),
        (Command::SelectBus(Bus::Redundant), &[0x04, 0x00, 1]),
    ];
    for (command, data) in wire {
        let data = padded::<8>(data);
        for sequence in [0, 1, 255] {
            // The sequence is the last byte.
            let data = [data[0], data[1], data[2], data[3], data[4], data[5], data[6], sequence];
            assert_eq!(command.encode(sequence).encode(CobIdOf::node(0x300).of(node(2))).data(), data);
            assert_eq!(Command::decode(&Message::decode(&frame(0x302, &data)).unwrap()), Some(command));
        }
    }
}

#[test]
fn commands_that_are_none() {
    let bad = [
        (0x0001, &[2][..]),
        (0x0001, &[1, 1]),
        (0x0002, &[0, 0, 0, 0, 1]),
        (0x0003, &[1]),
        (0x0004, &[2]),
        (0x0005, &[]),
    ];
    for (code, data) in bad {
        assert_eq!(Command::decode(&Message::new(code, padded(data))), None, "{code:04X} {data:?}");
    }
}

/// Verifies: ECSS 9.4.2b
#[test]
fn requests_have_a_code_each_and_no_data() {
    let codes = Request::ALL.map(Request::code);
    assert_eq!(codes, [0x101, 0x102, 0x103, 0x104, 0x110, 0x111, 0x120, 0x121, 0x130, 0x131]);
    for request in Request::ALL {
        assert_eq!(request.encode().data(), [0; 6]);
        assert_eq!(Request::decode(&request.encode()), Some(request));
        assert_eq!(Request::decode(&Message::of(request.code(), [1])), None);
    }
    assert_eq!(Request::decode(&Message::of(0x105, [])), None);
}

/// Verifies: ECSS 9.4.2b
#[test]
fn telemetry_on_the_wire() {
    let health = Health { state: ErrorState::Passive, tec: 128, rec: 3, last_error: LastError::Ack };
    let (bus, redundant) = (Bus::Nominal, Bus::Redundant);
    let wire = [
        (Telemetry::Uptime(0x0605_0403_0201), 0x101, &[1, 2, 3, 4, 5, 6][..]),
        (Telemetry::Value(0x0403_0201), 0x102, &[1, 2, 3, 4]),
        (Telemetry::Executed { count: 7, repeats: 0x0605 }, 0x103, &[7, 0, 0, 0, 5, 6]),
        (Telemetry::StampSource(None), 0x104, &[0]),
        (Telemetry::StampSource(Some(StampSource::Interrupt)), 0x104, &[1]),
        (Telemetry::StampSource(Some(StampSource::Capture)), 0x104, &[2]),
        (Telemetry::Traffic { bus, received: 0x03_0201, sent: 0x06_0504 }, 0x110, &[1, 2, 3, 4, 5, 6]),
        (
            Telemetry::Losses { bus: redundant, lost: 0x0201, malformed: 0x0403, failed: 0x0605 },
            0x121,
            &[1, 2, 3, 4, 5, 6],
        ),
        (Telemetry::Errors { bus: redundant, health }, 0x131, &[1, 128, 3, 3]),
    ];
    for (telemetry, code, data) in wire {
        let message = Message::new(code, padded(data));
        assert_eq!(telemetry.encode(), message);
        assert_eq!(Telemetry::decode(&message), Some(telemetry));
        assert_eq!(telemetry.request().code(), code);
    }
}

#[test]
fn telemetry_that_is_none() {
    let bad = [
        (0x102, &[0, 0, 0, 0, 0, 1][..]),
        (0x104, &[3]),
        (0x130, &[3, 0, 0, 0]),
        (0x130, &[0, 0, 0, 7]),
        (0x105, &[]),
    ];
    for (code, data) in bad {
        assert_eq!(Telemetry::decode(&Message::new(code, padded(data))), None, "{code:04X} {data:?}");
    }
}

#[test]
fn a_slave_answers_with_real_values() {
    let counters = Counters {
        received: 10,
        sent: 20,
        malformed: 1,
        ignored: 2,
        lost: 3,
        refused: 1,
        bus_left: 2,
        expired: 3,
        queue_full: 4,
        aborted: 5,
    };
    let health = Health { tec: 9, ..Health::default() };
    let status = Status {
        uptime: span(1_234),
        scet: Scet::default(),
        state: NmtState::Operational,
        active: Bus::Nominal,
        redundancy: STANDARD.redundancy(),
        counters: PerBus { nominal: Counters::default(), redundant: counters },
        health: PerBus { nominal: Health::default(), redundant: health },
    };
    let mut record = SlaveRecord::new();
    let value = Command::SetValue(42).encode(0);
    assert_eq!(record.take(&value, ms(1)), Ok(Command::SetValue(42)));
    assert_eq!(record.take(&Command::SetLed(true).encode(1), ms(2)), Ok(Command::SetLed(true)));
    assert_eq!(record.take(&Command::SetLed(true).encode(1), ms(2)), Err(Declined::Repeat));
    assert_eq!(record.take(&Message::of(5, []), ms(3)), Err(Declined::Unknown));
    let bus = Bus::Redundant;
    let answers = [
        (Request::Uptime, Telemetry::Uptime(1_234)),
        (Request::Value, Telemetry::Value(42)),
        (Request::Executed, Telemetry::Executed { count: 2, repeats: 1 }),
        (Request::StampSource, Telemetry::StampSource(None)),
        (Request::Traffic(bus), Telemetry::Traffic { bus, received: 10, sent: 20 }),
        (Request::Losses(bus), Telemetry::Losses { bus, lost: 3, malformed: 1, failed: 15 }),
        (Request::Errors(bus), Telemetry::Errors { bus, health }),
    ];
    for (request, telemetry) in answers {
        assert_eq!(record.answer(request, &status), telemetry);
    }
    assert!(record.led);
    assert_eq!(record.take(&Command::ResetCounters.encode(2), ms(4)), Ok(Command::ResetCounters));
    assert_eq!((record.executed, record.value, record.commands.repeats()), (0, 42, 0));
}
