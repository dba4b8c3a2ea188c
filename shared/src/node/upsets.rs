//! Object 2033h: upsets that a board found in its own registers.
//!
//! An *upset* is a bit that a particle inverted. A board compares its registers with a table while the node runs, and mends what
//! differs. It counts this in [`Upsets`], which its node reads after each of its own heartbeats: the object follows, and an
//! emergency 5000h reports the change.

use core::sync::atomic::{AtomicU32, Ordering};

use easy_ext::ext;

use super::SpacecraftDevice;
use super::services::Services;
use crate::emcy::ErrorCode;
use crate::od::{Objects, Record};

/// Source of the emergency that reports a mended register. The address of the register follows, little-endian.
const MENDED: u8 = 2;

/// Upsets that a board found. Its interrupts write it, its node reads it.
///
/// ```
/// use ecss_can::node::{FoundUpsets, Upsets};
///
/// static UPSETS: Upsets = Upsets::new();
///
/// UPSETS.count_mended(0x4000_661C); // CAN1_FA1R
/// assert_eq!(UPSETS.found(), FoundUpsets { registers: 1, last: 0x4000_661C });
/// ```
#[derive(Debug, Default)]
pub struct Upsets {
    registers: AtomicU32,
    last: AtomicU32,
}

impl Upsets {
    /// Makes the state at power-on: none was found.
    pub const fn new() -> Upsets {
        Upsets { registers: AtomicU32::new(0), last: AtomicU32::new(0) }
    }

    /// Counts a register that was mended, by its address.
    pub fn count_mended(&self, address: u32) {
        self.last.store(address, Ordering::Relaxed);
        self.registers.fetch_add(1, Ordering::Relaxed);
    }

    /// Returns what was found since power-on or the last reset.
    pub fn found(&self) -> FoundUpsets {
        let registers = self.registers.load(Ordering::Relaxed).min(u16::MAX.into()) as u16;
        FoundUpsets { registers, last: self.last.load(Ordering::Relaxed) }
    }
}

/// Upsets that a board found in its own registers (2033h).
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
}

/// Object of the upsets that the board found (2033h).
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct UpsetObjects {
    /// Upsets
    ///
    /// Emergency 5000h with source 2 reports a mended register.
    #[object(0x2033, record)]
    pub found: FoundUpsets,
}

#[ext(UpsetServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Shows what the board found, and reports it if a register was mended since the last call. Call it once for each heartbeat of
    /// the node.
    pub fn report_upsets(&mut self) {
        let Some(found) = self.state().upsets().map(Upsets::found) else { return };
        let shown = &mut self.objects_mut().extension.upsets.found;
        let before = core::mem::replace(shown, found);
        if before.registers != found.registers {
            let [a, b, c, d] = found.last.to_le_bytes();
            self.report_past(ErrorCode::HARDWARE, [MENDED, a, b, c, d]);
        }
    }
}
