//! One bit of a COB-ID or of the Node-ID flips in the memory of a running node (ECSS 6.10d, k).
//!
//! A copy of the flight is run for each place in RAM that holds the identifier or its complement.

use std::collections::BTreeSet;

use flight::*;

/// Static RAM of the F405 without its last 16 KiB, and the core-coupled memory.
const MEMORIES: [(u32, usize); 2] = [(0x2000_0000, 112 << 10), (0x1000_0000, 64 << 10)];

/// Time of the flip, when all nodes are Operational.
const FLIP_MS: u64 = 3_000;
/// End of a flight, when each COB-ID was compared: 32 heartbeats later.
const END_MS: u64 = FLIP_MS + 32 * 100 + 500;

/// EMCY code 5000h, hardware, whose first byte of information names a flipped bit.
const FLIPPED: [u8; 4] = [0x00, 0x50, 0x08, 0x01];

/// Bits that flip: of the Node-ID, and of the function code.
const BITS: [u32; 2] = [1, 8];

/// Copies of a COB-ID that a node keeps: object, service, service's complement, second copy, its complement.
const COPIES: usize = 5;

/// A slave whose Node-ID is rare among the bytes of its memory.
const SLAVE: u8 = 13;

fn flight() -> Flight {
    let setups = [MASTER_AND_THREE[0], BoardSetup { node: SLAVE, ..MASTER_AND_THREE[1] }];
    let mut flight = Flight::with(&setups, &STANDARD);
    flight.fly_to(FLIP_MS);
    flight
}

/// Returns the COB-IDs that a node sends.
fn sent(flight: &Flight, node: u8) -> BTreeSet<u16> {
    flight.of(node).filter_map(Seen::id).collect()
}

/// Returns the places of these bytes in the memory of a node.
fn places(flight: &Flight, node: u8, bytes: &[u8]) -> Vec<u32> {
    let board = flight.emulated(node);
    let mut places = Vec::new();
    for (start, len) in MEMORIES {
        let memory = board.read_memory(start, len).unwrap();
        let found = memory.chunks(bytes.len()).zip(0..).filter(|(chunk, _)| *chunk == bytes);
        places.extend(found.map(|(_, number)| start + number * bytes.len() as u32));
    }
    places
}

/// Effects of a flipped bit.
struct Outcome {
    /// Whether the node reported it.
    is_reported: bool,
    /// Frames of the node with a COB-ID that it did not use before.
    strange: Vec<u16>,
    /// Whether the flight ended early: the bit was one of a pointer, which led out of the modelled memory.
    is_lost: bool,
}

/// Runs a copy of the flight in which one bit of `node` flips.
fn flip(flight: &Flight, node: u8, address: u32, bit: u32) -> Outcome {
    let mut copy = flight.clone();
    let before = sent(flight, node);
    let board = copy.emulated_mut(node);
    let [byte] = board.read_memory(address + bit / 8, 1).unwrap()[..] else { unreachable!() };
    board.write_memory(address + bit / 8, &[byte ^ 1 << (bit % 8)]).unwrap();
    let lost = copy.twin.run_until(ms(END_MS)).err();
    copy.fly(lost.as_ref().map_or(ms(END_MS), |lost| lost.at));
    let later = || copy.of(node).filter(|seen| seen.end > flight.end);
    let emcy = 0x080 + u16::from(node);
    let strange = later().filter_map(Seen::id).filter(|id| *id != emcy && !before.contains(id)).collect();
    let is_reported = later().any(|seen| {
        seen.id() == Some(emcy) && [0, 1, 3].into_iter().all(|byte| seen.data()[byte] == FLIPPED[byte])
    });
    Outcome { is_reported, strange, is_lost: lost.is_some() }
}

/// Flips a bit in each place that holds `id` or its complement. No frame of the node may have the COB-ID that results. Returns
/// how many of the flips the node reported.
fn flip_all(flight: &Flight, node: u8, id: u16) -> usize {
    let mut reported = 0;
    for value in [id, !id] {
        for place in places(flight, node, &value.to_le_bytes()) {
            for bit in BITS {
                let outcome = flip(flight, node, place, bit);
                assert!(
                    outcome.strange.is_empty(),
                    "{:X?} from COB-ID {id:03X}h at {place:08X}h, bit {bit}",
                    outcome.strange
                );
                assert!(!outcome.is_lost, "COB-ID {id:03X}h at {place:08X}h");
                reported += usize::from(outcome.is_reported);
            }
        }
    }
    reported
}

/// Given a node in flight, when a bit flips in any place that holds the COB-ID of one of its PDOs, then no frame with
/// another COB-ID leaves it. It repairs and reports the copies that it keeps: the object, the one that the service uses
/// and its complement, the one for comparison and its complement.
///
/// Verifies: ECSS 6.10d
#[test]
fn a_flipped_bit_sends_no_false_cob_id() {
    let flight = flight();
    let of_slave = [0x180, 0x380].map(|function| (SLAVE, function + u16::from(SLAVE)));
    for (node, id) in of_slave.into_iter().chain([(MASTER, 0x180 + u16::from(MASTER))]) {
        assert!(sent(&flight, node).contains(&id));
        assert!(flip_all(&flight, node, id) >= COPIES * BITS.len(), "node {node}: {id:03X}h");
    }
    // The master computes the COB-ID of a command from the program, so it has no copy to repair.
    let command = 0x300 + u16::from(SLAVE);
    assert!(sent(&flight, MASTER).contains(&command));
    flip_all(&flight, MASTER, command);
}

/// Given a slave in flight, when a bit flips in any byte that equals its Node-ID, then no frame with the COB-ID of
/// another node leaves it. It repairs and reports each of the three copies that it keeps. Some of these bytes belong to
/// pointers: at most two of them end the flight.
///
/// Verifies: ECSS 6.10k
#[test]
fn a_flipped_bit_of_the_node_id_makes_no_other_node() {
    let flight = flight();
    let (mut reported, mut lost) = (0, 0);
    for place in places(&flight, SLAVE, &[SLAVE]) {
        let outcome = flip(&flight, SLAVE, place, 1);
        assert!(outcome.strange.is_empty(), "{:X?} from the Node-ID at {place:08X}h", outcome.strange);
        reported += usize::from(outcome.is_reported);
        lost += usize::from(outcome.is_lost);
    }
    assert!(reported >= 3 && lost <= 2, "{reported} reported, {lost} lost");
}
