//! Object 2033h: upsets that a board found in its own registers and in its program.
//!
//! An *upset* is a bit that a particle inverted. A board compares its registers with a table while the node runs, and mends what
//! differs. It counts this in [`Upsets`], which its node reads after each of its own heartbeats: the object follows, and an
//! emergency 5000h reports the change. A program in flash that is damaged or mended
//! is an error that lasts.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use crate::od::{Enumeration, Objects, Record};

/// Program in flash, as its board found it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum ProgramState {
    /// It has no checksum, or was not compared with it yet.
    #[default]
    Unchecked,
    /// It has its checksum.
    Whole,
    /// It has another checksum.
    Damaged,
    /// A bit of it is flipped. The core reads the right word in its place, until the power fails.
    Mended,
}

/// Upsets that a board found. Its interrupts write it, its node reads it.
///
/// ```
/// use ecss_can::node::{FoundUpsets, ProgramState, Upsets};
///
/// static UPSETS: Upsets = Upsets::new();
///
/// UPSETS.count_mended(0x4000_661C); // CAN1_FA1R
/// UPSETS.set_program(ProgramState::Whole);
/// let found = FoundUpsets { registers: 1, last: 0x4000_661C, program: ProgramState::Whole };
/// assert_eq!(UPSETS.found(), found);
/// ```
#[derive(Debug, Default)]
pub struct Upsets {
    registers: AtomicU32,
    last: AtomicU32,
    program: AtomicU8,
}

impl Upsets {
    /// Makes the state at power-on: none was found.
    pub const fn new() -> Upsets {
        Upsets {
            registers: AtomicU32::new(0),
            last: AtomicU32::new(0),
            program: AtomicU8::new(ProgramState::Unchecked as u8),
        }
    }

    /// Counts a register that was mended, by its address.
    pub fn count_mended(&self, address: u32) {
        self.last.store(address, Ordering::Relaxed);
        self.registers.fetch_add(1, Ordering::Relaxed);
    }

    /// Sets the state of the program.
    pub fn set_program(&self, state: ProgramState) {
        self.program.store(state as u8, Ordering::Relaxed);
    }

    /// Returns what was found since power-on or the last reset.
    pub fn found(&self) -> FoundUpsets {
        let registers = self.registers.load(Ordering::Relaxed).min(u16::MAX.into()) as u16;
        let program = match self.program.load(Ordering::Relaxed) {
            program if program == ProgramState::Whole as u8 => ProgramState::Whole,
            program if program == ProgramState::Damaged as u8 => ProgramState::Damaged,
            program if program == ProgramState::Mended as u8 => ProgramState::Mended,
            _ => ProgramState::Unchecked,
        };
        FoundUpsets { registers, last: self.last.load(Ordering::Relaxed), program }
    }
}

/// Upsets that a board found in its own registers and in its program (2033h).
#[doc(alias = "2033h")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct FoundUpsets {
    /// Registers mended
    ///
    /// Number of times since power-on or the last reset.
    #[sub(1, ro)]
    pub registers: u16,
    /// Last register mended
    ///
    /// Its address; zero if there was none.
    #[sub(2, ro)]
    pub last: u32,
    /// Program
    ///
    /// Result of the last comparison of the program in flash with its checksum. Unchecked: there was none.
    #[sub(3, ro)]
    pub program: ProgramState,
}

/// Object of the upsets that the board found (2033h).
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct UpsetObjects {
    /// Upsets
    ///
    /// Emergency 5000h with source 2 reports a mended register, with source 3 a damaged or mended program. The latter lasts until the
    /// program is whole again.
    #[object(0x2033, record)]
    pub found: FoundUpsets,
}
