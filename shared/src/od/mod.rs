//! Object dictionary: what a node holds under index and sub-index (CiA 301 7.4).

mod abort;
mod access;

pub use abort::AbortCode;
pub use access::{Address, ObjectAccess, Transfer};

/// COB-ID of the SYNC object, u32. Producer bit is bit 30.
pub const SYNC_COB_ID: u16 = 0x1005;
/// Communication cycle period, u32 in microseconds: period of the SYNC producer.
pub const SYNC_PERIOD: u16 = 0x1006;
/// Consumer heartbeat time, sub 1..: node << 16 | milliseconds.
pub const CONSUMER_HEARTBEAT: u16 = 0x1016;
/// Producer heartbeat time, u16 in milliseconds.
pub const PRODUCER_HEARTBEAT: u16 = 0x1017;
/// Redundancy: sub 1 Bdefault, 2 Ttoggle, 3 Ntoggle, 4 Ctoggle, all u8.
pub const REDUNDANCY: u16 = 0x2000;
/// Local SCET Set, 7 octets.
pub const LOCAL_SCET_SET: u16 = 0x2010;
/// Local SCET Get, 7 octets.
pub const LOCAL_SCET_GET: u16 = 0x2011;
/// Health of the nominal bus.
pub const HEALTH_NOMINAL: u16 = 0x2020;
/// Health of the redundant bus.
pub const HEALTH_REDUNDANT: u16 = 0x2021;
/// Telemetry: sub 1 code u16, sub 2 data of 6 octets.
pub const TELEMETRY: u16 = 0x6100;
/// Telecommand: sub 1 code u16, sub 2 data of 6 octets.
pub const TELECOMMAND: u16 = 0x6200;
