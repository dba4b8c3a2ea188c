//! Process data objects.

mod cob_id_of;
mod mapping;
mod message;
mod parameters;
mod planned;
mod receive;
pub mod rules;
mod sequence;
mod set;
mod transmit;

pub use cob_id_of::CobIdOf;
pub use mapping::{Direction, Layout};
pub use message::Message;
pub use parameters::{MAPPED, Mapping, PdoMapping, RpdoParameters, StaticMapping, TpdoParameters};
pub use planned::{Rpdo, Tpdo};
pub use receive::{RpdoError, RpdoEvent, Rpdos, Taken};
pub use sequence::{RepeatFilter, Sequence};
pub use set::PdoSet;
pub use transmit::Tpdos;
