//! Choice of the active bus by the master (ECSS 8.3.3a, b).

use super::peers::PLACES;
use super::slave_search::SlaveSearch;
use super::trial::Trial;
use super::{Parameters, PeerHeartbeat, Peers};
use crate::heartbeat::machine::Producer;
use crate::link::port::{ErrorState, Health, LastError};
use crate::types::{Bus, Canonical, Duration, Instant, NmtState, NodeId, PerBus, earliest};

mod action;

pub use action::{Action, SwitchCause};

/// Decides which bus is active, for the master. Hears nodes with Node-IDs below `N`.
///
/// The master makes a bus *active* by its heartbeat there. [`SwitchCause`] has the reasons to leave it. For
/// example, no node acknowledges any more, too many slaves are silent, or the application requests it. After a
/// switch it *announces* the new bus: its heartbeat is the first frame.
///
/// ```
/// use ecss_can::profile::Profile;
/// use ecss_can::redundancy::machine::{Action, Manager};
/// use ecss_can::redundancy::SwitchCause;
/// use ecss_can::types::{Bus, Duration, Instant};
///
/// let (dwell, grace) = (Duration::from_millis(10_000), Duration::from_millis(1));
/// let mut manager: Manager = Manager::new(Profile::DEFAULT.master_redundancy(), 50, dwell, grace);
/// manager.start(Instant::ZERO);
/// let at = manager.deadline().unwrap();
/// assert!(matches!(manager.poll(at), Some(Action::Heartbeat { bus: Bus::Nominal, .. })));
///
/// manager.request(Bus::Redundant);
/// let (from, to) = (Bus::Nominal, Bus::Redundant);
/// assert_eq!(manager.poll(at), Some(Action::Switched { from, to, cause: SwitchCause::Commanded }));
/// assert!(matches!(manager.poll(at), Some(Action::Heartbeat { bus: Bus::Redundant, .. })));
/// ```
///
/// # Limits
///
/// - Only nodes that count decide: those that 1F81h assigns, and those whose SDO server answered. See [`Peers`].
/// - A master that hears no slave on either bus changes the bus once in a *dwell* ([`Parameters::dwell`]), at most
///   Ntoggle times. Then it stays until it hears one. An Ntoggle of 255 is no limit.
/// - With Ttoggle or Ntoggle zero the master changes the bus by command alone.
#[doc(alias("redundancy master", "active bus", "bus switch"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct Manager<const N: usize = PLACES> {
    #[canonical(value = SlaveSearch::counting(self.parameters))]
    parameters: Parameters,
    /// Share of the slaves whose silence makes a bus bad, percent.
    silent_share: u8,
    /// Error passive this long without an acknowledgement or a received frame: the master is isolated. Rules out a
    /// burst of errors that ends with a frame of another node.
    grace: Duration,
    active: Bus,
    heartbeat: Producer,
    /// NMT state of the master, for its heartbeats.
    state: NmtState,
    announcing: bool,
    #[canonical(within = self.parameters)]
    peers: Peers<N>,
    /// A slave that counts was heard on the active bus since power-on or the last switch.
    heard_here: bool,
    /// End of the settling time after a switch; not isolated before.
    #[canonical(due)]
    guard: Instant,
    /// Last sign of another node on the active bus, while the controller reports that acknowledgements are missing.
    #[canonical(age = self.grace)]
    alone_since: Option<Instant>,
    unacknowledged: PerBus<bool>,
    failed: PerBus<bool>,
    wanted: Option<Bus>,
    /// Slaves that were silent on the other bus when it was left. A bus that failed counts as one that serves a
    /// single slave: any that serves more is better, and one without any is not.
    left_behind: u32,
    #[canonical(within = self.parameters)]
    search: SlaveSearch,
    trial: Trial,
    /// Instant at which assigned slaves that were never heard are reported.
    #[canonical(due)]
    report: Option<Instant>,
}

