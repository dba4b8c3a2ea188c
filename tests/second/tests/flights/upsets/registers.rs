//! Upsets of registers, which the board compares with what they have to be.

use can_twin::spacecraft::Bus;
use can_twin::wire::fault::Fault;
use ecss_can_cli::campaign::upsets::outcome::Outcome;
use ecss_can_cli::campaign::upsets::world::World;
use flight::*;

use super::differs;

/// Registers of the slave with parallel access: name, address, bit, outcome. Without the comparison of registers most of them stay
/// wrong.
const REGISTERS: [(&str, u32, u32, Outcome); 26] = [
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
    ("TIM2.DIER bit 0", 0x4000_000C, 0, Outcome::Reset),
    // Clocks and reset lines.
    ("RCC.APB1ENR bit 25", 0x4002_3840, 25, Outcome::Repaired),
    ("RCC.APB1RSTR bit 25", 0x4002_3820, 25, Outcome::Reset),
    ("RCC.APB1ENR bit 0", 0x4002_3840, 0, Outcome::Reset),
    ("FLASH.ACR bit 8", 0x4002_3C00, 8, Outcome::Repaired),
];

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
        let [registers, last] = words(board, "ecss_can_stm32f4::registers::UPSETS");
        assert_eq!((registers, last), (0, 0), "node {}, {last:08X}h", setup.node);
        assert_eq!(resets(&flight, setup.node), 0, "node {}", setup.node);
    }
}
