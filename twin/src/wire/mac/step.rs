//! The end of a bit: evaluation of its level in each state, and the next state (ISO 11898-1, 10 and 12).

use super::{
    DELIMITER_BITS, DOMINANT, EOF_BITS, FLAG_BITS, INTERMISSION_BITS, Mac, Note, RECESSIVE,
    RECOVERY_SEQUENCES, SEQUENCE_BITS, SUSPEND_BITS, State,
};
use crate::wire::confinement::ErrorCounters;
use crate::wire::controller::{ErrorKind, WireEvent};
use crate::wire::decode::Decoder;

impl Mac {
    /// Ends the present bit, whose sample is `sampled`, and begins the next. `line` is the present level.
    pub(in crate::wire) fn step(&mut self, sampled: bool, line: bool) -> Note {
        let note = self.decide(sampled);
        self.clock.next_bit(sampled);
        if self.state == State::Idle && line == DOMINANT {
            // The edge came after the last sample point: it synchronised this bit, which is a SOF.
            self.state = State::Sof;
            self.transmitter = false;
        }
        note
    }

    fn decide(&mut self, sampled: bool) -> Note {
        match self.state {
            State::Off | State::BusOff | State::Idle => Note::default(),
            State::Integrating { recessive } => self.integrate(sampled, recessive),
            State::Recovering { recessive, sequences } => self.recover(sampled, recessive, sequences),
            State::Sof => self.start_of_frame(sampled),
            State::Stuffed => self.stuffed(sampled),
            State::CrcDelimiter => self.fixed(sampled, State::AckSlot),
            State::AckSlot => self.ack_slot(sampled),
            State::AckDelimiter => self.ack_delimiter(sampled),
            State::Eof(bit) => self.end_of_frame(sampled, bit),
            State::Intermission(bit) => self.intermission(sampled, bit),
            State::Suspend(bit) => self.suspend(sampled, bit),
            State::ActiveFlag { error, sent } => self.active_flag(sampled, error, sent),
            State::PassiveFlag { .. } => self.passive_flag(sampled),
            State::Superposition { error, dominant } => self.superposition(sampled, error, dominant),
            State::Delimiter { seen } => self.delimiter(sampled, seen),
        }
    }

    fn integrate(&mut self, sampled: bool, recessive: u8) -> Note {
        let recessive = if sampled { recessive + 1 } else { 0 };
        if recessive == SEQUENCE_BITS {
            self.state = State::Idle;
            return WireEvent::Joined.into();
        }
        self.state = State::Integrating { recessive };
        Note::default()
    }

    fn recover(&mut self, sampled: bool, recessive: u8, sequences: u8) -> Note {
        let recessive = if sampled { recessive + 1 } else { 0 };
        if recessive < SEQUENCE_BITS {
            self.state = State::Recovering { recessive, sequences };
            return Note::default();
        }
        self.state = State::Recovering { recessive: 0, sequences: sequences + 1 };
        if sequences + 1 == RECOVERY_SEQUENCES {
            // Rule l.
            self.counters = ErrorCounters::default();
            self.state = State::Idle;
        }
        if sequences == 0 { WireEvent::Joined.into() } else { Note::default() }
    }

    fn start_of_frame(&mut self, sampled: bool) -> Note {
        if sampled == RECESSIVE {
            if self.transmission.is_some() {
                return self.fail(ErrorKind::BitDominant, false);
            }
            self.state = State::Idle;
            return Note::default();
        }
        self.begin_frame();
        Note { event: None, may_join: self.transmission.is_none() }
    }

    fn begin_frame(&mut self) {
        self.decoder = Decoder::new();
        // A first bit cannot break the stuffing rule.
        let _ = self.decoder.push(DOMINANT);
        self.state = State::Stuffed;
    }

    fn stuffed(&mut self, sampled: bool) -> Note {
        let sent = self.sends();
        let mut note = Note::default();
        if let Some(own) = &self.transmission
            && sampled != sent
        {
            let arbitrates = self.decoder.index() < own.encoded.arbitration_len();
            match (sent, arbitrates, self.decoder.stuff_is_due()) {
                (DOMINANT, ..) => return self.fail(ErrorKind::BitDominant, false),
                (RECESSIVE, false, _) => return self.fail(ErrorKind::BitRecessive, false),
                // Rule c, exception 2.
                (RECESSIVE, true, true) => return self.fail(ErrorKind::Stuff, true),
                (RECESSIVE, true, false) => {
                    self.finished = self.transmission.take();
                    self.transmitter = false;
                    note = WireEvent::ArbitrationLost.into();
                }
            }
        }
        if self.decoder.push(sampled).is_err() {
            return self.fail(ErrorKind::Stuff, false);
        }
        if self.decoder.is_complete() {
            self.state = State::CrcDelimiter;
        }
        note
    }

    /// Handles a bit that all nodes send recessive.
    fn fixed(&mut self, sampled: bool, next: State) -> Note {
        if sampled == DOMINANT {
            let sends = self.transmission.is_some();
            return self.fail(if sends { ErrorKind::BitRecessive } else { ErrorKind::Form }, false);
        }
        self.decoder.push_fixed();
        self.state = next;
        Note::default()
    }

    fn ack_slot(&mut self, sampled: bool) -> Note {
        if sampled == RECESSIVE {
            if self.transmission.is_some() {
                // Rule c, exception 1: the flag decides whether the error counts.
                let spared = self.counters.error_passive();
                return self.fail(ErrorKind::Ack, spared);
            }
            if self.acknowledges() {
                return self.fail(ErrorKind::BitDominant, false);
            }
        }
        self.decoder.push_fixed();
        self.state = State::AckDelimiter;
        Note::default()
    }

