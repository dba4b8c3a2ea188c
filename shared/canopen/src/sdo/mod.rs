//! Service data objects: server and client (CiA 301 7.2.4).
//!
//! By *SDO* a client reads (*upload*) or writes (*download*) one object of a server. An *expedited* transfer moves
//! up to 4 bytes at once, a *segmented* one 7 bytes in each confirmed frame, a *block* transfer up to 127 frames
//! for one confirmation. An *abort* ends a transfer with a code.
//!
//! ```
//! use async_canopen::sdo::Mode;
//! use async_canopen::sdo::machine::Client;
//! use async_canopen::types::{Address, Duration, Instant};
//!
//! let mut client = Client::new(Duration::from_millis(500));
//! client.start_upload(Address::new(0x1000, 0), 4, Mode::Segmented);
//!
//! let mut request = [0; 8];
//! client.poll(Instant::ZERO, &mut |payload| request = payload); // send it to 600h + Node-ID
//! assert_eq!(request, [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
//!
//! let response = [0x43, 0x00, 0x10, 0, 0x91, 0x01, 0x00, 0x00]; // of 580h + Node-ID
//! client.on_response(&response, Instant::ZERO, &mut |_| {});
//! let mut value = [0; 4];
//! client.pull(&mut value);
//! assert_eq!((client.outcome(), u32::from_le_bytes(value)), (Some(Ok(4)), 0x191));
//! ```
//!
//! [`Server`] answers requests by the trait [`ObjectAccess`](crate::od::ObjectAccess). Both take payloads and the
//! time, and return payloads. COB-IDs, buses and lifetimes belong to the node.
//!
//! # Limits
//!
//! - A [`Server`] has one channel, and a client one transfer at a time. A device with [`TwoSdoServers`] has a second server.
//! - A [`Server`] keeps at most 256 bytes of a value. A [`Client`] keeps one sub-block, which it may have to
//!   repeat.
//! - All calls of a server or client need `send` closures of the same type. Otherwise the compiler makes a copy of
//!   the code for each type.
//!
//! # Choices where CiA 301 is open
//!
//! - Reserved bits are ignored. An abort that belongs to no object names 0000h sub 0.
//! - In a sub-block every frame but an abort is a segment, even if it looks like a request. Therefore a download
//!   that fails in a sub-block is aborted at its end. Late segments of a transfer that was ended are ignored.
//! - A block download of an empty value is announced with size zero. Clients send one empty segment or none, and 7
//!   or 0 unused bytes at its end. The server accepts all four. The client of this crate
//!   sends one segment and 7 unused bytes.
//! - A sub-block that stops in the middle is acknowledged after a quarter of the timeout: its last segments are
//!   lost. A sub-block that does not begin is a timeout. After eight sub-blocks in a row without data the transfer
//!   is aborted (0504 0003h).
//! - A segment without data that is not the last one ends a transfer (0607 0013h). In a sub-block as many segments
//!   without effect may arrive as it has segments. Then it ends. So a peer without data blocks a transfer for at
//!   most the timeout.
//! - A frame of a block transfer that is received twice is ignored if it can be recognised. Otherwise checksum and
//!   size reveal it. Segments outside of blocks have a toggle bit; a repeated one is an error, and the transfer is
//!   aborted.
//! - The client of a block transfer always offers a checksum. The server offers one only to a client that does:
//!   some clients take an offer of the server for an agreement.
//! - The client ignores late answers of earlier transfers: each answer and each abort that names another object, and
//!   before the first answer of its transfer each frame that does not name its object. A first answer that names its
//!   object and has another command specifier than the request ends the transfer (0504 0001h).

mod block;
mod client;
mod crc;
pub mod machine;
mod objects;
mod second;
mod server;
mod servers;
pub(crate) mod sharing;
mod wire;

use crate::types::{AbortCode, Address};
pub(crate) use client::Client;
pub use client::{Error, Mode, STAGING};
pub use objects::{SdoParameters, SdoServerObjects};
pub use second::{SdoChannel, TwoSdoServers};
pub(crate) use server::Server;
pub use servers::SdoServers;
pub(crate) use wire::Payload;

/// Returns the payload that aborts the transfer of an object.
pub fn abort(at: Address, code: AbortCode) -> Payload {
    wire::abort(at, code.code())
}
