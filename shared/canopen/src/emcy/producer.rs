//! Producer of emergency messages.

use super::announced::{Announced, Message};
use super::objects::{COB_ID, ERRORS, INHIBIT};
use super::{Config, EmcyObjects, ErrorCode, ErrorRegister, History};
use crate::types::{Address, Canonical, Duration, Frame, Instant, NmtState, Sealed};

/// Errors that are remembered (object 1003h).
const HISTORY: usize = 8;
/// Errors that are active, or that the master may not know to be over.
const PLACES: usize = 16;

/// Error register, history, and the messages that report errors.
///
/// An error is reported when it appears and when it is gone. Its *source* is the first byte of the
/// manufacturer-specific field. Two errors with one code and two sources are different: for example the missed
/// heartbeats of two nodes.
///
/// A message stays here until a node acknowledged it: pass the end of each frame to [`Producer::on_end`]. On a bus that
/// is cut, the node that acknowledged may be another one than the master. So the producer sends a message again on
/// another bus unless the master was heard in between ([`Producer::confirm`], [`Producer::on_bus_changed`]).
///
/// An error that is gone before its first message was sent, sends none. The history has it. One that comes back before
/// its end was sent, sends nothing either. So an error has at most one message that waits, however often it comes and
/// goes.
#[doc(alias("EMCY producer", "1014h", "1015h"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct Producer {
    /// COB-ID of the messages.
    id: Sealed,
    inhibit: Duration,
    errors: [Announced; PLACES],
    /// Place whose turn it is.
    turn: u8,
    /// Place of the error that was raised last.
    newest: u8,
    history: History<HISTORY>,
    #[canonical(age = self.inhibit)]
    last: Option<Instant>,
    /// After a message that was not sent.
    #[canonical(due)]
    retry: Instant,
    is_due: bool,
    is_unconfirmed: bool,
    lost: u32,
}

impl Producer {
    /// Time from a message that was not sent to the next one.
    pub(crate) const RETRY: Duration = Duration::from_millis(50);

    /// Makes a producer without errors.
    pub const fn new(config: Config) -> Self {
        Producer {
            id: Sealed::maybe(config.id),
            inhibit: config.inhibit,
            errors: [Announced::NONE; PLACES],
            turn: 0,
            newest: 0,
            history: History::new(),
            last: None,
            retry: Instant::ZERO,
            is_due: false,
            is_unconfirmed: false,
            lost: 0,
        }
    }

    /// Returns the COB-ID of the messages with its complement. Without one, or when a bit of it has flipped, no
    /// message is sent.
    pub const fn id(&self) -> Sealed {
        self.id
    }

    /// Takes new values of 1014h and 1015h. The inhibit time counts from the last message that was sent. While the
    /// COB-ID is not valid, nothing is sent. Errors that are active when it becomes valid are reported then.
    pub fn configure(&mut self, config: Config) {
        let id = Sealed::maybe(config.id);
        let has_changed = core::mem::replace(&mut self.id, id) != id;
        self.inhibit = config.inhibit;
        if config.id.is_none() {
            self.change(Announced::forgive);
        }
        if has_changed {
            self.change(Announced::recall);
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
        let Self { errors, history, .. } = self;
        history.keep(|code, source| errors.iter().any(|error| error.is_active && error.is(code, source)));
    }

    /// Takes an error that appeared. The first byte of `info` is its source, zero if the code has only one. Returns
    /// `false` if the error is active already: then it is not reported again.
    ///
    /// There is room for 16 errors. One more is in the history alone, and counted.
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) -> bool {
        let [source, ..] = info;
        match self.find(code, source) {
            _ if code == ErrorCode::NO_ERROR => return false,
            Some(error) if error.is_active => return false,
            Some(error) => error.raise(info),
            None => self.add(Announced::new(code, info)),
        }
        self.remember(code, info);
        true
    }

    /// Takes an error that was over at once: it is reported, and so is its end. One more before its end was sent is
    /// not reported. Returns whether it is.
    pub fn report(&mut self, code: ErrorCode, info: [u8; 5]) -> bool {
        let [source, ..] = info;
        let is_silent = self.id == Sealed::NONE;
        match self.find(code, source) {
            Some(error) if error.is_active || !error.is_told() => return false,
            Some(error) => *error = Announced::past(code, info),
            None if is_silent => {}
            None => self.add(Announced::past(code, info)),
        }
        self.remember(code, info);
        true
    }

    fn remember(&mut self, code: ErrorCode, info: [u8; 5]) {
        let [source, detail, ..] = info;
        self.history.push(code, u16::from_le_bytes([source, detail]));
        if let Some(place) = self.errors.iter().position(|error| error.is(code, source)) {
            self.newest = place as u8;
        }
        self.settle();
    }

    /// In a full list an error that is over, and whose end was acknowledged, makes room.
    #[inline(never)] // of two callers
    fn add(&mut self, error: Announced) {
        let is_free = |place: &Announced| place.code == ErrorCode::NO_ERROR;
        let is_told = |place: &Announced| !place.is_active && place.is_told();
        let all = &self.errors;
        let Some(at) = all.iter().position(is_free).or_else(|| all.iter().position(is_told)) else {
            self.lost = self.lost.saturating_add(1);
            return;
        };
        if let Some(place) = self.errors.get_mut(at) {
            *place = error;
        }
    }

    /// Lets the message of the error that was raised last go out first, and now: the node is about to enter a state that
    /// forbids it.
    pub fn hasten(&mut self) {
        self.turn = self.newest;
        (self.last, self.retry) = (None, Instant::ZERO);
    }

