//! Active errors of the slaves (object 2048h): follows their emergencies, and reads what it may not have heard.
//!
//! After a change of the bus, a takeover, or the boot-up of a slave, the master reads the error register of the slave
//! (1001h) when it is heard on the active bus. It does so as well after its own controller was bus-off there or lost
//! frames. Where the known errors do not explain the register, it reads the history (1003h), the newest error first, until
//! they do. An error that it found so may end without a message, because the slave sent none when it began. So the master
//! reads the register once more a second later, until nothing changes. It also reads it a second after an emergency whose
//! register is not explained.
//! The boot-up process and the identification of new nodes go first.

use super::transfers::Owner;
use super::{Master, MasterEvent, Out};
use crate::emcy::{ActiveError, EmcyObjects, Emergency, ErrorRegister};
use crate::node::Device;
use crate::redundancy::MasterBoards;
use crate::sdo::{Error, Mode};
use crate::types::{Address, Duration, Instant, NmtState, NodeId};

const REGISTER: Address = EmcyObjects::REGISTER.address();
const HISTORY: u16 = EmcyObjects::ERRORS.index();
/// Most bytes of an answer.
const BYTES: usize = 4;
/// From an error that was found in the history, or a register in an emergency, to the next look at the register.
const AGAIN: Duration = Duration::from_millis(1_000);

/// Nodes whose errors have to be read.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ErrorCheck {
    /// A bit for each Node-ID.
    wanted: u128,
    /// Heard on the active bus since it is active.
    heard: u128,
    not_before: Instant,
    /// Nodes that are asked again then.
    again: u128,
    again_at: Instant,
    question: Option<Question>,
}

/// What is read next, or is being read.
#[derive(Clone, Copy, Debug)]
struct Question {
    node: NodeId,
    register: ErrorRegister,
    /// Active errors of the node that were known at first.
    known: usize,
    object: Object,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
            Object::Register => REGISTER,
            Object::History { sub, .. } => Address::new(HISTORY, sub),
        }
    }
}

impl ErrorCheck {
    /// The bus changed, or this board took over: every slave is asked when it is heard.
    pub fn restart(&mut self) {
        *self = ErrorCheck { not_before: self.not_before, ..ErrorCheck::default() };
    }

    /// The node is asked a second after `now`.
    fn ask_again(&mut self, node: NodeId, now: Instant) {
        if self.again == 0 {
            self.again_at = now + AGAIN;
        }
        self.again |= 1 << node.get();
    }

    /// Returns when the next question is due.
    fn deadline(&self) -> Option<Instant> {
        if self.question.is_some() || self.wanted != 0 {
            Some(self.not_before)
        } else {
            (self.again != 0).then(|| self.not_before.max(self.again_at))
        }
    }

    /// A slave is heard on the active bus in a state that allows SDO.
    #[inline]
    pub fn on_heard(&mut self, node: NodeId, state: NmtState) {
        let bit = 1 << node.get();
        if self.heard & bit == 0 || state == NmtState::Initialising {
            self.heard |= bit;
            self.wanted |= bit;
        }
    }
}

impl<D: Device, B: MasterBoards> Master<D, B> {
    /// Returns the active errors of the slaves, as far as they reported them (objects 2048h and 2049h).
    pub fn active_errors(&self) -> impl Iterator<Item = ActiveError> {
        self.services.dictionary.objects.application.errors.iter()
    }

    /// Takes an emergency of a slave.
    pub(super) fn follow_errors(&mut self, node: NodeId, emergency: &Emergency, now: Instant, out: &mut Out) {
        let errors = &mut self.services.dictionary.objects.application.errors;
        if !errors.on_emergency(node, emergency) {
            out.event(MasterEvent::ErrorNotKept { node });
        }
        if !errors.explain(node, emergency.register) {
            self.errors.ask_again(node, now);
        }
    }

    /// Returns when the errors of a slave can be read. `None` while the client is not free for it.
    pub(super) fn errors_deadline(&self) -> Option<Instant> {
        let due = self.errors.deadline()?;
        let is_free = self.transfers.owner == Owner::Nobody && self.redundancy.is_announced();
        (is_free && !self.boot.is_busy() && !self.redundancy.peers().is_any_unasked()).then_some(due)
    }

    /// Starts to read an object. Returns whether there is a transfer to run.
    pub(super) fn begin_errors(&mut self, until: Instant) -> bool {
        if self.errors_deadline().is_none_or(|deadline| deadline > until) {
            return false;
        }
        let Some(question) = self.errors.question.or_else(|| self.next_question()) else { return false };
        self.errors.question = Some(question);
        let client = self.transfers.take(Owner::Errors, question.node);
        client.start_upload(question.object.address(), BYTES, Mode::Segmented);
        self.services.dictionary.objects.application.network.show_client(question.node);
        true
    }

    /// The next node to ask. One that does not count has no SDO server as far as the master knows.
    fn next_question(&mut self) -> Option<Question> {
        if self.errors.wanted == 0 {
            self.errors.wanted = core::mem::take(&mut self.errors.again);
        }
        while self.errors.wanted != 0 {
            let node = NodeId::new(self.errors.wanted.trailing_zeros() as u8)?;
            self.errors.wanted &= self.errors.wanted - 1;
            if self.redundancy.peers().counts(node) && self.minimal(node).is_none() {
                let known = self.known_errors(node);
                let register = ErrorRegister::default();
                return Some(Question { node, register, known, object: Object::Register });
            }
        }
        None
    }

    fn known_errors(&self, node: NodeId) -> usize {
        self.active_errors().filter(|error| error.node == node).count()
    }

    /// Collects an answer.
    pub(super) fn collect_errors(&mut self, until: Instant, out: &mut Out) {
        if self.transfers.owner != Owner::Errors {
            return;
        }
        let client = &mut self.transfers.client;
        let mut value = [0; BYTES];
        // One piece: the values have 1 and 4 bytes.
        client.pull(&mut value);
        let Some(outcome) = client.outcome() else { return };
        self.transfers.owner = Owner::Nobody;
        let Some(question) = self.errors.question.take() else { return };
        match outcome {
            Ok(_) => self.errors.question = self.answered(question, u32::from_le_bytes(value)),
            Err(Error::BusChanged) => self.errors.wanted |= 1 << question.node.get(),
            Err(Error::Timeout) => self.errors.not_before = until + self.services.lifetimes.sdo,
            Err(Error::Abort(_) | Error::UnknownAbort(_) | Error::Protocol(_) | Error::TooLarge) => {}
        }
        if self.errors.question.is_none() && self.known_errors(question.node) != question.known {
            self.errors.ask_again(question.node, until);
            out.event(MasterEvent::ErrorsRead { node: question.node });
        }
    }

    /// Takes an answer. Returns the next question to the same node.
    fn answered(&mut self, question: Question, value: u32) -> Option<Question> {
        let Question { node, register, object, .. } = question;
        let errors = &mut self.services.dictionary.objects.application.errors;
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
        is_there.then_some(Question { register, object, ..question })
    }
}
