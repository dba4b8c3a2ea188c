//! Process data objects.

mod mapping;
mod message;
mod parameters;
mod receive;
pub mod rules;
mod sequence;
mod transmit;

pub use mapping::{Direction, Layout};
pub use message::Message;
pub use parameters::{MAPPED, Mapping, PdoMapping, RpdoParameters, StaticMapping, TpdoParameters};
pub use receive::{RpdoError, RpdoEvent, Rpdos, Taken};
pub use sequence::{RepeatFilter, Sequence};
pub use transmit::Tpdos;
