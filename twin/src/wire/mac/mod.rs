//! The protocol engine of one node: from sampled bits to frames, flags and error counters, and back.
//!
//! A [`Mac`] is stepped once per bit, at the bit's end, with the level at its sample point (ISO 11898-1, 10 and 12).
//! Its state describes the present bit.

mod step;

use std::sync::Arc;

use crate::wire::confinement::ErrorCounters;
use crate::wire::controller::{Attachment, WireEvent};
use crate::wire::decode::Decoder;
use crate::wire::encode::Encoded;
use crate::wire::field::Field;
use crate::wire::fine::Fine;
use crate::wire::frame::WireFrame;
use crate::wire::timing::{BitClock, BitTiming};

const FLAG_BITS: u8 = 6;
const DELIMITER_BITS: u8 = 8;
const INTERMISSION_BITS: u8 = 3;
const SUSPEND_BITS: u8 = 8;
const EOF_BITS: u8 = 7;
/// SOF and a standard identifier.
const IDENTIFIER_BITS: u8 = 12;
/// Recessive bits that synchronise a node with the bus.
const SEQUENCE_BITS: u8 = 11;
/// Number of such sequences that end bus-off.
const RECOVERY_SEQUENCES: u8 = 128;

/// Levels on the line.
pub(in crate::wire) const RECESSIVE: bool = true;
pub(in crate::wire) const DOMINANT: bool = false;

/// Meaning of the present bit for a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::wire) enum State {
    /// Does not take part.
    Off,
    /// Waits for 11 recessive bits.
    Integrating {
        recessive: u8,
    },
    /// Bus-off, without recovery.
    BusOff,
    /// Bus-off; counts 128 times 11 recessive bits.
    Recovering {
        recessive: u8,
        sequences: u8,
    },
    /// Between bits: waits for an edge or a request.
    Idle,
    /// SOF: its own, or one detected by an edge.
    Sof,
    /// Within a frame up to its CRC sequence.
    Stuffed,
    CrcDelimiter,
    AckSlot,
    AckDelimiter,
    Eof(u8),
    Intermission(u8),
    Suspend(u8),
    ActiveFlag {
        error: bool,
        sent: u8,
    },
    PassiveFlag {
        sent: u8,
        run: u8,
        level: bool,
        spared: bool,
    },
    /// After its own flag, until the line is recessive.
    Superposition {
        error: bool,
        dominant: u16,
    },
    Delimiter {
        seen: u8,
    },
}

/// A frame that a node sends.
#[derive(Clone, Debug)]
pub(in crate::wire) struct Transmission {
    pub(in crate::wire) frame: WireFrame,
    pub(in crate::wire) encoded: Arc<Encoded>,
    /// Start of its SOF.
    pub(in crate::wire) start: Fine,
    /// Length of its bits.
    pub(in crate::wire) bit: Fine,
    /// A babbled frame, which the controller did not request.
    pub(in crate::wire) babbled: bool,
}

/// One node's engine.
#[derive(Clone, Debug)]
pub(in crate::wire) struct Mac {
    pub(in crate::wire) attachment: Option<Attachment>,
    pub(in crate::wire) clock: BitClock,
    pub(in crate::wire) state: State,
    pub(in crate::wire) counters: ErrorCounters,
    pub(in crate::wire) decoder: Decoder,
    /// The frame that it sends at present.
    pub(in crate::wire) transmission: Option<Transmission>,
    /// The frame whose transmission has just ended, successful or not.
    pub(in crate::wire) finished: Option<Transmission>,
    /// It is the transmitter of the present frame, or of the one that has just ended.
    pub(in crate::wire) transmitter: bool,
    /// Power cycle of the attachment to which the counters belong.
    power_cycle: u32,
}

/// Result of the end of a bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::wire) struct Note {
    pub(in crate::wire) event: Option<WireEvent>,
    /// The bit was the SOF of another node: with a waiting frame this node may enter the arbitration.
    pub(in crate::wire) may_join: bool,
}

impl From<WireEvent> for Note {
    fn from(event: WireEvent) -> Self {
        Note { event: Some(event), may_join: false }
    }
}

