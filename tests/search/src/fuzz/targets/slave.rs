//! A complete slave with any frames of its filters, any events of its controllers, and its application.

use ecss_can::emcy::{DeviceError, ErrorCode};
use ecss_can::link::Stamp;
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::node::extend::LinkEvent;
use ecss_can::node::{DeviceNode, FailCause, Node};
use ecss_can::od::U48;
use ecss_can::types::{Duration, Frame, Instant, NmtState};

use super::device::Telemetry;
use super::node::{Bench, bus, frame, profile};
use crate::fuzz::{Input, Signature};

/// Identifiers that a slave listens to: module control, SYNC, its SDO server, the master's heartbeat, the time, its
/// telecommands and telemetry requests, another slave's heartbeat.
const IDS: [u16; 9] = [0x000, 0x080, 0x605, 0x605, 0x701, 0x181, 0x305, 0x405, 0x706];

/// Objects whose values change the behaviour of a node.
const WRITTEN: [(u16, u8, u8); 22] = [
    (0x1003, 0, 1),
    (0x1005, 0, 4),
    (0x1006, 0, 4),
    (0x1007, 0, 4),
    (0x1010, 1, 4),
    (0x1011, 1, 4),
    (0x1014, 0, 4),
    (0x1015, 0, 2),
    (0x1016, 1, 4),
    (0x1016, 2, 4),
    (0x1017, 0, 2),
    (0x1019, 0, 1),
    (0x1029, 1, 1),
    (0x1400, 1, 4),
    (0x1401, 5, 2),
    (0x1802, 5, 2),
    (0x1802, 3, 2),
    (0x2000, 1, 1),
    (0x2000, 2, 1),
    (0x2000, 3, 1),
    (0x2010, 1, 4),
    (0x2030, 0, 1),
];

const CODES: [ErrorCode; 4] =
    [ErrorCode::HEARTBEAT, ErrorCode::CAN_PASSIVE, ErrorCode::PDO_LENGTH, ErrorCode::NO_ERROR];

/// Runs an input. The first byte chooses the profile. An operation is a byte for its kind, and its arguments.
pub fn run(mut input: Input, signature: &mut Signature) {
    let profile = profile(input.byte());
    let mut bench = Bench::new(&profile);
    bench.acknowledge_boot_up();
    let mut flying: Vec<Frame> = vec![];
    while !input.is_empty() {
        act(&mut bench, &mut flying, &mut input, signature);
        flying.extend(bench.sent.iter().map(|(_, frame)| *frame));
        flying.truncate(16);
        note(&bench, signature);
        bench.poll();
        note(&bench, signature);
        if bench.slave.status(bench.now).state == NmtState::Initialising {
            assert!(bench.sent.is_empty(), "sent in Initialising");
        }
    }
    rest(&mut bench);
}

