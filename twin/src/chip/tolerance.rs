//! Accesses after an upset: what the part does, where the model refuses a program without faults.
//!
//! The model refuses accesses that a correct program does not make. After an upset a program may make them, so a tolerant chip answers
//! as the part does:
//!
//! * a peripheral without clock reads zero and ignores stores (RM0090 7.3.10). This includes each peripheral that the model lacks,
//!   because the program has not enabled its clock;
//! * a store to flash outside a programming sequence sets PGSERR and changes nothing (RM0090 3.9.4).
//!
//! Accesses for which the manuals define no result are refused in any case.

use std::ops::Range;

use super::Chip;
use crate::mmio::Refusal;
use crate::model::FLASH_BASE;

/// Peripherals on APB and AHB, and the registers of FSMC, FMC and QUADSPI.
const GATED: [Range<u32>; 2] = [0x4000_0000..0x6000_0000, 0xA000_0000..0xA000_2000];

impl Chip {
    /// Returns whether the part ignores an access that the model refused, and a load gives zero.
    pub(super) fn tolerates(&mut self, address: u32, write: bool, refusal: Refusal) -> bool {
        if !self.is_tolerant {
            return false;
        }
        // Flash also answers from zero on.
        let bytes = self.peripherals.part.flash_bytes();
        let in_flash = match refusal {
            Refusal::Misuse => address.wrapping_sub(FLASH_BASE) < bytes,
            Refusal::Unmodelled => address < bytes,
            _ => false,
        };
        if write && in_flash && self.peripherals.flash.operation().is_none() {
            self.peripherals.flash.note_stray_store();
            return true;
        }
        match refusal {
            Refusal::ClockOff => true,
            Refusal::Unmodelled => {
                let is_gated = GATED.iter().any(|range| range.contains(&address));
                is_gated && !self.peripherals.is_modelled(address)
            }
            _ => false,
        }
    }
}
