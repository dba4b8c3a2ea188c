//! Reads the errors of other nodes that a master may not have heard.

use super::objects::{ERRORS, REGISTER};
use super::{ActiveErrors, ErrorRegister};
use crate::types::{Address, Canonical, Duration, Instant, NodeId};

/// From an error that was found in the history, or a register in an emergency, to the next look at the register.
const AGAIN: Duration = Duration::from_millis(1_000);
/// Questions without an answer, one after the other, until a node is left alone.
const TRIES: u8 = 3;

/// Questions of a master to other nodes: their error register (1001h), and where the known errors do not explain it, their
/// history (1003h), the newest error first, until they do.
///
/// A node is asked when it is heard for the first time since [`restart`](ErrorReader::restart), when it may have booted, and
/// once in each period: a contact that opens for the time of one frame may lose an emergency. An error that was found may
/// end without a message, because its node sent none when it began. So the register is read once more a second later, until
/// nothing changes. A question without an answer is asked three times.
///
/// The owner asks one question at a time, by an SDO upload of at most four bytes:
///
/// ```
/// use async_canopen::emcy::machine::{ActiveErrors, ErrorReader, ReadOutcome};
/// use async_canopen::types::{Duration, Instant, NodeId};
///
/// let (node, timeout, now) = (NodeId::of::<5>(), Duration::from_millis(100), Instant::ZERO);
/// let (mut reader, mut errors) = (ErrorReader::new(Duration::from_millis(10_000)), ActiveErrors::default());
/// reader.on_heard(node, false, now);
///
/// let mut answers = [0x09, 1, 0x0001_4200].into_iter(); // temperature; one entry; 4200h, source 1
/// while reader.deadline().is_some_and(|due| due <= now)
///     && let Some((_, _object)) = reader.question(&errors, |_| true, now)
/// {
///     reader.on_answer(ReadOutcome::Value(answers.next().unwrap()), &mut errors, timeout, now);
/// }
/// assert_eq!(errors.iter().count(), 1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct ErrorReader {
    period: Duration,
    /// A bit for each Node-ID.
    wanted: u128,
    /// Heard since the restart, and not lost.
    heard: u128,
    /// All of these are asked then.
    #[canonical(due)]
    round_at: Instant,
    #[canonical(due)]
    not_before: Instant,
    /// Nodes that are asked again then.
    again: u128,
    #[canonical(due)]
    again_at: Instant,
    question: Option<Question>,
}

/// Outcome of a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadOutcome {
    /// The value of the object.
    Value(u32),
    /// The node has no such object, or its answer is none that an object of four bytes has.
    Refused,
    /// No answer came.
    Missing,
    /// The bus changed meanwhile.
    BusChanged,
}

/// What is read next, or is being read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
struct Question {
    node: NodeId,
    register: ErrorRegister,
    /// Active errors of the node that were known at first.
    known: u8,
    object: Object,
    /// Questions for this object that had no answer.
    tries: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
enum Object {
    Register,
    /// 1003h: an entry, or at sub-index 0 their number.
    History {
        sub: u8,
        last: u8,
    },
}

impl Object {
    const fn address(self) -> Address {
        match self {
            Object::Register => Address::new(REGISTER, 0),
            Object::History { sub, .. } => Address::new(ERRORS, sub),
        }
    }
}

impl ErrorReader {
    /// Makes one that asks each node once in `period`.
    pub const fn new(period: Duration) -> ErrorReader {
        ErrorReader {
            period,
            wanted: 0,
            heard: 0,
            round_at: Instant::NEVER,
            not_before: Instant::ZERO,
            again: 0,
            again_at: Instant::NEVER,
            question: None,
        }
    }

    /// What was heard until now may not be all: every node is asked when it is heard.
    pub fn restart(&mut self) {
        *self = ErrorReader { not_before: self.not_before, ..ErrorReader::new(self.period) };
    }

    /// The node is lost: it is asked when it is heard again.
    pub fn lose(&mut self, node: NodeId) {
        self.heard &= !(1 << node.get());
    }

