//! Boot-up processes of all slaves of a network.

use core::mem::{replace, take};

use super::process::{Next, Process};
use super::progress::Phase;
use super::record::{Duty, Record, Records, Run};
use super::senders::Senders;
use super::{
    Assignment, BootAction, BootCause, BootError, BootFailure, BootPolicy, BootProgress, BootRequest,
    CommonPdo, Difference, Expected, Identified, Setting,
};
use crate::nmt::Target;
use crate::sdo;
use crate::types::{CobId, Instant, NmtState, NodeId};

/// Runs the boot-up processes of all slaves.
#[doc(alias("NMT boot-up", "CiA 302-2", "1F80h", "1F81h", "1F89h"))]
#[derive(Clone, Debug)]
pub struct Boot {
    pub(super) policy: BootPolicy,
    pub(super) objects: Identified,
    pub(super) settings: &'static [Setting],
    pub(super) records: Records,
    pub(super) process: Option<Process>,
    pub(super) senders: Senders,
    /// Node-ID of the last process.
    pub(super) last: u8,
    pub(super) failure: Option<(NodeId, BootFailure)>,
    pub(super) deviation: Option<(NodeId, Difference)>,
    pub(super) start: Option<NodeId>,
    /// Everybody followed a SYNC, which is to be reported.
    pub(super) is_completed: bool,
    /// End of the boot time.
    pub(super) deadline: Option<Instant>,
    pub(super) phase: Phase,
    /// Something changed since the last look.
    pub(super) is_changed: bool,
}

impl Boot {
    /// Makes the process of a network to which no slave is assigned yet.
    pub const fn new(policy: BootPolicy, objects: Identified, settings: &'static [Setting]) -> Boot {
        Boot {
            policy,
            objects,
            settings,
            records: Records::new(),
            process: None,
            senders: Senders::new(),
            last: 0,
            failure: None,
            deviation: None,
            start: None,
            is_completed: false,
            deadline: None,
            phase: Phase::Configuring,
            is_changed: true,
        }
    }

    /// Returns the node that sends PDOs with this COB-ID: by the settings of the slaves, else by the pre-defined
    /// connection set.
    pub fn producer(&self, id: CobId) -> Option<NodeId> {
        let configured = self.settings.iter().find(|setting| setting.transmits() == Some(id));
        configured.map_or_else(|| id.node(), |setting| Some(setting.node))
    }

    /// Starts the boot time at power-on.
    pub fn start(&mut self, now: Instant) {
        let is_any_mandatory = self.records.all().any(|record| record.duty == Duty::Mandatory);
        let limited = self.policy.time.as_micros() > 0 && is_any_mandatory;
        self.deadline = limited.then(|| now + self.policy.time);
    }

    /// Takes an entry of 1F81h, at power-on or written. A new slave is booted when it is heard next.
    pub fn assign(&mut self, node: NodeId, assignment: Assignment) {
        let Some(record) = self.records.get_mut(node) else { return };
        let was_booted = replace(&mut record.duty, Duty::of(assignment)) != Duty::None;
        self.is_changed = true;
        match (was_booted, assignment.is_booted()) {
            (false, true) => self.set_progress(node, BootProgress::Awaited),
            (true, false) => {
                self.forget(node);
                self.senders.forget(node);
                self.set_progress(node, BootProgress::Unassigned);
            }
            _ => {}
        }
    }

    /// Returns whether [`assign`](Self::assign) was called so for a node.
    pub fn agrees(&self, node: NodeId, assignment: Assignment) -> bool {
        match self.records.get(node).duty {
            Duty::Excused => assignment.is_mandatory(),
            duty => duty == Duty::of(assignment),
        }
    }

    /// Returns the progress of a slave.
    pub fn progress(&self, node: NodeId) -> BootProgress {
        self.records.get(node).progress
    }

    /// Takes a heartbeat or boot-up message. `is_here`: it came on the active bus. `returned`: the slave was lost
    /// before. Returns whether the slave has to be started at once if it waits.
    pub fn on_heartbeat(&mut self, node: NodeId, state: NmtState, is_here: bool, returned: bool) -> bool {
        if self.records.get(node).duty == Duty::None {
            return true;
        }
        if state == NmtState::Initialising {
            // The process begins again, on whichever bus it was heard.
            self.forget(node);
            self.set_progress(node, BootProgress::Awaited);
        }
        let is_running = self.is_running(node);
        let Some(record) = self.records.get_mut(node) else { return true };
        if state == NmtState::PreOperational && record.is_operational || returned {
            (record.is_operational, record.is_doubtful) = (false, true);
        }
        if !is_here {
            return false;
        }
        if state == NmtState::Operational {
            record.is_operational |= record.is_started();
        }
        let (is_started, is_doubtful, progress) = (record.is_started(), record.is_doubtful, record.progress);
        match (state, progress) {
            // It answers no SDO now: a check that failed for this is done again when it does.
            (NmtState::Stopped, BootProgress::Failed) => self.set_progress(node, BootProgress::Awaited),
            (NmtState::Stopped, _) => {}
            (_, BootProgress::Awaited) => self.queue(node),
            _ if is_doubtful && !is_running => self.queue(node),
            _ => {}
        }
        if state == NmtState::Operational {
            self.on_synchronous(node);
        }
        is_started
    }

