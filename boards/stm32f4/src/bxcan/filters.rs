//! Acceptance filters in 16-bit mask mode, two to a bank (RM0090 32.7.4).

use ecss_can::link::port::Filter;

const RTR: u32 = 1 << 4;
const IDE: u32 = 1 << 3;

/// Returns one half of a bank: the identifier in the lower 16 bits, the mask in the upper ones. RTR and IDE are
/// compared and are 0 in the identifier, so that remote frames and those with 29-bit identifiers are never admitted.
pub(super) fn half_bank(filter: Filter) -> u32 {
    let identifier = u32::from(filter.id.raw()) << 5;
    let mask = u32::from(filter.mask & 0x7FF) << 5 | RTR | IDE;
    mask << 16 | identifier
}

#[cfg(test)]
mod tests {
    use super::*;
    use ecss_can::types::CobId;

    fn id(raw: u16) -> CobId {
        CobId::new(raw).unwrap()
    }

    /// Verifies: ECSS 11.1c
    /// Notices: ECSS 11.1c: filters admit remote frames.
    #[test]
    fn exact_filter_compares_every_identifier_bit_and_rtr_and_ide() {
        // STID 31:21 of the 16-bit register layout: 701h << 5 = E020h, mask 7FFh << 5 | 18h = FFF8h.
        assert_eq!(half_bank(Filter::exact(id(0x701))), 0xFFF8_E020);
    }

    /// Verifies: ECSS 11.1c
    #[test]
    fn a_function_filter_leaves_the_node_out() {
        assert_eq!(half_bank(Filter::function(id(0x380))), 0xF018_7000);
    }
}
