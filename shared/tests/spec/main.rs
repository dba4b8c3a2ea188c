//! The protocol core against the texts of ECSS-E-ST-50-15C and CiA 301.
//!
//! Sans-IO: every test makes its own time. Tests that verify a requirement name it.

mod bench;
mod bit_timing;
mod boot;
mod bus_off;
mod canopen_slave;
mod clash;
mod clock;
mod cob_id;
mod console;
mod contradictions;
mod counted;
mod device;
mod discipline;
mod emcy;
mod fleet;
mod heartbeat;
mod identify;
mod instrument;
mod link;
mod manager;
mod master;
mod master_deadline;
mod master_device;
mod master_pdos;
mod master_services;
mod nmt;
mod od;
mod pdo;
mod profiles;
mod queue;
mod random;
mod reset_guard;
mod retained;
mod scet;
mod sdo;
mod selector;
mod slave;
mod slave_bus;
mod standby;
mod store;
mod sync;
mod time;
mod trial;
mod utc;
