//! The Node-ID from five straps: four bits and odd parity. A sixth one is for maintenance mode (ECSS 6.10g).
//!
//! A strap to ground is 1, an open one 0. Odd parity over all five makes a board without straps, or with one wire lost
//! or shorted, recognisable: it must stay silent (ECSS 6.10f).
//!
//! They are read at power-on and when the reset pin was pulled. They are kept in RAM over every other reset, so that no command
//! and no failure of a program gives the board another Node-ID or takes it into maintenance mode.

use thiserror::Error;

use ecss_can::redundancy::Strap;
use ecss_can::store::identity::Straps;
use ecss_can::types::NodeId;

/// Reason why the straps give no Node-ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StrapError {
    /// No strap is closed.
    #[error("no strap is closed: close those of the Node-ID and its parity")]
    Open,
    /// An even number of straps is closed.
    #[error("an even number of straps is closed: with the strap of the parity it is odd")]
    Parity,
    /// A value below 2: 0 is no Node-ID, 1 is the master.
    #[error("the straps say {0}, which is no slave: 0 is no Node-ID, 1 is the master")]
    NotASlave(u8),
}

/// Node-ID of a slave, 2..=15, from bits 0 to 3 and parity, bit 4. Higher bits are ignored. 1 is a strap to ground.
///
/// # Errors
/// [`StrapError`].
pub fn node_id(bits: u8) -> Result<NodeId, StrapError> {
    let bits = bits & 0b1_1111;
    if bits.count_ones().is_multiple_of(2) {
        return Err(if bits == 0 { StrapError::Open } else { StrapError::Parity });
    }
    let value = bits & 0b1111;
    NodeId::new(value).filter(|id| *id != NodeId::MASTER).ok_or(StrapError::NotASlave(value))
}

/// Converts the Node-ID of the straps for a slave.
pub fn of_slave(node_id: Result<NodeId, StrapError>) -> Straps {
    match node_id {
        Ok(id) => Straps::Closed(id),
        Err(StrapError::Open) => Straps::Open,
        Err(StrapError::Parity | StrapError::NotASlave(_)) => Straps::Wrong,
    }
}

/// Upper byte of the word that keeps straps.
const MARK: u16 = 0x57 << 8;

/// Encodes straps into a word of RAM that keeps them over a reset.
pub fn latch(bits: u8) -> u32 {
    let word = MARK | u16::from(bits);
    u32::from(!word) << 16 | u32::from(word)
}

/// Decodes the straps from a word of RAM. Returns `None` if [`latch`] did not make it, as after power-on.
pub fn latched(word: u32) -> Option<u8> {
    let bits = word as u8;
    (word == latch(bits)).then_some(bits)
}

