//! Nodes in virtual time: with servers of others, and flights of host worlds that take minutes.

mod jolts;
mod sdo_blocks;
