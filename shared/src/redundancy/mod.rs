//! Redundancy management: which of the two buses is the active one (ECSS 8).
//!
//! The master decides by where it sends its heartbeat ([`Manager`]); slaves follow ([`Selector`]). Of two master
//! boards one is active ([`Standby`]). All are pure: facts and the time in, decisions out, equal states compare and
//! hash equal.

mod babblers;
#[cfg(feature = "model")]
mod broken;
mod bus_off;
mod dwell;
mod hold_off;
mod manager;
mod objects;
mod peers;
mod rivals;
mod selector;
mod standby;
mod trial;

pub use babblers::{Babblers, BabblingStep};
#[cfg(feature = "model")]
pub use broken::Broken;
pub use bus_off::{BusOffPolicy, BusOffRecovery, RecoveryStep};
pub use manager::{Action, Manager, SwitchCause};
pub use objects::{Redundancy, RedundancyObjects};
pub use peers::{PeerHeartbeat, Peers};
pub use rivals::Rivals;
pub use selector::{MasterMessage, Selection, Selector};
pub use standby::{Answer, Claim, Pair, Role, RoleCause, RoleChange, Standby, Strap};

use crate::types::{Bus, Duration};

/// Access of a node to its two buses (ECSS 8.2).
#[doc(alias("parallel access", "selective access"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusAccess {
    /// Two controllers, each on its bus all the time.
    #[default]
    Parallel,
    /// On one bus at a time. The node is silent on the other one.
    Selective,
}

/// Parameters of the bus redundancy management of a node (ECSS Tables 8-1 and 8-2).
#[doc(alias("2000h", "Bdefault", "Ttoggle", "Ntoggle", "Ctoggle"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
    /// Returns the time that a slave listens on one bus: Ttoggle consumer times.
    pub const fn toggling_time(&self) -> Duration {
        self.consumer.times(self.ttoggle as u32)
    }

    /// Returns the time that a contradiction counts: Ttoggle consumer times, but at least one consumer time and
    /// two heartbeats.
    pub fn hold_off_time(&self) -> Duration {
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
    pub fn quiet_time(&self) -> Duration {
        self.toggling_time().max(self.consumer).max(self.producer.times(2))
    }

    /// Returns whether a slave may change the bus by itself.
    pub const fn toggling_enabled(&self) -> bool {
        self.toggling_time().as_micros() > 0 && self.ntoggle > 0
    }
}
