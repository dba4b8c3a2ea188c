//! Bus selection of a slave (ECSS 8.3.3).

use super::Parameters;
use super::hold_off::{Move, Rhythm, Work};
use crate::types::{Bus, Canonical, Duration, Instant, PerBus, earliest};

mod canonical;

/// An intruder that is heard more seldom than Ttoggle consumer times costs a heartbeat period each time, so
/// hold-offs get longer: up to 128 times that.
const MOST_DOUBLINGS: u8 = 7;

/// Selects the active bus of a slave.
///
/// A spacecraft has two buses, and exactly one of them is *active*: the one on which the master sends its
/// heartbeat. A slave is always in one of three phases:
///
/// - **following**: heartbeats arrive on the selected bus, which therefore is the active one;
/// - **searching**: a heartbeat was overdue. The slave listens on each bus for Ttoggle consumer times and changes
///   to the other one, at most Ntoggle times. Then it gives up and listens on its bus;
/// - **unconfirmed**: during a search a command was heard, but no heartbeat yet. A command alone may be a stray
///   frame. So the search continues where it stopped, unless a heartbeat follows within one consumer time.
///
/// Pass the messages of the master to the selector, and call [`Selector::poll`] at [`Selector::deadline`]. It
/// returns the [`Selection`] that the node has to carry out.
///
/// ```
/// use ecss_can::profile::Profile;
/// use ecss_can::redundancy::machine::{MasterMessage, Selection, Selector};
/// use ecss_can::types::{Bus, Duration, Instant};
///
/// let ms = |ms| Instant::ZERO + Duration::from_millis(ms);
/// let mut selector = Selector::new(Profile::DEFAULT.redundancy()); // consumer time 250 ms, Ttoggle 2
/// selector.start(ms(0));
/// selector.on_master(Bus::Nominal, MasterMessage::Heartbeat, ms(10));
/// assert_eq!(selector.poll(ms(260)), Some(Selection::Missed { bus: Bus::Nominal }));
/// assert_eq!(selector.poll(ms(510)), Some(Selection::Toggled { to: Bus::Redundant }));
/// ```
///
/// A slave with selective access passes on messages of the selected bus only. A slave with parallel access passes
/// on those of both buses. The selector treats both alike.
///
/// # Two masters at once
///
/// A forged or faulty frame can imitate the master on the other bus. The slave follows it, because it looks like a
/// real change of the bus. It returns as soon as the old bus contradicts it ([`Selection::Contradicted`]). Then it
/// does not move on a heartbeat alone for `Parameters::hold_off_time`, unless the selected bus is silent. Each
/// further move that is reverted doubles this time, to at most 128 times its length.
///
/// # Limits
///
/// With a consumer time, Ttoggle or Ntoggle of zero the slave does not change the bus by itself.
#[doc(alias("redundancy slave", "bus selection", "Ttoggle", "Ntoggle", "Bdefault"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[canonical(context = PerBus<u32>)] // as for `Selector::on_work`; the node counts from zero again
pub struct Selector {
    #[canonical(value = self.counting_parameters())]
    parameters: Parameters,
    selected: Bus,
    #[canonical(within = self.parameters)]
    phase: Phase,
    /// Heartbeats on the bus that is followed.
    rhythm: Rhythm,
    /// The last change of the bus by a heartbeat alone.
    #[canonical(value = self.moved.filter(|moved| moved.has_effect(now, &self.parameters)), within = self.parameters)]
    moved: Option<Move>,
    /// Bus on which the master works, while the buses contradict each other.
    // Longer than any patience: gaps of a bus that is followed are at most a consumer time.
    #[canonical(
        value = self.observed_work(*context, now),
        within = self.parameters.consumer.max(self.parameters.producer).times(2)
    )]
    work: Work,
    /// Heartbeats on both buses: no change until then, unless the bus that is followed is silent.
    #[canonical(due)]
    hold_off: Option<Instant>,
    /// Moves taken back since power-on: each but the first doubles the hold-off.
    taken_back: u8,
    /// Bdefault as it is kept beyond power-off.
    kept: Bus,
    /// Instant at which a new Bdefault may be kept, after a consumer time without contradiction, and that bus.
    #[canonical(due)]
    keep: Option<(Instant, Bus)>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[canonical(context = Parameters)]
