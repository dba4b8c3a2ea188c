//! Service data objects: server and client (CiA 301 7.2.4, ECSS 6.1).
//!
//! Both speak every protocol of CiA 301: expedited, segmented, and block with sub-blocks that are repeated where frames
//! were lost. They are given payloads and the time and hand out payloads: COB-IDs, buses and lifetimes are the node's.
//! Neither keeps more of a value than it must: a [`Server`] 256 bytes, a [`Client`] one sub-block, because that is what it
//! may have to repeat.
//!
//! Where CiA 301 leaves room:
//!
//! * Reserved bits are not looked at. An abort that belongs to no object names 0000h sub 0.
//! * In a sub-block everything but an abort is a segment, also what looks like a request. So a download that fails in a
//!   sub-block is refused at its end, and segments that are late for a transfer that was ended are ignored, not obeyed.
//! * The block download of an empty value, announced with size zero, has one empty segment or none, and 7 or 0 unused bytes
//!   at its end: clients do all four. Our client sends one segment and 7.
//! * A sub-block that stops in the middle is acknowledged after a quarter of the timeout: its last segments are lost. One
//!   that does not begin is a timeout. After eight in a row that bring nothing the transfer is aborted (0504 0003h).
//! * A segment without data that is not the last one ends a transfer (0607 0013h). In a sub-block as many segments as it has
//!   may come that do not count, then it ends. A peer that brings nothing keeps nobody waiting longer than the timeout.
//! * Frames of block transfers that are received twice are ignored where that can be told; where it cannot, the checksum
//!   and the size tell. Segments outside of blocks have their toggle bit and are aborted.
//! * The client of a block transfer always offers a checksum, the server only to a client that does: there are clients that
//!   take the server's offer for an agreement.
//! * Aborts of another object than that of the transfer are late and are ignored by the client.
//!
//! Pass `send` closures of one type to all calls of a server or client, else the compiler makes a copy of the code for
//! each type.

mod block;
mod client;
mod crc;
mod objects;
mod server;
mod wire;

use crate::types::{AbortCode, Address};
pub use block::WINDOW;
pub use client::{Client, Error, Mode, STAGING};
pub use crc::Crc;
pub use objects::{SdoParameters, SdoServerObjects};
pub use server::Server;
pub use wire::Payload;

/// The frame that aborts a transfer.
pub(crate) fn abort(at: Address, code: AbortCode) -> Payload {
    wire::abort(at, code.code())
}
