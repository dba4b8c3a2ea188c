//! Process data objects: mapping, sets in constants, reception, transmission, and what an SDO may change of them.

pub mod device;
mod mapping;
mod optional;
mod receive;
mod rules;
mod sequence;
mod set;
mod transmit;
