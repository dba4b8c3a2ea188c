//! Service data objects: server and client (CiA 301 7.2.4, ECSS 6.1).
//!
//! Both speak every protocol of CiA 301: expedited, segmented, and block with sub-blocks that are repeated where frames
//! were lost. They are given payloads and the time and hand out payloads: COB-IDs, buses and lifetimes are the node's.
//! Neither keeps more of a value than it must: a [`Server`] 64 bytes, a [`Client`] one sub-block, because that is what it
//! may have to repeat.
//!
//! Pass `send` closures of one type to all calls of a server or client, else the compiler makes a copy of the code for
//! each type.

mod block;
mod client;
mod crc;
mod server;
mod wire;

pub use block::WINDOW;
pub use client::{Client, Error, Mode, STAGING};
pub use crc::Crc;
pub use server::{Server, WHOLE};
pub use wire::Payload;
