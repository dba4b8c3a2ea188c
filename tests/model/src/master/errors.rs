//! Knowledge of a master of the model about its slaves. It follows their emergencies and values, and reads errors that
//! it may have missed, with the machines of the firmware.

use ecss_can::emcy::machine::{ActiveErrors, ErrorReader, ReadOutcome};
use ecss_can::emcy::{ActiveError, Emergency};
use ecss_can::types::{
    Bus, Canonical, CobId, Duration, Frame, Instant, Instants as _, NmtState, NodeId, earliest,
};

use super::Master;
use crate::defect::Defect;
use crate::profile::{NO_ROUNDS, PARAMETERS};
use crate::station::Station;
use crate::what::{ERROR, SOURCE, What, value_id};

/// Time for an answer.
const TIMEOUT: Duration = PARAMETERS.producer;

/// Knowledge about the reporting slave.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Known {
    node: NodeId,
    what: What,
    defect: Option<Defect>,
    errors: ActiveErrors,
    reader: ErrorReader,
    /// Instant until which an answer is awaited.
    asked: Option<Instant>,
    has_changed: bool,
}

impl Known {
    /// Makes the knowledge of a master at power-on.
    pub fn new(node: NodeId, what: What, defect: Option<Defect>) -> Known {
        let (errors, reader) = (ActiveErrors::default(), ErrorReader::new(NO_ROUNDS));
        Known { node, what, defect, errors, reader, asked: None, has_changed: false }
    }

    /// Returns this knowledge before power-on.
    pub fn restarted(&self) -> Known {
        Known::new(self.node, self.what, self.defect)
    }

    /// Returns the reporting slave.
    pub fn node(&self) -> NodeId {
        self.node
    }

    /// Returns whether the active errors and the value are those of the slave.
    pub fn knows(&self, is_wrong: bool, has_changed: bool) -> bool {
        let error = ActiveError { node: self.node, code: ERROR, source: SOURCE };
        self.errors.iter().eq(is_wrong.then_some(error)) && self.has_changed == has_changed
    }

    /// Restarts after a change of the bus or a takeover.
    pub fn restart(&mut self) {
        self.asked = None;
        self.reader.restart();
    }

    fn answered(&mut self, answer: ReadOutcome, now: Instant) {
        self.asked = None;
        self.reader.on_answer(answer, &mut self.errors, TIMEOUT, now);
    }
}

impl Canonical for Known {
    type Context = ();

    fn canonical(&mut self, now: Instant, (): &()) {
        self.reader.canonical(now, &());
        self.asked.due(now);
    }
}

impl Master {
    /// Returns its knowledge about the reporting slave, if there is one.
    pub fn known(&self) -> Option<&Known> {
        self.known.as_ref()
    }

    /// Handles a heartbeat on the active bus.
    pub(super) fn is_heard(&mut self, node: NodeId, state: NmtState, has_changed: bool, now: Instant) {
        if let Some(known) = &mut self.known
            && known.what == What::Error
            && known.defect != Some(Defect::NeverReads)
            && (state.allows_sdo() || state == NmtState::Initialising)
        {
            let may_have_booted = state == NmtState::Initialising || has_changed && !state.allows_pdo();
            known.reader.on_heard(node, may_have_booted, now);
        }
    }

    /// Asks the reporting slave at its next heartbeat.
    pub fn ask_anew(&mut self) {
        self.known.iter_mut().for_each(|known| known.reader.lose(known.node));
    }

    /// Handles the loss of a slave.
    pub(super) fn lose(&mut self, node: NodeId) {
        self.known.iter_mut().for_each(|known| known.reader.lose(node));
    }

    /// Handles a frame that the redundancy does not use. A standby follows emergencies on either bus.
    pub(super) fn follow(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        let (is_active, is_here) = (self.is_active(), bus == self.active());
        let Some(known) = &mut self.known else { return };
        match Emergency::decode(frame) {
            Some((node, emergency)) if is_here || !is_active => {
                known.errors.on_emergency(node, &emergency);
                if !known.errors.explain(node, emergency.register) {
                    known.reader.ask_again(node, now);
                }
            }
            _ if frame.id() == value_id(known.node) && is_here && is_active => {
                known.has_changed = frame.data() == [1];
            }
            _ => {}
        }
    }

    /// Handles an answer to a question of this master.
    pub(super) fn take_answer(&mut self, frame: &Frame, now: Instant) {
        if let Some(known) = &mut self.known
            && known.asked.is_some()
            && let &[a, b, c, d] = frame.data()
        {
            known.answered(ReadOutcome::Value(u32::from_le_bytes([a, b, c, d])), now);
        }
    }

    /// Sends the questions that are due.
    pub(super) fn read_errors(&mut self, now: Instant) {
        let bus = self.active();
        let peers = self.redundancy.peers();
        let Some(known) = &mut self.known else { return };
        if known.asked.is_some_and(|end| end <= now) {
            known.answered(ReadOutcome::Missing, now);
        }
        if known.asked.is_none()
            && known.reader.deadline().is_some_and(|due| due <= now)
            && !peers.is_any_unasked()
            && let Some((node, object)) = known.reader.question(&known.errors, |node| peers.counts(node), now)
        {
            let [low, high] = object.index.to_le_bytes();
            known.asked = Some(now + TIMEOUT);
            self.outgoing.send(bus, Frame::of(CobId::sdo_request(node), [low, high, object.sub]), now);
        }
    }

    pub(super) fn errors_deadline(&self) -> Option<Instant> {
        let known = self.known.as_ref()?;
        let question = known.reader.deadline().filter(|_| known.asked.is_none());
        earliest(&[known.asked, question.filter(|_| !self.redundancy.peers().is_any_unasked())])
    }
}