/// Returns which of two master boards this is: straps of 1 mean the prime one, 0 the other, with odd parity. `None` for
/// the straps of a slave, and for a wire lost or shorted: such a board stays silent, for two prime ones would both be
/// active.
pub fn master_board(node_id: Result<NodeId, StrapError>) -> Option<Strap> {
    match node_id {
        Err(StrapError::NotASlave(1)) => Some(Strap::Prime),
        Err(StrapError::NotASlave(_)) => Some(Strap::Second),
        Ok(_) | Err(StrapError::Open | StrapError::Parity) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id_of(closed: [bool; 5]) -> Result<NodeId, StrapError> {
        node_id(closed.into_iter().rev().fold(0, |bits, strap| bits << 1 | u8::from(strap)))
    }

    /// Verifies: ECSS 8.1a
    #[test]
    fn a_master_board_with_a_wrong_wire_is_neither_prime_nor_second() {
        let prime = [true, false, false, false, false];
        let second = [false, false, false, false, true];
        assert_eq!(master_board(id_of(prime)), Some(Strap::Prime));
        assert_eq!(master_board(id_of(second)), Some(Strap::Second));
        for good in [prime, second] {
            for wire in 0..5 {
                let mut broken = good;
                broken[wire] = !broken[wire];
                assert_eq!(master_board(id_of(broken)), None, "wire {wire}");
            }
        }
        assert_eq!(master_board(id_of([false, true, false, false, false])), None, "a slave");
    }

    /// Verifies: ECSS 6.10e, 6.10j
    #[test]
    fn four_bits_least_significant_first_then_parity() {
        assert_eq!(id_of([false, true, false, false, false]), Ok(NodeId::of::<2>()));
        assert_eq!(id_of([true, true, false, false, true]), Ok(NodeId::of::<3>()));
        assert_eq!(id_of([false, false, true, false, false]), Ok(NodeId::of::<4>()));
        assert_eq!(id_of([true, true, true, true, true]), Ok(NodeId::of::<15>()));
    }

    /// Verifies: ECSS 6.10e, 6.10f
    #[test]
    fn a_board_without_straps_has_no_id_of() {
        assert_eq!(id_of([false; 5]), Err(StrapError::Open));
    }

    /// Verifies: ECSS 6.10f, 9.1a
    /// Notices: ECSS 9.1a: straps give a slave the Node-ID of the master.
    #[test]
    fn zero_and_one_are_no_slaves() {
        assert_eq!(id_of([false, false, false, false, true]), Err(StrapError::NotASlave(0)));
        assert_eq!(id_of([true, false, false, false, false]), Err(StrapError::NotASlave(1)));
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
            assert_eq!(id_of(straps_of(id)), Ok(NodeId::new(id).unwrap()), "{id}");
        }
    }

    /// Verifies: ECSS 6.10e, 6.10f
    /// Verifies: ECSS 6.10k
    /// Notices: ECSS 6.10e: the parity of the straps is not looked at when a strap is closed.
    #[test]
    fn every_single_fault_of_every_slave_is_recognised() {
        for id in 2..=15 {
            for wire in 0..5 {
                let mut broken = straps_of(id);
                broken[wire] = !broken[wire];
                let is_open = broken == [false; 5];
                let expected = if is_open { StrapError::Open } else { StrapError::Parity };
                assert_eq!(id_of(broken), Err(expected), "slave {id}, wire {wire}");
            }
        }
    }

    /// Given straps of each slave, written out, when the strap of maintenance mode is open or closed, then the Node-ID is the same. A
    /// lost wire is recognised either way.
    ///
    /// Verifies: ECSS 6.10g, 6.10e, 6.10k
    /// Notices: ECSS 6.10e: the strap of maintenance mode counts for the parity.
    #[test]
    fn strap_of_maintenance_mode_changes_no_node_id() {
        let straps = [
            0b0_0010, 0b1_0011, 0b0_0100, 0b1_0101, 0b1_0110, 0b0_0111, 0b0_1000, 0b1_1001, 0b1_1010,
            0b0_1011, 0b1_1100, 0b0_1101, 0b0_1110, 0b1_1111,
        ];
        for (id, bits) in (2..=15).zip(straps) {
            for maintenance in [0, 0b10_0000] {
                assert_eq!(node_id(bits | maintenance), Ok(NodeId::new(id).unwrap()), "{id}");
                for wire in (0..5).filter(|wire| bits != 1 << wire) {
                    let broken = (bits ^ 1 << wire) | maintenance;
                    assert_eq!(node_id(broken), Err(StrapError::Parity), "{broken:06b}");
                }
            }
        }
        // Closed alone, and together with straps that name no slave.
        assert_eq!(node_id(0b10_0000), Err(StrapError::Open));
        assert_eq!(node_id(0b11_0000), Err(StrapError::NotASlave(0)));
        assert_eq!(node_id(0b10_0001), Err(StrapError::NotASlave(1)));
    }

    /// Given a stored Node-ID, then only straps that are all open select it. Straps of a master are an error for a
    /// slave.
    ///
    /// Verifies: ECSS 6.10e, 6.10f
    /// Notices: ECSS 6.10e: straps of a master count as open straps of a slave.
    /// Notices: ECSS 6.10f: straps of no slave count as open, and a stored Node-ID is taken.
    #[test]
    fn straps_that_name_no_slave_are_wrong_and_not_open() {
        let id = NodeId::of::<2>();
        assert_eq!([of_slave(Ok(id)), of_slave(Err(StrapError::Open))], [Straps::Closed(id), Straps::Open]);
        for error in [StrapError::Parity, StrapError::NotASlave(0), StrapError::NotASlave(1)] {
            assert_eq!(of_slave(Err(error)), Straps::Wrong, "{error:?}");
        }
    }

    /// Verifies: ECSS 6.10g, 6.10e, 6.10k
    /// Notices: ECSS 6.10k: straps in RAM are taken with a flipped bit.
    #[test]
    fn straps_in_ram_are_taken_only_when_no_bit_has_changed() {
        for bits in 0..=0b11_1111 {
            let word = latch(bits);
            assert_eq!(latched(word), Some(bits));
            for bit in 0..32 {
                assert_eq!(latched(word ^ 1 << bit), None, "{bits:06b}, bit {bit}");
            }
        }
        assert_eq!([latched(0), latched(u32::MAX)], [None; 2]);
    }
}