    /// Notes that the master commands slaves to stop or to enter Pre-operational. The command explains their next
    /// Pre-operational.
    pub fn on_commanded(&mut self, target: Target) {
        for (record, raw) in self.records.all_mut().zip(0..) {
            if NodeId::new(raw).is_some_and(|node| target.includes(node)) {
                record.is_operational = false;
            }
        }
    }

    /// Notes that a slave is Operational: one of its heartbeats or PDOs on the active bus shows it.
    pub fn on_synchronous(&mut self, node: NodeId) {
        let is_synchronous = matches!(self.phase, Phase::Synchronising | Phase::Completed);
        if is_synchronous && self.progress(node) == BootProgress::Started {
            self.set_run(node, Run::Synchronised);
            self.set_progress(node, BootProgress::Booted);
        }
    }

    /// Takes the loss of a slave: there is no heartbeat on either bus.
    pub fn on_lost(&mut self, node: NodeId) {
        if self.is_running(node) {
            self.fail(node, BootFailure { error: BootError::Lost, cause: BootCause::Silence });
        } else if self.records.get(node).is_queued {
            self.await_again(node);
        }
    }

    /// Takes a change of the active bus. Slaves that are not started, also those that failed, begin again when
    /// they are heard there. A slave that is Pre-operational when it is first heard there may have been reset on
    /// the bus that was left.
    pub fn on_bus_changed(&mut self) {
        for record in self.records.all_mut() {
            record.is_operational |= record.is_started();
        }
        if let Some(process) = self.process.take() {
            self.await_again(process.node);
        }
        for node in (1..=127).filter_map(NodeId::new) {
            if self.records.get(node).is_queued || self.progress(node) == BootProgress::Failed {
                self.await_again(node);
            }
        }
    }

    /// Takes the end of a SYNC.
    pub fn on_sync_sent(&mut self) {
        if self.phase == Phase::Released {
            self.phase = Phase::Synchronising;
            self.is_changed = true;
        }
    }

    /// Boots a slave again, also one that failed. Does nothing if the slave is not assigned.
    pub fn queue(&mut self, node: NodeId) {
        if let Some(record) = self.records.get_mut(node)
            && record.duty != Duty::None
        {
            record.is_doubtful = false;
            self.records.set_queued(node, true);
            self.set_progress(node, BootProgress::Queued);
        }
    }

    /// Returns whether an SDO transfer is running or wanted.
    pub const fn is_busy(&self) -> bool {
        self.process.is_some() || self.records.is_any_queued()
    }

    /// Returns whether `poll` or `request` has work before the deadline.
    pub const fn is_due(&self) -> bool {
        self.is_changed || self.records.is_any_queued() && self.process.is_none()
    }

    /// Returns whether the result of the last transfer is still needed.
    pub fn is_asking(&self) -> bool {
        self.process.as_ref().is_some_and(|process| process.is_asked)
    }

