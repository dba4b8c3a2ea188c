//! Process data objects.

mod mapping;
mod message;
mod receive;
pub mod rules;
mod transmit;

pub use mapping::{Direction, Layout};
pub use message::Message;
pub use receive::{RpdoError, RpdoEvent, Rpdos, Taken};
pub use transmit::Tpdos;
