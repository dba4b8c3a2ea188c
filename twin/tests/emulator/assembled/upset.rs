//! Upsets of a board: bits of timers, clocks, watchdog, core and memory, and what the program makes of them.

use can_twin::board::{CoreRegister, EmulatedBoard, State, Use, Uses};
use can_twin::mmio::Refusal;
use can_twin::spacecraft::{BoardId, Spacecraft, SpacecraftConfig};
use can_twin::wire::time::Time;

use super::board::blinker;
use super::programs::*;

const RCC_APB1RSTR: u32 = RCC + 0x20;
const RCC_APB1LPENR: u32 = RCC + 0x60;
const TIM2_CNT: u32 = TIM2 + 0x24;
const TIM2_PSC: u32 = TIM2 + 0x28;
/// DAC, which the model lacks.
const DAC: u32 = 0x4000_7400;
/// FSMC, which the model lacks.
const FSMC: u32 = 0xA000_0000;
/// Time of the upset.
const UPSET: Time = Time::from_ms(10);

/// A board that toggles a pin each millisecond, in flight.
fn toggling() -> EmulatedBoard {
    let mut board = flown(board("blinker", blinker()), UPSET);
    board.take_pin_changes();
    board
}

/// Returns the number of toggles in 100 ms.
fn toggles(mut board: EmulatedBoard) -> usize {
    board.run_until(UPSET + Time::from_ms(100)).unwrap();
    board.take_pin_changes().len()
}

/// Given a timer that wakes the core, when it loses its low-power enable, then it stands as long as the core sleeps.
#[test]
fn timer_without_low_power_enable_stands_in_sleep() {
    assert_eq!(toggles(toggling()), 100);
    let mut board = toggling();
    board.flip_register(RCC_APB1LPENR, 0).unwrap();
    assert_eq!(toggles(board), 0);
    let mut other = toggling();
    other.flip_register(RCC_APB1LPENR, 1).unwrap();
    assert_eq!(toggles(other), 100, "TIM3 is not in use");
}

#[test]
fn timer_that_is_held_in_reset_stands() {
    let mut board = toggling();
    board.flip_register(RCC_APB1RSTR, 0).unwrap();
    assert_eq!(toggles(board), 0);
}

#[test]
fn timer_with_a_flipped_bit_counts_as_it_says() {
    // PSC 83 becomes 67, from the next overflow on.
    let mut faster = toggling();
    faster.flip_register(TIM2_PSC, 4).unwrap();
    let count = toggles(faster);
    assert!((123..=124).contains(&count), "{count}");
    // ARR is 999: the counter has to pass all of its 32 bits.
    let mut beyond = toggling();
    beyond.flip_register(TIM2_CNT, 16).unwrap();
    assert_eq!(toggles(beyond), 0);
}

#[test]
fn masked_interrupt_wakes_the_core_and_is_not_handled() {
    let mut board = toggling();
    board.flip_core(CoreRegister::Primask, 0);
    assert_eq!(toggles(board), 0);
    let mut board = toggling();
    assert!(board.flip_register(0xE000_E100, 28).is_ok(), "NVIC.ISER0");
    assert_eq!(toggles(board), 0);
}

/// Given a watchdog of 4 s that a program reloads once, when bits of its registers flip, then the prescaler applies at once, and the
/// reload value at the next reload.
#[test]
fn watchdog_takes_a_flipped_prescaler_at_once() {
    let program =
        [store(IWDG, 0x5555), store(IWDG + 4, 3), store(IWDG, 0xCCCC), store(IWDG, 0xAAAA), STOP.to_vec()]
            .concat();
    let start = || flown(board("watched", image(&program, &RETURN)), UPSET);
    let resets = |mut board: EmulatedBoard, ms| {
        board.run_until(Time::from_ms(ms)).unwrap();
        board.counters().watchdog_resets
    };
    assert_eq!(resets(start(), 4_000), 0);
    let mut faster = start();
    faster.flip_register(IWDG + 4, 1).unwrap();
    assert_eq!((resets(faster.clone(), 1_000), resets(faster, 1_050)), (0, 1));
    let mut later = start();
    later.flip_register(IWDG + 8, 11).unwrap();
    assert_eq!((resets(later.clone(), 4_000), resets(later, 4_150)), (0, 1));
}

