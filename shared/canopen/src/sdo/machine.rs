//! SDO server and client, as machines without input and output.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::block::WINDOW;
pub use super::client::Client;
pub use super::crc::Crc;
pub use super::server::Server;
pub use super::wire::Payload;
