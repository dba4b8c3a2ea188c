//! Registers in use that are compared with what they have to be, and mended.
//!
//! A particle may invert a bit of a register. Drivers of this crate compare the registers of their own peripherals where they
//! know the value: the port of a bus its controller, its filters, its pins and its capture. All other registers on which a board
//! depends are in this table: clocks, resets, time base, core. Each part of the program that owns
//! some of them lists them beside its code. An interrupt of the supervisor compares those of one owner, ten times a
//! second, and so all within a second.
//!
//! | what differs | what follows |
//! | --- | --- |
//! | most registers | the bits are written |
//! | a clock, a reset line, the time base | record with the address, and reset: what ran meanwhile is wrong |
//! | a bit that is wrong again after it was written | the same |
//! | the first FIFO of a controller is full for a second | the same: its port did not succeed in enabling the interrupt again |
//!
//! Bits that the application may change have no bit in the mask. The board of a minimal slave has no table, and nothing that counts.

#[cfg(feature = "full")]
mod entry;

#[cfg(feature = "full")]
pub(crate) use entry::{Kept, Register, is_sealed, seal};

/// Upsets of this board, for its node.
#[cfg(feature = "full")]
pub(crate) static UPSETS: ecss_can::node::Upsets = ecss_can::node::Upsets::new();

/// Counts a register that was mended, for the node.
#[cfg_attr(feature = "full", inline(never))] // row `size.pyboard-v11.slave.flash`
#[cfg_attr(not(feature = "full"), expect(unused_variables, reason = "a minimal slave has no object for it"))]
pub(crate) fn count(address: u32) {
    #[cfg(feature = "full")]
    UPSETS.count_mended(address);
}
