//! Commands and telemetry.
//!
//! One code per command and per telemetry request; telemetry repeats the code of its request. Numbers little-endian.
//!
//! A command is 8 bytes: a code (2 bytes), data (5), a sequence (1). The master increments the sequence with each
//! command to a slave. The slave executes a command once, even if CAN delivers it repeatedly: see
//! [`RepeatFilter`](ecss_can::pdo::RepeatFilter). A telemetry request needs its code only: it has 2 to 8 bytes, which
//! are zero behind the code.

use ecss_can::link::StampSource;
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::types::Bus;

use crate::Message;

const SET_LED: u16 = 0x0001;
const SET_VALUE: u16 = 0x0002;
const RESET_COUNTERS: u16 = 0x0003;
const SELECT_BUS: u16 = 0x0004;

const UPTIME: u16 = 0x0101;
const VALUE: u16 = 0x0102;
const EXECUTED: u16 = 0x0103;
const STAMP_SOURCE: u16 = 0x0104;
const TRAFFIC: u16 = 0x0110;
const LOSSES: u16 = 0x0120;
const ERRORS: u16 = 0x0130;

/// A telecommand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// Switch the command LED on or off.
    SetLed(bool),
    /// Keep a value, for telemetry to read back.
    SetValue(u32),
    /// Set the executed commands, the repeats and the counters of both buses to zero.
    ResetCounters,
    /// Search the master, beginning on this bus (ECSS 8.2.3a). Slaves with parallel access refuse it.
    SelectBus(Bus),
}

impl Command {
    /// Returns the message on the bus. `sequence`: next number of the master's [`Sequence`](ecss_can::pdo::Sequence)
    /// for this slave.
    pub fn encode(self, sequence: u8) -> Message {
        let (code, [a, b, c, d]) = match self {
            Command::SetLed(on) => (SET_LED, [u8::from(on), 0, 0, 0]),
            Command::SetValue(value) => (SET_VALUE, value.to_le_bytes()),
            Command::ResetCounters => (RESET_COUNTERS, [0; 4]),
            Command::SelectBus(bus) => (SELECT_BUS, [bus.bdefault(), 0, 0, 0]),
        };
        Message::new(code, [a, b, c, d, 0, sequence])
    }

    /// Returns the command of a message; the sequence is ignored. `None` for an unknown code, invalid data, an LED
    /// value other than 0 and 1, or a bus other than 0 (nominal) and 1 (redundant).
    pub fn decode(message: &Message) -> Option<Command> {
        let [data @ .., _sequence] = message.data();
        match (message.code(), data) {
            (SET_LED, [0, 0, 0, 0, 0]) => Some(Command::SetLed(false)),
            (SET_LED, [1, 0, 0, 0, 0]) => Some(Command::SetLed(true)),
            (SET_VALUE, [a, b, c, d, 0]) => Some(Command::SetValue(u32::from_le_bytes([a, b, c, d]))),
            (RESET_COUNTERS, [0, 0, 0, 0, 0]) => Some(Command::ResetCounters),
            (SELECT_BUS, [bus, 0, 0, 0, 0]) => Bus::from_bdefault(bus).map(Command::SelectBus),
            _ => None,
        }
    }
}

/// A telemetry request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Request {
    /// Time since power-on.
    Uptime,
    /// The value set by command.
    Value,
    /// Commands executed, and repeats dropped.
    Executed,
    /// Source of time stamps.
    StampSource,
    /// Frames received and sent.
    Traffic(Bus),
    /// Numbers of frames lost, malformed and not sent.
    Losses(Bus),
    /// Error state and counters.
    Errors(Bus),
}

impl Request {
    /// Every request once, for a master that sends them in turn.
    pub const ALL: [Request; 10] = [
        Request::Uptime,
        Request::Value,
        Request::Executed,
        Request::StampSource,
        Request::Traffic(Bus::Nominal),
        Request::Traffic(Bus::Redundant),
        Request::Losses(Bus::Nominal),
        Request::Losses(Bus::Redundant),
        Request::Errors(Bus::Nominal),
        Request::Errors(Bus::Redundant),
    ];

    /// Returns the code of the request and of its telemetry.
    pub const fn code(self) -> u16 {
        match self {
            Request::Uptime => UPTIME,
            Request::Value => VALUE,
            Request::Executed => EXECUTED,
            Request::StampSource => STAMP_SOURCE,
            Request::Traffic(bus) => TRAFFIC | bus as u16,
            Request::Losses(bus) => LOSSES | bus as u16,
            Request::Errors(bus) => ERRORS | bus as u16,
        }
    }

    /// Returns the message on the bus.
    pub fn encode(self) -> Message {
        Message::of(self.code(), [])
    }

    /// Returns the request of a message. `None` for an unknown code or data other than zero.
    pub fn decode(message: &Message) -> Option<Request> {
        if message.data() == [0; Message::DATA] { Self::from_code(message.code()) } else { None }
    }

    fn from_code(code: u16) -> Option<Request> {
        let bus = if code & 1 == 0 { Bus::Nominal } else { Bus::Redundant };
        Some(match code {
            UPTIME => Request::Uptime,
            VALUE => Request::Value,
            EXECUTED => Request::Executed,
            STAMP_SOURCE => Request::StampSource,
            _ => match code & !1 {
                TRAFFIC => Request::Traffic(bus),
                LOSSES => Request::Losses(bus),
                ERRORS => Request::Errors(bus),
                _ => return None,
            },
        })
    }
}

