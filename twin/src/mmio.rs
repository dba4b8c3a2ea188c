//! Accesses of the CPU to peripherals: widths, instants, refusals.

pub use crate::cpu::Width;
use crate::wire::time::Time;

/// Returns the bits of a word that an access at its low end touches.
pub(crate) const fn mask(width: Width) -> u32 {
    match width {
        Width::Byte => 0xFF,
        Width::Half => 0xFFFF,
        Width::Word => u32::MAX,
    }
}

/// Returns the word that results from storing `value` at `address` into one that held `old`.
pub(crate) const fn merge(width: Width, address: u32, old: u32, value: u32) -> u32 {
    let shift = 8 * (address & 3);
    old & !(mask(width) << shift) | value << shift
}

/// Returns the word that a bridge writes for a store to APB: the byte or half-word, repeated.
pub(crate) const fn duplicate(width: Width, value: u32) -> u32 {
    match width {
        Width::Byte => value * 0x0101_0101,
        Width::Half => value * 0x0001_0001,
        Width::Word => value,
    }
}

/// The instant of an access, in both units a peripheral may need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Now {
    /// HCLK cycles since power-on, those spent asleep included.
    pub cycle: u64,
    /// Virtual time of the spacecraft.
    pub time: Time,
}

/// Reason why the board refused an access. The CPU takes a bus fault and the board stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum Refusal {
    /// No modelled peripheral has this address.
    #[error("no modelled peripheral answers")]
    Unmodelled,
    /// The peripheral is modelled, but its clock is off in RCC.
    #[error("the peripheral's clock is off in RCC")]
    ClockOff,
    /// The register does not support this width or alignment.
    #[error("the register does not take this width or alignment")]
    Width,
    /// The reference manual forbids it in the peripheral's present state.
    #[error("the reference manual forbids it in the peripheral's present state")]
    Misuse,
    /// A clock would be above the limit of the part at the present scale of its regulator.
    #[error(
        "HCLK, PCLK1 or PCLK2 would be faster than the part allows at this scale of its regulator, without \
        over-drive: check the PLL, and whether the image is for the oscillator of the board"
    )]
    ClockLimit,
    /// The core would enter Stop or Standby.
    #[error("Stop and Standby are not modelled, clear SLEEPDEEP in SCR")]
    DeepSleep,
    /// Level 2 of the read-out protection.
    #[error("level 2 of the read-out protection can never be left: it is not modelled")]
    Irrevocable,
    /// The model does not have this system register of the core.
    #[error("the model of the core does not have this system register or value")]
    SystemRegister,
    /// The architecture does not define what the instruction does (DDI 0403E, "UNPREDICTABLE").
    #[error("the architecture does not define what this instruction does")]
    Unpredictable {
        /// Its encoding: the half-word, or the first half-word above the second.
        word: u32,
    },
}

/// An access that the board refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RefusedAccess {
    /// Address of the access.
    pub address: u32,
    /// True for a store, false for a load.
    pub write: bool,
    pub refusal: Refusal,
}