impl<const N: usize> Manager<N> {
    /// Makes a manager on the default bus with Ctoggle zero (ECSS 8.3.2a), idle until [`Manager::start`].
    /// `silent_share`: in percent, `1..=100`. `dwell`: shortest time on a bus while no slave is heard on either.
    /// `grace`: time that errors may last without an effect.
    #[inline(never)] // made in its place
    pub const fn new(parameters: Parameters, silent_share: u8, dwell: Duration, grace: Duration) -> Self {
        Manager {
            parameters: Parameters { ctoggle: 0, ..parameters },
            silent_share,
            grace,
            active: parameters.bdefault,
            heartbeat: Producer::new(NodeId::MASTER, parameters.producer),
            state: NmtState::Operational,
            announcing: false,
            heard_here: false,
            guard: Instant::ZERO,
            alone_since: None,
            unacknowledged: PerBus { nominal: false, redundant: false },
            failed: PerBus { nominal: false, redundant: false },
            wanted: None,
            left_behind: 0,
            search: SlaveSearch::new(dwell),
            trial: Trial::new(),
            report: None,
            // Last: then the compiler makes them in their place.
            peers: Peers::new(),
        }
    }

    /// Takes stored parameters before power-on. Bdefault becomes active.
    pub(crate) fn restore(&mut self, parameters: Parameters) {
        self.parameters = Parameters { ctoggle: 0, ..parameters };
        self.active = parameters.bdefault;
        self.heartbeat = Producer::new(NodeId::MASTER, parameters.producer);
    }

    /// Lends the NMT state of the master, for its heartbeats.
    pub(crate) fn state_mut(&mut self) -> &mut NmtState {
        &mut self.state
    }

    /// Takes parameters that differ from those in use, and brings instants that lie too far in the future back: in both cases a
    /// bit flipped. Returns whether a parameter differed.
    pub(crate) fn refresh(&mut self, written: Parameters, now: Instant) -> bool {
        self.guard = self.guard.min(now + self.parameters.settling_time());
        self.alone_since = self.alone_since.map(|since| since.min(now));
        self.report = self.report.map(|at| at.min(now + self.search.dwell(&self.parameters).times(2)));
        self.search.confine(now);
        let is_wrong = !written.agrees(&self.parameters);
        if is_wrong {
            self.configure(Parameters { ctoggle: self.parameters.ctoggle, ..written }, now);
        }
        is_wrong
    }

    /// Notes that the boot-up message was sent. From now on the manager sends heartbeats.
    pub fn start(&mut self, now: Instant) {
        self.heartbeat.announce(now);
        self.search.restart(now, &mut self.parameters);
        self.report_unheard(now);
    }

    /// Notes that another master is active on this bus.
    pub const fn follow(&mut self, bus: Bus) {
        self.active = bus;
    }

    /// Stops the heartbeat: another master is active.
    pub fn stand_by(&mut self) {
        self.heartbeat.stop();
    }

    /// Returns whether the heartbeats are on schedule, as [`Producer::is_on_schedule`].
    pub fn is_on_schedule(&self, now: Instant) -> bool {
        self.heartbeat.is_on_schedule(now)
    }

    /// Becomes active on this bus. The next action is its heartbeat, and nothing else may be sent before.
    /// `claimed`: number of slaves of the master that was active before. Those that were overheard count without an answer by
    /// SDO, unless they are more.
    pub fn take_over(&mut self, bus: Bus, claimed: u8, now: Instant) {
        self.peers.adopt_overheard(claimed);
        (self.unacknowledged, self.failed, self.wanted) = Default::default();
        self.trial = Trial::new();
        self.search.restart(now, &mut self.parameters);
        self.go_to(bus, 0, now);
        self.report_unheard(now);
    }

    /// Takes new values of 1016h, 1017h and 2000h. The heartbeat continues with the new period. The new Bdefault
    /// holds from the next power-on. A search continues with the new Ctoggle.
    pub fn configure(&mut self, parameters: Parameters, now: Instant) {
        self.parameters = parameters;
        self.heartbeat.set_period(parameters.producer, now);
    }

    /// Returns the parameters with the present Ctoggle.
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Returns the active bus.
    pub const fn active(&self) -> Bus {
        self.active
    }

    /// Returns whether the active bus was announced by a heartbeat. Until then nothing else may be sent on it:
    /// slaves that follow later would miss it, and most COB-IDs win arbitration against 701h.
    pub const fn is_announced(&self) -> bool {
        !self.announcing
    }

    /// Returns the nodes that were heard.
    pub const fn peers(&self) -> &Peers<N> {
        &self.peers
    }

