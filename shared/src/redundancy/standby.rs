//! Role of a master board: active, or standby of another board (ECSS 8.1a, Figure 4-2).
//!
//! Both boards are node 1 and run the same program. A strap numbers them. Each board listens first, without a
//! dominant bit. The board that hears no master becomes active.
//!
//! The claims of the two boards have different COB-IDs. Equal frames that begin together are one frame on the wire,
//! and neither sender hears the other. Frames with two COB-IDs never merge.

use crate::types::{Bus, Canonical, CobId, Duration, Flag, Frame, Instant};

/// A claim that went out so lately is still on its way: no other one follows. Bounds what a babbling node can provoke.
const CLAIM_PAUSE: Duration = Duration::from_millis(10);

/// Number of a master board, set by its strap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Strap {
    /// Board that becomes active if both get power together, and stays active at a tie.
    Prime,
    /// The other board.
    Second,
}

/// Parameters of a mission with two master boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pair {
    /// Silence of the active master on both buses after which the standby takes over.
    pub consumer: Duration,
    /// Time that the prime board listens after power-on.
    pub prime_listens: Duration,
    /// Time that the second board listens after power-on, longer than that of the prime board.
    pub second_listens: Duration,
    /// COB-ID of the claims of the prime board.
    pub prime_claims: CobId,
    /// COB-ID of the claims of the second board. It must differ: two nodes that send one COB-ID with different
    /// data destroy each other's frames.
    pub second_claims: CobId,
}

impl Pair {
    /// Returns the time that a board listens after power-on.
    pub(crate) const fn listens(&self, strap: Strap) -> Duration {
        match strap {
            Strap::Prime => self.prime_listens,
            Strap::Second => self.second_listens,
        }
    }

    /// Returns the COB-ID of the claims of a board.
    pub(crate) const fn claims(&self, strap: Strap) -> CobId {
        match strap {
            Strap::Prime => self.prime_claims,
            Strap::Second => self.second_claims,
        }
    }

    /// Returns the COB-IDs of the claims of both boards.
    pub const fn both_claims(&self) -> [CobId; 2] {
        [self.prime_claims, self.second_claims]
    }

    /// Decodes a claim. `None` for another frame and for a malformed one.
    pub fn claim(&self, frame: &Frame) -> Option<Claim> {
        let strap =
            [Strap::Prime, Strap::Second].into_iter().find(|strap| self.claims(*strap) == frame.id())?;
        match frame.data() {
            [slaves, number] if *number == strap as u8 => Some(Claim { slaves: *slaves, strap }),
            _ => None,
        }
    }

    /// Makes the frame of a claim: number of slaves, then 0 from the prime board, 1 from the second one.
    pub fn frame(&self, claim: Claim) -> Frame {
        Frame::of(self.claims(claim.strap), [claim.slaves, claim.strap as u8])
    }
}

/// Claim of an active master. Of two masters, the one that hears more slaves stays active; at a tie the prime
/// board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Claim {
    /// Number of slaves that count and are heard on the active bus.
    pub slaves: u8,
    /// Board that sends the claim.
    pub strap: Strap,
}

impl Claim {
    /// Returns whether the sender of `other` has to yield to this claim. Two claims with equal straps and equal
    /// numbers of slaves do not outrank each other: both senders stay active.
    pub(crate) const fn outranks(&self, other: &Claim) -> bool {
        let is_prime = matches!(self.strap, Strap::Prime);
        let is_tie = self.slaves == other.slaves;
        self.slaves > other.slaves || is_tie && is_prime && matches!(other.strap, Strap::Second)
    }
}

/// Role of a master board. Object 2045h has its byte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Role {
    /// Listens after power-on, and is silent.
    Listening,
    /// Hears the active master, and is silent.
    Standby,
    /// Manages the network.
    #[default]
    Active,
}

/// Reason for a change of the role.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RoleCause {
    /// Active: no master was heard after power-on.
    Alone,
    /// Standby: another master is active.
    MasterHeard,
    /// Active: the other master was silent on both buses for the consumer time.
    MasterSilent,
    /// Standby: another active master hears more slaves, or the same number and is the prime board.
    Yielded,
    /// Standby: the application commanded it.
    Commanded,
}

/// Change of the role of a master board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RoleChange {
    /// Role from now on.
    pub role: Role,
    /// Reason for the change.
    pub cause: RoleCause,
}