impl Mac {
    pub(in crate::wire) fn new() -> Self {
        Mac {
            attachment: None,
            clock: BitClock::new(BitTiming::MEGABIT, Fine(0)),
            state: State::Off,
            counters: ErrorCounters::default(),
            decoder: Decoder::new(),
            transmission: None,
            finished: None,
            transmitter: false,
            power_cycle: 0,
        }
    }

    /// Changes whether and how the node takes part, at `at`. `brought`: its error counters from another wire.
    pub(in crate::wire) fn attach(
        &mut self,
        attachment: Option<Attachment>,
        brought: Option<ErrorCounters>,
        at: Fine,
    ) {
        self.attachment = attachment;
        let Some(now) = attachment else {
            self.state = State::Off;
            self.transmission = None;
            return;
        };
        if self.power_cycle != now.power_cycle {
            self.power_cycle = now.power_cycle;
            self.counters = ErrorCounters::default();
            self.state = State::Off;
        }
        if self.state == State::Off {
            self.counters = brought.unwrap_or(self.counters);
        }
        let may_return = self.state == State::BusOff && now.recovers;
        if self.state == State::Off || may_return {
            self.transmitter = false;
            self.transmission = None;
            self.clock.restart(now.timing, at);
            self.state = match (self.counters.bus_off(), now.recovers) {
                (false, _) => State::Integrating { recessive: 0 },
                (true, true) => State::Recovering { recessive: 0, sequences: 0 },
                (true, false) => State::BusOff,
            };
        }
    }

    /// Returns whether a bit is in progress.
    pub(in crate::wire) fn is_running(&self) -> bool {
        !matches!(self.state, State::Off | State::BusOff | State::Idle)
    }

    /// Returns whether it neither sends nor receives, and on a recessive line only counts bits.
    pub(in crate::wire) fn is_quiet(&self) -> bool {
        !self.is_running()
            || matches!(
                self.state,
                State::Intermission(_)
                    | State::Suspend(_)
                    | State::Integrating { .. }
                    | State::Recovering { .. }
            )
    }

    pub(in crate::wire) fn is_silent(&self) -> bool {
        self.attachment.is_some_and(|attachment| attachment.silent)
    }

    /// Returns the number of bits, including the present one, that end without an event if there is no error.
    pub(in crate::wire) fn uneventful_bits(&self) -> u64 {
        let bits = match self.state {
            State::Sof => IDENTIFIER_BITS,
            State::Stuffed => IDENTIFIER_BITS.saturating_sub(self.decoder.index() as u8),
            State::Integrating { recessive } | State::Recovering { recessive, .. } => {
                SEQUENCE_BITS - recessive
            }
            State::ActiveFlag { sent, .. } => FLAG_BITS - sent,
            State::Delimiter { seen } => DELIMITER_BITS - seen,
            State::Intermission(bit) => INTERMISSION_BITS - bit,
            State::Suspend(bit) => SUSPEND_BITS - bit,
            _ => 1,
        };
        u64::from(bits.max(1))
    }

    /// Returns whether it drives the line dominant in the present bit.
    pub(in crate::wire) fn drives(&self) -> bool {
        match self.state {
            State::Sof => self.transmission.is_some(),
            State::Stuffed => self.sends() == DOMINANT,
            State::AckSlot => self.acknowledges(),
            State::ActiveFlag { .. } => true,
            _ => false,
        }
    }

    /// Returns whether it acknowledges the frame in the next ACK slot.
    pub(in crate::wire) fn acknowledges(&self) -> bool {
        self.transmission.is_none() && self.decoder.crc_is_good()
    }

    /// Returns the level that a transmitter sends in the present bit; recessive for others.
    fn sends(&self) -> bool {
        let index = self.decoder.index();
        self.transmission.as_ref().is_none_or(|own| own.encoded.bits()[index])
    }

    /// Returns the instant at which a frame may start if the line stays recessive; `None` if it cannot.
    pub(in crate::wire) fn idle_from(&self) -> Option<Fine> {
        let bits = match self.state {
            State::Idle => return Some(Fine(0)),
            State::Intermission(bit) => {
                let suspend = if self.is_suspended() { SUSPEND_BITS } else { 0 };
                INTERMISSION_BITS - bit + suspend
            }
            State::Suspend(bit) => SUSPEND_BITS - bit,
            _ => return None,
        };
        Some(self.clock.end + self.clock.bit.times(u64::from(bits - 1)))
    }

