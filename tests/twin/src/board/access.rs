//! Accesses that stop a board.

use std::fmt;

use can_wire::time::Time;

use crate::mmio::Refusal;

/// What the program asked for and nobody could give. The board stops there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AccessError {
    /// Name of the board.
    pub board: String,
    /// When.
    pub at: Time,
    /// The instruction.
    pub pc: u32,
    /// What it accessed.
    pub address: u32,
    /// A store, not a load or fetch.
    pub write: bool,
    /// Why it was refused.
    pub refusal: Refusal,
}

impl fmt::Display for AccessError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let AccessError { board, at, pc, address, write, refusal } = self;
        let kind = if *write { "store to" } else { "load from" };
        let us = at.as_us();
        write!(f, "{board}: {kind} {address:08X}h by the instruction at {pc:08X}h after {us} us: {refusal}")
    }
}

impl std::error::Error for AccessError {}