/// Reaction to a frame of another master.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RivalReaction {
    /// Nothing to do.
    Nothing,
    /// The role of this board changed.
    Changed(RoleChange),
    /// Send this claim on the bus on which the other master was heard.
    Claim(Claim),
}

/// State machine for the role of a master board.
///
/// Of two master boards one is *active*: it manages the network. The other one is the *standby*: it sends no
/// dominant bit, and takes over when the active board is silent on both buses. The active board sends a [`Claim`]
/// on both buses with each heartbeat, so that two active boards hear each other within a heartbeat period.
///
/// ```
/// use ecss_can::profile::Profile;
/// use ecss_can::redundancy::machine::{RivalReaction, Standby};
/// use ecss_can::redundancy::{Role, RoleCause, RoleChange, Strap};
/// use ecss_can::types::{Bus, Duration, Instant};
///
/// let ms = |ms| Instant::ZERO + Duration::from_millis(ms);
/// let mut second = Standby::new(Profile::PAIR, Strap::Second);
/// second.start(ms(0)); // listens
/// let heard = RoleChange { role: Role::Standby, cause: RoleCause::MasterHeard };
/// assert_eq!(second.on_master(Bus::Nominal, ms(700)), RivalReaction::Changed(heard));
///
/// let silent = RoleChange { role: Role::Active, cause: RoleCause::MasterSilent };
/// assert_eq!(second.poll(ms(1_099)), None);
/// assert_eq!(second.poll(ms(1_100)), Some(silent)); // after its consumer time, 400 ms
/// ```
///
/// # Limits
///
/// - Two boards with equal straps that hear the same number of slaves both stay active: neither claim outranks the other.
/// - 701h of a foreign node does not make an active board yield. Only a claim does.
#[doc(alias("standby master", "Figure 4-2"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct Standby {
    pair: Pair,
    strap: Strap,
    role: Role,
    /// Instant at which it becomes active, unless it hears a master before.
    #[canonical(value = self.deadline().unwrap_or(Instant::NEVER), due)]
    until: Instant,
    /// Bus on which another master was heard last.
    heard: Option<Bus>,
    /// It was active once because it heard no master after power-on.
    has_begun: Flag,
    /// The last claim that it made since it became active.
    said: Option<Claim>,
    #[canonical(value = self.present(now), within = self.pair.consumer)]
    encounter: Option<Encounter>,
    /// Most slaves that the active master claimed since this board is not active.
    claimed: u8,
}

/// The claim of another active master is heard. Both compare the same two claims, so that one of them yields and
/// not both: hence the own one stays as it was said before, until none was heard for the consumer time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[canonical(context = Duration)] // the consumer time
struct Encounter {
    own: Claim,
    /// The last claim of the other one.
    #[canonical(age = *context)]
    last: Instant,
    /// Nothing is sent before.
    #[canonical(due)]
    pause: Instant,
}

impl Standby {
    /// Makes the role of a board that listens from [`Standby::start`] on.
    pub const fn new(pair: Pair, strap: Strap) -> Standby {
        Standby {
            pair,
            strap,
            role: Role::Listening,
            until: Instant::NEVER,
            heard: None,
            has_begun: Flag::of(false),
            said: None,
            encounter: None,
            claimed: 0,
        }
    }

    /// Takes power-on at `now`.
    pub fn start(&mut self, now: Instant) {
        self.until = now + self.pair.listens(self.strap);
    }

    /// Takes the numbers of this board, and brings an instant that lies too far in the future back: a bit flipped.
    pub(crate) fn refresh(&mut self, (pair, strap): (Pair, Strap), now: Instant) {
        (self.pair, self.strap) = (pair, strap);
        self.until = self.until.min(now + pair.consumer.max(pair.listens(strap)));
    }

    /// Returns the parameters of the mission.
    pub const fn pair(&self) -> &Pair {
        &self.pair
    }

    /// Returns the number of this board.
    pub(crate) const fn strap(&self) -> Strap {
        self.strap
    }

    /// Returns the present role.
    pub const fn role(&self) -> Role {
        self.role
    }

    /// Returns whether this board manages the network.
    pub const fn is_active(&self) -> bool {
        matches!(self.role, Role::Active)
    }

    /// Returns whether the clock of this board is that of the network from the beginning: no other master was
    /// there when it first became active. Otherwise slaves have the time of another board.
    pub(crate) const fn has_begun(&self) -> bool {
        self.has_begun.is_set()
    }

    /// Returns the bus on which another master was heard last. `None` before the first time.
    pub const fn heard(&self) -> Option<Bus> {
        self.heard
    }

