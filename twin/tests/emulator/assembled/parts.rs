//! Boards with other parts and pins than those of the project: described by text, run with hand-assembled programs.

use can_twin::board::{BoardConfig, State};
use can_twin::bxcan::Side;
use can_twin::description::Description;
use can_twin::mmio::Refusal;
use can_twin::model::Model;
use can_twin::wire::time::Time;

use super::programs::*;

const RING1: u32 = RAM + 0x100;
const RING2: u32 = RAM + 0x200;

/// A board with this part, an 8 MHz crystal, and capture wires to PA2 (CAN1) and PA3 (CAN2).
fn described(chip: &str) -> Model {
    let text = format!(
        "name = \"test\"\nchip = \"{chip}\"\noscillator = {{ frequency = \"8MHz\", kind = \"crystal\" }}\n\
         can1 = {{ rx = \"PB8\", tx = \"PB9\" }}\ncan2 = {{ rx = \"PB12\", tx = \"PB13\" }}\n\
         capture = {{ can1 = \"PA2\", can2 = \"PA3\" }}\n"
    );
    Description::parse(&text, "board.toml").unwrap().model
}

fn on(chip: &str, program: &[u16]) -> BoardConfig {
    BoardConfig { model: described(chip), ..board("test", image(program, &STOP)) }
}

/// Given boards whose wires from CAN_RX end at PA2 and PA3, then edges of CAN1 and CAN2 arrive in the rings of TIM5_CH3
/// and TIM5_CH4, by each stream of these channels.
#[test]
fn captures_follow_the_pins_of_the_description() {
    for (chip, second) in [("STM32F407VG", 1), ("STM32F429ZI", 3), ("STM32F479NI", 1)] {
        let program = [capture(8, [(2, 0, RING1), (3, second, RING2)]), SLEEP.to_vec()].concat();
        let mut board = flown(on(chip, &program), Time::from_ms(5));
        for (side, us) in [(Side::Can1, [6_000, 6_001]), (Side::Can2, [6_010, 6_090])] {
            let edges = us.map(Time::from_us).into_iter().zip([false, true]);
            board.run_until(Time::from_us(us[1] + 1)).unwrap();
            board.can_rx_edges(side, edges);
        }
        board.run_until(Time::from_ms(7)).unwrap();
        let ([a, b], [c, d]) = (words(&board, RING1), words(&board, RING2));
        assert_eq!([b - a, c - a, d - c], [84, 840, 80 * 84], "{chip}");
    }
}

/// Given a part of 2 MiB whose program is in the first bank, when it erases a sector of the second bank, then the core
/// continues; when it erases one of the first bank, then the core waits a second. A part of 1 MiB waits for each of its
/// sectors.
#[test]
fn core_goes_on_while_the_other_bank_is_erased() {
    // SNB of sector 23, in the second bank, and of sector 11.
    for (chip, snb, waits) in [
        ("STM32F429ZI", 0x1B, false),
        ("STM32F429ZI", 11, true),
        ("STM32F469NI", 0x10, false),
        ("STM32F427VG", 11, true),
    ] {
        let program = [
            unlock(),
            store(FLASH_CR, 1 << 16 | 0b10 << 8 | snb << 3 | 1 << 1),
            store(RAM, 1),
            wait_for_clear(FLASH_SR, BSY),
            store(RAM, 2),
            STOP.to_vec(),
        ]
        .concat();
        let mut board = flown(on(chip, &program), Time::from_ms(100));
        let before = u32::from_le_bytes([0xA5; 4]);
        assert_eq!(words(&board, RAM), [if waits { before } else { 1 }], "{chip}: sector code {snb:X}h");
        board.run_until(Time::from_ms(1_001)).unwrap();
        assert_eq!((words(&board, RAM), board.counters().flash_erases), ([2], 1), "{chip}");
    }
}

/// The last word of SRAM, and the first address behind it, by the data sheets.
#[test]
fn sram_ends_where_the_part_ends_it() {
    for (chip, end) in
        [("STM32F407VG", 0x2002_0000), ("STM32F437ZI", 0x2003_0000), ("STM32F469ZG", 0x2005_0000)]
    {
        let handler = [copy(0xE000_ED38, RAM), STOP.to_vec()].concat();
        let program = [store(0xE000_ED24, 1 << 17), store(end - 4, 7), store(end, 7), STOP.to_vec()].concat();
        let config = BoardConfig { model: described(chip), ..board("test", image(&program, &handler)) };
        let board = flown(config, Time::from_us(50));
        assert_eq!((words(&board, end - 4), words(&board, RAM)), ([7], [end]), "{chip}: BFAR");
        assert_eq!(board.state(), &State::Running);
    }
}

/// Given peripherals that a part has and the twin does not model, then the board stops with their names.
#[test]
fn peripherals_of_other_parts_stop_the_board_with_their_names() {
    for (chip, address, name) in [
        ("STM32F407VG", 0x4002_8000, "Ethernet MAC + 0h"),
        ("STM32F417VG", 0x5006_0000, "CRYP.CR"),
        ("STM32F429ZI", 0x4001_6818, "LTDC.GCR"),
        ("STM32F427VI", 0x1FFE_C000, "option bytes of the second bank + 0h"),
        ("STM32F469NI", 0x4001_6C00, "DSI + 0h"),
    ] {
        let program = [copy(address, RAM), STOP.to_vec()].concat();
        let error = refused(on(chip, &program), Time::from_us(50));
        assert_eq!((error.address, error.refusal), (address, Refusal::Unmodelled), "{chip}");
        assert!(error.to_string().contains(name), "{error}");
    }
}

/// DEV_ID of RM0090 38.6.1, and of the chapters "Debug support" of RM0390 and RM0386; flash size in KiB of the device signature.
#[test]
fn identity_is_that_of_the_part() {
    for (chip, device, kib) in [
        ("STM32F417IG", 0x413, 1024),
        ("STM32F439NI", 0x419, 2048),
        ("STM32F446VC", 0x421, 256),
        ("STM32F469NE", 0x434, 512),
    ] {
        let program = [copy(0xE004_2000, RAM), copy(0x1FFF_7A20, RAM + 4), STOP.to_vec()].concat();
        let board = flown(on(chip, &program), Time::from_us(50));
        let [idcode, size] = words(&board, RAM);
        assert_eq!((idcode & 0xFFF, size >> 16), (device, kib), "{chip}");
    }
}
