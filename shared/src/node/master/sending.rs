//! Frames that the master sends, and the budgets of nodes that send too many: the master itself, and its slaves (ECSS 5.3.3.1b).

use async_canopen::node::extend::Part;

use super::{Master, MasterEvent, Turn};
use crate::emcy::ErrorCode;
use crate::link::budget::{Budget, BudgetStep, Over, is_sdo};
use crate::link::machine::Outgoing;
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::minimal::MinimalPdos;
use crate::node::services::SpacecraftServices;
use crate::node::{BusCommand, FailCause, Refusal, SpacecraftDevice};
use crate::pdo::{Pdo, PdoValues};
use crate::profile::{MinimalNode, Profile};
use crate::redundancy::{Babblers, BabblingStep, MasterBoards, Sending};
use crate::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, earliest};

/// Budgets of the frames that the master sends, and of those that it hears from its slaves.
#[derive(Debug)]
pub(super) struct Budgets {
    own: Budget,
    slaves: Babblers,
}

impl Budgets {
    pub const fn new(profile: &Profile) -> Self {
        let dwell = profile.redundancy().dwell(profile.dwell);
        Budgets {
            own: Budget::of_master(&profile.budget),
            slaves: Babblers::new(profile.budget.heard, dwell),
        }
    }
}

impl Part for Budgets {
    fn earliest(&self) -> Option<Instant> {
        earliest(&[self.own.deadline(), self.slaves.deadline()])
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Returns the last state of a slave. `None` if the slave was never heard, is lost or forgotten.
    pub fn slave_state(&self, node: NodeId) -> Option<NmtState> {
        self.redundancy.peers().state(node)
    }

    /// Returns whether a slave takes commands. It is Operational by its heartbeat, or it is a [minimal
    /// slave](MinimalNode) without a heartbeat.
    pub fn may_command(&self, node: NodeId) -> bool {
        let is_silent = self.minimal(node).is_some_and(|minimal| !minimal.has_heartbeat);
        is_silent || self.slave_state(node) == Some(NmtState::Operational)
    }

    /// Returns the entry of a slave of the minimal set.
    pub(super) fn minimal(&self, node: NodeId) -> Option<&'static MinimalNode> {
        self.minimal.iter().find(|minimal| minimal.node == node)
    }

    /// Sends a command or a telemetry request to a minimal slave by one of its four receive PDOs (0 is the first;
    /// ECSS 9.4.2c).
    ///
    /// # Errors
    /// As [`Master::send_frame`]. [`Refusal::NotValid`] for a fifth PDO or more than 8 bytes.
    /// [`Refusal::NotOperational`] if the slave does not take commands.
    pub fn send_to_minimal(
        &mut self,
        node: NodeId,
        number: usize,
        data: &[u8],
        now: Instant,
    ) -> Result<(), Refusal> {
        let id = MinimalPdos::DEFAULT.receive.get(number).copied().flatten();
        let frame = id.and_then(|pdo| Frame::new(pdo.cob_id.of(node), data).ok());
        let refusal = match frame {
            Some(frame) if self.may_command(node) => return self.send_frame(frame, now),
            Some(_) => Refusal::NotOperational,
            None => Refusal::NotValid,
        };
        self.services.buses_mut().count_refused(self.redundancy.active());
        Err(refusal)
    }

    /// Sends a transmit PDO (0 is the first) by its transmission type, even if its content has not changed.
    ///
    /// # Errors
    /// [`Refusal::NotValid`], [`Refusal::Busy`]; both are counted on the active bus.
    pub fn send_pdo(&mut self, number: usize, now: Instant) -> Result<(), Refusal> {
        let is_valid = self.services.tpdos().is_valid(number) && self.redundancy.state().allows_pdo();
        let refusal = if !is_valid {
            Refusal::NotValid
        } else if !self.redundancy.has_room() {
            Refusal::Busy
        } else {
            self.services.trigger(number, now);
            return Ok(());
        };
        self.services.buses_mut().count_refused(self.redundancy.active());
        Err(refusal)
    }

    /// Sends values to a slave by one of its receive PDOs. The master needs no object for them.
    ///
    /// # Errors
    /// As [`Master::send_frame`]. [`Refusal::NotOperational`], counted on the active bus, if the slave does not take commands.
    pub fn send_to<E, T: PdoValues>(
        &mut self,
        node: NodeId,
        pdo: Pdo<E, T>,
        values: T,
        now: Instant,
    ) -> Result<(), Refusal> {
        if !self.may_command(node) {
            self.services.buses_mut().count_refused(self.redundancy.active());
            return Err(Refusal::NotOperational);
        }
        self.send_frame(pdo.of(node).frame(values), now)
    }

    /// Returns whether a frame that was not sent is a command or another event of the application, which no later frame
    /// replaces.
    pub(super) fn is_lost(&self, frame: &Frame) -> bool {
        let id = frame.id();
        // PDOs have the function codes between those of emergencies and of SDO responses.
        let is_process_data = (0x180..0x580).contains(&id.raw());
        let is_raw = is_process_data && !self.services.tpdos().has(id);
        is_raw || self.services.tpdos().is_event(frame.id())
    }

