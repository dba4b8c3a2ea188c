//! Access of a server to a dictionary, use of a COB-ID by a service, and reasons of checks at compile time.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::access::{ObjectAccess, Transfer, WHOLE};
pub use super::cob_id_entry::EntryUse;
pub use super::reason::Reason;
