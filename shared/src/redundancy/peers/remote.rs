//! What a master knows of one other node.

use super::Parameters;
use crate::heartbeat::machine::{Consumer, ConsumerTimes};
use crate::types::{Canonical, Duration, Instant, NmtState};

/// Consumer times without a heartbeat after which a node is forgotten that has to answer first, or again.
pub(super) const MEMORY: u32 = 10;

/// One node, heard or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[canonical(context = RemoteTimes)]
pub(super) struct Remote {
    /// `None`: it was never heard, or is forgotten.
    #[canonical(within = *context)]
    pub heard: Option<Heard>,
    /// Consumer time of its own (1016h), milliseconds. Zero: the common one.
    pub time: u16,
    pub assignment: Assignment,
    /// Not to be started unasked, heard or not: the application stopped it.
    pub is_held: bool,
}

/// What is known of a node that was heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[canonical(context = RemoteTimes)]
pub(super) struct Heard {
    pub state: NmtState,
    pub standing: Standing,
    /// It booted up since it answered, or was adopted. It has to answer again.
    pub has_booted_up: bool,
    /// The question for its device type.
    pub question: Question,
    /// Questions without an answer since the node was first heard, or since its last boot-up message.
    pub unanswered: u8,
    /// Another master was active when this board heard it Operational.
    pub is_overheard: bool,
    /// Heartbeat period, milliseconds: the last gap between two heartbeats, where it was longer than the common consumer
    /// time. Else, and of a node that 1F81h assigns, zero.
    pub period: u16,
    #[canonical(within = context.heartbeat)]
    pub heartbeat: Consumer,
    /// Silent on the active bus from then on.
    // How long ago counts only together with the first heartbeat on the other bus.
    #[canonical(age = if self.first_there < Instant::NEVER { context.hold } else { Duration::ZERO })]
    pub silent_at: Instant,
    /// First and last heartbeat on the other bus since the last one on the active bus, never and zero without.
    #[canonical(age = context.hold)]
    first_there: Instant,
    #[canonical(age = context.hold)]
    last_there: Instant,
}

/// Assignment by 1F81h.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
pub(super) enum Assignment {
    None,
    /// Assigned, never heard, and not yet reported.
    Awaited,
    Assigned,
}

/// Reason why a node that 1F81h does not assign counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
pub(super) enum Standing {
    /// None: it is a foreign node.
    Foreign,
    /// It was a slave of the master that was active before, and did not answer this one yet.
    Adopted,
    /// Its SDO server answered once.
    Answered,
}

/// Question for the device type of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
pub(super) enum Question {
    /// Nothing is to be asked, or the answer is awaited.
    None,
    /// To be asked when it is heard on the active bus, in a state that allows SDO.
    Pending,
    /// It was heard so.
    Ready,
}

/// Times for which what a [`Heard`] notes has an effect.
#[derive(Clone, Copy)]
pub(super) struct RemoteTimes {
    pub heartbeat: ConsumerTimes,
    /// [`Parameters::hold_time`].
    pub hold: Duration,
}

impl Remote {
    /// A node of which nothing is known.
    pub const UNKNOWN: Remote = Remote { heard: None, time: 0, assignment: Assignment::None, is_held: false };

    pub fn is_assigned(&self) -> bool {
        self.assignment != Assignment::None
    }

    /// Notes that the node is no longer awaited: it was heard, or reported.
    pub fn end_wait(&mut self) {
        if self.assignment == Assignment::Awaited {
            self.assignment = Assignment::Assigned;
        }
    }

    /// Returns whether the node counts for the master's decisions.
    pub fn counts(&self) -> bool {
        self.is_assigned() || self.heard.as_ref().is_some_and(|heard| heard.standing != Standing::Foreign)
    }

    /// Returns whether the node has to be asked for its device type now. The boot-up process asks those that are assigned.
    pub fn is_unasked(&self) -> bool {
        !self.is_assigned() && self.heard.as_ref().is_some_and(|heard| heard.question == Question::Ready)
    }

