//! Words of the field, without behaviour of a service: frames and identifiers, buses, instants, spacecraft time.
//!
//! The ground floor: every other module may name these, and these name no other.

mod abort;
mod address;
mod bus;
mod cob_id;
mod fine;
mod frame;
mod instant;
mod nmt_state;
mod node_id;
mod periodic;
#[cfg(feature = "model")]
mod rebase;
mod scet;
mod utc;

pub use abort::AbortCode;
pub use address::Address;
pub use bus::{Bus, PerBus};
pub use cob_id::CobId;
pub use fine::{FineInstant, FineScet};
pub use frame::{Frame, FrameError};
pub use instant::{Duration, Instant, earliest};
pub use nmt_state::NmtState;
pub use node_id::NodeId;
pub use periodic::Periodic;
#[cfg(feature = "model")]
pub use rebase::Rebase;
pub use scet::Scet;
pub use utc::{Utc, UtcRelation};
