//! Process data objects: mapping, reception, transmission, and what an SDO may change of them.

mod device;
mod mapping;
mod optional;
mod receive;
mod rules;
mod sequence;
mod transmit;
