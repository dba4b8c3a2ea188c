//! Redundancy of a master: the machine that joins the choice of the bus, the role of the board, and the frames that
//! wait for an announced bus.
//!
//! The node reports what happens and does what the machine says:
//!
//! ```
//! use ecss_can::profile::Profile;
//! use ecss_can::link::access::BusAccess;
//! use ecss_can::redundancy::machine::{MasterAction, MasterRedundancy, MasterSetup};
//! use ecss_can::redundancy::OneBoard;
//! use ecss_can::types::{Bus, Duration, Instant};
//!
//! let setup = MasterSetup {
//!     parameters: Profile::DEFAULT.master_redundancy(),
//!     silent_share: 50,
//!     dwell: Duration::from_millis(10_000),
//!     grace: Duration::from_millis(1),
//!     access: BusAccess::Parallel,
//!     lifetime: Duration::from_millis(100),
//! };
//! let mut redundancy: MasterRedundancy = MasterRedundancy::new(OneBoard, &setup);
//! assert!(redundancy.start(Instant::ZERO)); // active at once
//! let (boot_up, state) = redundancy.boot_up(Instant::ZERO); // send it on the active bus
//!
//! let now = redundancy.deadline().unwrap();
//! while let Some(action) = redundancy.poll(now, now) {
//!     assert!(matches!(action, MasterAction::Heartbeat { bus: Bus::Nominal, .. }));
//! }
//! ```
//!
//! # Limits
//!
//! - The machine says which command a waiting slave gets. The boot-up process decides whether the slave may start.
//! - Recovery from bus-off, budgets of slaves and clashes of Node-IDs are outside. Their results are inputs: a failed
//!   bus, a request for a bus, a slave that is held, the state of a slave.

mod action;
mod boards;
#[cfg(test)]
mod flipped;
mod held;
mod reception;
mod role;

pub use action::MasterAction;
pub use boards::{MasterBoards, OneBoard, TwoBoards};
pub use held::Sending;
pub use reception::MasterVerdict;

use self::held::Held;
use super::peers::PLACES;
use super::{Action, Claim, Manager, Parameters, PeerHeartbeat, Peers, Rivals};
use crate::heartbeat;
use crate::link::access::BusAccess;
use crate::link::machine::Outgoing;
use crate::link::port::Health;
use crate::nmt::machine::{NmtSlave, Reaction};
use crate::nmt::{Command, NmtMessage, Target};
use crate::types::{Bus, Canonical, CobId, Duration, Instant, NmtState, NodeId, correct, earliest};

/// Frames that may wait until the active bus is announced.
const HELD: usize = 16;

/// Numbers of the redundancy of a master.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MasterSetup {
    /// Parameters at power-on.
    pub parameters: Parameters,
    /// Share of the slaves whose silence makes a bus bad, 1 to 100 percent.
    pub silent_share: u8,
    /// Shortest time on a bus while no slave is heard on either.
    pub dwell: Duration,
    /// Time that errors may last without an effect.
    pub grace: Duration,
    /// Access to the two buses.
    pub access: BusAccess,
    /// Longest lifetime of heartbeats and claims. It is never more than the period of the heartbeat.
    pub lifetime: Duration,
}

impl PeerHeartbeat {
    /// Returns the command that the slave needs (ECSS 8.3.3f). `may_start`: the slave may start at once. Else the boot-up
    /// process has to check it first.
    pub fn command(self, node: NodeId, state: NmtState, may_start: bool) -> Option<NmtMessage> {
        let command = match state {
            _ if !self.start => return None,
            // Unasked; also a slave that came back before it toggled.
            _ if may_start => Command::Start,
            // It answers no SDO while it is stopped.
            NmtState::Stopped => Command::EnterPreOperational,
            _ => return None,
        };
        Some(NmtMessage { command, target: Target::Node(node) })
    }
}

/// Decides about the active bus of a master, the role of its board, and what it sends when.
///
/// Hears nodes with Node-IDs below `N`. Up to `H` frames wait for the announcement of the bus.
#[doc(alias("redundancy master"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct MasterRedundancy<B: MasterBoards = OneBoard, const N: usize = PLACES, const H: usize = HELD> {
    boards: B,
    #[canonical(within = self.parameters().quiet_time())]
    rivals: Rivals,
    nmt: NmtSlave,
    /// Copy of the NMT state of `nmt` and of `manager`: two of the three have to agree.
    state: NmtState,
    access: BusAccess,
    lifetime: Duration,
    /// Claim that follows the last heartbeat, and its next bus.
    due: Option<(Claim, Bus)>,
    held: Held<H>,
    // Last: then the compiler makes it in its place.
    manager: Manager<N>,
}

