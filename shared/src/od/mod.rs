//! Object dictionary: what a node holds under index and sub-index (CiA 301 7.4).
//!
//! A device is declared once, as a struct: its fields are the values, typed, and belong to the node. `#[derive(Objects)]`
//! makes of it what SDO and PDO need (index and sub-index, types, access rights, limits) and what EDS and DCF tell. The
//! first line of a field's documentation is its name there.
//!
//! ```
//! use ecss_can::od::{Domain, Objects, Record, U24};
//!
//! /// A star tracker.
//! #[derive(Objects)]
//! struct StarTracker {
//!     /// Exposure time
//!     #[object(0x6000, rw, low = 1, high = 500)]
//!     exposure_ms: u16,
//!     /// Attitude
//!     #[object(0x6010, record)]
//!     attitude: Attitude,
//!     /// Temperatures
//!     #[object(0x6020, array, ro, pdo)]
//!     temperatures: [i16; 4],
//! }
//!
//! #[derive(Record)]
//! struct Attitude {
//!     /// Right ascension
//!     #[sub(1, ro, pdo)]
//!     right_ascension: U24,
//!     /// Declination
//!     #[sub(2, ro, pdo)]
//!     declination: U24,
//! }
//! ```

mod abort;
mod access;
pub mod checked;
pub mod communication;
mod data_type;
mod dictionary;
mod domain;
mod numbers;
mod object;
pub mod spacecraft;
mod texts;
mod times;
mod variable;

pub use abort::AbortCode;
pub use access::{Address, ObjectAccess, Transfer};
pub use data_type::DataType;
pub use dictionary::{Objects, Place, Record, among};
pub use domain::Domain;
pub use ecss_can_derive::{Objects, Record};
pub use numbers::{I24, I40, I48, I56, Signed, U24, U40, U48, U56, Unsigned};
pub use object::{Access, Entry, Limits, Names, Object, ObjectCode};
pub use texts::{OctetString, UnicodeString, VisibleString};
pub use times::{TimeDifference, TimeOfDay};
pub use variable::{Typed, Variable};

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