/// Telemetry: the answer to a [`Request`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Telemetry {
    /// Milliseconds since power-on, modulo 2^48.
    Uptime(u64),
    /// The value set by command.
    Value(u32),
    /// Commands since power-on or the last reset of counters.
    Executed {
        /// Number executed; wraps.
        count: u32,
        /// Number dropped as repeats of the command before; stays at its maximum.
        repeats: u16,
    },
    /// Source of the time stamp of the last SYNC; `None` before the first one.
    StampSource(Option<StampSource>),
    /// Numbers of frames of a bus, each modulo 2^24.
    Traffic {
        /// The bus counted.
        bus: Bus,
        /// Number received.
        received: u32,
        /// Number sent and acknowledged.
        sent: u32,
    },
    /// Numbers of lost and failed frames of a bus; each stays at its maximum.
    Losses {
        /// The bus counted.
        bus: Bus,
        /// Number lost in the receiver.
        lost: u16,
        /// Number of malformed frames.
        malformed: u16,
        /// Number not sent, for any cause.
        failed: u16,
    },
    /// Error state and counters of a bus.
    Errors {
        /// The bus counted.
        bus: Bus,
        /// State and counters of the controller.
        health: Health,
    },
}

impl Telemetry {
    /// Returns the request that this answers.
    pub const fn request(self) -> Request {
        match self {
            Telemetry::Uptime(_) => Request::Uptime,
            Telemetry::Value(_) => Request::Value,
            Telemetry::Executed { .. } => Request::Executed,
            Telemetry::StampSource(_) => Request::StampSource,
            Telemetry::Traffic { bus, .. } => Request::Traffic(bus),
            Telemetry::Losses { bus, .. } => Request::Losses(bus),
            Telemetry::Errors { bus, .. } => Request::Errors(bus),
        }
    }

    /// Returns the message on the bus.
    pub fn encode(self) -> Message {
        let data = match self {
            Telemetry::Uptime(ms) => ms,
            Telemetry::Value(value) => value.into(),
            Telemetry::Executed { count, repeats } => u64::from(count) | u64::from(repeats) << 32,
            Telemetry::StampSource(None) => 0,
            Telemetry::StampSource(Some(StampSource::Interrupt)) => 1,
            Telemetry::StampSource(Some(StampSource::Capture)) => 2,
            Telemetry::Traffic { received, sent, .. } => {
                u64::from(received & 0xFF_FFFF) | u64::from(sent) << 24
            }
            Telemetry::Losses { lost, malformed, failed, .. } => {
                u64::from(lost) | u64::from(malformed) << 16 | u64::from(failed) << 32
            }
            Telemetry::Errors { health: Health { state, tec, rec, last_error }, .. } => {
                u32::from_le_bytes([state as u8, tec, rec, last_error as u8]).into()
            }
        };
        let [a, b, c, d, e, f, ..] = data.to_le_bytes();
        Message::new(self.request().code(), [a, b, c, d, e, f])
    }

    /// Returns the telemetry of a message. `None` for an unknown code, invalid data or a value that is never sent.
    pub fn decode(message: &Message) -> Option<Telemetry> {
        Some(match (Request::from_code(message.code())?, message.data()) {
            (Request::Uptime, [a, b, c, d, e, f]) => {
                Telemetry::Uptime(u64::from_le_bytes([a, b, c, d, e, f, 0, 0]))
            }
            (Request::Value, [a, b, c, d, 0, 0]) => Telemetry::Value(u32::from_le_bytes([a, b, c, d])),
            (Request::Executed, [a, b, c, d, e, f]) => Telemetry::Executed {
                count: u32::from_le_bytes([a, b, c, d]),
                repeats: u16::from_le_bytes([e, f]),
            },
            (Request::StampSource, [0, 0, 0, 0, 0, 0]) => Telemetry::StampSource(None),
            (Request::StampSource, [1, 0, 0, 0, 0, 0]) => {
                Telemetry::StampSource(Some(StampSource::Interrupt))
            }
            (Request::StampSource, [2, 0, 0, 0, 0, 0]) => Telemetry::StampSource(Some(StampSource::Capture)),
            (Request::Traffic(bus), [a, b, c, d, e, f]) => Telemetry::Traffic {
                bus,
                received: u32::from_le_bytes([a, b, c, 0]),
                sent: u32::from_le_bytes([d, e, f, 0]),
            },
            (Request::Losses(bus), [a, b, c, d, e, f]) => Telemetry::Losses {
                bus,
                lost: u16::from_le_bytes([a, b]),
                malformed: u16::from_le_bytes([c, d]),
                failed: u16::from_le_bytes([e, f]),
            },
            (Request::Errors(bus), [state, tec, rec, last_error, 0, 0]) => Telemetry::Errors {
                bus,
                health: Health {
                    state: error_state(state)?,
                    tec,
                    rec,
                    last_error: last_error_code(last_error)?,
                },
            },
            _ => return None,
        })
    }
}

fn error_state(byte: u8) -> Option<ErrorState> {
    [ErrorState::Active, ErrorState::Passive, ErrorState::BusOff]
        .into_iter()
        .find(|state| *state as u8 == byte)
}

fn last_error_code(byte: u8) -> Option<LastError> {
    use LastError::{Ack, BitDominant, BitRecessive, Crc, Form, None as NoError, Stuff};
    [NoError, Stuff, Form, Ack, BitRecessive, BitDominant, Crc].into_iter().find(|code| *code as u8 == byte)
}
