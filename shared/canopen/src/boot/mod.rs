//! Boot-up of the network by its master: every slave is checked, configured and started, then SYNC begins.
//!
//! A slave is *assigned* if 1F81h of the master names it, and *mandatory* if SYNC has to wait for it. The *boot-up
//! process* of a slave reads its device type and identity, compares its configuration, writes the values that
//! differ, checks that no other node sends one of its COB-IDs, and starts it. ECSS Table 11-1 (7.3.1) has the order, CiA 302-2 the objects and the errors.
//!
//! ```
//! use async_canopen::boot::{AssignedSlave, Boot, BootAction, BootPolicy, BootProgress, BootRequest, Expected, Identified};
//! use async_canopen::sdo::Error;
//! use async_canopen::types::{AbortCode, Address, Duration, Instant, NmtState, NodeId};
//!
//! let node = NodeId::of::<2>();
//! let expected = Expected { device_type: 0x191, identity: [0; 4], stamp: [0; 2] };
//! let objects = Identified {
//!     device_type: 0x1000,
//!     identity: 0x1018,
//!     configuration: 0x1020,
//!     rpdo: 0x1400,
//!     emergency: 0x1014,
//!     tpdo: 0x1800,
//! };
//! let mut boot = Boot::new(BootPolicy { time: Duration::from_millis(500), goes_on: false }, objects, &[]);
//! boot.assign(node, AssignedSlave { node, mandatory: true, expected }.assignment());
//! boot.start(Instant::ZERO);
//! boot.on_heartbeat(node, NmtState::Initialising, true, false); // its boot-up message on the active bus
//!
//! let request = boot.request(|_| expected, None);
//! assert_eq!(request, Some(BootRequest::Read { node, at: Address::new(0x1000, 0), most: 4 }));
//! boot.on_data(&0x191_u32.to_le_bytes());
//! boot.on_done(Ok(()), |_| false);
//! // It has neither emergencies nor TPDOs: 1014h and 1800h to 1807h do not exist.
//! while boot.request(|_| expected, None).is_some() {
//!     boot.on_done(Err(Error::Abort(AbortCode::NoObject)), |_| false);
//! }
//! let actions: Vec<BootAction> = std::iter::from_fn(|| boot.poll(Instant::ZERO)).collect();
//! let reported = BootAction::ReportProgress { node, progress: BootProgress::Started };
//! assert_eq!(actions, [reported, BootAction::Start(node)]);
//! ```
//!
//! The process runs for every assigned slave that boots up, is heard for the first time, or was lost and returns.
//! After it the slave is started at once whenever it waits, until it boots up again. So a change of the bus does
//! not wait for SDO.
//!
//! # A slave that was reset without being heard
//!
//! If no command of the master explains why a slave waits, the slave may have been reset. The process then runs
//! after the start. A slave that lost its configuration returns to Pre-operational, is configured, and is started
//! again.
//!
//! # Limits
//!
//! - There is one SDO transfer at a time, in the order of the Node-IDs.
//! - COB-IDs of emergencies and of the first eight TPDOs are compared, of the master and of slaves that were checked
//!   since its power-on. A slave is not started if the network then has more than 64 of them outside the
//!   pre-defined connection set.
//! - Without mandatory slaves SYNC does not wait, and the end of the boot-up is never reported.

mod action;
mod expected;
mod overheard;
mod process;
mod progress;
mod senders;

pub use action::BootAction;
pub use expected::{AssignedSlave, Assignment, BootPolicy, Expected, Setting};
pub use process::{BootRequest, Identified, TimePdo};
pub use progress::{BootCause, BootError, BootFailure, BootProgress, Difference};

use crate::boot::process::{Next, Process};
use crate::boot::progress::Phase;
use crate::boot::senders::Senders;
use crate::nmt::Target;
use crate::sdo;
use crate::types::{CobId, Instant, NmtState, NodeId};

/// Node-IDs 0..=127.
const PLACES: usize = 128;

/// Runs the boot-up processes of all slaves.
#[doc(alias("NMT boot-up", "CiA 302-2", "1F80h", "1F81h", "1F89h"))]
#[derive(Clone, Debug)]
pub struct Boot {
    policy: BootPolicy,
    objects: Identified,
    settings: &'static [Setting],
    progress: [BootProgress; PLACES],
    /// Sets of slaves, one bit per Node-ID.
    assigned: u128,
    mandatory: u128,
    queued: u128,
    /// Slaves that passed the process since their boot-up message.
    started: u128,
    synchronised: u128,
    /// Their next Pre-operational is not explained by a command of the master.
    operational: u128,
    /// May have been reset without being heard.
    doubtful: u128,
    /// Mandatory slaves without which SYNC continues after the boot time.
    excused: u128,
    /// Their progress is to be reported.
    changed: u128,
    process: Option<Process>,
    senders: Senders,
    /// Node-ID of the last process.
    last: u8,
    failure: Option<(NodeId, BootFailure)>,
    deviation: Option<(NodeId, Difference)>,
    /// Silent when the boot time ended, and to be reported.
    silent: u128,
    start: Option<NodeId>,
    /// Everybody followed a SYNC, which is to be reported.
    is_completed: bool,
    /// End of the boot time.
    deadline: Option<Instant>,
    phase: Phase,
    /// Something changed since the last look.
    is_changed: bool,
}

