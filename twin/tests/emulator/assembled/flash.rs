//! Flash under hand-assembled programs: programming, erasing, the stall, power that fails in the middle.

use std::sync::Arc;

use can_twin::board::{BoardConfig, EmulatedBoard, Fittings, Remains, State};
use can_twin::bxcan::Side;
use can_twin::image::Image;
use can_twin::mmio::Refusal;
use can_twin::peripherals::FlashSpeed;
use can_twin::pin::Pin;
use can_twin::spacecraft::{BoardId, Bus, Spacecraft};
use can_twin::wire::time::Time;

use super::programs::*;

fn erase() -> Vec<u16> {
    [store(FLASH_CR, ERASE), wait_for_clear(FLASH_SR, BSY)].concat()
}

fn program(address: u32, value: u32) -> Vec<u16> {
    [store(FLASH_CR, X32 | 1), store(address, value), wait_for_clear(FLASH_SR, BSY)].concat()
}

/// Returns a program that writes two words and stops.
fn writer() -> Arc<Image> {
    let code = [
        unlock(),
        program(SECTOR, 0x1234_5678),
        program(SECTOR + 4, 0x9ABC_DEF0),
        store(RAM, 1),
        STOP.to_vec(),
    ];
    image(&code.concat(), &STOP)
}

fn eraser() -> Arc<Image> {
    image(&[unlock(), erase(), store(RAM, 1), STOP.to_vec()].concat(), &STOP)
}

fn on(name: &str, image: Arc<Image>) -> EmulatedBoard {
    powered(board(name, image))
}

#[test]
fn programmed_words_stay_through_resets_and_without_power() {
    let mut board = flown(board("writer", writer()), Time::from_us(200));
    let expected = [0x1234_5678, 0x9ABC_DEF0, u32::MAX];
    assert_eq!((words(&board, SECTOR), word(&board, RAM)), (expected, 1));
    assert_eq!((board.counters().flash_programs, board.counters().flash_erases), (2, 0));
    board.reset();
    assert_eq!(words(&board, SECTOR), expected);
    board.power(false);
    assert_eq!(words(&board, SECTOR), expected);
    board.power(true);
    board.run_until(Time::from_us(201)).unwrap();
    assert_eq!(words(&board, SECTOR), expected);
}

#[test]
fn a_programmed_bit_comes_back_only_by_erasing() {
    let code = [unlock(), program(SECTOR, 0xFFFF_00FF), program(SECTOR, 0x1234_FF78), STOP.to_vec()].concat();
    let twice = flown(board("twice", image(&code, &STOP)), Time::from_us(200));
    assert_eq!(word(&twice, SECTOR), 0x1234_0078);

    let mut eraser = on("eraser", eraser());
    eraser.write_flash(SECTOR, &[0; 0x2_0000]).unwrap();
    eraser.write_flash(SECTOR - 4, &[1; 4]).unwrap();
    eraser.run_until(Time::from_ms(1001)).unwrap();
    assert!(eraser.read_memory(SECTOR, 0x2_0000).unwrap().iter().all(|&byte| byte == 0xFF));
    assert_eq!(word(&eraser, SECTOR - 4), 0x0101_0101, "the sector before is as it was");
    assert_eq!(eraser.counters().flash_erases, 1);
}

/// A word takes typically 16 us and at most 100 us (DS8626 table 40).
#[test]
fn the_core_waits_for_a_word_as_long_as_flash_takes() {
    let toggle = |bit: u32| store(GPIOB + 0x18, bit);
    let code = [
        store(RCC + 0x30, 1 << 1),
        store(GPIOB, 0x0000_0180),
        unlock(),
        store(FLASH_CR, X32 | 1),
        toggle(1 << 4),
        store(SECTOR, 0),
        toggle(1 << 20),
        STOP.to_vec(),
    ];
    let code = image(&code.concat(), &STOP);
    for (flash_speed, us) in [(FlashSpeed::Typical, 16), (FlashSpeed::Slowest, 100)] {
        let fittings = Fittings { flash_speed, ..Fittings::default() };
        let config = BoardConfig { fittings, ..board("toggling", code.clone()) };
        let changes = flown(config, Time::from_us(300)).take_pin_changes();
        assert!(changes.iter().all(|change| change.pin == Pin::new('B', 4)));
        let span = changes[1].at.since(changes[0].at);
        // Two stores of eight moves and two accesses at 16 MHz: some 20 cycles of 62.5 ns.
        assert!(span > Time::from_us(us) && span < Time::from_us(us + 2), "{flash_speed:?}: {span:?}");
    }
}

