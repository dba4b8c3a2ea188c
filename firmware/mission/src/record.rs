//! State that a slave of the mission keeps besides its node.

use ecss_can::link::StampSource;
use ecss_can::node::Status;
use ecss_can::pdo::RepeatFilter;
use ecss_can::types::Instant;

use crate::{COMMAND_PERIOD, Command, Message, Request, Telemetry};

/// State that commands change and telemetry reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SlaveRecord {
    /// State of the command LED.
    pub led: bool,
    /// The value set by command.
    pub value: u32,
    /// Commands executed; wraps.
    pub executed: u32,
    /// Drops repeats of commands.
    pub commands: RepeatFilter<Message>,
    /// Source of the time stamp of the last SYNC; `None` before the first one.
    pub stamp_source: Option<StampSource>,
}

/// Reason why a telecommand was not executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Declined {
    /// CAN delivered the last command once more.
    Repeat,
    /// The code is unknown, or the data do not fit it.
    Unknown,
}

impl Default for SlaveRecord {
    fn default() -> Self {
        Self::new()
    }
}

impl SlaveRecord {
    /// Makes the record at power-on.
    pub const fn new() -> SlaveRecord {
        SlaveRecord {
            led: false,
            value: 0,
            executed: 0,
            commands: RepeatFilter::new(COMMAND_PERIOD),
            stamp_source: None,
        }
    }

    /// Executes a telecommand that was received `at`. The caller handles LEDs, the dictionary, the node's counters for
    /// [`Command::ResetCounters`] and its bus for [`Command::SelectBus`].
    ///
    /// # Errors
    /// [`Declined`]: nothing was executed.
    pub fn take(&mut self, message: &Message, at: Instant) -> Result<Command, Declined> {
        if !self.commands.accept(*message, at) {
            return Err(Declined::Repeat);
        }
        self.execute(message)
    }

    /// Executes a telecommand, also a repeated one. For a slave whose commands have no sequence.
    ///
    /// # Errors
    /// [`Declined::Unknown`]: nothing was executed.
    pub fn execute(&mut self, message: &Message) -> Result<Command, Declined> {
        let command = Command::decode(message).ok_or(Declined::Unknown)?;
        self.executed = self.executed.wrapping_add(1);
        match command {
            Command::SetLed(on) => self.led = on,
            Command::SetValue(value) => self.value = value,
            Command::ResetCounters => {
                self.executed = 0;
                self.commands.reset_count();
            }
            Command::SelectBus(_) => {}
        }
        Ok(command)
    }

    /// Returns the answer to a telemetry request.
    pub fn answer(&self, request: Request, status: &Status) -> Telemetry {
        match request {
            Request::Uptime => Telemetry::Uptime(status.uptime.as_millis()),
            Request::Value => Telemetry::Value(self.value),
            Request::Executed => Telemetry::Executed {
                count: self.executed,
                repeats: u16::try_from(self.commands.repeats()).unwrap_or(u16::MAX),
            },
            Request::StampSource => Telemetry::StampSource(self.stamp_source),
            Request::Traffic(bus) => {
                let counters = &status.counters[bus];
                Telemetry::Traffic { bus, received: counters.received, sent: counters.sent }
            }
            Request::Losses(bus) => {
                let counters = &status.counters[bus];
                Telemetry::Losses {
                    bus,
                    lost: counters.lost,
                    malformed: counters.malformed,
                    failed: counters.failed(),
                }
            }
            Request::Errors(bus) => Telemetry::Errors { bus, health: status.health[bus] },
        }
    }
}