impl Boot {
    /// Makes the process of a network to which no slave is assigned yet.
    pub const fn new(policy: BootPolicy, objects: Identified, settings: &'static [Setting]) -> Boot {
        Boot {
            policy,
            objects,
            settings,
            progress: [BootProgress::Unassigned; PLACES],
            assigned: 0,
            mandatory: 0,
            queued: 0,
            started: 0,
            synchronised: 0,
            operational: 0,
            doubtful: 0,
            excused: 0,
            changed: 0,
            process: None,
            senders: Senders::new(),
            last: 0,
            failure: None,
            deviation: None,
            silent: 0,
            start: None,
            is_completed: false,
            deadline: None,
            phase: Phase::Configuring,
            is_changed: true,
        }
    }

    /// Starts the boot time at power-on.
    pub fn start(&mut self, now: Instant) {
        let limited = self.policy.time.as_micros() > 0 && self.mandatory != 0;
        self.deadline = limited.then(|| now + self.policy.time);
    }

    /// Takes an entry of 1F81h, at power-on or written. A new slave is booted when it is heard next.
    pub fn assign(&mut self, node: NodeId, assignment: Assignment) {
        let bit = bit(node);
        let was_assigned = self.assigned & bit != 0;
        set(&mut self.assigned, bit, assignment.is_booted());
        set(&mut self.mandatory, bit, assignment.is_mandatory());
        match (was_assigned, assignment.is_booted()) {
            (false, true) => self.set_progress(node, BootProgress::Awaited),
            (true, false) => {
                self.forget(node);
                self.senders.forget(node);
                self.set_progress(node, BootProgress::Unassigned);
            }
            _ => {}
        }
    }

    /// Returns the progress of a slave.
    pub fn progress(&self, node: NodeId) -> BootProgress {
        self.progress.get(usize::from(node.get())).copied().unwrap_or_default()
    }

    /// Takes a heartbeat or boot-up message. `is_here`: it came on the active bus. `returned`: the slave was lost
    /// before. Returns whether the slave has to be started at once if it waits.
    pub fn on_heartbeat(&mut self, node: NodeId, state: NmtState, is_here: bool, returned: bool) -> bool {
        let bit = bit(node);
        if self.assigned & bit == 0 {
            return true;
        }
        if state == NmtState::Initialising {
            // The process begins again, on whichever bus it was heard.
            self.forget(node);
            self.set_progress(node, BootProgress::Awaited);
        }
        if state == NmtState::PreOperational && self.operational & bit != 0 || returned {
            self.operational &= !bit;
            self.doubtful |= bit;
        }
        if !is_here {
            return false;
        }
        let is_running = self.process.as_ref().is_some_and(|process| process.node == node);
        if state == NmtState::Stopped {
            // It answers no SDO now: a check that failed for this is done again when it does.
            if self.progress(node) == BootProgress::Failed {
                self.set_progress(node, BootProgress::Awaited);
            }
        } else if self.progress(node) == BootProgress::Awaited || self.doubtful & bit != 0 && !is_running {
            self.queue(node);
        }
        if state == NmtState::Operational {
            self.operational |= self.started & bit;
            self.on_synchronous(node);
        }
        self.started & bit != 0
    }

    /// Notes that the master commands slaves to stop or to enter Pre-operational. The command explains their next
    /// Pre-operational.
    pub fn on_commanded(&mut self, target: Target) {
        match target {
            Target::All => self.operational = 0,
            Target::Node(node) => self.operational &= !bit(node),
        }
    }

    /// Notes that a slave is Operational: one of its heartbeats or PDOs on the active bus shows it.
    pub fn on_synchronous(&mut self, node: NodeId) {
        let is_synchronous = matches!(self.phase, Phase::Synchronising | Phase::Completed);
        if is_synchronous && self.progress(node) == BootProgress::Started {
            self.synchronised |= bit(node);
            self.set_progress(node, BootProgress::Booted);
        }
    }

    /// Takes the loss of a slave: there is no heartbeat on either bus.
    pub fn on_lost(&mut self, node: NodeId) {
        if self.process.as_ref().is_some_and(|process| process.node == node) {
            self.fail(node, BootFailure { error: BootError::Lost, cause: BootCause::Silence });
        } else if self.queued & bit(node) != 0 {
            self.await_again(node);
        }
    }

