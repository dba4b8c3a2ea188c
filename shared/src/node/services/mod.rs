//! What the services of a node of a spacecraft do beyond those of CANopen.

mod live;
mod mapped;
mod spacecraft;
mod state;
mod time;
mod upsets;

pub use live::LiveServices;
pub use mapped::{MappedTime, carries_time};
pub use spacecraft::SpacecraftServices;
pub use state::State;
pub use time::{TimeServices, check_submilliseconds};
pub use upsets::UpsetServices;

use async_canopen::node::extend;

use super::Spacecraft;

/// Services of a node of a spacecraft.
pub type Services<D> = extend::Services<D, Spacecraft>;