#[test]
fn timers_count_on_while_an_erase_stalls_the_core() {
    let code = [
        store(RCC + 0x40, 1),
        store(TIM2 + 0x28, 15_999), // 1 kHz of 16 MHz
        store(TIM2 + 0x14, 1),
        unlock(),
        store(TIM2, 1),
        erase(),
        copy(TIM2 + 0x24, RAM),
        STOP.to_vec(),
    ];
    let mut board = flown(board("waiting", image(&code.concat(), &STOP)), Time::from_ms(1));
    let stalled = board.counters().instructions;
    board.run_until(Time::from_ms(1000)).unwrap();
    assert_eq!(board.counters().instructions, stalled);
    board.run_until(Time::from_ms(1001)).unwrap();
    assert_eq!(word(&board, RAM), 1000);
}

#[test]
fn a_core_that_runs_from_ram_sees_the_interface_busy() {
    // STR r3, [r4]; loop: ADDS r2, #1; LDR r1, [r0]; LSLS r1, r1, #15; BMI loop; BX lr
    let routine = [0x3201_6023, 0x03C9_6801, 0x4770_D4FB];
    let routine = (0..).zip(routine).flat_map(|(k, word)| store(RAM + 0x100 + 4 * k, word));
    let code = [
        routine.collect(),
        unlock(),
        store(FLASH_CR, X32 | 1),
        [
            &load(0, FLASH_SR)[..],
            &load(2, 0),
            &load(3, 0),
            &load(4, SECTOR),
            &load(5, RAM + 0x101),
            &[0x47A8],
        ]
        .concat(),
        [&load(0, RAM)[..], &[0x6002]].concat(),
        STOP.to_vec(),
    ];
    let board = flown(board("in RAM", image(&code.concat(), &STOP)), Time::from_us(200));
    assert_eq!(word(&board, SECTOR), 0);
    let loops = word(&board, RAM);
    // 256 cycles of 16 MHz, five to nine of them each turn.
    assert!((28..=52).contains(&loops), "{loops}");
}

#[test]
fn power_failure_keeps_earlier_words_and_leaves_chosen_remains() {
    for (remains, expected) in [(Remains::Old, u32::MAX), (Remains::New, 0x9ABC_DEF0)] {
        let mut board = on("writer", writer());
        board.cut_power_at(2, remains);
        board.run_until(Time::from_ms(1)).unwrap();
        assert_eq!(*board.state(), State::Off);
        assert_eq!(words(&board, SECTOR), [0x1234_5678, expected]);
    }
    let seen: Vec<_> = (0..40)
        .map(|seed| {
            let mut board = on("writer", writer());
            board.cut_power_at(2, Remains::Mixed(seed));
            board.run_until(Time::from_ms(1)).unwrap();
            word(&board, SECTOR + 4)
        })
        .collect();
    assert!(seen.iter().all(|word| word & 0x9ABC_DEF0 == 0x9ABC_DEF0), "bits to keep are kept");
    let torn = |word: &&u32| **word != u32::MAX && **word != 0x9ABC_DEF0;
    assert!(seen.contains(&u32::MAX) && seen.contains(&0x9ABC_DEF0) && seen.iter().filter(torn).count() > 5);
}

#[test]
fn board_restarts_after_power_failure_that_does_not_recur() {
    let mut board = on("writer", writer());
    board.cut_power_at(1, Remains::Old);
    board.run_until(Time::from_ms(1)).unwrap();
    assert_eq!(board.counters().flash_programs, 1);
    board.power(true);
    board.run_until(Time::from_ms(2)).unwrap();
    assert_eq!(*board.state(), State::Running);
    assert_eq!(words(&board, SECTOR), [0x1234_5678, 0x9ABC_DEF0]);
}

#[test]
fn power_that_fails_in_an_erase_leaves_a_sector_of_old_and_new() {
    let mut board = on("eraser", eraser());
    board.write_flash(SECTOR, &[0x3C; 0x2_0000]).unwrap();
    board.cut_power_at(1, Remains::Mixed(7));
    board.run_until(Time::from_ms(2000)).unwrap();
    assert_eq!(*board.state(), State::Off);
    let content = board.read_memory(SECTOR, 0x2_0000).unwrap();
    let words = |byte: u8| content.chunks(4).filter(|chunk| *chunk == [byte; 4]).count();
    assert!(words(0x3C) > 5000 && words(0xFF) > 5000 && words(0x3C) + words(0xFF) < 30_000);
}

