//! A minimal slave that speaks the frames of the LibreCube prototype of 2017: the one of profile `librecube`.
//!
//! | PDO | COB-ID | what |
//! | --- | --- | --- |
//! | RPDO 1 | 181h | spacecraft time: fine time (3 bytes), coarse time (4) |
//! | RPDO 2 | 300h + node | command: code (2 bytes), data (0 to 6) |
//! | RPDO 3 | 400h + node | telemetry request: code (2 bytes), data (0 to 6), which is ignored |
//! | RPDO 4 | 500h + node | command and request in one: keep these bytes, send those kept before |
//! | TPDO 1 | 180h + node | with every SYNC: local time at the end of that SYNC |
//! | TPDO 3 | 380h + node | telemetry: code of the request (2 bytes), data (6) |
//! | TPDO 4 | 480h + node | the bytes kept before |
//!
//! RPDO 1 differs from Table 9-4 of the standard, which has 200h + node. A command has no sequence: one that CAN
//! delivers twice is executed twice. The last byte of its data, which is the sequence for other slaves of the mission,
//! is ignored.

mod objects;

use ecss_can::node::minimal::{MinimalDevice, MinimalPdos, MinimalRpdo, Payload, Trigger};
use ecss_can::pdo::CobIdOf;
use ecss_can::types::{Duration, Instant, Scet};
pub use objects::PrototypeObjects;

use super::{MissionDevice, payload, receive, transmit};
use crate::counters::COUNTERS;
use crate::{Command, Message, Request, SlaveRecord, Telemetry};

/// Index of a PDO, from zero.
const TIME: usize = 0;
const COMMAND: usize = 1;
const REQUEST: usize = 2;
const TELEMETRY: usize = 2;
const KEPT: usize = 3;

/// Data that the prototype sends for every request, from the listing of its slave.
const DUMMY: [u8; Message::DATA] = [0x11, 0x22, 0x33, 0x44, 0x55, 0x66];
/// Longest time from the end of a SYNC to the spacecraft time that belongs to it. Without such a SYNC the time is that
/// of the end of its own frame.
const OF_SYNC: Duration = Duration::from_millis(500);

/// The device of a minimal slave in profile `librecube`.
#[derive(Clone, Debug)]
pub struct PrototypeMission {
    record: SlaveRecord,
    kept: Payload,
    clock: Clock,
}

/// Local time. It runs from power-on and is set by the master.
#[derive(Clone, Copy, Debug)]
struct Clock {
    /// Local time at `at`.
    scet: Scet,
    at: Instant,
    last_sync: Option<Instant>,
}

impl Clock {
    fn set(&mut self, scet: Scet, received: Instant) {
        let of_sync = self.last_sync.filter(|sync| received.since(*sync) <= OF_SYNC);
        (self.scet, self.at) = (scet, of_sync.unwrap_or(received));
    }

    /// Returns the time at an instant, which must not be before the time was set.
    fn time(&self, at: Instant) -> Scet {
        self.scet.plus(at.since(self.at))
    }
}

impl PrototypeMission {
    /// Makes the device at power-on.
    pub const fn new() -> PrototypeMission {
        let clock = Clock { scet: Scet::from_units(0), at: Instant::ZERO, last_sync: None };
        PrototypeMission { record: SlaveRecord::new(), kept: Payload::new(), clock }
    }

    fn on_command(&mut self, message: &Message) {
        // `SelectBus` is not executed: the bus follows the master.
        let is_taken = !matches!(Command::decode(message), None | Some(Command::SelectBus(_)));
        if is_taken && self.record.execute(message).is_ok() {
            COUNTERS.commands.count();
        }
    }

    /// Returns the answer to a request: the value for codes of the mission that this device supports, `None` for those
    /// of other slaves, and the prototype's data for all other codes.
    fn answer(&self, code: u16, at: Instant) -> Option<Message> {
        let telemetry = match Request::decode(&Message::of(code, [])) {
            None => return Some(Message::new(code, DUMMY)),
            Some(Request::Uptime) => Telemetry::Uptime(at.as_micros() / 1_000),
            Some(Request::Value) => Telemetry::Value(self.record.value),
            Some(Request::Executed) => Telemetry::Executed { count: self.record.executed, repeats: 0 },
            Some(_) => return None,
        };
        Some(telemetry.encode())
    }
}

impl Default for PrototypeMission {
    fn default() -> Self {
        Self::new()
    }
}

impl MissionDevice for PrototypeMission {
    const TIME_RPDO: Option<u8> = Some(TIME as u8);

    fn led(&self) -> bool {
        self.record.led
    }
}

impl MinimalDevice for PrototypeMission {
    const PDOS: MinimalPdos = MinimalPdos {
        receive: [
            Some(MinimalRpdo { cob_id: CobIdOf::fixed(0x181), least: Scet::LEN as u8 }),
            receive(0x300, 2),
            receive(0x400, 2),
            receive(0x500, 0),
        ],
        transmit: [
            transmit(0x180, Trigger::Sync(1)),
            None,
            transmit(0x380, Trigger::Request),
            transmit(0x480, Trigger::Request),
        ],
    };

    fn on_pdo(&mut self, number: usize, data: &[u8], at: Instant) -> Option<(usize, Payload)> {
        match number {
            TIME => {
                self.clock.set(Scet::decode(data)?, at);
                None
            }
            COMMAND => {
                self.on_command(&Message::from_start(data)?);
                None
            }
            REQUEST => {
                let answer = self.answer(Message::from_start(data)?.code(), at)?;
                COUNTERS.requests.count();
                Some((TELEMETRY, payload(&answer)))
            }
            _ => {
                let new = Payload::from_slice(data).ok()?;
                Some((KEPT, core::mem::replace(&mut self.kept, new)))
            }
        }
    }

    /// Returns the local time, the only PDO that follows SYNC.
    fn on_sync(&mut self, _number: usize, at: Instant) -> Option<Payload> {
        self.clock.last_sync = Some(at);
        Payload::from_slice(&self.clock.time(at).encode()).ok()
    }
}
