//! Where a value is in an object dictionary.

/// Index and sub-index of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Address {
    /// Index, `0001h..=FFFFh`.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
}

impl Address {
    /// A value of an object.
    pub const fn new(index: u16, sub: u8) -> Address {
        Address { index, sub }
    }
}