#[test]
fn a_reset_in_an_erase_leaves_nobody_knows_what() {
    let mut board = on("eraser", eraser());
    board.write_flash(SECTOR, &[0x3C; 0x2_0000]).unwrap();
    board.run_until(Time::from_ms(500)).unwrap();
    assert_eq!(word(&board, SECTOR), 0x3C3C_3C3C, "it changes at the end");
    board.reset();
    let content = board.read_memory(SECTOR, 0x2_0000).unwrap();
    assert!(content.contains(&0x3C) && content.contains(&0xFF));
}

/// RM0090 chapter 21: FFFh counts of LSI/4 are 512 ms at 32 kHz, and the core cannot feed the watchdog.
#[test]
fn the_watchdog_bites_a_core_that_waits_for_an_erase() {
    let code = [store(0x4000_3000, 0xCCCC), unlock(), erase(), STOP.to_vec()].concat();
    let mut board = flown(board("starved", image(&code, &STOP)), Time::from_ms(511));
    assert_eq!(board.counters().watchdog_resets, 0);
    board.run_until(Time::from_ms(513)).unwrap();
    assert_eq!(board.counters().watchdog_resets, 1);
}

#[test]
fn a_stray_store_to_flash_stops_the_board() {
    let mut board = on("stray", image(&[store(SECTOR, 0), STOP.to_vec()].concat(), &STOP));
    let error = board.run_until(Time::from_ms(1)).unwrap_err();
    assert_eq!((error.address, error.write, error.refusal), (SECTOR, true, Refusal::Misuse));
    assert_eq!(word(&board, SECTOR), u32::MAX);
}

#[test]
fn controller_acknowledges_while_its_core_waits_for_an_erase() {
    let listener = [join_both_buses(), unlock(), erase(), receive(CAN1, RAM), STOP.to_vec()].concat();
    let asker = [join_both_buses(), send(CAN1, 0x123, 0x1122_3344), STOP.to_vec()].concat();
    let late = BoardConfig { power_on_at: Time::from_ms(500), ..board("asker", image(&asker, &STOP)) };
    let mut spacecraft = spacecraft([board("listener", image(&listener, &STOP)), late]);
    spacecraft.run_until(Time::from_ms(900)).unwrap();
    assert!(!completed(&spacecraft.take_frames()).is_empty(), "somebody acknowledged");
    let listener = |spacecraft: &Spacecraft| {
        let board = spacecraft.board(BoardId(0));
        (board.can_stats(Side::Can1).stored[0], word(board, RAM))
    };
    assert_eq!(listener(&spacecraft).0, 1);
    assert_ne!(listener(&spacecraft).1, 0x1122_3344, "the core has not seen it");
    spacecraft.run_until(Time::from_ms(1010)).unwrap();
    assert_eq!(listener(&spacecraft), (1, 0x1122_3344));
}

#[test]
fn power_failure_takes_board_off_its_bus_in_mid_frame() {
    let request =
        [store(CAN1 + 0x184, 4), store(CAN1 + 0x188, 0x1122_3344), store(CAN1 + 0x180, 0x123 << 21 | 1)]
            .concat();
    let words: Vec<_> = (0..4).flat_map(|k| program(SECTOR + 4 * k, 0)).collect();
    let sender = [join_both_buses(), unlock(), request, words, STOP.to_vec()].concat();
    let listener = [join_both_buses(), receive(CAN1, RAM), STOP.to_vec()].concat();
    let late = BoardConfig { power_on_at: Time::from_ms(1), ..board("sender", image(&sender, &STOP)) };
    let mut spacecraft = spacecraft([late, board("listener", image(&listener, &STOP))]);
    let (sender, listener) = (BoardId(0), BoardId(1));
    // Some 56 us into a frame of at least 76.
    spacecraft.board_mut(sender).cut_power_at(4, Remains::Old);
    spacecraft.run_until(Time::from_ms(10)).unwrap();
    assert_eq!(*spacecraft.board(sender).state(), State::Off);
    assert_eq!(completed(&spacecraft.take_frames()), []);
    assert_eq!(spacecraft.wire(Bus::Nominal).counters().destroyed, 1);
    assert_eq!(spacecraft.board(listener).can_stats(Side::Can1).stored[0], 0);
    spacecraft.power(sender, true);
    spacecraft.run_until(Time::from_ms(20)).unwrap();
    assert_eq!(completed(&spacecraft.take_frames()).len(), 1);
    assert_eq!(word(spacecraft.board(listener), RAM), 0x1122_3344);
    assert_eq!(word(spacecraft.board(sender), SECTOR + 12), 0);
}