enum Phase {
    /// The selected bus is the active one.
    Following {
        /// The last heartbeat.
        #[canonical(age = context.consumer)]
        last: Instant,
    },
    /// Found by a command alone: without a heartbeat until then the search goes on, as if it had not ended.
    Unconfirmed {
        #[canonical(due)]
        until: Instant,
        bdefault: Bus,
        #[canonical(within = *context)]
        search: Search,
    },
    /// Bus selection process.
    Searching(#[canonical(within = *context)] Search),
}

/// A search on a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[canonical(context = Parameters)]
struct Search {
    bus: Bus,
    /// On this bus since then. `None`: switching is disabled, or Ntoggle switches were in vain; it stays and listens.
    // A switch that is later than that does not count from its time.
    #[canonical(age = context.toggling_time().times(2))]
    since: Option<Instant>,
}

/// Message of the master. An "NMT message" of ECSS 8.3.3g is any of these without an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MasterMessage {
    /// Heartbeat or boot-up message of the master.
    Heartbeat,
    /// Module control command of the master, to any node.
    Command,
}

/// Decision of the selector, which the node carries out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Selection {
    /// The master is missed on the active bus: enter Pre-operational.
    Missed {
        /// Bus on which it was heard last.
        bus: Bus,
    },
    /// Change to the other bus in Pre-operational, and send the heartbeat there.
    Toggled {
        /// Bus that is selected now.
        to: Bus,
    },
    /// The search ended without the master: stay on the selected bus and listen.
    GaveUp {
        /// Bus on which the node stays.
        bus: Bus,
    },
    /// The master was found: the selected bus is the active one.
    Found {
        /// Bus that is active now.
        bus: Bus,
        /// `true`: the node changes the bus with this decision.
        moved: bool,
    },
    /// A heartbeat confirmed the bus that was found by a command alone.
    Confirmed,
    /// No heartbeat confirmed the bus that was found by a command alone: enter Pre-operational, and the search
    /// continues.
    Unconfirmed {
        /// Bus on which the search continues.
        bus: Bus,
        /// `true`: the node changes the bus with this decision.
        moved: bool,
    },
    /// The master changed to the other bus before it was missed: follow it at once.
    Followed {
        /// Bus that is active now.
        to: Bus,
    },
    /// The master is heard on both buses: stay, or return to the bus that was left.
    Contradicted {
        /// Bus that is active now.
        bus: Bus,
        /// `true`: the node returns to the bus that it left.
        moved: bool,
    },
    /// The master was heard on only one bus for Ttoggle consumer times.
    Undisputed,
    /// Nothing contradicted the new Bdefault for a consumer time: it may be kept beyond power-off.
    KeepBdefault {
        /// New value of Bdefault.
        bus: Bus,
    },
}

impl Selector {
    /// Makes a selector on the default bus with Ctoggle zero (ECSS 8.3.2a), idle until [`Selector::start`].
    pub const fn new(parameters: Parameters) -> Self {
        let bus = parameters.bdefault;
        Selector {
            selected: bus,
            parameters: Parameters { ctoggle: 0, ..parameters },
            phase: Phase::Searching(Search { bus, since: None }),
            rhythm: Rhythm::new(),
            moved: None,
            work: Work::new(),
            hold_off: None,
            taken_back: 0,
            kept: bus,
            keep: None,
        }
    }

    /// Returns the bus that the node considers active, or on which it searches.
    pub const fn selected(&self) -> Bus {
        self.selected
    }

    /// Notes that `bus` is kept beyond power-off, for example by "save". A Bdefault that was found before is not
    /// kept any more.
    pub(crate) fn set_kept(&mut self, bus: Bus) {
        (self.kept, self.keep) = (bus, None);
    }

    /// Returns whether a heartbeat of the master was heard on the selected bus and is not missed.
    pub const fn is_confirmed(&self) -> bool {
        matches!(self.phase, Phase::Following { .. })
    }

    /// Returns the parameters with the present Bdefault and Ctoggle.
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Takes new parameters. A search continues with them. It ends if they disable switching.
    pub fn configure(&mut self, parameters: Parameters) {
        self.parameters = parameters;
        if let Phase::Searching(search) | Phase::Unconfirmed { search, .. } = &mut self.phase
            && !parameters.toggling_enabled()
        {
            search.since = None;
        }
    }

