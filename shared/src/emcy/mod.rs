//! Emergency object: producer, messages, error register, history (CiA 301 7.2.7, ECSS 6.4).

mod code;
mod consumers;
mod history;
mod message;
mod objects;
mod post_mortem;
mod producer;
mod register;

pub use code::ErrorCode;
pub use consumers::EmcyConsumers;
pub use history::History;
pub use message::Emergency;
pub use objects::{EmcyObjects, ErrorField};
pub use post_mortem::{PostMortem, PostMortemObjects};
pub use producer::{Config, Producer};
pub use register::ErrorRegister;