    /// Takes a heartbeat or boot-up message of another master. An active master only notes the bus: 701h may come
    /// from a foreign node, and only a claim shows that the other board is active.
    pub fn on_master(&mut self, bus: Bus, at: Instant) -> RivalReaction {
        self.heard = Some(bus);
        if self.is_active() { RivalReaction::Nothing } else { self.alive(at) }
    }

    /// Takes a SYNC or a spacecraft time of another master. `slaves`: number of slaves that count and are heard on
    /// the active bus.
    ///
    /// The frame is a sign of life only if no slave is heard. Without slaves no node acknowledges, and a frame that
    /// wins arbitration against the heartbeat is repeated in its place. With slaves the heartbeat is sent, and such
    /// a frame without it comes from another node.
    pub(crate) fn on_other_frame(&mut self, bus: Bus, at: Instant, slaves: u8) -> RivalReaction {
        if self.is_active() || slaves > 0 {
            return RivalReaction::Nothing;
        }
        self.heard = Some(bus);
        self.alive(at)
    }

    /// Another master is active.
    fn alive(&mut self, at: Instant) -> RivalReaction {
        if self.role == Role::Listening {
            return RivalReaction::Changed(self.stand_by(at, RoleCause::MasterHeard));
        }
        self.until = at + self.pair.consumer;
        RivalReaction::Nothing
    }

    /// Returns the largest number of slaves that the active master claimed.
    pub const fn claimed(&self) -> u8 {
        self.claimed
    }

    /// Takes a claim of another active master. `slaves`: number of slaves that count and are heard on the active
    /// bus.
    pub fn on_claim(&mut self, bus: Bus, claim: &Claim, at: Instant, slaves: u8) -> RivalReaction {
        if !self.is_active() {
            self.claimed = self.claimed.max(claim.slaves);
            // Its heartbeat may be on the other bus.
            self.heard.get_or_insert(bus);
            return self.alive(at);
        }
        let said = self.said.unwrap_or(Claim { slaves, strap: self.strap });
        let mut encounter = self.present(at).unwrap_or(Encounter { own: said, last: at, pause: at });
        encounter.last = at;
        let is_due = encounter.pause <= at;
        if is_due {
            encounter.pause = at + CLAIM_PAUSE;
        }
        self.encounter = Some(encounter);
        if claim.outranks(&encounter.own) {
            return RivalReaction::Changed(self.stand_by(at, RoleCause::Yielded));
        }
        // Two boards strapped alike at a tie would answer each other for ever.
        if is_due && encounter.own.strap != claim.strap {
            RivalReaction::Claim(encounter.own)
        } else {
            RivalReaction::Nothing
        }
    }

    /// Returns the claim to send on both buses with a heartbeat. `None` while this board is not active.
    ///
    /// A standby that is cut off from the active bus hears the claim on the other one. Without the claim it would
    /// take over and yield again and again.
    pub fn call(&mut self, now: Instant, slaves: u8) -> Option<Claim> {
        let fresh = Claim { slaves, strap: self.strap };
        let claim = self.present(now).map_or(fresh, |encounter| encounter.own);
        self.said = self.is_active().then_some(claim);
        self.said
    }

    fn present(&self, now: Instant) -> Option<Encounter> {
        self.encounter.filter(|encounter| now < encounter.last + self.pair.consumer)
    }

    /// Stops being active. The board takes over again if no other master is heard for the consumer time.
    pub fn stand_by(&mut self, now: Instant, cause: RoleCause) -> RoleChange {
        (self.role, self.until) = (Role::Standby, now + self.pair.consumer);
        (self.said, self.encounter) = (None, None);
        self.claimed = 0;
        RoleChange { role: self.role, cause }
    }

    /// Becomes active when it is due, on the bus where a master was [heard](Standby::heard) last.
    pub fn poll(&mut self, now: Instant) -> Option<RoleChange> {
        if self.deadline().is_none_or(|due| now < due) {
            return None;
        }
        let is_first = self.role == Role::Listening;
        if is_first {
            self.has_begun = Flag::of(true);
        }
        let cause = if is_first { RoleCause::Alone } else { RoleCause::MasterSilent };
        self.role = Role::Active;
        Some(RoleChange { role: self.role, cause })
    }

    /// Returns when to call [`Standby::poll`] next.
    pub fn deadline(&self) -> Option<Instant> {
        (!self.is_active()).then_some(self.until)
    }
}
