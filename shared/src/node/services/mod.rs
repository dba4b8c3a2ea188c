//! What the services of a node of a spacecraft do beyond those of CANopen.

mod live;
mod over_budget;
mod post_mortem;
mod redundancy;
mod time;

pub use live::{LiveServices, State};
pub use over_budget::BudgetServices;
pub use post_mortem::PostMortemServices;
pub use redundancy::RedundancyServices;
pub use time::{MappedTime, TimeServices, carries_time, check_submilliseconds};

use super::Spacecraft;
use async_canopen::node::extend;

/// Services of a node of a spacecraft.
pub type Services<D> = extend::Services<D, Spacecraft>;