impl<B: MasterBoards, const N: usize, const H: usize> MasterRedundancy<B, N, H> {
    /// Makes the redundancy of a master before power-on.
    #[inline(never)] // made in its place
    pub fn new(boards: B, setup: &MasterSetup) -> Self {
        let MasterSetup { parameters, silent_share, dwell, grace, access, lifetime } = *setup;
        MasterRedundancy {
            boards,
            rivals: Rivals::default(),
            nmt: NmtSlave::new(true),
            state: NmtState::Initialising,
            access,
            lifetime,
            due: None,
            held: Held::new(),
            manager: Manager::new(parameters, silent_share, dwell, grace),
        }
    }

    /// Takes stored parameters before power-on.
    pub fn restore(&mut self, parameters: Parameters) {
        self.manager.restore(parameters);
    }

    /// Takes new values of 1016h, 1017h and 2000h. A new Bdefault holds from the next power-on.
    pub fn configure(&mut self, parameters: Parameters, now: Instant) {
        self.manager.configure(parameters, now);
    }

    /// Powers the board on. Returns whether it is active: [boot up](MasterRedundancy::boot_up) then. One of two
    /// boards listens first.
    pub fn start(&mut self, now: Instant) -> bool {
        match self.boards.standby_mut() {
            Some(standby) => standby.start(now),
            None => self.manager.start(now),
        }
        self.is_active()
    }

    /// Leaves Initialising. Returns the boot-up message for the active bus, to be sent before anything else, and
    /// the NMT state of the master.
    pub fn boot_up(&mut self, now: Instant) -> (Outgoing, NmtState) {
        let frame = heartbeat::encode(NodeId::MASTER, NmtState::Initialising);
        let state = self.nmt.boot();
        self.set_state(state);
        (Outgoing { frame, expires: now + self.lifetime() }, state)
    }

    /// Returns the lifetime of heartbeats and claims, at most a period of the heartbeat (1017h).
    fn lifetime(&self) -> Duration {
        let period = self.parameters().producer;
        if period > Duration::ZERO { self.lifetime.min(period) } else { self.lifetime }
    }

    /// Takes a command to the master itself. After a reset of the communication boot up again.
    pub fn on_own_command(&mut self, command: Command) -> Reaction {
        let reaction = self.nmt.on_command(command);
        if let Reaction::Entered(state) = reaction {
            self.set_state(state);
        }
        reaction
    }

    pub(super) fn set_state(&mut self, state: NmtState) {
        (self.state, *self.manager.state_mut()) = (state, state);
    }

    /// Corrects the NMT state by its copies. Takes parameters that differ from those in use, and bounds stored instants. Call it
    /// periodically with the `written` parameters. Returns whether a bit was wrong.
    pub fn refresh(&mut self, written: Parameters, now: Instant) -> bool {
        let is_active = self.is_active();
        let copies = [self.nmt.state_mut(), self.manager.state_mut(), &mut self.state];
        // That of a standby decides nothing.
        let is_wrong = is_active && correct(copies);
        let is_other_board = self.boards.refresh(now);
        self.manager.refresh(written, now) || is_wrong || is_other_board
    }

    /// Takes a command of the application to slaves. A slave that it stops, or makes Pre-operational, is held there.
    /// Returns whether the slaves are held.
    pub fn on_command(&mut self, command: Command, target: Target) -> bool {
        let is_held = matches!(command, Command::Stop | Command::EnterPreOperational);
        self.manager.peers_mut().hold(target, is_held);
        is_held
    }

    /// Requests this bus. Does nothing if it is active already.
    pub fn request(&mut self, bus: Bus) {
        self.manager.request(bus);
    }

    /// Returns the NMT state of the master.
    pub const fn state(&self) -> NmtState {
        self.nmt.state()
    }

    /// Returns the parameters with the present Ctoggle.
    pub const fn parameters(&self) -> &Parameters {
        self.manager.parameters()
    }

    /// Returns the active bus.
    pub const fn active(&self) -> Bus {
        self.manager.active()
    }

    /// Returns whether the active bus was announced by a heartbeat. Until then no other frame is sent on it.
    pub const fn is_announced(&self) -> bool {
        self.manager.is_announced()
    }

    /// Returns whether the master takes part in this bus.
    pub fn is_joined(&self, bus: Bus) -> bool {
        self.access.joins(bus, self.active())
    }

