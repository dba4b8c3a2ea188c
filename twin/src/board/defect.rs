//! Defects of a board, in addition to those of [`Fittings`](super::Fittings).

use super::EmulatedBoard;
use crate::bxcan::StuckBits;

/// A defect of a chip or its wires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Defect {
    /// Stuck bits of a register of the CAN controllers.
    Can(StuckBits),
    /// The wires from CAN_RX to the capture inputs are exchanged: CAN1 to PA1, CAN2 to PA0.
    ExchangedCaptures,
    /// The prescaler of APB1 always divides by 2.
    Apb1Prescaler,
    /// A word of flash is worn: some of its bits remain one when they are programmed to zero.
    WornFlash {
        /// Address of the word.
        address: u32,
        /// Bits that remain one.
        bits: u32,
    },
}

impl EmulatedBoard {
    /// Adds a permanent defect. Call it before the board has power: a running program does not see the change.
    pub fn inflict(&mut self, defect: Defect) {
        match defect {
            Defect::Can(bits) => self.chip.peripherals.can.stick(bits),
            Defect::ExchangedCaptures => self.captures_exchanged = true,
            Defect::WornFlash { address, bits } => self.flash.worn.push((address, bits)),
            Defect::Apb1Prescaler => self.chip.peripherals.rcc.apb1_stuck = true,
        }
    }
}