    /// Sends a frame that no PDO covers, with the lifetime of event-driven PDOs.
    ///
    /// # Errors
    /// [`Refusal::NotValid`] for a restricted COB-ID (CiA 301 7.3.5) and if the master is not Operational,
    /// [`Refusal::Busy`]. Both are counted on the active bus.
    pub fn send_frame(&mut self, frame: Frame, now: Instant) -> Result<(), Refusal> {
        let expires = now + self.services.event_lifetime();
        let refusal = if frame.id().is_restricted() || !self.redundancy.state().allows_pdo() {
            Refusal::NotValid
        } else if !self.redundancy_mut().queue(Outgoing { frame, expires }) {
            Refusal::Busy
        } else {
            return Ok(());
        };
        self.services.buses_mut().count_refused(self.redundancy.active());
        Err(refusal)
    }

    pub(super) fn send_nmt(&mut self, message: NmtMessage, turn: &mut Turn) -> bool {
        self.send(message.encode(), self.services.heartbeat_lifetime(), turn)
    }

    /// Sends a frame on the active bus, when it is announced. Returns false when there was no room to wait for that.
    pub(super) fn send(&mut self, frame: Frame, lifetime: Duration, turn: &mut Turn) -> bool {
        let outgoing = Outgoing { frame, expires: turn.now + lifetime };
        match self.redundancy_mut().send(outgoing) {
            Sending::Now(bus) => turn.out.command(bus, BusCommand::Send(outgoing)),
            Sending::Held => {}
            Sending::Refused(bus) => {
                self.services.buses_mut().count_refused(bus);
                return false;
            }
        }
        true
    }

    /// Reports a frame that was dropped before its bus was announced.
    pub(super) fn fail(&mut self, bus: Bus, frame: Frame, cause: FailCause, turn: &mut Turn) {
        self.services.buses_mut().count_failed(bus, cause);
        self.on_failed(bus, &frame, cause, turn);
    }

    /// Takes a frame from the budget of the master. Returns whether it may be sent. Above its budget the master is in
    /// Pre-operational: it sends no PDO and no frame of the application. Heartbeat, SYNC, NMT and time have separate limits.
    pub(super) fn takes_token(&mut self, id: CobId, turn: &mut Turn) -> bool {
        let Some(over) = self.budgets.no_sooner().own.take(id, turn.now) else { return true };
        self.budgets.settle(self.services.wakes_mut());
        if self.services.over_budget(id, over) {
            turn.out.event(MasterEvent::OverBudget { id });
        }
        if over == Over::Node {
            self.on_own_command(Command::EnterPreOperational, turn);
        }
        false
    }

    /// Takes a frame of a slave from the budget of that slave. SDO is free: another client may have a transfer with it.
    pub(super) fn watch(&mut self, bus: Bus, id: CobId, node: NodeId, at: Instant, turn: &mut Turn) {
        if bus != self.redundancy.active() || is_sdo(id) || !self.redundancy.peers().counts(node) {
            return;
        }
        let is_held = self.redundancy.peers().is_held(node);
        let wakes = self.services.wakes_mut();
        let step = self.budgets.step(wakes, |budgets| budgets.slaves.on_frame(node, is_held, at));
        if let Some(step) = step {
            self.silence(node, step, turn);
        }
    }

    fn silence(&mut self, node: NodeId, step: BabblingStep, turn: &mut Turn) {
        let target = Target::Node(node);
        match step {
            BabblingStep::Stopped => {
                self.redundancy_mut().peers_mut().hold(target, true);
                self.boot_mut().on_commanded(target);
                self.services.raise(ErrorCode::MONITORING, [node.get(), 0, 0, 0, 0]);
                self.send_nmt(NmtMessage { command: Command::Stop, target }, turn);
            }
            BabblingStep::Reset => {
                _ = self.send_nmt(NmtMessage { command: Command::ResetNode, target }, turn)
            }
            BabblingStep::BusLeft => {
                let other = self.redundancy.active().other();
                self.redundancy_mut().request(other);
            }
            BabblingStep::Quiet => {}
        }
        turn.out.event(MasterEvent::Babbling { node, step });
    }

    /// Ends the silence, and what was reported.
    pub(super) fn run_budget(&mut self, turn: &mut Turn) {
        match self.budgets.no_sooner().own.poll(turn.until) {
            Some(BudgetStep::Resume) => self.on_own_command(Command::Start, turn),
            Some(BudgetStep::Calm) => self.services.within_budget(),
            None => {}
        }
        while let Some((node, was_held)) = self.budgets.no_sooner().slaves.poll(turn.until) {
            self.redundancy_mut().peers_mut().hold(Target::Node(node), was_held);
            self.end_babbling(node, turn);
        }
    }

    /// Ends the measures against babbling slaves that the application commands.
    pub(super) fn on_application_command(&mut self, target: Target, turn: &mut Turn) {
        while let Some(node) = self.budgets.no_sooner().slaves.on_commanded(target) {
            self.end_babbling(node, turn);
        }
    }

    fn end_babbling(&mut self, node: NodeId, turn: &mut Turn) {
        self.services.clear(ErrorCode::MONITORING, node.get());
        turn.out.event(MasterEvent::Babbling { node, step: BabblingStep::Quiet });
    }
}