    fn ack_delimiter(&mut self, sampled: bool) -> Note {
        if sampled == RECESSIVE && self.transmission.is_none() && !self.decoder.crc_is_good() {
            return self.fail(ErrorKind::Crc, false);
        }
        self.fixed(sampled, State::Eof(0))
    }

    fn end_of_frame(&mut self, sampled: bool, bit: u8) -> Note {
        let sends = self.transmission.is_some();
        let last = bit == EOF_BITS - 1;
        if sampled == DOMINANT && last && !sends {
            self.overload();
            return Note::default();
        }
        let note = self.fixed(sampled, if last { State::Intermission(0) } else { State::Eof(bit + 1) });
        if sampled == DOMINANT {
            return note;
        }
        if last && sends {
            self.finished = self.transmission.take();
            self.counters.transmitted();
            return WireEvent::Transmitted.into();
        }
        if bit + 2 == EOF_BITS && !sends {
            self.counters.received();
            return WireEvent::Received(self.decoder.frame()).into();
        }
        note
    }

    fn intermission(&mut self, sampled: bool, bit: u8) -> Note {
        let last = bit + 1 == INTERMISSION_BITS;
        match (sampled, last) {
            (RECESSIVE, false) => self.state = State::Intermission(bit + 1),
            (RECESSIVE, true) => {
                self.state = if self.is_suspended() { State::Suspend(0) } else { State::Idle };
            }
            (DOMINANT, false) => self.overload(),
            (DOMINANT, true) => {
                let may_join = !self.is_suspended();
                self.transmitter = false;
                self.begin_frame();
                return Note { event: None, may_join };
            }
        }
        Note::default()
    }

    fn suspend(&mut self, sampled: bool, bit: u8) -> Note {
        if sampled == DOMINANT {
            self.transmitter = false;
            self.begin_frame();
        } else {
            self.state = if bit + 1 == SUSPEND_BITS { State::Idle } else { State::Suspend(bit + 1) };
        }
        Note::default()
    }

    fn overload(&mut self) {
        self.state = State::ActiveFlag { error: false, sent: 0 };
    }

    fn active_flag(&mut self, sampled: bool, error: bool, sent: u8) -> Note {
        if sampled == RECESSIVE {
            // Rules d and e.
            let passive = self.counters.error_passive();
            self.counters.add_eight(self.transmitter);
            self.flag(passive, false);
            return WireEvent::ReceiveError(ErrorKind::BitDominant).into();
        }
        self.state = if sent + 1 == FLAG_BITS {
            State::Superposition { error, dominant: 0 }
        } else {
            State::ActiveFlag { error, sent: sent + 1 }
        };
        Note::default()
    }

    fn passive_flag(&mut self, sampled: bool) -> Note {
        let State::PassiveFlag { sent, run, level, mut spared } = self.state else { return Note::default() };
        if spared && sampled == DOMINANT {
            spared = false;
            self.counters.add_eight(true);
            if self.counters.bus_off() {
                self.leave_bus();
                return Note::default();
            }
        }
        let run = if sent > 0 && sampled == level { run + 1 } else { 1 };
        self.state = if run == FLAG_BITS {
            State::Superposition { error: true, dominant: 0 }
        } else {
            State::PassiveFlag { sent: sent.saturating_add(1), run, level: sampled, spared }
        };
        Note::default()
    }

    fn superposition(&mut self, sampled: bool, error: bool, dominant: u16) -> Note {
        if sampled == RECESSIVE {
            self.state = State::Delimiter { seen: 1 };
            return Note::default();
        }
        if error && dominant == 0 && !self.transmitter {
            // Rule b.
            self.counters.add_eight(false);
        }
        let dominant = if dominant == u16::MAX { 8 } else { dominant + 1 };
        if dominant.is_multiple_of(8) {
            // Rule f.
            self.counters.add_eight(self.transmitter);
        }
        self.state = State::Superposition { error, dominant };
        if self.counters.bus_off() {
            self.leave_bus();
        }
        Note::default()
    }

    fn delimiter(&mut self, sampled: bool, seen: u8) -> Note {
        if sampled == DOMINANT {
            if seen + 1 == DELIMITER_BITS {
                self.overload();
                return Note::default();
            }
            return self.fail(ErrorKind::Form, false);
        }
        self.state = if seen + 1 == DELIMITER_BITS {
            State::Intermission(0)
        } else {
            State::Delimiter { seen: seen + 1 }
        };
        Note::default()
    }

    /// Handles an error: rules a and c, then the flag. `spared`: an exception to rule c applies.
    fn fail(&mut self, kind: ErrorKind, spared: bool) -> Note {
        let passive = self.counters.error_passive();
        self.finished = self.transmission.take();
        if !self.transmitter {
            self.counters.receive_error();
        } else if !spared {
            self.counters.add_eight(true);
        }
        self.flag(passive, spared && kind == ErrorKind::Ack);
        if self.finished.is_some() { WireEvent::TransmitError(kind) } else { WireEvent::ReceiveError(kind) }
            .into()
    }

    /// The error that makes a node error passive still shows with an active flag; bus-off sends none.
    fn flag(&mut self, passive: bool, spared: bool) {
        if self.counters.bus_off() {
            self.leave_bus();
        } else if passive {
            self.state = State::PassiveFlag { sent: 0, run: 0, level: RECESSIVE, spared };
        } else {
            self.state = State::ActiveFlag { error: true, sent: 0 };
        }
    }

    fn leave_bus(&mut self) {
        let recovers = self.attachment.is_some_and(|attachment| attachment.recovers);
        self.transmission = None;
        self.state = if recovers { State::Recovering { recessive: 0, sequences: 0 } } else { State::BusOff };
    }
}
