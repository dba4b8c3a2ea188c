//! Who a slave is: straps, and three stored copies of its Node-ID of which two must agree (ECSS 6.10).
//!
//! Verifies: ECSS 6.10e, 6.10f, 6.10k

use ecss_can::store::identity::{NoNodeId, Straps, agreed, copy, node_id, of_copy};
use ecss_can::types::NodeId;

use crate::bench::node;

/// Every Node-ID that straps can say.
const SLAVES: std::ops::RangeInclusive<u8> = 2..=15;

/// The remainder of a division by x5 + x2 + 1, digit by digit, of number and Node-ID with five zeros behind.
fn crc(number: u8, id: u8) -> String {
    let mut digits: Vec<char> = format!("{number:02b}{id:07b}00000").chars().collect();
    for first in 0..9 {
        if digits[first] == '1' {
            for place in [0, 3, 5] {
                digits[first + place] = if digits[first + place] == '1' { '0' } else { '1' };
            }
        }
    }
    digits[9..].iter().collect()
}

/// A copy as the format has it.
fn expected(number: u8, id: u8) -> u16 {
    u16::from_str_radix(&format!("01{number:02b}{id:07b}{}", crc(number, id)), 2).unwrap()
}

/// What is read of a copy with this number: a copy with another one takes no place of it.
fn read(copy: u16, number: u8) -> u8 {
    of_copy(copy).filter(|(found, _)| *found == number).map_or(0, |(_, id)| id)
}

#[test]
fn a_copy_has_the_documented_format() {
    // By hand: 01 01 0000010 00100.
    assert_eq!(expected(1, 2), 0b0101_0000_0100_0100);
    for number in 1..=3 {
        for id in 0..=127 {
            assert_eq!(copy(number, id), expected(number, id), "copy {number} of {id}");
            assert_eq!(of_copy(expected(number, id)), Some((number, id)));
            assert!((0x4001..=0x7FFF).contains(&copy(number, id)), "no length and no note");
        }
    }
    assert_eq!((0..=u16::MAX).filter(|word| of_copy(*word).is_some()).count(), 3 * 128);
}

#[test]
fn every_flipped_bit_of_every_copy_changes_no_node_id() {
    for id in 2..=126 {
        for flipped in 1..=3 {
            for bit in 0..16 {
                let found = [1, 2, 3].map(|number| {
                    let flip = if number == flipped { 1 << bit } else { 0 };
                    read(expected(number, id) ^ flip, number)
                });
                assert_eq!(found[usize::from(flipped) - 1], 0, "copy {flipped} of {id}, bit {bit}");
                assert_eq!(agreed(found), Some(node(id)), "copy {flipped} of {id}, bit {bit}");
            }
        }
    }
}

/// Every copy that reads as another Node-ID, or as none.
///
/// Notices: ECSS 6.10k: one copy of three is enough.
#[test]
fn one_wrong_copy_of_three_changes_no_node_id() {
    for id in 2..=126 {
        for wrong in (0..=127).filter(|wrong| *wrong != id) {
            for place in 0..3 {
                let mut copies = [id; 3];
                copies[place] = wrong;
                assert_eq!(agreed(copies), Some(node(id)));
            }
            for place in 0..3 {
                let mut copies = [0; 3];
                copies[place] = id;
                copies[(place + 1) % 3] = wrong;
                assert_eq!(agreed(copies), None, "one copy is not enough: {copies:?}");
            }
        }
    }
    // Three that differ, none that is one of a slave.
    assert_eq!([agreed([2, 3, 4]), agreed([0; 3]), agreed([1; 3])], [None; 3]);
}

/// Given copies or straps with the Node-ID of the master, 1, or of boards in maintenance mode, 127, then they give the board none,
/// alone or together.
///
/// Verifies: ECSS 6.10h, 9.1a, 6.10j
/// Notices: ECSS 9.1a: a slave accepts Node-ID 1.
/// Notices: ECSS 6.10j: Node-IDs above 15 cannot be stored.
#[test]
fn no_slave_has_the_node_id_of_master_or_maintenance() {
    for id in [1, 127] {
        assert_eq!(agreed([id; 3]), None);
        for other in 0..=127 {
            for copies in [[other, id, id], [id, other, id], [id, id, other]] {
                assert_eq!(agreed(copies), None, "{copies:?}");
            }
        }
        let id = node(id);
        assert_eq!(node_id(Straps::Open, Some(id)), Err(NoNodeId::Missing));
        for stored in [None, Some(node(3)), Some(id)] {
            assert_eq!(node_id(Straps::Closed(id), stored), Err(NoNodeId::Straps), "{stored:?}");
        }
        // The straps are right, the store is not.
        let found = node_id(Straps::Closed(node(3)), Some(id));
        assert_eq!(found, Err(NoNodeId::Contradiction { straps: node(3), stored: id }));
    }
    for id in [2, 126] {
        assert_eq!(agreed([id; 3]), Some(node(id)));
        assert_eq!(node_id(Straps::Open, Some(node(id))), Ok(node(id)));
        assert_eq!(node_id(Straps::Closed(node(id)), None), Ok(node(id)));
    }
}

