//! Emergencies: producer, message, error register, history (CiA 301 7.2.7; objects 1001h, 1003h, 1014h,
//! 1015h).
//!
//! An *emergency* (EMCY) reports that an error appeared or is gone. An error has a *code* and a *source*: the first
//! byte of the manufacturer-specific field. Two nodes that are missed have the same code, and their Node-IDs as
//! sources.
//!
//! ```
//! use async_canopen::emcy::machine::{Config, Producer};
//! use async_canopen::emcy::{Emergency, ErrorCode};
//! use async_canopen::types::{Duration, Instant, NmtState};
//!
//! let mut producer = Producer::new(Config::new(0x083, 1_000)); // 1014h; 1015h: 100 ms between two messages
//! assert!(producer.raise(ErrorCode::TEMPERATURE_DEVICE, [1, 0, 0, 0, 0])); // source 1
//! assert!(!producer.raise(ErrorCode::TEMPERATURE_DEVICE, [1, 0, 0, 0, 0])); // active already
//!
//! let frame = producer.poll(Instant::ZERO, NmtState::Operational).unwrap();
//! let (node, emergency) = Emergency::decode(&frame).unwrap();
//! assert_eq!((node.get(), emergency.code.get()), (3, 0x4200));
//! producer.on_end(&frame, true, Instant::ZERO); // a node acknowledged it
//!
//! assert!(producer.clear(ErrorCode::TEMPERATURE_DEVICE, 1));
//! assert_eq!(producer.register().bits(), 0);
//! let frame = producer.poll(Instant::ZERO + Duration::from_millis(100), NmtState::Operational).unwrap();
//! assert_eq!(Emergency::decode(&frame).unwrap().1.ended(), Some((ErrorCode::TEMPERATURE_DEVICE, 1)));
//! ```
//!
//! | type | purpose |
//! | --- | --- |
//! | [`Producer`] | errors of a node, and the messages that report them |
//! | [`DeviceError`] | error code and source of an error that an application reports |
//! | [`Emergency`] | message: error code, error register, five bytes of the manufacturer |
//! | [`ActiveErrors`] | objects 2048h and 2049h: the active errors of the other nodes, as a master knows them |
//! | [`ErrorReader`] | what a master reads of the errors that it may not have heard |
//! | [`EmcyConsumers`](machine::EmcyConsumers) | object 1028h: the nodes whose emergencies a master consumes |
//!
//! # Limits
//!
//! - A producer has room for 16 errors that are active or whose end waits, and for 8 errors in its history.
//! - A master keeps at most 64 active errors of other nodes. More are counted.
//! - The end of an error is not reported if its beginning was not: "no error" would then seem to mean another
//!   error.

mod active;
mod announced;
mod code;
mod config;
mod consumers;
mod device_error;
mod history;
pub mod machine;
mod message;
mod objects;
mod producer;
mod reader;
mod register;

pub use active::ActiveError;
pub(crate) use active::ActiveErrors;
pub use code::ErrorCode;
pub(crate) use config::Config;
pub use device_error::DeviceError;
pub(crate) use history::History;
pub use message::Emergency;
pub use objects::{EmcyObjects, ErrorField};
pub(crate) use producer::Producer;
pub(crate) use reader::ErrorReader;
pub use register::ErrorRegister;
