//! Address of a value in an object dictionary.

/// Index and sub-index of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Address {
    /// Index, `0001h..=FFFFh`.
    pub index: u16,
    /// Sub-index, `00h..=FFh`.
    pub sub: u8,
}

impl Address {
    /// Makes the address of a value.
    pub const fn new(index: u16, sub: u8) -> Address {
        Address { index, sub }
    }
}
