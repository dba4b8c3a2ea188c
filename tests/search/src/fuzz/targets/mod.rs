//! The targets.

mod device;
pub mod nmt;
mod node;
pub mod pdo_mapping;
mod pdo_reference;
pub mod sdo_client;
mod sdo_objects;
pub mod sdo_server;
pub mod slave;