    /// Takes parameters that differ from those in use, and brings instants that lie too far in the future back: in both cases a
    /// bit flipped. Returns whether a parameter differed.
    pub(crate) fn refresh(&mut self, written: Parameters, now: Instant) -> bool {
        let present = self.parameters;
        let latest = now + present.consumer;
        match &mut self.phase {
            Phase::Following { last } => last.confine(now),
            Phase::Unconfirmed { until, .. } => until.confine(latest),
            Phase::Searching(search) => search.since.iter_mut().for_each(|since| since.confine(now)),
        }
        self.keep.iter_mut().for_each(|(at, _)| at.confine(latest));
        let is_wrong = !written.agrees(&present);
        if is_wrong {
            self.configure(Parameters { bdefault: present.bdefault, ctoggle: present.ctoggle, ..written });
        }
        is_wrong
    }

    /// Starts the search on the selected bus, when Pre-operational was entered after power-on or "reset
    /// communication" (ECSS 8.3.2b). "Reset communication" keeps the bus. Only power-on selects Bdefault.
    pub fn start(&mut self, now: Instant) {
        self.search(now);
    }

    /// Starts a search on the bus that the application chose (ECSS 8.2.3a). Returns whether it is another bus.
    pub fn select(&mut self, bus: Bus, now: Instant) -> bool {
        let moved = bus != self.selected;
        self.selected = bus;
        self.search(now);
        moved
    }

    /// Takes the number of frames of the master's services (SYNC, SDO, PDO) received on each bus since power-on.
    /// They show where the master works.
    pub fn on_work(&mut self, frames: PerBus<u32>) {
        self.work.frames = frames;
    }

    /// Takes the heartbeat of nearly every call: on the selected bus, while it is followed. Returns whether it
    /// was such a heartbeat. If not, call [`Selector::on_master`]. Deadlines only become later.
    #[inline]
    pub(crate) fn on_beat(&mut self, bus: Bus, at: Instant) -> bool {
        match &mut self.phase {
            Phase::Following { last } if bus == self.selected => {
                self.rhythm.note(at.since(*last));
                *last = at;
                true
            }
            _ => false,
        }
    }

    /// Takes a message of the master on `bus` that ended at `at`.
    pub fn on_master(&mut self, bus: Bus, message: MasterMessage, at: Instant) -> Option<Selection> {
        let is_heartbeat = message == MasterMessage::Heartbeat;
        let is_here = bus == self.selected;
        if is_heartbeat && self.on_beat(bus, at) {
            return None;
        }
        match &mut self.phase {
            // Frames of two buses may be reported out of order.
            Phase::Following { last } if is_heartbeat && at >= *last => {
                let last = *last;
                self.on_other_bus(bus, at, last)
            }
            // ECSS 8.3.3g stands in the search: a command on the other bus moves no node that follows.
            Phase::Following { .. } => None,
            Phase::Unconfirmed { .. } if is_heartbeat => {
                self.follow(bus, bus, at);
                Some(if is_here { Selection::Confirmed } else { Selection::Found { bus, moved: true } })
            }
            Phase::Unconfirmed { .. } => None,
            Phase::Searching(search) => {
                let (search, bdefault, consumer) =
                    (*search, self.parameters.bdefault, self.parameters.consumer);
                self.follow(bus, bus, at);
                if !is_heartbeat && consumer > Duration::ZERO {
                    self.phase = Phase::Unconfirmed { until: at + consumer, bdefault, search };
                }
                Some(Selection::Found { bus, moved: !is_here })
            }
        }
    }

    /// A heartbeat on the other bus, while the last one on the selected bus was at `last`.
    fn on_other_bus(&mut self, bus: Bus, at: Instant, last: Instant) -> Option<Selection> {
        let parameters = self.parameters;
        let patience = self.rhythm.patience(&parameters);
        match self.moved {
            Some(mut moved) if moved.was_under_way(at) => {
                moved.last = at;
                self.moved = Some(moved);
                return None;
            }
            Some(moved) if moved.is_open(at, &parameters) && !self.work.is_only_on(self.selected) => {
                self.rhythm = moved.rhythm;
                self.rhythm.note(at.since(moved.last));
                self.follow(bus, moved.bdefault, at);
                self.taken_back = self.taken_back.saturating_add(1).min(MOST_DOUBLINGS + 1);
                self.hold_off(at);
                return Some(Selection::Contradicted { bus, moved: true });
            }
            _ => {}
        }
        let is_silent = at >= last + patience;
        if self.hold_off.is_some() || self.moved.is_some_and(|moved| moved.is_open(at, &parameters)) {
            if self.work.is_only_on(bus) {
                self.follow(bus, bus, at);
                self.hold_off(at);
                return Some(Selection::Followed { to: bus });
            }
            if !is_silent {
                self.work.renew(at, patience);
                self.hold_off(at);
                return Some(Selection::Contradicted { bus: self.selected, moved: false });
            }
        }
        let moved = Move { at, last, bdefault: parameters.bdefault, rhythm: self.rhythm };
        self.follow(bus, bus, at);
        self.moved = Some(moved);
        Some(Selection::Followed { to: bus })
    }

