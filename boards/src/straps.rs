//! The Node-ID from five straps: four bits and odd parity.
//!
//! A strap to ground is 1, an open one 0. Odd parity over all five makes a board without straps, or with one wire lost
//! or shorted, recognisable: it must stay silent (ECSS 6.10f).

use ecss_can::redundancy::Strap;
use ecss_can::types::NodeId;

/// Why the straps give no Node-ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum StrapError {
    /// An even number of straps is closed.
    Parity,
    /// A value below 2: 0 is no Node-ID, 1 is the master.
    NotASlave(u8),
}

/// Node-ID of a slave, 2..=15. `closed` are bits 0 to 3, then parity; true is a strap to ground.
///
/// # Errors
/// [`StrapError`], see there.
pub fn node_id(closed: [bool; 5]) -> Result<NodeId, StrapError> {
    let bits = closed.into_iter().rev().fold(0u8, |bits, strap| bits << 1 | u8::from(strap));
    if bits.count_ones() % 2 == 0 {
        return Err(StrapError::Parity);
    }
    let value = bits & 0b1111;
    NodeId::new(value).filter(|id| *id != NodeId::MASTER).ok_or(StrapError::NotASlave(value))
}

/// Which of two master boards it is: 1 on the straps is the prime one, 0 the other, with odd parity. `None` for the straps of a
/// slave, and for a wire lost or shorted: such a board stays silent, for two prime ones would both be active.
pub fn master_board(node_id: Result<NodeId, StrapError>) -> Option<Strap> {
    match node_id {
        Err(StrapError::NotASlave(1)) => Some(Strap::Prime),
        Err(StrapError::NotASlave(_)) => Some(Strap::Second),
        Ok(_) | Err(StrapError::Parity) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Verifies: ECSS 8.1a
    #[test]
    fn a_master_board_with_a_wrong_wire_is_neither_prime_nor_second() {
        let prime = [true, false, false, false, false];
        let second = [false, false, false, false, true];
        assert_eq!(master_board(node_id(prime)), Some(Strap::Prime));
        assert_eq!(master_board(node_id(second)), Some(Strap::Second));
        for good in [prime, second] {
            for wire in 0..5 {
                let mut broken = good;
                broken[wire] = !broken[wire];
                assert_eq!(master_board(node_id(broken)), None, "wire {wire}");
            }
        }
        assert_eq!(master_board(node_id([false, true, false, false, false])), None, "a slave");
    }

    #[test]
    fn four_bits_least_significant_first_then_parity() {
        assert_eq!(node_id([false, true, false, false, false]), Ok(NodeId::of::<2>()));
        assert_eq!(node_id([true, true, false, false, true]), Ok(NodeId::of::<3>()));
        assert_eq!(node_id([false, false, true, false, false]), Ok(NodeId::of::<4>()));
        assert_eq!(node_id([true, true, true, true, true]), Ok(NodeId::of::<15>()));
    }

    #[test]
    fn a_board_without_straps_has_no_node_id() {
        assert_eq!(node_id([false; 5]), Err(StrapError::Parity));
    }

    #[test]
    fn zero_and_one_are_no_slaves() {
        assert_eq!(node_id([false, false, false, false, true]), Err(StrapError::NotASlave(0)));
        assert_eq!(node_id([true, false, false, false, false]), Err(StrapError::NotASlave(1)));
    }

    /// The straps of a slave, wire by wire: bits 0 to 3, then odd parity.
    fn straps_of(id: u8) -> [bool; 5] {
        let bits = [0, 1, 2, 3].map(|bit| id >> bit & 1 == 1);
        let is_even = bits.iter().filter(|closed| **closed).count() % 2 == 0;
        [bits[0], bits[1], bits[2], bits[3], is_even]
    }

    /// Verifies: ECSS 6.10e
    /// Verifies: ECSS 6.10j
    #[test]
    fn every_slave_has_its_own_straps() {
        for id in 2..=15 {
            assert_eq!(node_id(straps_of(id)), Ok(NodeId::new(id).unwrap()), "{id}");
        }
    }

    /// Verifies: ECSS 6.10f
    /// Verifies: ECSS 6.10k
    #[test]
    fn every_single_fault_of_every_slave_is_recognised() {
        for id in 2..=15 {
            for wire in 0..5 {
                let mut broken = straps_of(id);
                broken[wire] = !broken[wire];
                assert_eq!(node_id(broken), Err(StrapError::Parity), "slave {id}, wire {wire}");
            }
        }
    }
}
