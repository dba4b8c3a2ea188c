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
mod run;
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
pub use object::{Access, Entry, Limits, Names, Object, ObjectCode, sub_indices};
pub use run::Run;
pub use texts::{OctetString, UnicodeString, VisibleString};
pub use times::{TimeDifference, TimeOfDay};
pub use variable::{Typed, Variable};
