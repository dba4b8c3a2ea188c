//! Upsets of the program in flash, and of the stack pointer.

use can_twin::spacecraft::BoardId;
use ecss_can_cli::campaign::upsets::outcome::Outcome;
use ecss_can_cli::campaign::upsets::world::World;

use super::{AT_US, SLAVE, differs};

/// Stack pointers out of the CCM: name, place. To the alias of flash, beyond its end, and between it and flash.
const OF_STACK: [(&str, &str); 3] = [
    ("SP bit 28", "core board=1 register=SP bit=28"),
    ("SP bit 20", "core board=1 register=SP bit=20"),
    ("SP bit 27", "core board=1 register=SP bit=27"),
];

/// Returns the address of the last byte of the slave's program: initial values of variables, read at a start alone.
fn last_byte(world: &World) -> u32 {
    let flight = world.flight_at(AT_US);
    let board = flight.craft.board(BoardId(SLAVE));
    let seal = board.symbol("__program_seal").expect("a seal").address;
    let length = board.read_memory(seal, 4).expect("flash").try_into().expect("a word");
    0x0800_0000 + u32::from_le_bytes(length) - 1
}

/// Given a spacecraft in flight, when a bit of a program flips that is not executed, then the slave goes on, and its emergency is the
/// difference. When a bit of its stack pointer flips, then it is reset.
#[test]
fn upsets_of_programs_have_known_outcomes() {
    let world = World::prepare(1, 1, false).expect("images");
    let place = format!("flash board=1 address={:08X} bit=5", last_byte(&world));
    let of_flash = differs(&world, "bit 5", &place, Outcome::Repaired);
    let of_stack = OF_STACK.iter().filter_map(|(name, place)| differs(&world, name, place, Outcome::Reset));
    assert_eq!(of_flash.into_iter().chain(of_stack).collect::<Vec<_>>(), [""; 0]);
}
