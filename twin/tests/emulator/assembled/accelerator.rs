//! FLASH_ACR under hand-assembled programs: stale lines, wait states, what the manual forbids.

use std::sync::Arc;

use can_twin::board::{BoardConfig, Defect, EmulatedBoard, Fittings, FlashTiming};
use can_twin::image::Image;
use can_twin::mmio::Refusal;
use can_twin::wire::time::Time;

use super::programs::*;

const PRFTEN: u32 = 1 << 8;
const ICEN: u32 = 1 << 9;
const DCEN: u32 = 1 << 10;
const DCRST: u32 = 1 << 12;

fn on(image: Arc<Image>, fittings: Fittings) -> EmulatedBoard {
    powered(BoardConfig { fittings, ..board("accelerated", image) })
}

/// Loads a word, erases its sector, loads it again; `reset` comes in between.
fn erase_between_loads(reset: &[u16]) -> [u32; 2] {
    let program = [
        store(FLASH_ACR, ICEN | DCEN),
        copy(SECTOR + 4, RAM),
        unlock(),
        store(FLASH_CR, ERASE),
        wait_for_clear(FLASH_SR, BSY),
        reset.to_vec(),
        copy(SECTOR + 4, RAM + 4),
        STOP.to_vec(),
    ];
    let mut board = on(image(&program.concat(), &STOP), Fittings::default());
    board.write_flash(SECTOR, &[0x3C; 16]).unwrap();
    board.run_until(Time::from_ms(1_001)).unwrap();
    assert_eq!(word(&board, SECTOR + 4), u32::MAX, "the flash itself is erased");
    words::<2>(&board, RAM)
}

#[test]
fn load_after_an_erase_is_stale_until_the_cache_is_reset() {
    assert_eq!(erase_between_loads(&[]), [0x3C3C_3C3C; 2]);
    let reset =
        [store(FLASH_ACR, ICEN), store(FLASH_ACR, ICEN | DCRST), store(FLASH_ACR, ICEN | DCEN)].concat();
    assert_eq!(erase_between_loads(&reset), [0x3C3C_3C3C, u32::MAX]);
    assert_eq!(erase_between_loads(&store(FLASH_ACR, ICEN)), [0x3C3C_3C3C, u32::MAX], "switched off");
}

/// RM0090 3.5.2: a store to flash changes the data in the cache as well.
#[test]
fn load_after_programming_is_not_stale() {
    let program = [
        store(FLASH_ACR, DCEN),
        copy(SECTOR, RAM),
        unlock(),
        store(FLASH_CR, X32 | 1),
        store(SECTOR, 0x1234_5678),
        wait_for_clear(FLASH_SR, BSY),
        copy(SECTOR, RAM + 4),
        STOP.to_vec(),
    ];
    let board = flown(board("accelerated", image(&program.concat(), &STOP)), Time::from_us(200));
    assert_eq!(words::<2>(&board, RAM), [u32::MAX, 0x1234_5678]);
}

/// Given a worn word in the data cache, when it is programmed, then a load shows what was stored (RM0090 3.6.4). After a reset of the
/// cache it shows what flash holds.
#[test]
fn load_of_a_worn_word_shows_the_stored_value_until_the_reset() {
    let program = [
        store(FLASH_ACR, DCEN),
        copy(SECTOR, RAM),
        unlock(),
        store(FLASH_CR, X32 | 1),
        store(SECTOR + 4, 0x1234_5678),
        wait_for_clear(FLASH_SR, BSY),
        copy(SECTOR + 4, RAM),
        store(FLASH_ACR, 0),
        store(FLASH_ACR, DCRST),
        store(FLASH_ACR, DCEN),
        copy(SECTOR + 4, RAM + 4),
        STOP.to_vec(),
    ];
    let mut board = EmulatedBoard::new(board("worn", image(&program.concat(), &STOP)), 0);
    board.inflict(Defect::WornFlash { address: SECTOR + 4, bits: 0x0000_0180 });
    board.power(true);
    board.run_until(Time::from_us(200)).unwrap();
    assert_eq!(words::<2>(&board, RAM), [0x1234_5678, 0x1234_57F8]);
    assert_eq!(word(&board, SECTOR + 4), 0x1234_57F8);
}

/// 160 NOPs of 16 bits are 20 lines. At 168 MHz each line costs five cycles more; prefetch and ideal memory hide them.
#[test]
fn straight_code_costs_the_wait_states_that_acr_says() {
    const BSRR: u32 = GPIOB + 0x18;
    const CYCLE: u64 = 2; // ticks at 168 MHz
    let span = |nops: usize, acr: u32, flash_timing: FlashTiming| {
        let program = [
            run_at_168_mhz(),
            store(FLASH_ACR, acr),
            store(RCC + 0x30, 1 << 1),
            store(GPIOB, 0x0000_0180),
            store(BSRR, 1 << 4),
            [0xBF00].repeat(nops),
            store(BSRR, 1 << 20),
            STOP.to_vec(),
        ];
        let program = image(&program.concat(), &STOP);
        let mut board = on(program, Fittings { flash_timing, ..Fittings::default() });
        board.run_until(Time::from_ms(3)).unwrap();
        let changes = board.take_pin_changes();
        changes[1].at.since(changes[0].at).0 / CYCLE
    };
    for (acr, timing, expected) in [
        (5, FlashTiming::AsSet, 160 + 20 * 5),
        (7, FlashTiming::AsSet, 160 + 20 * 7),
        (5 | PRFTEN, FlashTiming::AsSet, 160),
        (5 | PRFTEN | ICEN, FlashTiming::Unaccelerated, 160 + 20 * 5),
        (5, FlashTiming::Ideal, 160),
    ] {
        assert_eq!(span(168, acr, timing) - span(8, acr, timing), expected, "ACR {acr:X}h, {timing:?}");
    }
}

#[test]
fn too_few_wait_states_for_the_clock_stop_the_board() {
    let too_early = [store(FLASH_ACR, 4), run_at_168_mhz()[9..].to_vec(), STOP.to_vec()];
    let too_late = [run_at_168_mhz(), store(FLASH_ACR, PRFTEN | 4), STOP.to_vec()];
    for (name, program, address) in [("early", too_early, RCC + 0x08), ("late", too_late, FLASH_ACR)] {
        let error = refused(board(name, image(&program.concat(), &STOP)), Time::from_ms(5));
        assert_eq!((error.address, error.write, error.refusal), (address, true, Refusal::Misuse), "{name}");
    }
}

#[test]
fn prefetch_on_revision_a_stops_the_board() {
    for (revision_a, refused) in [(false, false), (true, true)] {
        let program = image(&[store(FLASH_ACR, PRFTEN), STOP.to_vec()].concat(), &STOP);
        let mut board = on(program, Fittings { revision_a, ..Fittings::default() });
        let error = board.run_until(Time::from_us(100)).err();
        assert_eq!(error.map(|error| error.address), refused.then_some(FLASH_ACR));
    }
}

/// A cache is reset while it is off; the other one may be on.
#[test]
fn cache_is_reset_while_it_is_off() {
    for (acr, reset, refused) in [(DCEN, DCRST, true), (ICEN, DCRST | ICEN, false), (0, DCRST, false)] {
        let program = [store(FLASH_ACR, acr), store(FLASH_ACR, reset), STOP.to_vec()].concat();
        let mut board = on(image(&program, &STOP), Fittings::default());
        assert_eq!(board.run_until(Time::from_us(100)).is_err(), refused, "{acr:X}h, then {reset:X}h");
    }
}
