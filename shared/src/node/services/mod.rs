//! What the services of a node of a spacecraft do beyond those of CANopen.

mod live;
mod mapped;
mod over_budget;
mod post_mortem;
mod redundancy;
mod state;
mod time;

pub use live::LiveServices;
pub use mapped::{MappedTime, carries_time};
pub use over_budget::BudgetServices;
pub use post_mortem::PostMortemServices;
pub use redundancy::RedundancyServices;
pub use state::State;
pub use time::{TimeServices, check_submilliseconds};

use async_canopen::node::extend;

use super::Spacecraft;

/// Services of a node of a spacecraft.
pub type Services<D> = extend::Services<D, Spacecraft>;