fn act(bench: &mut Bench, flying: &mut Vec<Frame>, input: &mut Input, signature: &mut Signature) {
    let operation = input.byte() % 12;
    match operation {
        0 => {
            let (on, id, dlc) = (bus(input.byte()), input.word(), input.byte() % 9);
            receive(bench, on, frame(id, dlc, input.bytes()), 0);
        }
        1 | 2 => {
            let (on, id, dlc, age) = (bus(input.byte()), input.pick(&IDS), input.byte() % 9, input.byte());
            receive(bench, on, frame(id, dlc, input.bytes()), age);
        }
        3 => {
            // Module control, mostly a valid command.
            let (on, command) = (bus(input.byte()), input.pick(&[1, 2, 0x80, 0x82, 1, 1, 0x81, 3]));
            receive(bench, on, frame(0, 2, [command, input.pick(&[0, 5]), 0, 0, 0, 0, 0, 0]), 0);
        }
        4 => receive(bench, bus(input.byte()), frame(0x701, 1, [5; 8]), 0),
        5 | 6 => {
            let (index, sub, size) = input.pick(&WRITTEN);
            let [low, high] = index.to_le_bytes();
            let [a, b, c, d] = input.bytes();
            let command = 0x23 | (4 - size) << 2;
            let on = bench.slave.status(bench.now).active;
            receive(bench, on, frame(0x605, 8, [command, low, high, sub, a, b, c, d]), 0);
        }
        7 => {
            let on = bench.slave.status(bench.now).active;
            receive(bench, on, frame(0x605, 8, input.bytes()), 0);
        }
        8 | 9 => {
            let span = Duration::from_micros(u64::from(input.byte()) * 500);
            bench.wait(span, |bench| note(bench, signature));
        }
        10 => {
            let (on, which, how) = (bus(input.byte()), input.byte(), input.byte());
            let health = Health {
                state: [ErrorState::Active, ErrorState::Passive, ErrorState::BusOff][usize::from(how % 3)],
                tec: how,
                rec: which,
                last_error: LastError::Ack,
            };
            let stamp = Stamp::interrupt(bench.now);
            let cause = [FailCause::BusLeft, FailCause::Expired, FailCause::QueueFull, FailCause::Aborted]
                [usize::from(how % 4)];
            let event = match (which % 8, flying.pop()) {
                (0..=2, Some(frame)) => LinkEvent::Transmitted { frame, stamp },
                (3, Some(frame)) => LinkEvent::Failed { frame, cause },
                (4, _) => LinkEvent::Unsent { frames: u16::from(how) },
                (5, _) => LinkEvent::Overrun { lost: u16::from(how) },
                (6, _) => LinkEvent::Counters(health),
                (7, _) => LinkEvent::Stalled,
                _ => LinkEvent::Health(health),
            };
            bench.step(|slave, turn| slave.on_link(on, &event, turn));
        }
        _ => {
            let (which, how) = (input.byte(), input.byte());
            let (now, slave) = (bench.now, &mut bench.slave);
            match which % 4 {
                0 => slave.send_pdo(usize::from(how % 9), now),
                1 => {
                    let data = U48::new(u64::from_le_bytes([how; 8]));
                    slave.change(now, |objects| objects.telemetry = Telemetry { code: how.into(), data });
                }
                2 => slave.raise(DeviceError::new(CODES[usize::from(how % 4)], how), [how; 4]),
                _ => slave.clear(DeviceError::new(CODES[usize::from(how % 4)], how)),
            }
        }
    }
}

/// Receives a frame that ended a short time ago.
fn receive(bench: &mut Bench, on: ecss_can::types::Bus, frame: Frame, age: u8) {
    let at = Instant::from_micros(bench.now.as_micros() - u64::from(age));
    let stamp = Stamp::interrupt(at);
    bench.step(|slave, turn| slave.on_link(on, &LinkEvent::Received { frame, stamp }, turn));
}

fn note(bench: &Bench, signature: &mut Signature) {
    for (on, frame) in &bench.sent {
        let (function, command) = (u32::from(frame.id().function()), u32::from(frame.padded()[0] >> 5));
        signature.note(function << 8 | command << 1 | *on as u32);
    }
    for event in &bench.events {
        let text = std::mem::discriminant(event);
        signature.note(hash(&text));
    }
}

fn hash(value: &impl std::hash::Hash) -> u32 {
    use std::hash::{DefaultHasher, Hasher};
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish() as u32
}

/// Checks that a client is served on the bus of the master. A slave that waits for its reset only requests it.
fn rest(bench: &mut Bench) {
    bench.wait(Duration::from_millis(200), |_| {});
    let status = bench.slave.status(bench.now);
    let on = status.active;
    bench.receive(on, frame(0x701, 1, [5; 8]));
    if status.state == NmtState::Initialising {
        assert!(bench.sent.is_empty(), "sent in Initialising");
        assert_eq!(bench.events, [ecss_can::node::SlaveEvent::ResetNode]);
        return;
    }
    bench.acknowledge_boot_up();
    bench.receive(on, frame(0x000, 2, [0x80, 5, 0, 0, 0, 0, 0, 0]));
    // A client that restarts after it lost its transfer.
    bench.receive(on, frame(0x605, 8, [0x80, 0, 0, 0, 0, 0, 4, 5]));
    bench.receive(on, frame(0x605, 8, [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]));
    let answer = bench.sent.iter().find(|(_, frame)| frame.id().raw() == 0x585);
    assert_eq!(answer, Some(&(on, frame(0x585, 8, [0x43, 0x00, 0x10, 0, 0, 0, 0, 0]))), "the device type");
}
