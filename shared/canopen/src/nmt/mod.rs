//! Network management of a node (CiA 301 7.2.8, 7.3.2).
//!
//! The *NMT state* of a node decides about its services: PDOs work only in Operational, SDOs also in
//! Pre-operational. The NMT master changes the state by *module control* commands. A node sends a *boot-up message*
//! when it leaves Initialising.
//!
//! ```
//! use async_canopen::nmt::{Command, NmtMessage, Target};
//! use async_canopen::nmt::machine::{NmtSlave, Reaction};
//! use async_canopen::types::{NmtState, NodeId};
//!
//! let mut slave = NmtSlave::new(false); // no autostart
//! assert_eq!(slave.boot(), NmtState::PreOperational);
//!
//! let frame = NmtMessage { command: Command::Start, target: Target::All }.encode(); // 000h, 01h 00h
//! let message = NmtMessage::decode(&frame).unwrap();
//! assert!(message.target.includes(NodeId::of::<3>()));
//! assert_eq!(slave.on_command(message.command), Reaction::Entered(NmtState::Operational));
//! ```
//!
//! | type | purpose |
//! | --- | --- |
//! | [`NmtSlave`] | state machine of a slave |
//! | [`NmtMessage`] | module control message |
//! | [`NmtStartup`], [`ErrorBehaviour`] | objects 1F80h and 1029h |
//! | [`ResetGuard`](machine::ResetGuard) | ignores a reset that is sent again and again |
//! | [`ClashWatch`](machine::ClashWatch), [`StateClashes`](machine::StateClashes) | detect two nodes with one Node-ID, in the node and in the master |
//!
//! # Limits
//!
//! - The module has the states of a node. The master starts its slaves by [`boot`](crate::boot).
//! - Error control is by [`heartbeat`](crate::heartbeat). There is no node guarding and no life guarding.

mod clash;
mod command;
mod error_behaviour;
pub mod machine;
mod objects;
mod reset_guard;
mod slave;
mod startup;
mod state_clash;

pub(crate) use clash::CROSSING;
pub use command::{Command, NmtMessage, Target};
pub use error_behaviour::ErrorBehaviour;
pub use objects::NmtObjects;
pub(crate) use slave::{NmtSlave, Reaction};
pub use startup::NmtStartup;