    /// Takes a heartbeat or boot-up message of a node in a state that allows SDO, or is about to. `may_have_booted`: what is known
    /// of it may be wrong.
    pub fn on_heard(&mut self, node: NodeId, may_have_booted: bool, now: Instant) {
        let bit = 1 << node.get();
        if self.heard & bit == 0 || may_have_booted {
            if self.heard == 0 {
                self.round_at = now + self.period;
            }
            self.heard |= bit;
            self.wanted |= bit;
        }
    }

    /// Asks the node a second after `now`: the known errors do not explain a register of it.
    pub fn ask_again(&mut self, node: NodeId, now: Instant) {
        self.again_at = self.again_at.min(now + AGAIN);
        self.again |= 1 << node.get();
    }

    /// Returns when there may be a question. `None` if there is none.
    pub fn deadline(&self) -> Option<Instant> {
        if self.question.is_some() || self.wanted != 0 {
            return Some(self.not_before);
        }
        let due = self.again_at.min(self.round_at);
        (due < Instant::NEVER).then(|| self.not_before.max(due))
    }

    /// Returns the node to ask, and its object to read. `has_server`: whether a node has an SDO server, as far as the
    /// master knows.
    pub fn question(
        &mut self,
        errors: &ActiveErrors,
        has_server: impl Fn(NodeId) -> bool,
        now: Instant,
    ) -> Option<(NodeId, Address)> {
        let question = self.question.or_else(|| self.next(errors, has_server, now))?;
        self.question = Some(question);
        Some((question.node, question.object.address()))
    }

    fn next(
        &mut self,
        errors: &ActiveErrors,
        has_server: impl Fn(NodeId) -> bool,
        now: Instant,
    ) -> Option<Question> {
        if self.round_at <= now {
            self.wanted |= self.heard;
            self.round_at = now + self.period;
        }
        if self.again_at <= now {
            self.wanted |= core::mem::take(&mut self.again);
            self.again_at = Instant::NEVER;
        }
        while self.wanted != 0 {
            let node = NodeId::new(self.wanted.trailing_zeros() as u8)?;
            self.wanted &= self.wanted - 1;
            if has_server(node) {
                let (register, known) = (ErrorRegister::default(), errors.of(node));
                return Some(Question { node, register, known, object: Object::Register, tries: 0 });
            }
        }
        None
    }

    /// Takes the outcome of the question. `timeout`: after a question without an answer the SDO client is free for others for
    /// this time. Returns the node if its known errors changed.
    pub fn on_answer(
        &mut self,
        answer: ReadOutcome,
        errors: &mut ActiveErrors,
        timeout: Duration,
        now: Instant,
    ) -> Option<NodeId> {
        let question = self.question.take()?;
        match answer {
            ReadOutcome::Value(value) => self.question = answered(question, value, errors),
            ReadOutcome::BusChanged => self.wanted |= 1 << question.node.get(),
            ReadOutcome::Missing => {
                self.not_before = now + timeout;
                let tries = question.tries + 1;
                self.question = (tries < TRIES).then_some(Question { tries, ..question });
            }
            ReadOutcome::Refused => {}
        }
        let has_changed = self.question.is_none() && errors.of(question.node) != question.known;
        if has_changed {
            self.ask_again(question.node, now);
        }
        has_changed.then_some(question.node)
    }
}

/// Takes an answer. Returns the next question to the same node.
fn answered(question: Question, value: u32, errors: &mut ActiveErrors) -> Option<Question> {
    let Question { node, register, object, .. } = question;
    let (register, object) = match object {
        Object::Register => {
            let register = ErrorRegister::from_bits(value as u8);
            if errors.on_register(node, register) {
                return None;
            }
            (register, Object::History { sub: 0, last: 0 })
        }
        Object::History { sub: 0, .. } => (register, Object::History { sub: 1, last: value as u8 }),
        Object::History { sub, last } => {
            if errors.on_history(node, register, value) {
                return None;
            }
            (register, Object::History { sub: sub.checked_add(1)?, last })
        }
    };
    let is_there = !matches!(object, Object::History { sub, last } if sub > last);
    is_there.then_some(Question { register, object, tries: 0, ..question })
}