    /// Notes that an error is gone. The message is "error reset" with the errors that remain in the error
    /// register. Its manufacturer-specific field has code and source of this error. Returns whether the error was
    /// active.
    pub fn clear(&mut self, code: ErrorCode, source: u8) -> bool {
        let Some(error) = self.find(code, source).filter(|error| error.is_active) else { return false };
        error.is_active = false;
        self.settle();
        true
    }

    /// Takes the end of a frame of this node on the bus that it uses: a node acknowledged it, or it was not sent. A
    /// message that was not sent is due again after 50 ms.
    pub fn on_end(&mut self, frame: &Frame, is_acknowledged: bool, now: Instant) {
        let Some([low, high, _, info @ ..]) = frame.full().filter(|_| self.id.is(frame.id())) else { return };
        let [first, second, third, ..] = *info;
        let (message, code, source) = match u16::from_le_bytes([*low, *high]) {
            0 => (Message::End, u16::from_le_bytes([first, second]), third),
            code => (Message::Begin, code, first),
        };
        if let Some(error) = self.find(ErrorCode::new(code), source) {
            error.on_end(message, is_acknowledged);
            if !is_acknowledged {
                self.retry = now + Self::RETRY;
            }
            self.settle();
        }
    }

    /// The master was heard on the bus that the node uses: it knows the messages that were acknowledged.
    pub fn confirm(&mut self) {
        if self.is_unconfirmed {
            self.change(Announced::confirm);
        }
    }

    /// A bus will not send what it has of this producer: it was left, or had no room. That is due again from `at` on.
    pub fn recall(&mut self, at: Instant) {
        self.retry = at;
        self.change(Announced::recall);
    }

    /// The master is on another bus, or is another one: what it may not have heard is due again.
    pub fn on_bus_changed(&mut self) {
        self.retry = Instant::ZERO;
        self.change(Announced::repeat);
    }

    /// Brings instants that lie too far in the future back to `now`: a bit of them flipped.
    pub(crate) fn confine(&mut self, now: Instant) {
        self.last.iter_mut().for_each(|last| last.confine(now));
        self.retry.confine(now + Self::RETRY);
    }

    fn change(&mut self, change: impl Fn(&mut Announced)) {
        self.errors.iter_mut().for_each(change);
        self.settle();
    }

    /// Removes what is over, and notes what is to be done.
    #[inline(never)] // of many callers
    fn settle(&mut self) {
        (self.is_due, self.is_unconfirmed) = (false, false);
        let is_silent = self.id == Sealed::NONE;
        for error in &mut self.errors {
            if error.is_over() {
                *error = Announced::NONE;
            }
            self.is_due |= !is_silent && error.due().is_some();
            self.is_unconfirmed |= error.is_unconfirmed();
        }
    }

    #[inline(never)] // of many callers
    fn find(&mut self, code: ErrorCode, source: u8) -> Option<&mut Announced> {
        self.errors.iter_mut().find(|error| error.is(code, source))
    }

    /// Returns the error register (1001h).
    pub fn register(&self) -> ErrorRegister {
        let active = self.errors.iter().filter(|error| error.is_active);
        active.map(|error| ErrorRegister::of(error.code)).fold(ErrorRegister::default(), ErrorRegister::and)
    }

    /// Returns the history of errors (1003h).
    pub const fn history(&self) -> &History<HISTORY> {
        &self.history
    }

    /// Returns the history of errors (1003h), to remove errors.
    pub const fn history_mut(&mut self) -> &mut History<HISTORY> {
        &mut self.history
    }

    /// Returns the number of errors that were not reported because too many were active. The history has them.
    pub const fn lost(&self) -> u32 {
        self.lost
    }

    /// Returns the next message if one is due, the inhibit time is over, and `state` allows it. Messages of different
    /// errors take turns.
    pub fn poll(&mut self, now: Instant, state: NmtState) -> Option<Frame> {
        let id = self.id.id()?;
        self.deadline(state).filter(|due| *due <= now)?;
        let register = self.register();
        let mut places = (0..PLACES).map(|nth| (usize::from(self.turn) + nth) % PLACES);
        let at = places.find(|at| self.errors.get(*at).is_some_and(|error| error.due().is_some()))?;
        let error = self.errors.get_mut(at)?;
        let emergency = error.hand_out(error.due()?, register);
        (self.turn, self.last) = (at as u8 + 1, Some(now));
        self.settle();
        Some(emergency.encode(id))
    }

    /// Returns when the next message may go out, which may be in the past. `None` if none is due or `state`
    /// forbids it.
    pub fn deadline(&self, state: NmtState) -> Option<Instant> {
        if !self.is_due || !state.allows_emcy() {
            return None;
        }
        Some(self.last.map_or(Instant::ZERO, |last| last + self.inhibit).max(self.retry))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::CobId;

    /// Given an error to report, while one bit of the COB-ID or of its complement is wrong, then no message is sent.
    ///
    /// Verifies: ECSS 6.10d
    #[test]
    fn no_message_is_sent_while_a_bit_of_the_cob_id_is_wrong() {
        let sealed = Sealed::of(CobId::new(0x085).unwrap());
        let sent = |id| {
            let mut producer = Producer::new(Config { id: CobId::new(0x085), inhibit: Duration::ZERO });
            producer.id = id;
            producer.raise(ErrorCode::GENERIC, [0; 5]);
            producer.poll(Instant::ZERO, NmtState::Operational)
        };
        assert!(sent(sealed).is_some());
        assert!(sealed.flipped().all(|id| sent(id).is_none()));
    }
}
