//! Network management: node identifiers, states, module control (CiA 301 7.2.8, 7.3.2), boot-up of the network
//! (CiA 302-2).

mod clash;
mod command;
mod error_behaviour;
mod objects;
mod reset_guard;
mod slave;
mod startup;
mod state_clash;

pub use clash::{Clash, ClashWatch};
pub use command::{Command, NmtMessage, Target};
pub use error_behaviour::ErrorBehaviour;
pub use objects::NmtObjects;
pub use reset_guard::{ResetGuard, ResetVerdict};
pub use slave::{NmtSlave, Reaction};
pub use startup::NmtStartup;
pub use state_clash::{Judged, StateClashes};
