//! One error, and what the network knows of it.

use super::{Emergency, ErrorCode, ErrorRegister};
use crate::types::Canonical;

/// Way of a message to the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
enum Progress {
    /// The message is to be sent, when there is a reason for it.
    Due,
    /// A bus has the message, and did not report its end yet.
    Pending,
    /// A node acknowledged the message. The master was not heard since.
    Acknowledged,
    /// The master was heard since, on the same bus.
    Known,
}

impl Progress {
    const fn is_told(self) -> bool {
        matches!(self, Progress::Acknowledged | Progress::Known)
    }

    /// Returns the progress after the bus reported the end of the message.
    const fn ended(self, is_acknowledged: bool) -> Progress {
        match self {
            Progress::Pending if is_acknowledged => Progress::Acknowledged,
            Progress::Pending => Progress::Due,
            other => other,
        }
    }
}

/// Message of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Message {
    /// The error appeared.
    Begin,
    /// The error is gone.
    End,
}

/// An error that is active, or that the master may not know to be over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
pub(super) struct Announced {
    pub code: ErrorCode,
    info: [u8; 5],
    pub is_active: bool,
    /// `true`: messages have to be sent, whether the error is active or over: it was over at once, or the master may have heard
    /// a message of it or not.
    is_owed: bool,
    begin: Progress,
    end: Progress,
}

impl Announced {
    /// No error.
    pub const NONE: Announced = Announced { is_active: false, ..Announced::new(ErrorCode::NO_ERROR, [0; 5]) };

    /// Takes an error that appeared.
    pub const fn new(code: ErrorCode, info: [u8; 5]) -> Announced {
        let (begin, end) = (Progress::Due, Progress::Due);
        Announced { code, info, is_active: true, is_owed: false, begin, end }
    }

    /// Takes an error that was over at once.
    pub const fn past(code: ErrorCode, info: [u8; 5]) -> Announced {
        Announced { is_active: false, is_owed: true, ..Announced::new(code, info) }
    }

    /// Returns whether it is the error with this code and source.
    pub fn is(&self, code: ErrorCode, source: u8) -> bool {
        self.code == code && self.source() == source
    }

    const fn source(&self) -> u8 {
        let [source, ..] = self.info;
        source
    }

    /// Returns whether both messages were sent.
    pub const fn is_told(&self) -> bool {
        self.begin.is_told() && self.end.is_told()
    }

    /// The error appeared again. Before its end was sent, that sends nothing.
    pub fn raise(&mut self, info: [u8; 5]) {
        if self.begin.is_told() && (self.end.is_told() || self.is_owed) {
            // The master may have heard the last end, or not: both have to follow.
            *self = Announced { is_owed: true, ..Announced::new(self.code, info) };
        }
        self.is_active = true;
    }

    /// Sends nothing of an error that is over and was not reported.
    pub fn forgive(&mut self) {
        self.is_owed = false;
    }

    /// Returns the message that is due.
    pub const fn due(&self) -> Option<Message> {
        match (self.begin, self.end) {
            (Progress::Due, _) if self.is_active || self.is_owed => Some(Message::Begin),
            (begin, Progress::Due) if begin.is_told() && !self.is_active => Some(Message::End),
            _ => None,
        }
    }

    /// Hands out a message that is due. `register`: the errors that are active.
    pub fn hand_out(&mut self, message: Message, register: ErrorRegister) -> Emergency {
        match message {
            Message::Begin => {
                self.begin = Progress::Pending;
                let register = register.and(ErrorRegister::of(self.code));
                Emergency { code: self.code, register, info: self.info }
            }
            Message::End => {
                self.end = Progress::Pending;
                let [low, high] = self.code.get().to_le_bytes();
                let info = [low, high, self.source(), 0, 0];
                Emergency { code: ErrorCode::NO_ERROR, register, info }
            }
        }
    }

    /// Takes the end of a message that was handed out: acknowledged, or not sent.
    pub fn on_end(&mut self, message: Message, is_acknowledged: bool) {
        match message {
            Message::Begin => self.begin = self.begin.ended(is_acknowledged),
            Message::End => {
                self.end = self.end.ended(is_acknowledged);
                if self.end.is_told() && self.is_active {
                    // It came back while its end was on the way, which the master may not have heard.
                    (self.begin, self.end, self.is_owed) = (Progress::Due, Progress::Due, true);
                }
            }
        }
    }

    /// Takes back a message that its bus will not send.
    pub fn recall(&mut self) {
        (self.begin, self.end) = (self.begin.ended(false), self.end.ended(false));
    }

    /// Sends again what the master may not have heard.
    pub fn repeat(&mut self) {
        if self.begin == Progress::Acknowledged {
            // The master may have heard it: the end has to follow, whenever it comes.
            (self.begin, self.is_owed) = (Progress::Due, true);
        }
        if self.end == Progress::Acknowledged {
            (self.end, self.is_owed) = (Progress::Due, true);
        }
    }

    /// The master was heard.
    pub fn confirm(&mut self) {
        if self.begin == Progress::Acknowledged {
            (self.begin, self.is_owed) = (Progress::Known, false);
        }
        if self.end == Progress::Acknowledged {
            self.end = Progress::Known;
        }
    }

    /// Returns whether the master may not know a message that was acknowledged.
    pub fn is_unconfirmed(&self) -> bool {
        self.begin == Progress::Acknowledged || self.end == Progress::Acknowledged
    }

    /// Returns whether nothing is left to tell.
    pub fn is_over(&self) -> bool {
        let is_known = match self.begin {
            Progress::Due => !self.is_owed,
            Progress::Pending => false,
            _ => self.end == Progress::Known,
        };
        is_known && !self.is_active
    }
}