    /// Returns whether silence makes the master forget this node.
    pub fn is_forgettable(&self) -> bool {
        let must_answer = |heard: &Heard| heard.standing == Standing::Foreign || heard.has_booted_up;
        !self.is_assigned() && self.heard.as_ref().is_none_or(must_answer)
    }

    /// Returns when the node is forgotten, if it may be.
    pub fn forgotten_at(&self, consumer: Duration) -> Option<Instant> {
        let heard = self.heard.as_ref().filter(|_| self.is_forgettable())?;
        match heard.heartbeat {
            Consumer::Missed { last } => Some(last + consumer.times(MEMORY)),
            Consumer::Unarmed | Consumer::Armed { .. } => None,
        }
    }

    /// Discards what was heard of the node.
    pub fn forget(&mut self) {
        self.heard = None;
    }
}

impl Heard {
    /// First heartbeat or boot-up message, at `at`.
    pub fn new(state: NmtState, at: Instant, parameters: &Parameters) -> Heard {
        Heard {
            state,
            standing: Standing::Foreign,
            has_booted_up: false,
            question: Question::Pending,
            unanswered: 0,
            is_overheard: false,
            period: 0,
            heartbeat: Consumer::Unarmed,
            // Time in which a slave heard on the other bus may come to the active one.
            silent_at: at + parameters.settling_time().max(parameters.consumer),
            first_there: Instant::NEVER,
            last_there: Instant::ZERO,
        }
    }

    /// Notes on which bus it was heard at `at`. Returns the next instant at which that may matter.
    pub fn note_bus(&mut self, active: bool, counts: bool, at: Instant, parameters: &Parameters) -> Instant {
        let was_elsewhere = self.is_elsewhere(at, parameters);
        if active {
            self.silent_at = at + parameters.consumer;
            (self.first_there, self.last_there) = (Instant::NEVER, Instant::ZERO);
        } else {
            (self.first_there, self.last_there) = (self.first_there.min(at), at);
        }
        // An instant before this heartbeat was checked when it was due.
        let silent_at = if self.silent_at > at { self.silent_at } else { Instant::NEVER };
        match (counts, active) {
            (false, _) => Instant::NEVER,
            (true, true) => silent_at,
            (true, false) if self.elsewhere_at(parameters) > at => {
                silent_at.min(self.elsewhere_at(parameters))
            }
            (true, false) if was_elsewhere => silent_at,
            (true, false) => at,
        }
    }

    /// Silent on the active bus and heard on the other one for the hold time, from then on.
    pub fn elsewhere_at(&self, parameters: &Parameters) -> Instant {
        self.silent_at.max(self.first_there) + parameters.hold_time()
    }

    pub fn is_elsewhere(&self, now: Instant, parameters: &Parameters) -> bool {
        self.elsewhere_at(parameters) <= now && self.last_there + parameters.hold_time() > now
    }

    /// Takes its boot-up message: it has to answer, or to answer again.
    pub fn on_boot_up(&mut self) {
        self.unanswered = 0;
        self.has_booted_up = self.standing != Standing::Foreign;
        self.ask_again();
    }

    pub fn ask_again(&mut self) {
        if self.question == Question::None {
            self.question = Question::Pending;
        }
    }

    pub fn on_answer(&mut self) {
        self.unanswered = 0;
        (self.standing, self.has_booted_up, self.question) = (Standing::Answered, false, Question::None);
    }

    /// Counts it as a slave of the master that was active before.
    pub fn adopt(&mut self) {
        if self.standing == Standing::Foreign {
            self.standing = Standing::Adopted;
        }
    }

    /// It was no slave of that master.
    pub fn disown(&mut self) {
        (self.standing, self.has_booted_up) = (Standing::Foreign, false);
    }

    /// Notes that the active bus changed: it has until `silent_at` to be heard there.
    pub fn on_switch(&mut self, silent_at: Instant) {
        self.silent_at = silent_at;
        (self.first_there, self.last_there) = (Instant::NEVER, Instant::ZERO);
        if self.question == Question::Ready {
            self.question = Question::Pending;
        }
    }
}