    /// Returns the nodes that were heard.
    pub const fn peers(&self) -> &Peers<N> {
        self.manager.peers()
    }

    /// Returns the nodes that were heard, to assign, hold or ask some of them.
    pub fn peers_mut(&mut self) -> &mut Peers<N> {
        self.manager.peers_mut()
    }

    /// Takes any frame of another node on a bus that is joined. `node`: its sender, if the COB-ID has one.
    pub fn on_frame(&mut self, bus: Bus, node: Option<NodeId>, at: Instant) {
        self.manager.on_frame(bus, node, at);
    }

    /// Takes a heartbeat or boot-up message of a node while this board is active. [Send](MasterRedundancy::send) the
    /// [command](PeerHeartbeat::command) that the slave needs.
    pub fn on_heartbeat(&mut self, bus: Bus, node: NodeId, state: NmtState, at: Instant) -> PeerHeartbeat {
        self.manager.on_heartbeat(bus, node, state, at)
    }

    /// Takes an answer of the SDO server of `node` that ended at `at`: the node counts as a slave.
    pub fn on_answer(&mut self, node: NodeId, at: Instant) {
        self.manager.on_answer(node, at);
    }

    /// Takes a frame of this node that was acknowledged. Returns whether it was a heartbeat or boot-up message.
    pub fn on_sent(&mut self, bus: Bus, id: CobId, at: Instant) -> bool {
        self.manager.on_sent(bus, at);
        let is_heartbeat = id == CobId::heartbeat(NodeId::MASTER);
        if is_heartbeat {
            self.manager.on_heartbeat_sent(bus, at);
        }
        is_heartbeat
    }

    /// Takes a frame of this node that was not sent, for another reason than that its bus was left.
    pub fn on_failed(&mut self, bus: Bus, id: CobId) {
        if id == CobId::heartbeat(NodeId::MASTER) {
            self.manager.on_heartbeat_failed(bus);
        }
    }

    /// Takes the state of a controller. `failed`: it went bus-off too often.
    pub fn on_health(&mut self, bus: Bus, health: Health, failed: bool, now: Instant) {
        self.manager.on_health(bus, health, failed, now);
    }

    /// Returns one action of all that was due at `until`, which may be before `now`: a frame is judged by its end.
    /// Call it until `None`.
    pub fn poll(&mut self, until: Instant, now: Instant) -> Option<MasterAction> {
        if let Some(action) = self.held.take_left() {
            return Some(action);
        }
        if let Some(action) = self.take_over(until, now) {
            return Some(action);
        }
        if !self.is_active() {
            return None;
        }
        if let Some(action) = self.next_claim(now) {
            return Some(action);
        }
        if let Some(action) = self.manager.poll(until) {
            return Some(self.managed(action, now));
        }
        if let Some(bus) = self.rivals.poll(until, self.manager.parameters().quiet_time()) {
            if self.rivals.are_silent() {
                self.manager.on_rivals_silent(until);
            }
            return Some(MasterAction::RivalSilent(bus));
        }
        self.release(now)
    }

    fn managed(&mut self, action: Action, now: Instant) -> MasterAction {
        match action {
            Action::Heartbeat { bus, frame } => {
                self.call(now);
                MasterAction::Heartbeat { bus, frame, expires: now + self.lifetime() }
            }
            Action::Switched { from, to, cause } => {
                self.held.leave(from);
                MasterAction::Switched { from, to, cause }
            }
            Action::Lost(node) => MasterAction::Lost(node),
            Action::Forgotten(node) => MasterAction::Forgotten(node),
            Action::Unheard(node) => MasterAction::Unheard(node),
            Action::GaveUp { bus } => MasterAction::GaveUp(bus),
        }
    }

    /// Returns whether the heartbeats are on schedule, as [`Producer::is_on_schedule`](crate::heartbeat::machine::Producer::is_on_schedule).
    pub fn is_on_schedule(&self, now: Instant) -> bool {
        self.manager.is_on_schedule(now)
    }

    /// Returns when to call [`MasterRedundancy::poll`] next.
    pub fn deadline(&self) -> Option<Instant> {
        if let Some(standby) = self.boards.standby()
            && !standby.is_active()
        {
            return standby.deadline();
        }
        let is_due = self.due.is_some() || self.held.is_due(self.is_announced());
        let quiet_time = self.manager.parameters().quiet_time();
        earliest(&[
            is_due.then_some(Instant::ZERO),
            self.manager.deadline(),
            self.rivals.deadline(quiet_time),
        ])
    }
}
