//! Process data objects.

mod message;

pub use message::Message;