/// Given a program that accesses a block without clock, one that the model lacks, and flash, then a tolerant chip ignores it.
#[test]
fn tolerant_chip_ignores_what_the_part_ignores() {
    let program = [
        store(GPIOB, 1),
        copy(GPIOB + 0x10, RAM),
        store(DAC, 1),
        copy(FSMC, RAM),
        store(0x0800_0F00, 0),
        store(0x0000_0F00, 0),
        store(RAM + 4, 7),
        STOP.to_vec(),
    ]
    .concat();
    let config = || board("stray", image(&program, &STOP));
    let mut strict = EmulatedBoard::new(config(), 1);
    strict.power(true);
    assert_eq!(strict.run_until(UPSET).map_err(|error| error.refusal), Err(Refusal::ClockOff));
    let mut board = EmulatedBoard::new(config(), 1);
    board.tolerate_upsets();
    board.power(true);
    board.run_until(UPSET).unwrap();
    assert_eq!(*board.state(), State::Running);
    assert_eq!(board.read_memory(RAM, 8).unwrap(), [0, 0, 0, 0, 7, 0, 0, 0]);
    assert_eq!(board.read_memory(0x0800_0F00, 4).unwrap(), [0xFF; 4]);
}

#[test]
fn first_use_of_each_byte_is_recorded() {
    let program =
        [copy(RAM + 4, RAM + 8), store(RAM + 4, 1), copy(RAM + 8, RAM + 12), STOP.to_vec()].concat();
    let mut board = EmulatedBoard::new(board("uses", image(&program, &STOP)), 1);
    board.power(true);
    board.watch_memory();
    board.run_until(UPSET).unwrap();
    let uses = board.take_uses().unwrap();
    let at = |offset| uses.at(RAM + offset);
    assert_eq!(
        [at(0), at(4), at(7), at(8), at(12), at(16)],
        [Use::None, Use::Read, Use::Read, Use::Written, Use::Written, Use::None]
    );
    assert_eq!(board.take_uses(), None);
}

/// Given two copies of a flight, then they continue alike. When a bit of one flips in a byte that is not used, then they are not equal.
#[test]
fn copies_are_equal_until_a_bit_flips() {
    let mut craft = Spacecraft::new(SpacecraftConfig::default());
    craft.add_board(board("blinker", blinker()));
    craft.run_until(UPSET).unwrap();
    let mut copy = craft.clone();
    for craft in [&mut craft, &mut copy] {
        craft.run_until(UPSET + Time::from_ms(5)).unwrap();
        craft.take_logs();
        craft.take_frames();
    }
    assert!(copy.continues_as(&craft, &[]));
    copy.board_mut(BoardId(0)).flip_memory(RAM + 0x2000, 3).unwrap();
    assert!(!copy.continues_as(&craft, &[]));
    copy.board_mut(BoardId(0)).flip_memory(RAM + 0x2000, 3).unwrap();
    assert!(copy.continues_as(&craft, &[]));
}

/// Given a program that reads, writes and leaves alone some words later, then a copy continues alike with a bit flipped in a byte that is
/// written first or not used, and does not with a bit flipped in one that is read.
#[test]
fn bytes_that_are_read_later_count_and_others_do_not() {
    const BEGUN: Time = Time::from_us(10);
    let begin = store(RAM + 0x100, 1).repeat(60);
    let program = [begin, copy(RAM + 4, RAM + 8), store(RAM + 4, 1), STOP.to_vec()].concat();
    let mut reference = spacecraft([board("uses", image(&program, &STOP))]);
    reference.run_until(BEGUN).unwrap();
    let later = uses_until(&reference, UPSET);
    let is_equal = |address, later: &[Uses]| {
        let mut copy = reference.clone();
        copy.board_mut(BoardId(0)).flip_memory(address, 3).unwrap();
        copy.continues_as(&reference, later)
    };
    assert_eq!([RAM, RAM + 4, RAM + 8].map(|address| is_equal(address, &later)), [true, false, true]);
    assert_eq!([RAM, RAM + 4, RAM + 8].map(|address| is_equal(address, &[])), [false; 3]);
}

