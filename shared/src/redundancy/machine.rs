//! Choice of the active bus by a master, its standby and a slave, as machines without input and output.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::babblers::Babblers;
pub use super::manager::{Action, Manager};
pub use super::master::{MasterAction, MasterRedundancy, MasterSetup, MasterVerdict, Sending};
pub use super::peers::{PeerHeartbeat, Peers};
pub use super::rescue::Rescue;
pub use super::rivals::Rivals;
pub use super::selector::{MasterMessage, Selection, Selector};
pub use super::slave::{Retained, SlaveAction, SlaveActions, SlaveRedundancy, SlaveStep, SlaveVerdict};
pub use super::standby::{Claim, RivalReaction, Standby};
