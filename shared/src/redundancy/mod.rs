//! Redundancy management: the choice of the active bus (ECSS 8).
//!
//! A spacecraft has two buses, and exactly one of them is *active*: the one on which the master sends its
//! heartbeat. A node with *parallel access* is on both buses all the time. A node with *selective access* is on one
//! bus at a time. A slave that misses the master *searches*: it changes the bus every *Ttoggle* consumer times, at
//! most *Ntoggle* times.
//!
//! | type | decides |
//! | --- | --- |
//! | [`MasterRedundancy`] | what a master does: it joins [`Manager`] and [`Standby`] with what the node reports |
//! | [`Manager`] | which bus the master makes active, and when it changes |
//! | [`Selector`] | which bus a slave considers active |
//! | [`SlaveRedundancy`] | all of a slave: its bus, its NMT state, which resets it obeys |
//! | [`Standby`] | which of two master boards is active |
//! | [`Babblers`] | what the master does against a slave that sends too many frames |
//! | [`Peers`] | which nodes count as slaves, and which of them are lost or silent |
//!
//! ```
//! use ecss_can::redundancy::Parameters;
//! use ecss_can::types::{Bus, Duration};
//!
//! let parameters = Parameters {
//!     consumer: Duration::from_millis(250), // 1016h
//!     producer: Duration::from_millis(100), // 1017h
//!     bdefault: Bus::Nominal,               // 2000h sub 1
//!     ttoggle: 2,                           // 2000h sub 2
//!     ntoggle: 50,                          // 2000h sub 3
//!     ctoggle: 0,                           // 2000h sub 4
//! };
//! assert_eq!(parameters.toggling_time().as_millis(), 500); // on one bus
//! assert_eq!(parameters.search_time().as_millis(), 25_500); // until the slave gives up
//! ```
//!
//! All types are pure state machines: they take facts and the time, and return decisions. Equal states are equal
//! and have equal hashes, so that a model checker can visit them all.
//!
//! # Limits
//!
//! - A slave follows a forged heartbeat on the other bus, and returns when the old bus contradicts it (EMCY 8150h).
//! - Two nodes that send the heartbeat of the master on one bus look like one to a slave.
//! - A slave with selective access that gave up its search on a dead bus stays there (ECSS 8.3.3j). The profile
//!   checks that a search is long enough:
//!   [`is_search_long_enough`](crate::profile::Profile::is_search_long_enough).

mod babblers;
mod hold_off;
pub mod machine;
mod manager;
mod master;
mod objects;
mod peers;
mod rescue;
mod rivals;
mod selector;
mod slave;
mod slave_search;
mod standby;
mod trial;

pub(crate) use babblers::Babblers;
pub use babblers::BabblingStep;
pub use manager::SwitchCause;
pub(crate) use manager::{Action, Manager};
pub(crate) use master::{MasterAction, MasterRedundancy, MasterSetup, MasterVerdict, Sending};
pub use master::{MasterBoards, OneBoard, TwoBoards};
pub use objects::{Redundancy, RedundancyObjects};
pub(crate) use peers::{PeerHeartbeat, Peers};
pub(crate) use rescue::Rescue;
pub(crate) use rivals::Rivals;
pub(crate) use selector::{MasterMessage, Selection, Selector};
pub use slave::BusCause;
pub(crate) use slave::{Retained, SlaveAction, SlaveRedundancy, SlaveStep, SlaveVerdict};
pub(crate) use standby::{Claim, RivalReaction, Standby};
pub use standby::{Pair, Role, RoleCause, RoleChange, Strap};

use crate::heartbeat::HeartbeatTimes;
use crate::types::{Bus, Canonical, Duration};

/// Parameters of the bus redundancy management of a node (ECSS Tables 8-1 and 8-2).
#[doc(alias("2000h", "Bdefault", "Ttoggle", "Ntoggle", "Ctoggle"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Consumer heartbeat time (1016h). Zero: no monitoring.
    pub consumer: Duration,
    /// Producer heartbeat time (1017h). Zero: no heartbeat.
    pub producer: Duration,
    /// Bus that is active after power-on or hardware reset: Bdefault (2000h sub 1).
    pub bdefault: Bus,
    /// Number of consumer times to listen on a bus before switching: Ttoggle (2000h sub 2). Zero: no toggling.
    pub ttoggle: u8,
    /// Number of switches before the search ends: Ntoggle (2000h sub 3). Zero: no toggling.
    pub ntoggle: u8,
    /// Number of switches so far in this search: Ctoggle (2000h sub 4).
    pub ctoggle: u8,
}

impl Parameters {
    /// Ntoggle of a master that goes on changing the bus until it hears a slave.
    pub const NO_LIMIT: u8 = 255;

    /// Returns the times of heartbeats among them.
    pub(crate) const fn heartbeats(&self) -> HeartbeatTimes {
        HeartbeatTimes { consumer: self.consumer, producer: self.producer }
    }

    /// Returns whether the parameters are the same, apart from those that a node changes itself: Bdefault and Ctoggle.
    pub(crate) fn agrees(&self, other: &Parameters) -> bool {
        let fixed = |all: &Parameters| (all.consumer, all.producer, all.ttoggle, all.ntoggle);
        fixed(self) == fixed(other)
    }

    /// Returns the time that a slave listens on one bus: Ttoggle consumer times.
    pub const fn toggling_time(&self) -> Duration {
        self.consumer.times(self.ttoggle as u32)
    }

    /// Returns the time that a contradiction counts: Ttoggle consumer times, but at least one consumer time and
    /// two heartbeats.
    pub(crate) fn hold_off_time(&self) -> Duration {
        self.toggling_time().max(self.consumer).max(self.producer.times(2))
    }

    /// Returns the time after a switch of the master within which every reachable slave is heard on the new bus.
    pub fn settling_time(&self) -> Duration {
        self.toggling_time() + self.producer.times(2)
    }

    /// Returns the time that a master stays on a bus while it hears no slave on either, at least `shortest`.
    /// Slaves that search reach the bus within it.
    pub const fn dwell(&self, shortest: Duration) -> Duration {
        let search = self.toggling_time().times(2).as_micros() + self.producer.times(2).as_micros();
        if search > shortest.as_micros() { Duration::from_micros(search) } else { shortest }
    }

    /// Returns the time that a slave searches before it gives up: on each bus in turn, Ntoggle times and once
    /// more.
    pub const fn search_time(&self) -> Duration {
        self.toggling_time().times(self.ntoggle as u32 + 1)
    }

    /// Returns the time that a slave must be silent on the active bus and heard on the other one before the
    /// master tries that one. Within it, a slave that was reset on the other bus returns. A slave that searches
    /// is still there.
    pub fn hold_time(&self) -> Duration {
        let stay = self.toggling_time().as_micros().saturating_sub(self.producer.as_micros());
        Duration::from_micros(stay).max(self.consumer)
    }

    /// Returns the time without 701h of another node after which its collision with the master's is over.
    pub(crate) fn quiet_time(&self) -> Duration {
        self.toggling_time().max(self.consumer).max(self.producer.times(2))
    }

    /// Returns whether a slave may change the bus by itself.
    pub(crate) const fn toggling_enabled(&self) -> bool {
        self.toggling_time().as_micros() > 0 && self.ntoggle > 0
    }
}
