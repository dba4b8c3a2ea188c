//! The services of CANopen against the texts of CiA 301, CiA 302-2 and ECSS-E-ST-50-15C.
//!
//! Sans-IO: every test makes its own time. Tests that verify a requirement name it.

mod active_errors;
mod adapter;
mod bench;
mod bit_timing;
mod boot;
mod boot_cob_ids;
mod boot_running;
mod canonical;
mod cob_id;
mod emcy;
mod enumeration;
mod error_history;
mod error_reader;
mod heartbeat;
mod link;
mod nmt;
mod od;
mod one_controller;
mod pdo;
mod queue;
mod random;
mod refused;
mod reset_guard;
mod sdo;
mod stamp;
mod store;
mod sync;
