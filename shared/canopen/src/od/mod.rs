//! Object dictionary: the values of a node under index and sub-index (CiA 301 7.4).
//!
//! An *object* is a value, an array or a record with an *index*. A *sub-index* selects a value of an array or
//! record. A device is declared once, as a struct. Its fields are the values, and belong to the node.
//! `#[derive(Objects)]` makes from it all that SDO and PDO need: index and sub-index, types, access rights, limits.
//! The same declaration gives EDS and DCF; there the name of an object is the first line of its documentation. A
//! function of the device checks a value beyond type and limits.
//!
//! ```
//! use async_canopen::od::{Field, NotWritable, Objects, Readable, Record, U24, checked};
//! use async_canopen::types::{AbortCode, Address};
//!
//! /// A star tracker.
//! #[derive(Objects)]
//! #[objects(check = StarTracker::may_write)]
//! struct StarTracker {
//!     /// Exposure time
//!     #[object(0x6000, rw, low = 1, high = 500, default = 100)]
//!     exposure_ms: u16,
//!     /// Frame period
//!     #[object(0x6001, rw, low = 100, default = 200)]
//!     period_ms: u16,
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
//!
//! impl StarTracker {
//!     /// An exposure ends before the next one begins.
//!     fn may_write(&self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
//!         const EXPOSURE: Address = StarTracker::EXPOSURE_MS.address();
//!         const PERIOD: Address = StarTracker::PERIOD_MS.address();
//!         let (exposure, period) = match (at, value) {
//!             (EXPOSURE, &[low, high]) => (u16::from_le_bytes([low, high]), self.period_ms),
//!             (PERIOD, &[low, high]) => (self.exposure_ms, u16::from_le_bytes([low, high])),
//!             _ => return Ok(()),
//!         };
//!         if exposure < period { Ok(()) } else { Err(AbortCode::ParameterIncompatible) }
//!     }
//! }
//!
//! let mut tracker = StarTracker::default();
//! let exposure = StarTracker::EXPOSURE_MS.address();
//! assert_eq!(checked::write(&mut tracker, exposure, &[199, 0]), Ok(()));
//! assert_eq!(checked::write(&mut tracker, exposure, &[200, 0]), Err(AbortCode::ParameterIncompatible));
//! assert_eq!(tracker.exposure_ms, 199);
//!
//! // Constants of each field, of records and of arrays.
//! assert_eq!(StarTracker::ATTITUDE.field(Attitude::DECLINATION).address(), Address::new(0x6010, 2));
//! assert_eq!(StarTracker::TEMPERATURES.sub(4).address(), Address::new(0x6020, 4));
//! // They have the type and the access right of the value: an SDO client writes no string to a number.
//! const EXPOSURE: Field<u16> = StarTracker::EXPOSURE_MS;
//! const FOURTH: Field<i16, Readable, NotWritable> = StarTracker::TEMPERATURES.sub(4);
//! ```
//!
//! Two fields with one index do not compile, even in different groups (`#[objects]`) or consecutive objects
//! (`#[object(0x6000.., record)]`). Neither do limits that exclude each other or that the type cannot reach, nor a
//! `default` outside its limits. A field without attribute is an error; `#[skip]` hides it from clients. The
//! documentation of the derive macro [`Objects`] lists all attributes.
//!
//! # Limits
//!
//! - A client writes at most [`WHOLE`] bytes of a string. A DOMAIN moves in parts, and takes any length up to its capacity.
//! - A PDO carries neither a string nor a DOMAIN.
//! - The check of a device sees one value at a time.

mod access;
pub mod checked;
mod cob_id_entry;
pub(crate) mod copies;
mod data_type;
mod declared;
mod dictionary;
mod domain;
mod field;
mod initial;
mod limits;
pub mod machine;
mod named_value;
mod numbers;
mod object;
mod reason;
mod run;
mod texts;
mod times;
mod typed;
mod variable;

pub(crate) use access::{ObjectAccess, Transfer, WHOLE};
/// # Example
///
/// ```
/// use async_canopen::od::checked;
/// use async_canopen::prelude::*;
///
/// /// How the heater works.
/// #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
/// #[repr(u8)]
/// enum Mode {
///     /// The heater is off.
///     #[default]
///     Off,
///     /// The heater holds the set point.
///     Auto,
///     /// The heater has full power.
///     Boost = 8,
/// }
///
/// /// A heater.
/// #[derive(Objects)]
/// struct Heater {
///     /// Mode
///     #[object(0x6301, rw, default = Mode::Auto)]
///     mode: Mode,
/// }
///
/// let mut heater = Heater::default();
/// let mode = Heater::MODE.address();
/// assert_eq!(heater.mode, Mode::Auto);
/// assert_eq!(checked::write(&mut heater, mode, &[8]), Ok(()));
/// assert_eq!(checked::write(&mut heater, mode, &[7]), Err(AbortCode::ValueRange));
/// assert_eq!(heater.mode, Mode::Boost);
/// ```
pub use async_canopen_derive::Enumeration;
/// # Example
///
/// ```
/// use async_canopen::od::{Field, NotWritable, Readable, eds};
/// use async_canopen::pdo::{Pdo, PdoSet};
/// use async_canopen::types::{Address, NodeId};
///
/// eds! {
///     /// Valve of another maker.
///     pub struct Valve = "tests/eds/valve.eds";
/// }
///
/// const OPENING: Field<u8> = Valve::WANTED_OPENING;
/// const POWER: Field<u8, Readable, NotWritable> = Valve::MOTOR_POWER;
/// const CHANGE: Pdo<Valve, (u8, i16)> = Valve::TPDO_1;
///
/// const VALVE: NodeId = NodeId::of::<9>();
/// /// PDOs of a master: it receives the changes of the valve. It sends by `send_to(VALVE, Valve::RPDO_1, (60,))`.
/// const PDOS: PdoSet = PdoSet::new(&[Valve::TPDO_1.of(VALVE).receive(1)], &[]);
///
/// assert_eq!(Valve::MOTOR_POWER.address(), Address::new(0x6001, 1));
/// assert_eq!(CHANGE.of(VALVE).cob_id().raw(), 0x189);
/// ```
pub use async_canopen_derive::eds;
pub use async_canopen_derive::{Objects, Record};
pub(crate) use cob_id_entry::EntryUse;
pub use cob_id_entry::{CobIdEntry, INVALID, NO_REMOTE};
pub use data_type::DataType;
pub use declared::{Declared, assert_entries};
pub use dictionary::{Objects, Place, Record};
pub use domain::Domain;
pub use field::{Field, Fields, SubIndex};
pub use initial::{Initial, NoNumbers, Numbers, Unwritten};
pub use limits::Limits;
pub use named_value::NamedValue;
pub use numbers::{I24, I40, I48, I56, Signed, U24, U40, U48, U56, Unsigned};
pub use object::{Access, Entry, Names, Object, ObjectCode, PdoUse, sub_indices};
pub(crate) use reason::Reason;
pub use run::Run;
pub use texts::{OctetString, UnicodeString, VisibleString};
pub use times::{TimeDifference, TimeOfDay};
pub use typed::{NotReadable, NotWritable, Number, Readable, Right, Untyped, Writable};
pub use variable::{Bytes, Typed, Variable, number};