    /// A heartbeat of the master on `bus`, which is the active one now.
    fn follow(&mut self, bus: Bus, bdefault: Bus, at: Instant) {
        self.selected = bus;
        self.phase = Phase::Following { last: at };
        self.moved = None;
        self.work.restart(at);
        // ECSS 8.3.3k, l: whenever an active bus was found, also late.
        self.parameters.bdefault = bdefault;
        self.keep = (bdefault != self.kept).then_some((at + self.parameters.consumer, bdefault));
    }

    /// The master was heard on both buses.
    fn hold_off(&mut self, at: Instant) {
        self.hold_off =
            Some(at + self.parameters.hold_off_time().times(1 << self.taken_back.saturating_sub(1)));
        self.keep = self.keep.map(|(_, bus)| (at + self.parameters.consumer, bus));
    }

    /// Returns one decision that is due at `now`. Call it until `None`.
    pub fn poll(&mut self, now: Instant) -> Option<Selection> {
        if self.hold_off.is_some_and(|until| until <= now) {
            self.hold_off = None;
            return Some(Selection::Undisputed);
        }
        if self.phase_deadline().is_some_and(|deadline| deadline <= now) {
            return Some(self.go_on(now));
        }
        let (_, bus) = self.keep.take_if(|(at, _)| *at <= now)?;
        self.kept = bus;
        Some(Selection::KeepBdefault { bus })
    }

    /// The deadline of the phase has come.
    fn go_on(&mut self, now: Instant) -> Selection {
        match self.phase {
            Phase::Following { last } => {
                // The toggling time counts from the last heartbeat, not from the miss (ECSS 8.3.3e, Figure 8-2).
                self.search(last);
                Selection::Missed { bus: self.selected }
            }
            Phase::Unconfirmed { bdefault, search, .. } => {
                let moved = self.selected != search.bus;
                self.selected = search.bus;
                self.phase = Phase::Searching(search);
                (self.parameters.bdefault, self.keep) = (bdefault, None);
                Selection::Unconfirmed { bus: search.bus, moved }
            }
            Phase::Searching(search) => self.toggle(search, now),
        }
    }

    /// The toggling time on a bus is over (ECSS 8.3.3h, i, j).
    fn toggle(&mut self, search: Search, now: Instant) -> Selection {
        let Parameters { ctoggle, ntoggle, .. } = self.parameters;
        let bus = search.bus;
        if ctoggle >= ntoggle {
            self.phase = Phase::Searching(Search { bus, since: None });
            return Selection::GaveUp { bus };
        }
        // A toggling time that was shortened meanwhile may have passed several times: each bus is listened to.
        let toggling = self.parameters.toggling_time();
        let end = search.since.map_or(now, |since| since + toggling);
        let since = Some(if now < end + toggling { end } else { now });
        self.parameters.ctoggle = ctoggle.saturating_add(1);
        self.selected = bus.other();
        self.phase = Phase::Searching(Search { bus: self.selected, since });
        Selection::Toggled { to: self.selected }
    }

    /// Returns when to call [`Selector::poll`] next.
    pub fn deadline(&self) -> Option<Instant> {
        earliest(&[self.phase_deadline(), self.hold_off, self.keep.map(|(at, _)| at)])
    }

    fn phase_deadline(&self) -> Option<Instant> {
        let Parameters { consumer, .. } = self.parameters;
        match self.phase {
            Phase::Following { last } => (consumer > Duration::ZERO).then_some(last + consumer),
            Phase::Unconfirmed { until, .. } => Some(until),
            Phase::Searching(Search { since, .. }) => {
                since.map(|since| since + self.parameters.toggling_time())
            }
        }
    }

    /// Searches on the selected bus, which was listened to since `since`. Ctoggle keeps the count of the last
    /// search until then, so that the master can read it (ECSS Table 8-1).
    fn search(&mut self, since: Instant) {
        self.parameters.ctoggle = 0;
        (self.moved, self.keep) = (None, None);
        let since = self.parameters.toggling_enabled().then_some(since);
        self.phase = Phase::Searching(Search { bus: self.selected, since });
    }
}
