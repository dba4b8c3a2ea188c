//! A minimal slave of the mission (ECSS 9): meaning of its four receive PDOs, and content of its transmit PDOs.
//!
//! | PDO | COB-ID | what |
//! | --- | --- | --- |
//! | RPDO 1 | 200h + node | command: keep these bytes, 0 to 8 of them |
//! | RPDO 2, 3 | 300h, 400h + node | command or telemetry request of the mission, by its code, as for full slaves |
//! | RPDO 4 | 500h + node | request: send the kept bytes by TPDO 4; its own bytes are ignored |
//! | TPDO 2 | 280h + node | with every SYNC: commands executed (4 bytes), state of the LED (1) |
//! | TPDO 3 | 380h + node | telemetry of the mission |
//! | TPDO 4 | 480h + node | the kept bytes, as many as the command had |
//!
//! In profile `librecube` it is [another one](prototype). TPDO 1 is not used: the master expects the time of a slave in
//! 180h + node, and a minimal slave has no clock.

mod objects;
pub mod prototype;

use ecss_can::node::minimal::{MinimalDevice, MinimalPdos, MinimalRpdo, MinimalTpdo, Payload, Trigger};
use ecss_can::pdo::CobIdOf;
use ecss_can::types::Instant;
pub use objects::{CyclicState, FixedPdo, MinimalMessage, MinimalObjects, MinimalTelemetry};

use crate::counters::COUNTERS;
use crate::{Command, Message, Request, SlaveRecord, Telemetry};

/// The device of the shipped image.
#[cfg(all(feature = "librecube", not(feature = "standby")))]
pub type Shipped = prototype::PrototypeMission;
/// The device of the shipped image.
#[cfg(not(all(feature = "librecube", not(feature = "standby"))))]
pub type Shipped = MinimalMission;

/// Index of a PDO, from zero.
const KEEP: usize = 0;
const REPLY: usize = 3;
const CYCLIC: usize = 1;
const TELEMETRY: usize = 2;
const KEPT: usize = 3;

/// A device that the application of the minimal slave runs with.
pub trait MissionDevice: MinimalDevice {
    /// Index of the RPDO with the spacecraft time, from zero. `None`: there is none.
    const TIME_RPDO: Option<u8>;

    /// Returns the state of the command LED.
    fn led(&self) -> bool;
}

/// The device of a minimal slave.
#[derive(Clone, Debug)]
pub struct MinimalMission {
    record: SlaveRecord,
    kept: Payload,
}

impl MinimalMission {
    /// Makes the device at power-on.
    pub const fn new() -> MinimalMission {
        MinimalMission { record: SlaveRecord::new(), kept: Payload::new() }
    }

    /// Handles a command or a telemetry request, by its code. Returns the telemetry.
    fn on_message(&mut self, data: &[u8], at: Instant) -> Option<Payload> {
        let message = Message::from_start(data)?;
        if let Some(telemetry) = self.answer(&message, at) {
            COUNTERS.requests.count();
            return Some(payload(&telemetry.encode()));
        }
        // `SelectBus` is not executed: the bus follows the master.
        if !matches!(Command::decode(&message), None | Some(Command::SelectBus(_))) {
            match self.record.take(&message, at) {
                Ok(_) => COUNTERS.commands.count(),
                Err(_) => COUNTERS.repeats.count(),
            }
        }
        None
    }

    /// Returns the answer to a telemetry request that this device supports. The device cannot read counters of its
    /// node.
    fn answer(&self, message: &Message, at: Instant) -> Option<Telemetry> {
        let SlaveRecord { value, executed, commands, .. } = &self.record;
        Some(match Request::decode(message)? {
            Request::Uptime => Telemetry::Uptime(at.as_micros() / 1_000),
            Request::Value => Telemetry::Value(*value),
            Request::Executed => Telemetry::Executed {
                count: *executed,
                repeats: u16::try_from(commands.repeats()).unwrap_or(u16::MAX),
            },
            _ => return None,
        })
    }
}

impl Default for MinimalMission {
    fn default() -> Self {
        Self::new()
    }
}

impl MissionDevice for MinimalMission {
    const TIME_RPDO: Option<u8> = None;

    fn led(&self) -> bool {
        self.record.led
    }
}

impl MinimalDevice for MinimalMission {
    const PDOS: MinimalPdos = MinimalPdos {
        receive: [receive(0x200, 0), receive(0x300, 2), receive(0x400, 2), receive(0x500, 0)],
        transmit: [
            None,
            transmit(0x280, Trigger::Sync(1)),
            transmit(0x380, Trigger::Request),
            transmit(0x480, Trigger::Request),
        ],
    };

    fn on_pdo(&mut self, number: usize, data: &[u8], at: Instant) -> Option<(usize, Payload)> {
        match number {
            KEEP => {
                self.kept.clear();
                // Never fails: a PDO has at most 8 bytes.
                let _ = self.kept.extend_from_slice(data);
                None
            }
            REPLY => Some((KEPT, self.kept.clone())),
            _ => self.on_message(data, at).map(|telemetry| (TELEMETRY, telemetry)),
        }
    }

    fn on_sync(&mut self, number: usize, _at: Instant) -> Option<Payload> {
        let [a, b, c, d] = self.record.executed.to_le_bytes();
        (number == CYCLIC).then(|| Payload::from_iter([a, b, c, d, self.record.led.into()]))
    }
}

const fn receive(base: u16, least: u8) -> Option<MinimalRpdo> {
    Some(MinimalRpdo { cob_id: CobIdOf::node(base), least })
}

const fn transmit(base: u16, trigger: Trigger) -> Option<MinimalTpdo> {
    Some(MinimalTpdo { cob_id: CobIdOf::node(base), trigger })
}

fn payload(message: &Message) -> Payload {
    let [low, high] = message.code().to_le_bytes();
    let [a, b, c, d, e, f] = message.data();
    Payload::from_array([low, high, a, b, c, d, e, f])
}
