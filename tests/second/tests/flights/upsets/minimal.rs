//! Upsets of a minimal slave, in the spacecraft with two masters.

use can_twin::spacecraft::BoardId;
use ecss_can::profile::Profile;
use ecss_can_cli::campaign::upsets::fly::{Flown, fly};
use ecss_can_cli::campaign::upsets::outcome::Outcome;
use ecss_can_cli::campaign::upsets::place::Upset;
use ecss_can_cli::campaign::upsets::world::World;

use super::AT_US;

/// Index of the minimal slave.
const MINIMAL: usize = 3;

const RAM: u32 = 0x2000_0000;
const RAM_BYTES: usize = 128 << 10;
/// Fields of CAN_BTR that are the bit timing, and its value: prescaler 3, segments of 11 and 2 time quanta.
const TIMING: u32 = 0x001A_0002;

/// Alternate functions of the CAN pins: name, bit of GPIOB.AFRH.
const PINS: [(&str, u32); 4] = [("CAN1_RX", 1), ("CAN1_TX", 7), ("CAN2_RX", 17), ("CAN2_TX", 23)];

/// Returns the places of these words in RAM, one after the other.
fn places<const N: usize>(world: &World, wanted: [u32; N]) -> Vec<u32> {
    let flight = world.flight_at(AT_US);
    let ram = flight.craft.board(BoardId(MINIMAL)).read_memory(RAM, RAM_BYTES).expect("RAM");
    let words: Vec<u32> = ram.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let found = words.windows(N).zip((RAM..).step_by(4)).filter(|(words, _)| **words == wanted);
    found.map(|(_, address)| address).collect()
}

fn fly_at(world: &World, place: &str) -> Flown {
    let upset: Upset = format!("upset masters=2 at={AT_US} place={place}").parse().expect("a place");
    fly(world, &upset)
}

/// Given a spacecraft in flight, when a bit of the pins or of the bit timing of a minimal slave flips, in a register or in RAM, then it
/// takes part again, also after a change of the bus.
///
/// Verifies: ECSS 6.10d
#[test]
fn minimal_slave_recovers_from_upsets_of_its_ports() {
    let world = World::prepare(2, 1, false).expect("images");
    let pins =
        PINS.map(|(name, bit)| (name, format!("peripherals board={MINIMAL} address=40020424 bit={bit}")));
    // Of both controllers, with its complement.
    let timings = places(&world, [TIMING, !TIMING]);
    assert_eq!(timings.len(), 2);
    let timings = timings.iter().flat_map(|at| [*at, *at + 4]);
    let in_ram = timings.map(|at| ("timing", format!("ram board={MINIMAL} address={:08X} bit=4", at + 2)));
    let bad = pins.into_iter().chain(in_ram).filter_map(|(name, place)| {
        let flown = fly_at(&world, &place);
        flown.outcome.is_bad().then(|| format!("{name}: {flown:?}"))
    });
    assert_eq!(bad.collect::<Vec<_>>(), [""; 0]);
}

/// Given a minimal slave in flight, when a bit flips of the lifetime of its telemetry, or of the copy, then it is reset.
#[test]
fn minimal_slave_is_reset_after_an_upset_of_its_lifetime() {
    let world = World::prepare(2, 1, false).expect("images");
    let us = Profile::DEFAULT.event.as_micros();
    let [low, high] = [us as u32, (us >> 32) as u32];
    let lifetimes = places(&world, [low, high, low, high]);
    assert_eq!(lifetimes.len(), 1);
    let both = [lifetimes[0], lifetimes[0] + 8];
    let outcomes =
        both.map(|at| fly_at(&world, &format!("ram board={MINIMAL} address={:08X} bit=3", at + 3)).outcome);
    assert_eq!(outcomes, [Outcome::Reset; 2]);
}
