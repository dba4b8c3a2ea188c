//! Aimed upsets of a spacecraft with one master, and their outcomes.

use can_twin::spacecraft::Bus;
use can_twin::wire::fault::Fault;
use ecss_can_cli::campaign::upsets::fly::fly;
use ecss_can_cli::campaign::upsets::outcome::Outcome;
use ecss_can_cli::campaign::upsets::place::Upset;
use ecss_can_cli::campaign::upsets::world::World;
use flight::*;

/// Upsets of the slave with parallel access: name, place, outcome.
const AIMED: [(&str, &str, Outcome); 6] = [
    ("TIM2.CNT bit 16", "peripherals board=1 address=40000024 bit=16", Outcome::NotRecovered),
    // The FIFO of a controller stays full.
    ("BASEPRI bit 4", "masks board=1 register=BASEPRI bit=4", Outcome::Reset),
    // The watchdog resets the board late: the master changes the bus, and the slave with selective access has to search.
    ("PRIMASK bit 0", "masks board=1 register=PRIMASK bit=0", Outcome::OthersLose),
    ("S31 bit 3", "core board=1 register=S31 bit=3", Outcome::None),
    ("PC bit 20", "core board=1 register=PC bit=20", Outcome::Reset),
    // The emulator refuses settings of a PLL that runs.
    ("RCC.PLLCFGR bit 7", "peripherals board=1 address=40023804 bit=7", Outcome::Unjudged),
];

/// Registers of the slave with parallel access: name, address, bit, outcome. Without the comparison of registers most of them stay
/// wrong.
const REGISTERS: [(&str, u32, u32, Outcome); 31] = [
    // What all filter banks share: deaf on both buses.
    ("CAN1.FMR bit 0", 0x4000_6600, 0, Outcome::Repaired),
    ("CAN1.FMR bit 11", 0x4000_6600, 11, Outcome::Repaired),
    ("CAN1.FM1R bit 1", 0x4000_6604, 1, Outcome::Repaired),
    ("CAN1.FS1R bit 6", 0x4000_660C, 6, Outcome::Repaired),
    ("CAN1.FFA1R bit 1", 0x4000_6614, 1, Outcome::Repaired),
    ("CAN1.FA1R bit 0", 0x4000_661C, 0, Outcome::Repaired),
    ("CAN1.FA1R bit 14", 0x4000_661C, 14, Outcome::Repaired),
    // The runner sets filters again in turn, and nothing counts it.
    ("CAN1.F0R1 bit 5", 0x4000_6640, 5, Outcome::None),
    // Interrupts of the first FIFO and of the mailboxes.
    ("CAN1.IER bit 1", 0x4000_6414, 1, Outcome::Repaired),
    ("CAN1.IER bit 0", 0x4000_6414, 0, Outcome::Repaired),
    ("NVIC.ISER0 bit 20", 0xE000_E100, 20, Outcome::Repaired),
    ("NVIC.ISER0 bit 28", 0xE000_E100, 28, Outcome::Reset),
    // Bit timing, and the mode: Init, sleep, no retransmission.
    ("CAN1.BTR bit 0", 0x4000_641C, 0, Outcome::Repaired),
    ("CAN2.BTR bit 0", 0x4000_681C, 0, Outcome::Repaired),
    ("CAN1.MCR bit 0", 0x4000_6400, 0, Outcome::Repaired),
    ("CAN1.MCR bit 1", 0x4000_6400, 1, Outcome::Repaired),
    ("CAN1.MCR bit 4", 0x4000_6400, 4, Outcome::Repaired),
    // CAN_RX of the bus that is not in use.
    ("GPIOB.AFRH bit 17", 0x4002_0424, 17, Outcome::Repaired),
    ("GPIOB.MODER bit 17", 0x4002_0400, 17, Outcome::Repaired),
    // Capture of edges.
    ("DMA1.S2CR bit 0", 0x4002_6040, 0, Outcome::Repaired),
    ("DMA1.S2NDTR bit 3", 0x4002_6044, 3, Outcome::None),
    ("TIM5.CCER bit 0", 0x4000_0C20, 0, Outcome::Repaired),
    ("TIM5.PSC bit 0", 0x4000_0C28, 0, Outcome::Reset),
    ("TIM5.CR1 bit 0", 0x4000_0C00, 0, Outcome::Reset),
    // The time base.
    ("TIM2.CR1 bit 0", 0x4000_0000, 0, Outcome::Reset),
    ("TIM2.PSC bit 5", 0x4000_0028, 5, Outcome::Reset),
    ("TIM2.DIER bit 0", 0x4000_000C, 0, Outcome::Reset),
    // Clocks and reset lines.
    ("RCC.APB1ENR bit 25", 0x4002_3840, 25, Outcome::Repaired),
    ("RCC.APB1RSTR bit 25", 0x4002_3820, 25, Outcome::Reset),
    ("RCC.APB1ENR bit 0", 0x4002_3840, 0, Outcome::Reset),
    ("FLASH.ACR bit 8", 0x4002_3C00, 8, Outcome::Repaired),
];

/// Flies an upset of the slave with parallel access. Returns a text if name or outcome differ.
fn differs(world: &World, name: &str, place: &str, expected: Outcome) -> Option<String> {
    let text = format!("upset masters=1 at=5499455 place={place}");
    let upset: Upset = text.parse().expect(name);
    let flown = fly(world, &upset);
    let is_named = flown.name.contains(name);
    (flown.outcome != expected || !is_named).then(|| format!("{name}: {flown:?}"))
}

/// Given a spacecraft in flight, when one bit flips, then the outcome is the known one.
#[test]
fn aimed_upsets_have_known_outcomes() {
    let world = World::prepare(1, 1, false).expect("images");
    let wrong = AIMED.iter().filter_map(|(name, place, expected)| differs(&world, name, place, *expected));
    assert_eq!(wrong.collect::<Vec<_>>(), [""; 0]);
}

/// Given a spacecraft in flight, when a bit of a register flips, then the board mends it or is reset.
///
/// Verifies: ECSS 6.10d
#[test]
fn flipped_registers_are_mended() {
    let world = World::prepare(1, 1, false).expect("images");
    let wrong = REGISTERS.iter().filter_map(|(name, address, bit, expected)| {
        let place = format!("peripherals board=1 address={address:08X} bit={bit}");
        differs(&world, name, &place, *expected)
    });
    assert_eq!(wrong.collect::<Vec<_>>(), [""; 0]);
}

/// Given a flight without upsets, in which the master leaves a cut bus and the bus is whole again and then dominant, so that its nodes
/// are bus-off, then no board mends a register, and none is reset.
#[test]
fn no_register_is_mended_in_a_flight_without_upsets() {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    flight.fly_to(3_000);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly_to(8_000);
    flight.twin.wire_mut(Bus::Nominal).restore_all();
    let wire = flight.twin.wire_mut(Bus::Redundant);
    wire.schedule(ms(10_000), Fault::Short { position_m: 1.0, level: false }).unwrap();
    wire.schedule(ms(10_900), Fault::ClearShorts).unwrap();
    flight.fly_to(20_000);
    for setup in MASTER_AND_THREE {
        let board = flight.emulated(setup.node);
        let [registers, last] = words(board, "ecss_can_stm32f4::registers::table::UPSETS");
        assert_eq!((registers, last), (0, 0), "node {}, {last:08X}h", setup.node);
        assert_eq!(resets(&flight, setup.node), 0, "node {}", setup.node);
    }
}
