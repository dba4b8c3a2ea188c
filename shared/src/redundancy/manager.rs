//! The master's side: heartbeat on the active bus, and when to go to the other one (ECSS 8.3.3a, b).

use super::{Heard, Parameters, Peers};
use crate::heartbeat::Producer;
use crate::link::port::{ErrorState, Health, LastError};
use crate::link::{Bus, Frame, PerBus};
use crate::nmt::{NmtState, NodeId};
use crate::time::{Duration, Instant, earliest};

/// Unacknowledged in error passive this long, and nothing received meanwhile: nobody is there. Rules out a burst of
/// errors that ends with a frame of somebody else.
const ISOLATION_GRACE: Duration = Duration::from_millis(2);

/// Decides which bus is active.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Manager {
    parameters: Parameters,
    /// Share of the monitored slaves whose silence makes a bus bad, percent.
    silent_share: u8,
    active: Bus,
    heartbeat: Producer,
    announcing: bool,
    peers: Peers,
    /// A peer was heard on the active bus since power-on or the last switch.
    heard_here: bool,
    /// Settled after a switch from then on; not isolated before.
    guard: Instant,
    /// On the active bus unacknowledged and without reception since then.
    alone_since: Option<Instant>,
    unacknowledged: PerBus<bool>,
    failed: PerBus<bool>,
    wanted: Option<Bus>,
    /// Slaves that were silent on the other bus when it was left for that.
    left_behind: u8,
}

/// Why the master left a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SwitchCause {
    /// Its controller went bus-off too often.
    BusOff,
    /// Nobody acknowledges there any more.
    Isolated,
    /// Too many slaves went silent there.
    SlavesSilent,
    /// The application wanted it.
    Commanded,
}

/// What is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Action {
    /// Send this heartbeat on this bus.
    Heartbeat {
        /// The active bus.
        bus: Bus,
        /// 701h.
        frame: Frame,
    },
    /// The active bus changed. Its heartbeat is the next action; nothing else goes out there before it did.
    Switched {
        /// Abandon everything here.
        from: Bus,
        /// The active bus now.
        to: Bus,
        /// Why.
        cause: SwitchCause,
    },
    /// No heartbeat of this slave for its consumer time, on neither bus.
    Lost(NodeId),
}

impl Manager {
    /// On the default bus (ECSS 8.3.2a). `silent_share` in percent, `1..=100`. Idle until [`Manager::start`].
    pub const fn new(parameters: Parameters, silent_share: u8) -> Self {
        Manager {
            parameters,
            silent_share,
            active: parameters.bdefault,
            heartbeat: Producer::new(NodeId::MASTER, parameters.producer),
            announcing: false,
            peers: Peers::new(),
            heard_here: false,
            guard: Instant::ZERO,
            alone_since: None,
            unacknowledged: PerBus { nominal: false, redundant: false },
            failed: PerBus { nominal: false, redundant: false },
            wanted: None,
            left_behind: 0,
        }
    }

    /// The boot-up message went out: heartbeats from now on.
    pub fn start(&mut self, now: Instant) {
        self.heartbeat.announce(now);
    }

    /// New values of 1016h, 1017h and 2000h. The heartbeat goes on in a new period; the default bus is that of the next
    /// power-on.
    pub fn configure(&mut self, parameters: Parameters, now: Instant) {
        self.parameters = parameters;
        self.heartbeat.set_period(parameters.producer, now);
    }

    /// The active bus.
    pub const fn active(&self) -> Bus {
        self.active
    }

    /// Whether the active bus is announced by a heartbeat. Until then nothing else may go out on it: slaves that follow
    /// later would miss what came first, and most COB-IDs win arbitration against 701h.
    pub const fn is_announced(&self) -> bool {
        !self.announcing
    }

    /// The slaves heard.
    pub const fn peers(&self) -> &Peers {
        &self.peers
    }

    /// The slaves heard, to hold some.
    pub fn peers_mut(&mut self) -> &mut Peers {
        &mut self.peers
    }

    /// Any frame of a slave on `bus`.
    pub fn on_peer(&mut self, bus: Bus, at: Instant) {
        if bus == self.active {
            self.heard_here = true;
            self.not_alone(at);
        }
    }

    /// A heartbeat or boot-up message of a slave.
    pub fn on_heartbeat(&mut self, bus: Bus, node: NodeId, state: NmtState, at: Instant) -> Heard {
        let times = (self.parameters.consumer, self.parameters.settling_time());
        self.peers.on_heartbeat(node, state, bus == self.active, at, times)
    }

