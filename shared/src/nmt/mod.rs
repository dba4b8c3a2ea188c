//! Network management: node identifiers, states, module control (CiA 301 7.2.8, 7.3.2).

mod node_id;

pub use node_id::NodeId;
