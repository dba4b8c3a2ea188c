//! Upsets of what a port in RAM knows of its controller.

use can_twin::spacecraft::BoardId;
use ecss_can_cli::campaign::upsets::outcome::Outcome;
use ecss_can_cli::campaign::upsets::world::World;

use super::{AT_US, SLAVE, fly_at};

const RAM: u32 = 0x2000_0000;
const RAM_BYTES: usize = 128 << 10;
/// Registers of both controllers.
const CONTROLLERS: [u32; 2] = [0x4000_6400, 0x4000_6800];

/// Given a slave in flight, when a bit flips of an address of a controller in its RAM, then it is reset, and the spacecraft is healthy,
/// also after a change of the bus.
#[test]
fn board_whose_port_has_the_address_of_no_controller_is_reset() {
    let world = World::prepare(1, 1, false).expect("images");
    let flight = world.flight_at(AT_US);
    let ram = flight.craft.board(BoardId(SLAVE)).read_memory(RAM, RAM_BYTES).expect("RAM");
    let words = ram.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word));
    let places: Vec<u32> = (RAM..)
        .step_by(4)
        .zip(words)
        .filter(|(_, word)| CONTROLLERS.contains(word))
        .map(|(at, _)| at)
        .collect();
    assert!(places.len() >= 2, "{places:08X?}");
    let bad = places.iter().filter_map(|at| {
        let flown = fly_at(&world, &format!("ram board={SLAVE} address={:08X} bit=0", at + 2));
        (flown.outcome != Outcome::Reset).then(|| format!("{flown:?}"))
    });
    assert_eq!(bad.collect::<Vec<_>>(), [""; 0]);
}