    /// Our heartbeat was acknowledged on `bus`.
    pub fn on_heartbeat_sent(&mut self, bus: Bus, at: Instant) {
        if bus == self.active {
            self.announcing = false;
            self.not_alone(at);
        } else {
            // It was on the wire when its bus was left, and may have taken parallel slaves back there.
            self.heartbeat.announce(at);
        }
    }

    /// Our heartbeat did not go out on `bus`, for another reason than leaving it.
    pub fn on_heartbeat_failed(&mut self, bus: Bus) {
        if bus == self.active {
            self.announcing = false;
        }
    }

    /// State of a controller; `failed`: it went bus-off too often.
    pub fn on_health(&mut self, bus: Bus, health: Health, failed: bool, now: Instant) {
        let unacknowledged = health.state == ErrorState::Passive && health.last_error == LastError::Ack;
        self.unacknowledged[bus] = unacknowledged;
        self.failed[bus] = failed;
        if bus == self.active {
            self.alone_since = unacknowledged.then(|| self.alone_since.unwrap_or(now));
        }
        self.peers.recheck(now);
    }

    /// The application wants this bus active; nothing happens if it is.
    pub fn request(&mut self, bus: Bus) {
        self.wanted = Some(bus);
    }

    /// One thing that is due at `now`; call until `None`.
    pub fn poll(&mut self, now: Instant) -> Option<Action> {
        if let Some(wanted) = self.wanted.take()
            && wanted != self.active
        {
            return Some(self.switch(SwitchCause::Commanded, 0, now));
        }
        if !self.failed[self.active.other()] {
            if self.failed[self.active] {
                return Some(self.switch(SwitchCause::BusOff, 0, now));
            }
            if self.isolated_at().is_some_and(|at| at <= now) {
                return Some(self.switch(SwitchCause::Isolated, 0, now));
            }
        }
        if self.peers.is_due(now) {
            if let Some(node) = self.peers.next_lost(now, self.parameters.consumer) {
                return Some(Action::Lost(node));
            }
            self.peers.checked(now, self.parameters.consumer);
            if let Some(silent) = self.too_many_silent(now) {
                return Some(self.switch(SwitchCause::SlavesSilent, silent, now));
            }
        }
        let frame = self.heartbeat.poll(now, NmtState::Operational)?;
        Some(Action::Heartbeat { bus: self.active, frame })
    }

    /// When [`Manager::poll`] has something to do.
    pub fn deadline(&self) -> Option<Instant> {
        let isolated = if self.failed[self.active.other()] { None } else { self.isolated_at() };
        earliest(&[self.heartbeat.deadline(), self.peers.deadline(), isolated])
    }

    fn isolated_at(&self) -> Option<Instant> {
        let since = self.alone_since.filter(|_| self.heard_here)?;
        Some((since + ISOLATION_GRACE).max(self.guard))
    }

    /// How many, when they are enough to leave the bus for it.
    fn too_many_silent(&mut self, now: Instant) -> Option<u8> {
        if self.parameters.consumer == Duration::ZERO || self.failed[self.active.other()] {
            return None;
        }
        let (silent, total) = self.peers.silent(now);
        if silent == 0 {
            if self.guard <= now {
                self.left_behind = 0;
            }
            return None;
        }
        let share_reached = u32::from(silent) * 100 >= u32::from(total) * u32::from(self.silent_share);
        // Of two half-dead buses the better one is kept; with everybody silent the search goes on.
        let promising = silent > self.left_behind || silent == total;
        (share_reached && promising).then_some(silent)
    }

    fn not_alone(&mut self, at: Instant) {
        self.alone_since = self.alone_since.map(|_| at);
    }

    /// ECSS 8.3.3b: the heartbeat stops on one bus and starts on the other at once.
    fn switch(&mut self, cause: SwitchCause, silent: u8, now: Instant) -> Action {
        let from = self.active;
        let to = from.other();
        let settling = self.parameters.settling_time();
        self.active = to;
        self.heartbeat.announce(now);
        self.announcing = true;
        self.peers.on_switch(now, settling.max(self.parameters.consumer));
        self.heard_here = false;
        self.guard = now + settling;
        self.alone_since = self.unacknowledged[to].then_some(now);
        self.left_behind = silent;
        Action::Switched { from, to, cause }
    }
}