    /// Skips the rest of an undisturbed intermission if it has ended at `at` and idle follows.
    pub(in crate::wire) fn pass_intermission(&mut self, at: Fine) -> bool {
        let State::Intermission(bit) = self.state else { return false };
        // A pulse may have been sampled in the present bit and have ended.
        let was_sampled = self.clock.latched.is_some();
        if was_sampled || self.is_suspended() || self.idle_from().is_none_or(|idle| idle > at) {
            return false;
        }
        self.clock.skip(u64::from(INTERMISSION_BITS - bit), RECESSIVE);
        self.state = State::Idle;
        true
    }

    fn is_suspended(&self) -> bool {
        self.transmitter && self.counters.error_passive()
    }

    /// Starts a frame.
    pub(in crate::wire) fn start(&mut self, own: Transmission) {
        self.clock.restart(self.timing(), own.start);
        self.state = State::Sof;
        self.join(own);
    }

    /// Enters the arbitration whose SOF has just been sampled.
    pub(in crate::wire) fn join(&mut self, own: Transmission) {
        self.transmission = Some(own);
        self.transmitter = true;
    }

    /// Returns the timing configured by its controller, used from its next frame on.
    pub(in crate::wire) fn timing(&self) -> BitTiming {
        self.attachment.map_or(self.clock.timing, |attachment| attachment.timing)
    }

    /// Returns its clock in idle after a falling edge at `at`.
    pub(in crate::wire) fn clock_from_edge(&self, at: Fine) -> BitClock {
        let mut clock = self.clock;
        if self.timing() != clock.timing {
            clock.restart(self.timing(), at);
        }
        clock.begin_with_edge(at);
        clock
    }

    /// Handles a dominant edge at `at`.
    pub(in crate::wire) fn dominant_edge(&mut self, at: Fine) {
        match self.state {
            State::Off | State::BusOff => {}
            State::Idle => {
                self.clock = self.clock_from_edge(at);
                self.state = State::Sof;
                self.transmitter = false;
            }
            State::Intermission(1..)
            | State::Suspend(_)
            | State::Integrating { .. }
            | State::Recovering { .. } => {
                self.clock.hard_synchronise(at);
            }
            _ => {
                let drives = self.drives();
                self.clock.dominant_edge(at, drives);
            }
        }
    }
}

/// Methods for observers.
impl Mac {
    /// Returns the index of the present bit within its frame, stuff bits included; 0 is SOF.
    pub(in crate::wire) fn position(&self) -> Option<usize> {
        match self.state {
            State::Sof => Some(0),
            State::Stuffed | State::CrcDelimiter | State::AckSlot | State::AckDelimiter | State::Eof(_) => {
                Some(self.decoder.index())
            }
            _ => None,
        }
    }

    /// Returns the field of the present bit, for observers and for faults at a place.
    pub(in crate::wire) fn field(&self) -> Field {
        match self.state {
            State::Off
            | State::BusOff
            | State::Idle
            | State::Integrating { .. }
            | State::Recovering { .. } => Field::Idle,
            State::Sof => Field::Sof,
            State::Stuffed => self.decoder.field(),
            State::CrcDelimiter => Field::CrcDelimiter,
            State::AckSlot => Field::AckSlot,
            State::AckDelimiter => Field::AckDelimiter,
            State::Eof(bit) => Field::Eof(bit),
            State::Intermission(bit) => Field::Intermission(bit),
            State::Suspend(bit) => Field::Suspend(bit),
            State::ActiveFlag { error: true, sent } | State::PassiveFlag { sent, .. } => {
                Field::ErrorFlag(sent)
            }
            State::ActiveFlag { error: false, sent } => Field::OverloadFlag(sent),
            State::Superposition { dominant, .. } => Field::Superposition(dominant.min(255) as u8),
            State::Delimiter { seen } => Field::Delimiter(seen),
        }
    }
}