    /// Takes a change of the active bus. Slaves that are not started, also those that failed, begin again when
    /// they are heard there. A slave that is Pre-operational when it is first heard there may have been reset on
    /// the bus that was left.
    pub fn on_bus_changed(&mut self) {
        self.operational |= self.started;
        if let Some(process) = self.process.take() {
            self.await_again(process.node);
        }
        while let Some(node) = first(self.queued) {
            self.await_again(node);
        }
        for node in (1..=127).filter_map(NodeId::new) {
            if self.progress(node) == BootProgress::Failed {
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
        let bit = bit(node);
        if self.assigned & bit != 0 {
            self.queued |= bit;
            self.doubtful &= !bit;
            self.set_progress(node, BootProgress::Queued);
        }
    }

    /// Returns whether an SDO transfer is running or wanted.
    pub const fn is_busy(&self) -> bool {
        self.process.is_some() || self.queued != 0
    }

    /// Returns whether `poll` or `request` has work before the deadline.
    pub const fn is_due(&self) -> bool {
        self.is_changed || self.queued != 0 && self.process.is_none()
    }

    /// Returns whether the result of the last transfer is still needed.
    pub fn is_asking(&self) -> bool {
        self.process.as_ref().is_some_and(|process| process.is_asked)
    }

    /// Returns the next SDO transfer if none is running. `expected` returns the expected identity of a slave.
    /// `time` describes the Spacecraft Time PDO if the master sends one.
    pub fn request(
        &mut self,
        expected: impl FnOnce(NodeId) -> Expected,
        time: Option<TimePdo>,
    ) -> Option<BootRequest<'_>> {
        if self.process.is_none() {
            // In turn: a slave that does not answer must not delay the others.
            let after = self.queued & (u128::MAX << self.last).wrapping_shl(1);
            let node = first(after).or_else(|| first(self.queued))?;
            self.queued &= !bit(node);
            self.last = node.get();
            self.senders.forget(node);
            self.process = Some(Process::new(node, self.objects, expected(node), self.settings, time));
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
            && self.started & bit(node) != 0
        {
            self.started &= !bit(node);
            self.operational &= !bit(node);
            self.deviation = Some((node, difference));
        }
        match next {
            Next::Transfer => {
                if progress != self.progress(node) {
                    self.set_progress(node, progress);
                }
            }
            Next::Start => {
                self.process = None;
                self.started |= bit(node);
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
        if let Some(node) = first(self.silent) {
            self.silent &= !bit(node);
            let failure = BootFailure { error: BootError::Silent, cause: BootCause::Silence };
            return Some(BootAction::ReportFailure { node, failure });
        }
        if let Some(node) = first(self.changed) {
            self.changed &= !bit(node);
            return Some(BootAction::ReportProgress { node, progress: self.progress(node) });
        }
        if let Some(node) = self.start.take() {
            return Some(BootAction::Start(node));
        }
        core::mem::take(&mut self.is_completed).then_some(BootAction::ReportCompleted)
    }

    /// The boot time is over: mandatory slaves that were never heard are reported.
    fn end_boot_time(&mut self) {
        self.deadline = None;
        let missing = self.mandatory & !self.started;
        self.silent = missing;
        for (place, nth) in self.progress.iter().zip(0..) {
            if *place != BootProgress::Awaited {
                self.silent &= !(1_u128 << (nth & 0x7F));
            }
        }
        if self.policy.goes_on {
            self.excused = missing;
        }
    }

    /// Enters the next phase when nothing is missing.
    fn advance(&mut self) {
        match self.phase {
            Phase::Configuring if self.mandatory & !self.started & !self.excused == 0 => {
                self.deadline = None;
                self.phase = Phase::Released;
            }
            Phase::Synchronising if self.mandatory & !self.synchronised & !self.excused == 0 => {
                self.phase = Phase::Completed;
                self.is_completed = self.mandatory != 0;
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
    fn forget(&mut self, node: NodeId) {
        let bit = bit(node);
        self.queued &= !bit;
        self.started &= !bit;
        self.synchronised &= !bit;
        self.operational &= !bit;
        self.doubtful &= !bit;
        if self.process.as_ref().is_some_and(|process| process.node == node) {
            self.process = None;
        }
    }

    fn await_again(&mut self, node: NodeId) {
        self.queued &= !bit(node);
        self.set_progress(node, BootProgress::Awaited);
    }

    fn fail(&mut self, node: NodeId, failure: BootFailure) {
        let was_started = self.started & bit(node);
        self.forget(node);
        if matches!(failure.cause, BootCause::Silence | BootCause::Transfer { .. }) {
            // It ran when its check failed, and nothing was refuted: fail-over does not wait for SDO.
            self.started |= was_started;
        }
        self.failure = Some((node, failure));
        self.set_progress(node, BootProgress::Failed);
    }

    fn set_progress(&mut self, node: NodeId, progress: BootProgress) {
        if let Some(place) = self.progress.get_mut(usize::from(node.get())) {
            *place = progress;
            self.changed |= bit(node);
            self.is_changed = true;
        }
    }
}

fn bit(node: NodeId) -> u128 {
    1 << (node.get() & 0x7F)
}

fn set(nodes: &mut u128, bit: u128, is_in: bool) {
    *nodes = if is_in { *nodes | bit } else { *nodes & !bit };
}

/// The lowest Node-ID of a set.
fn first(nodes: u128) -> Option<NodeId> {
    NodeId::new(nodes.trailing_zeros() as u8)
}
