//! Nodes in virtual time: with servers of others, and flights of host worlds that take minutes.

mod double_resets;
mod events;
mod jolts;
mod sdo_blocks;