/// Given a program that uses neither FPU nor DMA, then their registers do not count, and those that it uses do.
#[test]
fn registers_without_effect_do_not_count() {
    const DMA1_S0M1AR: u32 = 0x4002_6020;
    const GPIOB_OSPEEDR: u32 = GPIOB + 8;
    let program = [store(RCC + 0x30, 1 << 1 | 1 << 21), store(GPIOB, 0x180), STOP.to_vec()].concat();
    let mut reference = spacecraft([board("still", image(&program, &STOP))]);
    reference.run_until(UPSET).unwrap();
    let later = uses_until(&reference, UPSET + UPSET);
    let is_equal = |flip: &dyn Fn(&mut EmulatedBoard), later: &[Uses]| {
        let [mut copy, mut reference] = [&reference; 2].map(Spacecraft::clone);
        flip(copy.board_mut(BoardId(0)));
        for craft in [&mut copy, &mut reference] {
            craft.run_until(UPSET + Time::from_ms(1)).unwrap();
        }
        copy.continues_as(&reference, later)
    };
    let flip_register = |address| move |board: &mut EmulatedBoard| board.flip_register(address, 4).unwrap();
    let flips: [&dyn Fn(&mut EmulatedBoard); 3] = [
        &|board| board.flip_core(CoreRegister::S(3), 7),
        &flip_register(DMA1_S0M1AR),
        &flip_register(GPIOB_OSPEEDR),
    ];
    for flip in flips {
        assert_eq!((is_equal(flip, &later), is_equal(flip, &[])), (true, false));
    }
    assert!(!is_equal(&flip_register(GPIOB), &later), "MODER has an effect");
    assert!(!is_equal(&|board| board.flip_core(CoreRegister::R(4), 7), &later));
}

/// Returns the uses of each board of a copy of a flight until `until`.
fn uses_until(craft: &Spacecraft, until: Time) -> Vec<Uses> {
    let mut copy = craft.clone();
    copy.board_mut(BoardId(0)).watch_memory();
    copy.run_until(until).unwrap();
    copy.board_mut(BoardId(0)).take_uses().into_iter().collect()
}

/// Given a running board, then each bit of its registers flips, or is refused for a reason of the part.
#[test]
fn each_listed_bit_flips_or_is_refused() {
    let start = toggling();
    let registers = start.state_registers();
    for name in [
        "TIM2.PSC",
        "RCC.APB1LPENR",
        "GPIOB.MODER",
        "IWDG.RLR",
        "FLASH.ACR",
        "FPB.FP_COMP7",
        "NVIC.ISER0",
        "SysTick.LOAD",
    ] {
        assert!(registers.iter().any(|register| register.name == name), "{name}");
    }
    for name in ["CAN1", "CRC"] {
        assert!(!registers.iter().any(|register| register.name.starts_with(name)), "{name} has no clock");
    }
    let mut refused = 0;
    let mut bits = 0;
    for register in &registers {
        for bit in (0..32).filter(|bit| register.bits >> bit & 1 == 1) {
            bits += 1;
            refused += usize::from(start.clone().flip_register(register.address, bit).is_err());
        }
    }
    assert!(bits > 1_000 && refused * 20 < bits, "{refused} of {bits} bits are refused");
    assert_eq!(start.clone().flip_register(TIM2_PSC, 16), Err(Refusal::Unmodelled));
}
