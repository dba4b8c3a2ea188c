//! Producer of emergency messages.

use heapless::Deque;

use super::objects::{COB_ID, ERRORS, INHIBIT};
use super::{Config, EmcyObjects, Emergency, ErrorCode, ErrorRegister, History};
use crate::types::{Address, Duration, Frame, Instant, NmtState, Sealed};

/// Errors that are remembered (object 1003h).
const HISTORY: usize = 8;
/// Messages that may wait for the inhibit time or for a state that allows them.
const WAITING: usize = 8;
/// Errors that may be active together.
const ACTIVE: usize = 16;
/// Flag of an active error: its message was sent or waits.
const TOLD: u32 = 1 << 31;

/// Error register, history, and the messages that report errors.
///
/// An error is reported once when it appears and once when it is gone. Its *source* is the first byte of the
/// manufacturer-specific field. Two errors with one code and two sources are different: for example the missed
/// heartbeats of two nodes.
///
/// The end of an error is not reported if its message was never sent, because there was no COB-ID or the queue was
/// full. Otherwise "no error" would seem to mean another error.
#[doc(alias("EMCY producer", "1014h", "1015h"))]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Producer {
    /// COB-ID of the messages.
    id: Sealed,
    inhibit: Duration,
    /// Code and source of each, see [`key`], and [`TOLD`]; zero is a free place.
    active: [u32; ACTIVE],
    history: History<HISTORY>,
    waiting: Deque<Emergency, WAITING>,
    last: Option<Instant>,
    lost: u32,
}

impl Producer {
    /// Makes a producer without errors.
    pub const fn new(config: Config) -> Self {
        Producer {
            id: Sealed::maybe(config.id),
            inhibit: config.inhibit,
            active: [0; ACTIVE],
            history: History::new(),
            waiting: Deque::new(),
            last: None,
            lost: 0,
        }
    }

    /// Returns the COB-ID of the messages with its complement. Without one, or when a bit of it has flipped, no
    /// message is sent.
    pub const fn id(&self) -> Sealed {
        self.id
    }

    /// Takes new values of 1014h and 1015h. The inhibit time counts from the last message that was sent. If the
    /// COB-ID is not valid any more, messages that wait are dropped.
    pub fn configure(&mut self, config: Config) {
        (self.id, self.inhibit) = (Sealed::maybe(config.id), config.inhibit);
        while config.id.is_none()
            && let Some(dropped) = self.waiting.pop_front()
        {
            let [source, ..] = dropped.info;
            if let Some(place) = self.place(key(dropped.code, source)) {
                *place &= !TOLD;
            }
        }
    }

    /// Takes the new value of one of its objects that was written.
    pub fn follow(&mut self, at: Address, objects: &mut EmcyObjects) {
        match at.index {
            ERRORS => {
                let _ = self.history.write_len(0);
                self.show(objects);
            }
            COB_ID | INHIBIT => self.configure(objects.config()),
            _ => {}
        }
    }

    /// Copies register and history into the objects.
    pub fn show(&self, objects: &mut EmcyObjects) {
        objects.register = self.register().bits();
        objects.errors.count = self.history.len();
        for (slot, sub) in objects.errors.errors.iter_mut().zip(1..) {
            *slot = self.history.read(sub).unwrap_or(0);
        }
    }

    /// Takes a reset of the communication. The history then holds the errors that are still active, like the
    /// register (CiA 301: the communication profile returns to its power-on values).
    pub fn restart(&mut self) {
        let Self { active, history, .. } = self;
        history.keep(|code, source| active.iter().any(|error| error & !TOLD == key(code, source)));
    }

    /// Takes an error that appeared. The first byte of `info` is its source, zero if the code has only one. Returns
    /// `false` if the error is active already: then it is not reported again.
    ///
    /// At most 16 errors are active. One more is reported, but not recorded as active.
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) -> bool {
        let [source, detail, ..] = info;
        let error = key(code, source);
        if code == ErrorCode::NO_ERROR || self.place(error).is_some() {
            return false;
        }
        if let Some(free) = self.place(0) {
            *free = error;
        }
        self.history.push(code, u16::from_le_bytes([source, detail]));
        let register = self.register().and(ErrorRegister::of(code));
        if self.tell(Emergency { code, register, info })
            && let Some(place) = self.place(error)
        {
            *place |= TOLD;
        }
        true
    }

    /// Lets the message of the error that was raised last go out first, and now: the node is about to enter a state that
    /// forbids it.
    pub fn hasten(&mut self) {
        if let Some(newest) = self.waiting.pop_back()
            && self.waiting.push_front(newest).is_ok()
        {
            self.last = None;
        }
    }

    /// Notes that an error is gone. The message is "error reset" with the errors that remain in the error
    /// register. Its manufacturer-specific field has code and source of this error. Returns whether the error was
    /// active.
    pub fn clear(&mut self, code: ErrorCode, source: u8) -> bool {
        if code == ErrorCode::NO_ERROR {
            return false;
        }
        let Some(place) = self.place(key(code, source)) else { return false };
        let was_told = core::mem::take(place) & TOLD != 0;
        let [low, high] = code.get().to_le_bytes();
        let info = [low, high, source, 0, 0];
        if was_told {
            self.tell(Emergency { code: ErrorCode::NO_ERROR, register: self.register(), info });
        }
        true
    }

    /// Returns whether a message of this error waits.
    pub fn is_waiting(&self, code: ErrorCode, source: u8) -> bool {
        self.waiting.iter().any(|message| message.code == code && message.info.first() == Some(&source))
    }

    fn place(&mut self, holding: u32) -> Option<&mut u32> {
        self.active.iter_mut().find(|place| **place & !TOLD == holding)
    }

    /// Returns whether the message will be sent.
    fn tell(&mut self, emergency: Emergency) -> bool {
        if self.id == Sealed::NONE {
            return false;
        }
        let is_taken = self.waiting.push_back(emergency).is_ok();
        self.lost = self.lost.saturating_add(u32::from(!is_taken));
        is_taken
    }

    /// Returns the error register (1001h).
    pub fn register(&self) -> ErrorRegister {
        let kinds = self.active.iter().map(|error| ErrorRegister::of(ErrorCode::new((error >> 8) as u16)));
        kinds.fold(ErrorRegister::default(), ErrorRegister::and)
    }

    /// Returns the history of errors (1003h).
    pub const fn history(&self) -> &History<HISTORY> {
        &self.history
    }

    /// Returns the history of errors (1003h), to remove errors.
    pub const fn history_mut(&mut self) -> &mut History<HISTORY> {
        &mut self.history
    }

    /// Returns the number of messages lost because too many waited before them. The history has their errors.
    pub const fn lost(&self) -> u32 {
        self.lost
    }

    /// Returns the next message if one waits, the inhibit time is over, and `state` allows it.
    pub fn poll(&mut self, now: Instant, state: NmtState) -> Option<Frame> {
        let id = self.id.id()?;
        self.deadline(state).filter(|due| *due <= now)?;
        let emergency = self.waiting.pop_front()?;
        self.last = Some(now);
        Some(emergency.encode(id))
    }

    /// Returns when the next message may go out, which may be in the past. `None` if none waits or `state`
    /// forbids it.
    pub fn deadline(&self, state: NmtState) -> Option<Instant> {
        if self.waiting.is_empty() || !state.allows_emcy() {
            return None;
        }
        Some(self.last.map_or(Instant::ZERO, |last| last + self.inhibit))
    }
}

fn key(code: ErrorCode, source: u8) -> u32 {
    u32::from(code.get()) << 8 | u32::from(source)
}
