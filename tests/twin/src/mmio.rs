//! What a CPU meets outside its own memories: widths, instants, refusals.

use can_wire::time::Time;

/// Width of one access.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Width {
    /// 8 bits.
    Byte,
    /// 16 bits.
    Half,
    /// 32 bits.
    Word,
}

impl Width {
    /// Bytes of the access.
    pub const fn bytes(self) -> u32 {
        match self {
            Width::Byte => 1,
            Width::Half => 2,
            Width::Word => 4,
        }
    }

    /// The bits of a word that an access at its low end touches.
    pub const fn mask(self) -> u32 {
        match self {
            Width::Byte => 0xFF,
            Width::Half => 0xFFFF,
            Width::Word => u32::MAX,
        }
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

/// Why the board refused an access. The CPU takes a bus fault and the board stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// No peripheral of the model answers here.
    Unmodelled,
    /// The peripheral is modelled, its clock is off in RCC.
    ClockOff,
    /// The register exists; this width or alignment does not.
    Width,
    /// The reference manual forbids it in the peripheral's present state.
    Misuse,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Refusal::Unmodelled => "no modelled peripheral answers",
            Refusal::ClockOff => "the peripheral's clock is off in RCC",
            Refusal::Width => "the register does not take this width or alignment",
            Refusal::Misuse => "the reference manual forbids it in the peripheral's present state",
        })
    }
}
