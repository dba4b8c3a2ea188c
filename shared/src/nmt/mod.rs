//! Network management: node identifiers, states, module control (CiA 301 7.2.8, 7.3.2).

mod command;
mod node_id;
mod slave;
mod state;

pub use command::{Command, NmtMessage, Target};
pub use node_id::NodeId;
pub use slave::{NmtSlave, Reaction};
pub use state::NmtState;
