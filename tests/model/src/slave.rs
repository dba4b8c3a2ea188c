//! A slave of the model: the state machines of flight, and what joins them in `node::slave`.

use ecss_can::heartbeat::{self, Producer};
use ecss_can::nmt::{Command, NmtMessage, NmtSlave, Reaction, ResetGuard, ResetVerdict};
use ecss_can::redundancy::{Broken, BusAccess, MasterMessage, Selection, Selector};
use ecss_can::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, PerBus, Rebase, earliest};
use judge::selector::is_bdefault_right;

use crate::profile::PARAMETERS;
use crate::station::{Outgoing, Station};

/// A slave.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Slave {
    id: NodeId,
    /// How it accesses its buses.
    pub access: BusAccess,
    broken: Option<Broken>,
    /// Decides which bus is active.
    pub selector: Selector,
    nmt: NmtSlave,
    heartbeat: Producer,
    guard: ResetGuard,
    /// Bdefault in the memory that outlives a reset.
    retained: Option<Bus>,
    outgoing: Outgoing,
    /// Frames of the master's services.
    work: PerBus<u32>,
    /// It gave up its search and stays where it is.
    pub has_given_up: bool,
    /// Bdefault changed for no reason that the standard knows.
    pub has_wrong_bdefault: bool,
}

impl Slave {
    /// A slave before power-on. `broken`: a rule that does not hold.
    pub fn new(id: NodeId, access: BusAccess, broken: Option<Broken>) -> Self {
        Slave {
            broken,
            id,
            access,
            selector: Selector::new(PARAMETERS),
            nmt: NmtSlave::new(false),
            heartbeat: Producer::new(id, PARAMETERS.producer),
            guard: ResetGuard::default(),
            retained: None,
            outgoing: Outgoing::default(),
            work: PerBus::default(),
            has_given_up: false,
            has_wrong_bdefault: false,
        }
    }

    /// Shifts the clock.
    pub fn rebase(&mut self, now: Instant) {
        let to = Rebase::new(now);
        self.work = self.selector.rebase(self.work, now);
        self.heartbeat.rebase(&to);
        self.guard.rebase(&to, pause());
        self.outgoing.rebase(&to);
    }

    fn boot(&mut self, now: Instant) {
        self.outgoing.send(self.selector.selected(), heartbeat::encode(self.id, NmtState::Initialising), now);
        self.nmt.boot();
        self.heartbeat.restart(now);
        self.selector.start(now);
        self.has_given_up = false;
        self.guard.on_boot(now);
    }

    fn on_nmt(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        let Some(message) = NmtMessage::decode(frame) else { return };
        let is_reset = matches!(message.command, Command::ResetNode | Command::ResetCommunication);
        if is_reset && message.target.includes(self.id) {
            self.guard.poll(now, pause());
            if self.guard.on_reset(now) != ResetVerdict::Obey {
                return;
            }
        }
        self.on_master(bus, MasterMessage::Command, now);
        if bus != self.selector.selected() || !message.target.includes(self.id) {
            return;
        }
        match self.nmt.on_command(message.command) {
            Reaction::Unchanged => {}
            Reaction::Entered(_) => self.heartbeat.announce(now),
            Reaction::ResetNode => {
                self.guard.obeyed();
                self.start(now);
            }
            Reaction::ResetCommunication => {
                self.guard.obeyed();
                self.boot(now);
            }
        }
    }

    fn on_master(&mut self, bus: Bus, message: MasterMessage, now: Instant) {
        let before = self.selector.parameters().bdefault;
        self.selector.on_work(self.work);
        let selection = self.selector.on_master(bus, message, now);
        self.judge(before, selection);
        if let Some(selection) = selection {
            self.apply(selection, now);
        }
    }

    fn judge(&mut self, before: Bus, selection: Option<Selection>) {
        let after = self.selector.parameters().bdefault;
        self.has_wrong_bdefault |= !is_bdefault_right(before, after, selection);
    }