/// Every setting of five straps: 1 is closed.
fn straps(bits: u8) -> Straps {
    let is_odd = [1, 2, 4, 7, 8, 11, 13, 14, 16, 19, 21, 22, 25, 26, 28, 31].contains(&bits);
    match bits & 0b1111 {
        0 if bits == 0 => Straps::Open,
        id if is_odd && id >= 2 => Straps::Closed(node(id)),
        _ => Straps::Wrong,
    }
}

/// Given a board of each Node-ID, with straps, stored copies or both, when one of five wires or one bit of a copy is wrong, then the
/// board has its Node-ID or none.
#[test]
fn no_single_failure_gives_a_board_another_node_id() {
    for id in SLAVES {
        let right = (0..32).find(|bits| straps(*bits) == Straps::Closed(node(id))).unwrap();
        let whole = [1, 2, 3].map(|number| expected(number, id));
        let decided = |bits: u8, copies: Option<[u16; 3]>| {
            let copies = copies.map_or([0; 3], |[a, b, c]| [read(a, 1), read(b, 2), read(c, 3)]);
            node_id(straps(bits), agreed(copies))
        };
        let is_safe = |found: Result<NodeId, NoNodeId>| found.is_err() || found == Ok(node(id));
        let (both, alone, stored) =
            (decided(right, Some(whole)), decided(right, None), decided(0, Some(whole)));
        assert_eq!([both, alone, stored], [Ok(node(id)); 3]);
        for wire in 0..5 {
            let wrong = right ^ 1 << wire;
            // One wire is closed at most: without it there are no straps, and the store decides.
            let expected = if wrong == 0 { Ok(node(id)) } else { Err(NoNodeId::Straps) };
            assert_eq!(decided(wrong, Some(whole)), expected, "node {id}, wire {wire}");
            assert!(decided(wrong, None).is_err(), "node {id}, wire {wire}");
            assert!(
                is_safe(decided(1 << wire, Some(whole))),
                "node {id} without straps, wire {wire} shorted"
            );
        }
        for (flipped, bit) in (0..3).flat_map(|copy| (0..16).map(move |bit| (copy, bit))) {
            let mut copies = whole;
            copies[flipped] ^= 1 << bit;
            let found = [decided(right, Some(copies)), decided(0, Some(copies))];
            assert_eq!(found, [Ok(node(id)); 2], "node {id}, copy {flipped}, bit {bit}");
            // Another wire beside: two failures, and still no other Node-ID.
            for wire in 0..5 {
                assert!(is_safe(decided(right ^ 1 << wire, Some(copies))));
                assert!(is_safe(decided(1 << wire, Some(copies))));
            }
        }
        // Every wrong setting of the straps, not of one wire alone.
        for bits in (0..32).filter(|bits| *bits != right) {
            assert!(is_safe(decided(bits, Some(whole))), "node {id}, straps {bits:05b}");
        }
    }
}

/// Verifies: ECSS 6.10j
/// Notices: ECSS 6.10e: straps win over a stored Node-ID that differs.
/// Notices: ECSS 6.10f: a board without any Node-ID takes 127 and communicates.
/// Notices: ECSS 6.10j: a board without straps does not take its stored Node-ID.
#[test]
fn straps_and_store_decide_as_documented() {
    let (three, five) = (node(3), node(5));
    for (straps, stored, expected) in [
        (Straps::Closed(three), None, Ok(three)),
        (Straps::Closed(three), Some(three), Ok(three)),
        (Straps::Closed(three), Some(five), Err(NoNodeId::Contradiction { straps: three, stored: five })),
        (Straps::Open, Some(five), Ok(five)),
        (Straps::Open, None, Err(NoNodeId::Missing)),
        (Straps::Wrong, None, Err(NoNodeId::Straps)),
        (Straps::Wrong, Some(five), Err(NoNodeId::Straps)),
    ] {
        assert_eq!(node_id(straps, stored), expected, "{straps:?}, {stored:?}");
    }
}
