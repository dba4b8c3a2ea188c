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

/// Returns places of a bit in the last byte of the slave's program, an initial value of a variable, and of one in the first instruction
/// of a handler, which then faults.
fn of_flash(world: &World) -> [String; 2] {
    let flight = world.flight_at(AT_US);
    let board = flight.craft.board(BoardId(SLAVE));
    let address = |name| board.symbol(name).expect(name).address;
    let length = board.read_memory(address("__program_seal"), 4).expect("flash").try_into().expect("a word");
    let last = 0x0800_0000 + u32::from_le_bytes(length) - 1;
    let handler = address("CAN1_RX0") & !1;
    [(last, 5), (handler + 1, 4)]
        .map(|(address, bit)| format!("flash board=1 address={address:08X} bit={bit}"))
}

/// Given a spacecraft in flight, when a bit of a program flips that is not executed, then the slave goes on, and its emergency is the
/// difference. When one flips without which it faults, or one of its stack pointer, then it is reset.
#[test]
fn upsets_of_programs_have_known_outcomes() {
    let world = World::prepare(1, 1, false).expect("images");
    let [unused, used] = of_flash(&world);
    let of_flash = [
        differs(&world, "bit 5", &unused, Outcome::Repaired),
        differs(&world, "CAN1_RX0", &used, Outcome::Reset),
    ];
    let of_stack = OF_STACK.iter().filter_map(|(name, place)| differs(&world, name, place, Outcome::Reset));
    assert_eq!(of_flash.into_iter().flatten().chain(of_stack).collect::<Vec<_>>(), [""; 0]);
}