    /// Returns the nodes that were heard, to assign, hold or ask some of them.
    pub fn peers_mut(&mut self) -> &mut Peers<N> {
        &mut self.peers
    }

    /// Takes a frame on `bus`. `node`: its sender, if the COB-ID has one.
    pub fn on_frame(&mut self, bus: Bus, node: Option<NodeId>, at: Instant) {
        if bus == self.active {
            self.not_alone(at);
        }
        if node.is_some_and(|node| self.peers.counts(node)) {
            self.search.on_heard(at);
            self.heard_here |= bus == self.active;
        }
    }

    /// Takes a heartbeat or boot-up message of another node.
    pub fn on_heartbeat(&mut self, bus: Bus, node: NodeId, state: NmtState, at: Instant) -> PeerHeartbeat {
        self.peers.on_heartbeat(node, state, bus == self.active, at, &self.parameters)
    }

    /// Takes an answer of the SDO server of `node` on the active bus: the node counts as a slave.
    pub fn on_answer(&mut self, node: NodeId, at: Instant) {
        self.peers.on_answer(node, at);
        self.on_frame(self.active, Some(node), at);
    }

    /// Notes that a frame of this node was acknowledged on `bus`.
    pub fn on_sent(&mut self, bus: Bus, at: Instant) {
        if bus == self.active {
            self.not_alone(at);
        }
    }

    /// Notes that the heartbeat of this node was acknowledged on `bus`.
    pub fn on_heartbeat_sent(&mut self, bus: Bus, at: Instant) {
        if bus == self.active {
            self.announcing = false;
        } else {
            // It was on the wire when its bus was left, and may have taken parallel slaves back there.
            self.heartbeat.announce(at);
        }
    }

    /// Notes that the heartbeat of this node was not sent on `bus`, for another reason than leaving it.
    pub fn on_heartbeat_failed(&mut self, bus: Bus) {
        if bus == self.active {
            self.announcing = false;
        }
    }

    /// Takes a frame of another node with the COB-ID of the master's heartbeat.
    pub fn on_rival(&mut self) {
        self.trial.on_rival();
    }

    /// Notes that no other node sends the heartbeat of the master any more, on either bus.
    pub fn on_rivals_silent(&mut self, now: Instant) {
        self.trial.on_rivals_silent();
        self.peers.recheck(now);
    }

    /// Takes the state of a controller. `failed`: it went bus-off too often.
    pub fn on_health(&mut self, bus: Bus, health: Health, failed: bool, now: Instant) {
        let unacknowledged = health.state == ErrorState::Passive && health.last_error == LastError::Ack;
        self.unacknowledged[bus] = unacknowledged;
        self.failed[bus] = failed;
        if bus == self.active {
            self.alone_since = unacknowledged.then(|| self.alone_since.unwrap_or(now));
        }
        self.peers.recheck(now);
    }

    /// Requests this bus. Does nothing if it is active already.
    pub fn request(&mut self, bus: Bus) {
        self.wanted = Some(bus);
    }

    /// Returns one action that is due at `now`. Call it until `None`.
    pub fn poll(&mut self, now: Instant) -> Option<Action> {
        if let Some(wanted) = self.wanted.take()
            && wanted != self.active
        {
            return Some(self.switch(SwitchCause::Commanded, 0, now));
        }
        if self.may_leave() {
            if self.failed[self.active] {
                return Some(self.switch(SwitchCause::BusOff, self.most(now), now));
            }
            if self.isolated_at().is_some_and(|at| at <= now) {
                return Some(self.switch(SwitchCause::Isolated, self.most(now), now));
            }
        }
        if self.peers.is_due(now) {
            if let Some(node) = self.peers.next_lost(now, self.parameters.consumer) {
                return Some(Action::Lost(node));
            }
            if let Some(node) = self.peers.next_forgotten(now, self.parameters.consumer) {
                return Some(Action::Forgotten(node));
            }
            self.peers.checked(now, &self.parameters);
            if let Some((cause, silent)) = self.silence(now) {
                return Some(self.switch(cause, silent, now));
            }
        }
        if self.unheard_at().is_some_and(|at| at <= now) {
            if !self.may_leave() {
                self.search.give_up();
                return Some(Action::GaveUp { bus: self.active });
            }
            let (silent, _) = self.peers.silent_and_heard(now);
            return Some(self.switch(SwitchCause::Unheard, silent.count_ones(), now));
        }
        if self.report.is_some_and(|at| at <= now) {
            if let Some(node) = self.peers.next_unheard() {
                return Some(Action::Unheard(node));
            }
            self.report = None;
        }
        let frame = self.heartbeat.poll(now, self.state)?;
        Some(Action::Heartbeat { bus: self.active, frame })
    }