    /// Returns the next SDO transfer if none is running. `expected` returns the expected identity of a slave.
    /// `common` is a PDO of the master whose consumers are checked, if there is one.
    pub fn request(
        &mut self,
        expected: impl FnOnce(NodeId) -> Expected,
        common: Option<CommonPdo>,
    ) -> Option<BootRequest<'_>> {
        if self.process.is_none() {
            let node = self.records.next_queued(self.last)?;
            self.last = node.get();
            self.records.set_queued(node, false);
            self.senders.forget(node);
            self.process = Some(Process::new(node, self.objects, expected(node), self.settings, common));
            self.set_progress(node, BootProgress::Checking);
        }
        self.process.as_mut().filter(|process| !process.is_asked).map(Process::request)
    }

    /// Takes bytes that a transfer read.
    pub fn on_data(&mut self, part: &[u8]) {
        if let Some(process) = &mut self.process {
            process.on_data(part);
        }
    }

    /// Takes the outcome of a transfer. `is_own` returns whether the master sends a COB-ID.
    pub fn on_done(&mut self, outcome: Result<(), sdo::Error>, is_own: impl FnOnce(CobId) -> bool) {
        let Some(process) = &mut self.process else { return };
        let node = process.node;
        let mut next = process.on_done(outcome);
        let (deviation, sent, progress) = (process.take_deviation(), process.take_sent(), process.progress());
        let unique = match sent {
            Some((at, id)) if is_own(id) => Err(BootCause::CobIdInUse { at, id, other: NodeId::MASTER }),
            Some((at, id)) => self.senders.add(at, id, node),
            None => Ok(()),
        };
        if let Err(cause) = unique {
            self.senders.forget(node);
            next = Next::Fail(BootFailure { error: BootError::Configuration, cause });
        }
        if let Some(difference) = deviation
            && let Some(record) = self.records.get_mut(node)
            && record.is_started()
        {
            (record.run, record.is_operational) = (Run::Waits, false);
            (self.deviation, self.is_changed) = (Some((node, difference)), true);
        }
        match next {
            Next::Transfer => {
                if progress != self.progress(node) {
                    self.set_progress(node, progress);
                }
            }
            Next::Start => {
                self.process = None;
                self.set_run(node, Run::Started);
                self.start = Some(node);
                self.set_progress(node, BootProgress::Started);
            }
            Next::Fail(failure) => self.fail(node, failure),
        }
    }

    /// Returns the next thing to do or to report at `now`. Call it until `None`, at the deadline and after each input.
    pub fn poll(&mut self, now: Instant) -> Option<BootAction> {
        if self.deadline.is_some_and(|deadline| deadline <= now) {
            self.end_boot_time();
            self.is_changed = true;
        }
        if !self.is_changed {
            return None;
        }
        self.advance();
        let action = self.next_action();
        self.is_changed = action.is_some();
        action
    }

    fn next_action(&mut self) -> Option<BootAction> {
        if let Some((node, difference)) = self.deviation.take() {
            return Some(BootAction::Hold { node, difference });
        }
        if let Some((node, failure)) = self.failure.take() {
            return Some(BootAction::ReportFailure { node, failure });
        }
        if let Some(node) = self.records.take_first(|record| &mut record.is_silent) {
            let failure = BootFailure { error: BootError::Silent, cause: BootCause::Silence };
            return Some(BootAction::ReportFailure { node, failure });
        }
        if let Some(node) = self.records.take_first(|record| &mut record.has_progressed) {
            return Some(BootAction::ReportProgress { node, progress: self.progress(node) });
        }
        if let Some(node) = self.start.take() {
            return Some(BootAction::Start(node));
        }
        take(&mut self.is_completed).then_some(BootAction::ReportCompleted)
    }

    /// The boot time is over: mandatory slaves that were never heard are reported.
    fn end_boot_time(&mut self) {
        self.deadline = None;
        let missing = |record: &&mut Record| record.duty == Duty::Mandatory && !record.is_started();
        for record in self.records.all_mut().filter(missing) {
            record.is_silent = record.progress == BootProgress::Awaited;
            if self.policy.goes_on {
                record.duty = Duty::Excused;
            }
        }
    }

    /// Enters the next phase when nothing is missing.
    fn advance(&mut self) {
        let is_behind =
            |least: Run| move |record: &Record| record.duty == Duty::Mandatory && record.run < least;
        match self.phase {
            Phase::Configuring if !self.records.all().any(is_behind(Run::Started)) => {
                self.deadline = None;
                self.phase = Phase::Released;
            }
            Phase::Synchronising if !self.records.all().any(is_behind(Run::Synchronised)) => {
                self.phase = Phase::Completed;
                self.is_completed = self.records.all().any(|record| record.duty >= Duty::Mandatory);
            }
            _ => {}
        }
    }

    /// Returns whether SYNC may be sent.
    pub fn is_released(&self) -> bool {
        self.phase != Phase::Configuring
    }

    /// Returns the end of the boot time.
    pub const fn deadline(&self) -> Option<Instant> {
        self.deadline
    }

    /// Discards all that is known of a slave.
    pub(super) fn forget(&mut self, node: NodeId) {
        self.records.forget(node);
        if self.is_running(node) {
            self.process = None;
        }
    }

    fn await_again(&mut self, node: NodeId) {
        self.records.set_queued(node, false);
        self.set_progress(node, BootProgress::Awaited);
    }

    fn fail(&mut self, node: NodeId, failure: BootFailure) {
        let was_started = self.records.get(node).is_started();
        self.forget(node);
        if was_started && matches!(failure.cause, BootCause::Silence | BootCause::Transfer { .. }) {
            // It ran when its check failed, and nothing was refuted: fail-over does not wait for SDO.
            self.set_run(node, Run::Started);
        }
        self.failure = Some((node, failure));
        self.set_progress(node, BootProgress::Failed);
    }

    fn is_running(&self, node: NodeId) -> bool {
        self.process.as_ref().is_some_and(|process| process.node == node)
    }

    pub(super) fn set_progress(&mut self, node: NodeId, progress: BootProgress) {
        if let Some(record) = self.records.get_mut(node) {
            (record.progress, record.has_progressed) = (progress, true);
            self.is_changed = true;
        }
    }

    fn set_run(&mut self, node: NodeId, run: Run) {
        if let Some(record) = self.records.get_mut(node) {
            record.run = run;
        }
    }
}
