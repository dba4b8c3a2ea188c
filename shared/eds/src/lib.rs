//! EDS and DCF (CiA 306) of an object dictionary declared in Rust.
//!
//! An electronic data sheet (EDS) tells tools what a type of device holds; a device configuration file (DCF) tells the same
//! of one device, with its Node-ID and the values it has. Both come from the declaration itself ([`Objects::describe`]) and
//! from freshly made dictionaries: what is a default here is what the device has after power-on.
//!
//! ```
//! use ecss_can::types::NodeId;
//! use ecss_can::node::Communication;
//! use ecss_can_eds::{Commissioning, Description, Device, Timestamp};
//!
//! let device = Device {
//!     vendor: "Somebody".into(),
//!     product: "Star tracker".into(),
//!     bit_rates: vec![1000],
//!     boot_up_slave: true,
//!     ..Device::new(Timestamp { year: 2026, month: 1, day: 31, hour: 12, minute: 0 })
//! };
//! let description = Description::new(&device, Communication::new)?;
//! assert!(description.eds("tracker.eds").contains("DefaultValue=$NODEID+0x80"));
//!
//! let node = NodeId::of::<3>();
//! let mut configured = Communication::new(node);
//! configured.heartbeat.time = 100;
//! let dcf = description.dcf("tracker-3.dcf", "tracker.eds", &Commissioning::new(node), &mut configured)?;
//! assert!(dcf.contains("ParameterValue=0x0064"));
//! # Ok::<(), ecss_can_eds::Error>(())
//! ```
//!
//! [`DataSheet`] reads the files of other tools.
//!
//! The files are written so that the readers at hand agree on what it means:
//!
//! * Unsigned numbers are hexadecimal, signed ones decimal: some readers take FFh for 255 whatever the type.
//! * REALs are decimal, as most readers want them; zero is `0`, which those of bit patterns read as well.
//! * Strings stand as they are, without quotation marks; OCTET_STRINGs have two hexadecimal digits a byte.
//! * Zero of an integer of 24, 40, 48 or 56 bits and an empty UNICODE_STRING have no default: some readers do not know the
//!   types, and refuse the file for the default alone.
//! * A value that follows the Node-ID is `$NODEID+0x...`, the formula first, also with high bits set in it.
//! * A value that follows the Node-ID in another way has no default in an EDS, but its value in each DCF.
//! * What cannot be read (write-only, an error that has not occurred), blocks of bytes (DOMAIN) and times (TIME_OF_DAY,
//!   TIME_DIFFERENCE) have no default either. There is never an empty number.
//! * An object of code DOMAIN is written as a VAR of type DOMAIN: some readers do not know the code.
//! * CiA 306 has no keyword for the capacity of a string, the names of an enumeration, and what "save" (1010h) keeps: they stand in
//!   `[Comments]`. The limits of an enumeration are its least and its greatest number.
//! * `ParameterValue` stands where a DCF differs from the default and nowhere else: tools write what they find there into
//!   the device, and 1010h or the mapping of a valid PDO do not take their own value back.
//!
//! Related crates: [`ecss-can`](https://docs.rs/ecss-can), [`async-canopen`](https://docs.rs/async-canopen),
//! [`async-canopen-eds`](https://docs.rs/async-canopen-eds), [`ecss-can-cli`](https://docs.rs/ecss-can-cli).

#![forbid(unsafe_code)]

mod description;
mod device;
mod dictionary;
mod file;
pub mod network;
mod notes;
pub mod pdos;
mod program;
mod value;

pub use async_canopen_eds::{DataSheet, Entry, Unreadable, Value};
pub use description::Description;
pub use device::{BIT_RATES, Commissioning, Device, Timestamp};
pub use program::{canopen_program, master_program, program, slave_program};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

#[cfg(doc)]
use ecss_can::od::Objects;
use ecss_can::types::AbortCode;

/// Why a dictionary cannot be described.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Two objects of a dictionary have one index.
    #[error("{index:04X}h is declared twice")]
    Twice {
        /// The index.
        index: u16,
    },
    /// A declared value does not exist.
    #[error("{index:04X}h sub {sub} is declared and cannot be found ({code:?})")]
    Missing {
        /// The index.
        index: u16,
        /// The sub-index.
        sub: u8,
        /// What an SDO would answer.
        code: AbortCode,
    },
    /// A text has what readers of such files cannot take.
    #[error("`{text}` cannot stand in an EDS: at most {max} printable ASCII characters, no ';', '#' or backslash, no blank at an end, no quotation mark first", max = file::LINE)]
    Text {
        /// The text.
        text: String,
    },
    /// A device has a further bit rate without all those of the standard.
    #[error(
        "bit rate {rate} kbit/s is for devices with 125, 250 and 500 kbit/s (ECSS 5.4.2b): name all in `bit_rates`"
    )]
    BitRate {
        /// The further bit rate, kbit/s.
        rate: u16,
    },
}
