//! Process data objects: declaration, mapping, reception, transmission (CiA 301 7.2.2).
//!
//! A *PDO* is a message with up to 8 bytes of values, without confirmation. A node receives *RPDOs* and transmits
//! *TPDOs*. The *mapping* of a PDO is the list of its values. The *transmission type* decides when a PDO is sent
//! and takes effect: 0 to 240 with SYNC, 254 and 255 on events.
//!
//! The PDOs that a device has at power-on are a [`PdoSet`], a constant. It is built from the constants that the
//! derive macro makes of each field (`Thermometer::TEMPERATURE`), so that no index, sub-index or number of bits is
//! written twice. An impossible set does not compile. The reasons are:
//!
//! - a value that is not for PDOs, or not for this direction;
//! - more than 64 bits or 8 values;
//! - a PDO number, transmission type or COB-ID that is not allowed;
//! - two PDOs with one number.
//!
//! [`PdoSet::assert_within`] checks the set against the objects of the node.
//!
//! ```
//! use async_canopen::emcy::EmcyObjects;
//! use async_canopen::od::{Objects, Record};
//! use async_canopen::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, Rpdo, Tpdo};
//! use async_canopen::types::NodeId;
//!
//! /// A thermometer.
//! #[derive(Objects)]
//! struct Thermometer {
//!     /// Temperature
//!     #[object(0x6000, ro, pdo)]
//!     temperature: i16,
//!     /// Mode
//!     #[object(0x6001, record)]
//!     mode: Mode,
//! }
//!
//! #[derive(Record)]
//! struct Mode {
//!     /// Rate
//!     #[sub(1, rww, pdo)]
//!     rate: u8,
//!     /// Range
//!     #[sub(2, rww, pdo)]
//!     range: u8,
//! }
//!
//! const PDOS: PdoSet = PdoSet::new(
//!     &[
//!         // The same for all nodes.
//!         Pdo::<()>::new(CobIdOf::fixed(0x200)).map(Thermometer::MODE.field(Mode::RATE)).receive(1),
//!         Pdo::<()>::new(CobIdOf::node(0x300)).map(Thermometer::MODE.field(Mode::RATE)).map(Thermometer::MODE.field(Mode::RANGE)).receive(2),
//!     ],
//!     // With every SYNC, beside the error register.
//!     &[Pdo::<()>::new(CobIdOf::node(0x280)).map(Thermometer::TEMPERATURE).map(EmcyObjects::REGISTER).transmit(2).transmission(1)],
//! );
//!
//! let objects: PdoObjects<4, 4> = PDOS.at_power_on(NodeId::of::<5>());
//! assert_eq!(objects.tpdos[1].cob_id, 0x4000_0285);
//! assert_eq!(objects.tpdo_mappings[1].objects[..2], [0x6000_0010, 0x1001_0008]);
//! ```
//!
//! The temperature is read only. A receive PDO that carries it is refused with "object 6000h sub-index 0 is `ro`: a
//! receive PDO carries `wo`, `rw` and `rww`":
//!
//! ```compile_fail,E0080
//! # use async_canopen::od::Objects;
//! # use async_canopen::pdo::{CobIdOf, Pdo, Rpdo};
//! # /// A thermometer.
//! # #[derive(Objects)]
//! # struct Thermometer {
//! #     /// Temperature
//! #     #[object(0x6000, ro, pdo)]
//! #     temperature: i16,
//! # }
//! const WRONG: Rpdo = Pdo::<()>::new(CobIdOf::node(0x200)).map(Thermometer::TEMPERATURE).receive(1);
//! ```
//!
//! | type | purpose |
//! | --- | --- |
//! | [`PdoSet`], [`Rpdo`], [`Tpdo`], [`CobIdOf`] | declaration of the PDOs at power-on |
//! | [`PdoValues`](trait@PdoValues) | values of a PDO: a tuple, or a struct with names |
//! | [`PdoObjects`] | objects 1400h, 1600h, 1800h, 1A00h |
//! | [`Rpdos`], [`Tpdos`] | PDOs at run time |
//! | [`rules`](machine::rules) | rules for writing these objects by SDO |
//! | [`Sequence`], [`RepeatFilter`] | commands that must not be executed twice |
//!
//! # Limits
//!
//! - A device has at most 512 PDOs in each direction. A PDO carries at most 8 values.
//! - There are no remote requests: transmission types 252 and 253 are refused.
//! - CAN may deliver a PDO twice. A command needs a [`Sequence`].

mod carried;
mod cob_id_of;
pub mod machine;
mod mapping;
mod named;
mod objects;
mod parameters;
mod planned;
mod receive;
mod received;
mod rpdo_error;
pub(crate) mod rules;
mod sequence;
mod set;
mod transmit;
mod values;

/// # Example
///
/// ```
/// use async_canopen::prelude::*;
///
/// /// A heater.
/// #[derive(Objects)]
/// struct Heater {
///     /// Temperature
///     #[object(0x6000, ro, pdo)]
///     temperature: i16,
///     /// Power
///     #[object(0x6001, ro, pdo)]
///     power: u8,
/// }
///
/// /// Values of [`CHANGE`].
/// #[derive(Clone, Copy, Debug, PartialEq, PdoValues)]
/// struct Change {
///     /// Temperature, 0.1 °C.
///     temperature: i16,
///     /// Power, percent.
///     power: u8,
/// }
///
/// /// Change of a value: 280h + node.
/// const CHANGE: Pdo<Heater, Change> =
///     Pdo::new(CobIdOf::node(0x280)).map(Heater::TEMPERATURE).map(Heater::POWER).into_struct();
///
/// const HEATER: NodeId = NodeId::of::<5>();
/// let frame = CHANGE.of(HEATER).frame(Change { temperature: 400, power: 100 });
/// assert_eq!(frame.data(), [0x90, 0x01, 100]);
///
/// /// PDOs of another node: it receives the changes of the heater.
/// const PDOS: PdoSet = PdoSet::new(&[CHANGE.of(HEATER).receive(1)], &[]);
/// # let pdo = ReceivedPdo::new(&PDOS, 0, Bus::Nominal, [0x90, 0x01, 100, 0, 0, 0, 0, 0], Instant::ZERO);
/// if let Some(change) = pdo.get(CHANGE.of(HEATER)) {
///     assert_eq!((change.temperature, change.power), (400, 100));
/// }
/// ```
pub use async_canopen_derive::PdoValues;
pub use cob_id_of::CobIdOf;
pub use mapping::{Direction, Layout};
pub use named::{NodePdo, Pdo, Received};
pub use objects::{PdoObjects, PdoSlots};
pub(crate) use parameters::MAPPED;
pub use parameters::{Mapping, PdoMapping, PdoParameters, RpdoParameters, StaticMapping};
pub use planned::{Rpdo, Tpdo};
pub(crate) use receive::{Rpdos, Taken};
pub use received::{ReceivedPdo, SetRpdo};
pub use rpdo_error::{RpdoError, RpdoEvent};
pub use sequence::{RepeatFilter, Sequence};
pub use set::PdoSet;
pub(crate) use transmit::Tpdos;
pub use values::{Append, PdoValues};
