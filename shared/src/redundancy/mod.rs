//! Redundancy management: which of the two buses is the active one (ECSS 8).
//!
//! The master decides by where it sends its heartbeat ([`Manager`]); slaves follow ([`Selector`]). Of two master boards one is
//! active ([`Standby`]). All are pure: facts and the time in, decisions out, equal states compare and hash equal.

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

/// How a node reaches its two buses (ECSS 8.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusAccess {
    /// Two controllers, both on their bus all the time.
    #[default]
    Parallel,
    /// On one bus at a time; off the other, silent.
    Selective,
}

/// Bus redundancy management parameters of a node (ECSS Tables 8-1 and 8-2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Consumer heartbeat time (1016h). Zero: no monitoring.
    pub consumer: Duration,
    /// Producer heartbeat time (1017h). Zero: no heartbeat.
    pub producer: Duration,
    /// Bdefault (2000h sub 1): the active bus after power-on or hardware reset.
    pub bdefault: Bus,
    /// Ttoggle (2000h sub 2): consumer times to listen on a bus before switching. Zero: no toggling.
    pub ttoggle: u8,
    /// Ntoggle (2000h sub 3): bus switches before giving up. Zero: no toggling.
    pub ntoggle: u8,
    /// Ctoggle (2000h sub 4): switches done so far in this search.
    pub ctoggle: u8,
}

impl Parameters {
    /// How long a slave listens on one bus: Ttoggle consumer times.
    pub const fn toggling_time(&self) -> Duration {
        self.consumer.times(self.ttoggle as u32)
    }

    /// How long a contradiction counts: Ttoggle consumer times, a consumer time and two heartbeats at least.
    pub fn hold_off_time(&self) -> Duration {
        self.toggling_time().max(self.consumer).max(self.producer.times(2))
    }

    /// How long after a switch of the master every reachable slave has been heard on the new bus, at the latest.
    pub fn settling_time(&self) -> Duration {
        self.toggling_time() + self.producer.times(2)
    }

    /// How long a master stays on a bus while it hears no slave on either: slaves that search come there meanwhile.
    /// At least `shortest`.
    pub const fn dwell(&self, shortest: Duration) -> Duration {
        let search = self.toggling_time().times(2).as_micros() + self.producer.times(2).as_micros();
        if search > shortest.as_micros() { Duration::from_micros(search) } else { shortest }
    }

    /// How long a slave listens in vain before it gives up: on each bus in turn, Ntoggle times and once more.
    pub const fn search_time(&self) -> Duration {
        self.toggling_time().times(self.ntoggle as u32 + 1)
    }

    /// How long a slave must be silent on the active bus and heard on the other one before the master tries that. A slave
    /// that was reset on the other bus is back by then, and one that searches is still there.
    pub fn hold_time(&self) -> Duration {
        let stay = self.toggling_time().as_micros().saturating_sub(self.producer.as_micros());
        Duration::from_micros(stay).max(self.consumer)
    }

    /// How long 701h of another node must be absent before its collision with the master's is over.
    pub fn quiet_time(&self) -> Duration {
        self.toggling_time().max(self.consumer).max(self.producer.times(2))
    }

    /// Whether a slave may change the bus by itself.
    pub const fn toggling_enabled(&self) -> bool {
        self.toggling_time().as_micros() > 0 && self.ntoggle > 0
    }
}