    /// Returns when to call [`Manager::poll`] next.
    pub fn deadline(&self) -> Option<Instant> {
        let isolated = self.isolated_at().filter(|_| self.may_leave());
        earliest(&[
            self.wanted.map(|_| Instant::ZERO),
            self.heartbeat.deadline(),
            self.peers.deadline(),
            isolated,
            self.unheard_at(),
            self.report,
        ])
    }

    fn may_leave(&self) -> bool {
        self.is_other_usable() && self.search.may_change(&self.parameters)
    }

    fn is_other_usable(&self) -> bool {
        !self.failed[self.active.other()]
    }

    fn isolated_at(&self) -> Option<Instant> {
        let since = self.alone_since.filter(|_| self.heard_here)?;
        Some((since + self.grace).max(self.guard))
    }

    fn unheard_at(&self) -> Option<Instant> {
        self.search.dwells_until(&self.parameters).filter(|_| self.is_other_usable())
    }

    /// Returns the reason to leave the bus because of silent slaves, and their number.
    fn silence(&mut self, now: Instant) -> Option<(SwitchCause, u32)> {
        if self.parameters.consumer == Duration::ZERO || !self.may_leave() {
            return None;
        }
        let (silent, heard) = self.peers.silent_and_heard(now);
        let (number, others) = (silent.count_ones(), heard.count_ones());
        if self.trial.judge(now, others) == Some(true) {
            return Some((SwitchCause::TriedInVain, number));
        }
        if silent == 0 {
            if self.guard <= now {
                self.left_behind = 0;
            }
            return None;
        }
        let share_reached = number * 100 >= (number + others) * u32::from(self.silent_share);
        // Of two half-dead buses the better one is kept.
        if share_reached && number > self.left_behind {
            return Some((SwitchCause::SlavesSilent, number));
        }
        let is_tried =
            self.trial.is_allowed(self.active, silent) && self.peers.is_any_elsewhere(now, &self.parameters);
        is_tried.then(|| {
            self.trial.begin(self.active, silent, others, now + self.visit());
            (SwitchCause::Tried, number)
        })
    }

    /// All slaves that count and were heard, but one.
    fn most(&self, now: Instant) -> u32 {
        let (silent, heard) = self.peers.silent_and_heard(now);
        (silent | heard).count_ones().saturating_sub(1)
    }

    fn not_alone(&mut self, at: Instant) {
        self.alone_since = self.alone_since.map(|since| since.max(at));
    }

    /// Returns the time after a switch in which slaves have to be heard.
    fn visit(&self) -> Duration {
        self.parameters.settling_time().max(self.parameters.consumer)
    }

    /// ECSS 8.3.3b: the heartbeat stops on one bus and starts on the other at once.
    fn switch(&mut self, cause: SwitchCause, silent: u32, now: Instant) -> Action {
        let from = self.active;
        let to = from.other();
        if cause == SwitchCause::Commanded {
            self.search.restart(now, &mut self.parameters);
        } else {
            self.search.on_change(now, &mut self.parameters);
        }
        self.go_to(to, silent, now);
        if cause != SwitchCause::Tried {
            self.trial.abandon();
        }
        Action::Switched { from, to, cause }
    }

    /// `to` is the active bus now; so many slaves were silent on the other one.
    fn go_to(&mut self, to: Bus, silent: u32, now: Instant) {
        self.active = to;
        self.heartbeat.announce(now);
        self.announcing = true;
        self.peers.on_switch(now, now + self.visit());
        self.heard_here = false;
        self.guard = now + self.parameters.settling_time();
        self.alone_since = self.unacknowledged[to].then_some(now);
        self.left_behind = silent;
    }

    fn report_unheard(&mut self, now: Instant) {
        self.report = Some(now + self.search.dwell(&self.parameters).times(2));
    }
}
