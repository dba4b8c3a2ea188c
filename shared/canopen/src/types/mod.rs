//! Words of the field that all modules use: frames and identifiers, buses, instants.
//!
//! A *frame* is a message on a CAN bus, and its identifier is a *COB-ID*. An [`Instant`] is a time of one node:
//! microseconds since its power-on.
//!
//! ```
//! use async_canopen::types::{CobId, Duration, Frame, Instant, NmtState, NodeId};
//!
//! const SLAVE: NodeId = NodeId::of::<3>();
//! let heartbeat = Frame::of(CobId::heartbeat(SLAVE), [NmtState::Operational.byte()]);
//! assert_eq!((heartbeat.id().raw(), heartbeat.data()), (0x703, &[0x05][..]));
//! assert_eq!(heartbeat.id().node(), Some(SLAVE));
//!
//! let deadline = Instant::ZERO + Duration::from_millis(250);
//! assert_eq!(deadline.since(Instant::from_micros(50_000)).as_millis(), 200);
//! ```
//!
//! # Limits
//!
//! - A frame has an 11-bit identifier and at most 8 data bytes. Remote and extended frames cannot be expressed.
//! - Arithmetic with instants saturates.
//! - The module has no behaviour of a service, and uses no other module.

mod abort;
mod address;
mod bus;
mod canonical;
mod cob_id;
mod ecc;
mod fine;
mod flag;
mod frame;
mod instant;
mod instants;
mod majority;
mod nmt_state;
mod node_id;
mod periodic;
mod sealed;

pub use abort::AbortCode;
pub use address::Address;
pub use bus::{Bus, PerBus};
pub use canonical::Canonical;
pub use cob_id::CobId;
pub use ecc::{Ecc, Uncorrectable};
pub use fine::FineInstant;
pub use flag::Flag;
pub use frame::{Frame, FrameError};
pub use instant::{Duration, Instant, earliest};
pub use instants::Instants;
pub use majority::correct;
pub use nmt_state::NmtState;
pub use node_id::{IsNodeId, NodeId, RawNodeId};
pub use periodic::Periodic;
pub use sealed::Sealed;