    fn apply(&mut self, selection: Selection, now: Instant) {
        if matches!(
            selection,
            Selection::Missed { .. } | Selection::Toggled { .. } | Selection::Unconfirmed { .. }
        ) {
            self.nmt.on_master_missed();
        }
        match selection {
            Selection::Missed { .. } => self.has_given_up = false,
            Selection::Toggled { to } => self.move_to(to, now),
            Selection::GaveUp { .. } => self.has_given_up = true,
            Selection::Found { bus, moved } => {
                self.confirm();
                self.go_to(bus, moved, now);
            }
            Selection::Unconfirmed { bus, moved } => self.go_to(bus, moved, now),
            Selection::Confirmed => self.confirm(),
            Selection::Followed { to: bus } | Selection::Contradicted { bus, moved: true } => {
                self.move_to(bus, now);
                self.retained = Some(self.selector.parameters().bdefault);
            }
            Selection::Contradicted { moved: false, .. }
            | Selection::Undisputed
            | Selection::KeepBdefault { .. } => {}
        }
    }

    fn confirm(&mut self) {
        if self.selector.is_confirmed() {
            self.has_given_up = false;
            self.retained = Some(self.selector.parameters().bdefault);
        }
    }

    fn go_to(&mut self, bus: Bus, moved: bool, now: Instant) {
        if moved {
            self.move_to(bus, now);
        }
    }

    fn move_to(&mut self, bus: Bus, now: Instant) {
        self.outgoing.abandon(bus.other());
        self.heartbeat.announce(now);
    }
}

impl Station for Slave {
    fn start(&mut self, now: Instant) {
        let bdefault = self.retained.unwrap_or(self.selector.kept());
        let kept = self.selector.kept();
        self.selector = Selector::new(ecss_can::redundancy::Parameters { bdefault, ..PARAMETERS });
        self.selector.set_kept(kept);
        self.selector.break_rule(self.broken);
        self.nmt = NmtSlave::new(false);
        self.guard = ResetGuard::new(self.guard.row());
        self.outgoing.clear();
        self.work = PerBus::default();
        self.boot(now);
    }

    fn power_off(&mut self) {
        let kept = self.selector.kept();
        *self = Slave::new(self.id, self.access, self.broken);
        self.selector.set_kept(kept);
    }

    fn poll(&mut self, now: Instant) {
        loop {
            let before = self.selector.parameters().bdefault;
            let Some(selection) = self.selector.poll(now) else { break };
            self.judge(before, Some(selection));
            self.apply(selection, now);
        }
        self.guard.poll(now, pause());
        if let Some(frame) = self.heartbeat.poll(now, self.nmt.state()) {
            self.outgoing.send(self.selector.selected(), frame, now);
        }
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.poll(now);
        let id = frame.id();
        if id == CobId::SYNC {
            self.work[bus] += 1;
        }
        if id == CobId::NMT {
            self.on_nmt(bus, frame, now);
        } else if id == CobId::sdo_request(self.id) {
            if bus == self.selector.selected() && self.nmt.state().allows_sdo() {
                self.outgoing.send(bus, Frame::of(CobId::sdo_response(self.id), []), now);
            }
        } else if id == CobId::heartbeat(NodeId::MASTER) {
            if heartbeat::decode(frame).is_none() {
                return;
            }
            self.guard.on_heartbeat();
            if !self.selector.on_beat(bus, now) {
                self.on_master(bus, MasterMessage::Heartbeat, now);
            }
        }
        self.poll(now);
    }

    fn on_sent(&mut self, bus: Bus, frame: &Frame, _now: Instant) {
        self.outgoing.acknowledge(bus, frame);
    }

    fn on_expired(&mut self, _bus: Bus, _frame: &Frame, _now: Instant) {}

    fn on_unacknowledged(&mut self, _bus: Bus, _unacknowledged: bool, _now: Instant) {}

    fn deadline(&self) -> Option<Instant> {
        earliest(&[
            self.selector.deadline(),
            self.heartbeat.deadline(),
            self.guard.deadline(pause()),
            self.outgoing.deadline(),
        ])
    }

    fn is_joined(&self, bus: Bus) -> bool {
        self.access == BusAccess::Parallel || bus == self.selector.selected()
    }

    fn is_silent(&self) -> bool {
        false
    }

    fn active(&self) -> Bus {
        self.selector.selected()
    }

    fn state(&self) -> NmtState {
        self.nmt.state()
    }

    fn outgoing(&mut self) -> &mut Outgoing {
        &mut self.outgoing
    }

    fn waiting(&self) -> &Outgoing {
        &self.outgoing
    }
}

/// As long as a reset in a row counts.
fn pause() -> Duration {
    PARAMETERS.consumer.times(2)
}
