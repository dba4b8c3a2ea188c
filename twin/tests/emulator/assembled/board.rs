//! One board with hand-assembled programs: time, interrupts, sleep, resets, refusals.

use std::sync::Arc;

use can_twin::board::{BoardConfig, EmulatedBoard, State};
use can_twin::crystal::Crystal;
use can_twin::image::Symbol;
use can_twin::mmio::Refusal;
use can_twin::model::Model;
use can_twin::peripherals::PinChange;
use can_twin::pin::Pin;
use can_twin::wire::time::Time;

use super::programs::*;

/// Returns a program that toggles PB4 at every update of TIM2, once per millisecond of the board's own time, and sleeps
/// in between.
pub fn blinker() -> std::sync::Arc<can_twin::image::Image> {
    let program = [
        run_at_168_mhz(),
        store(RCC + 0x30, 1 << 1),
        store(GPIOB, 0x0000_0180),
        store(RCC + 0x40, 1),
        store(TIM2 + 0x28, 83),
        store(TIM2 + 0x2C, 999),
        store(TIM2, 1 << 2),
        store(TIM2 + 0x14, 1),
        store(TIM2 + 0x0C, 1),
        store(NVIC_ISER0, 1 << 28),
        store(TIM2, 1),
        SLEEP.to_vec(),
    ]
    .concat();
    // r0 = TIM2 SR; r1 = 0; STR; r0 = GPIOB ODR; LDR r1, [r0]; EOR r1, r1, #16; STR r1, [r0]; BX lr
    let handler =
        [&store(TIM2 + 0x10, 0)[..], &load(0, GPIOB + 0x14), &[0x6801, 0xF081, 0x0110, 0x6001], &RETURN]
            .concat();
    image(&program, &handler)
}

fn toggles(ppm: f64, until: Time) -> Vec<PinChange> {
    flown(BoardConfig { crystal: Crystal::ppm(ppm), ..board("blinker", blinker()) }, until).take_pin_changes()
}

#[test]
fn a_timer_interrupt_wakes_the_core_every_millisecond() {
    let changes = toggles(0.0, Time::from_ms(1000));
    let pin = Pin::new('B', 4);
    assert!(changes.iter().all(|change| change.pin == pin));
    assert!((990..=998).contains(&changes.len()), "the oscillators take 2.2 ms: {}", changes.len());
    for pair in changes.windows(2) {
        assert_eq!(pair[1].at.since(pair[0].at), Time::from_ms(1));
        assert_ne!(pair[0].high, pair[1].high);
    }
}

#[test]
fn the_crystals_error_shows_in_the_boards_time() {
    let span = |ppm| {
        let changes = toggles(ppm, Time::from_ms(1010));
        changes[900].at.since(changes[0].at)
    };
    // 900 ms on a crystal that is 100 ppm fast last 900 ms / 1.0001 = 899.910009 ms = 302 369 763.02 ticks.
    let fast = span(100.0).0;
    assert!(fast.abs_diff(302_369_763) <= 3, "{fast}");
    let slow = span(-100.0).0;
    // 900 ms / 0.9999 = 900.090009 ms = 302 430 243.02 ticks.
    assert!(slow.abs_diff(302_430_243) <= 3, "{slow}");
}

#[test]
fn sleep_costs_no_instructions() {
    let board = flown(board("blinker", blinker()), Time::from_ms(1000));
    let awake = board.counters().cycles_awake;
    // About a thousand interrupts of some 40 cycles and the start; a core awake all the time has 168 000 000.
    assert!(awake < 200_000, "{awake}");
}

#[test]
fn the_same_flight_gives_the_same_instants_whatever_the_stride() {
    let reference = toggles(12.5, Time::from_ms(50));
    for stride_us in [1, 7, 333] {
        let mut board = powered(BoardConfig { crystal: Crystal::ppm(12.5), ..board("blinker", blinker()) });
        let mut now = Time::ZERO;
        while now < Time::from_ms(50) {
            now = (now + Time::from_us(stride_us)).min(Time::from_ms(50));
            board.run_until(now).unwrap();
        }
        assert_eq!(board.take_pin_changes(), reference, "strides of {stride_us} us");
    }
}

#[test]
fn straps_are_read_as_the_harness_ties_them() {
    let gpioc = 0x4002_0800;
    let program =
        [store(RCC + 0x30, 1 << 2), store(gpioc + 0x0C, 0x5555_5555), copy(gpioc + 0x10, RAM), STOP.to_vec()]
            .concat();
    let straps = vec![(Pin::new('C', 0), false), (Pin::new('C', 5), false), (Pin::new('C', 6), true)];
    let board = flown(BoardConfig { straps, ..board("strapped", image(&program, &STOP)) }, Time::from_us(50));
    assert_eq!(word(&board, RAM), 0xFFFF & !(1 << 0) & !(1 << 5));
}

#[test]
fn access_to_unmodelled_address_names_board_pc_and_address() {
    let program = [store(0x4000_7400, 1), STOP.to_vec()].concat();
    let mut board = powered(board("lost", image(&program, &STOP)));
    let error = board.run_until(Time::from_us(50)).unwrap_err();
    assert_eq!((error.address, error.write, error.refusal), (0x4000_7400, true, Refusal::Unmodelled));
    // Reset vector at 200h, four 32-bit moves before the store.
    assert_eq!(error.pc, 0x0800_0210);
    let text = error.to_string();
    for part in ["lost", "08000210h", "DAC.CR", "40007400h"] {
        assert!(text.contains(part), "{text}");
    }
    assert_eq!(*board.state(), State::Refused(error));
    let counted = board.counters().instructions;
    board.run_until(Time::from_ms(1)).unwrap();
    assert_eq!(board.counters().instructions, counted, "it stays stopped");
}

/// Given a store to ITM_TER, which the core does not have, then the board stops before the store.
#[test]
fn unmodelled_system_register_stops_the_board() {
    let error = refused(board("traced", image(&store(0xE000_0E00, 1), &STOP)), Time::from_us(50));
    assert_eq!((error.address, error.write, error.refusal), (0xE000_0E00, true, Refusal::SystemRegister));
    assert_eq!(error.pc, 0x0800_0210);
    let text = error.to_string();
    for part in ["traced", "store to a system register of the core", "E0000E00h", "08000210h"] {
        assert!(text.contains(part), "{text}");
    }
}

/// Given BX r0 with one of its low three bits set, which should be zero (DDI 0403E A7.7.20), then the board stops before it.
#[test]
fn unpredictable_instruction_stops_the_board() {
    let error = refused(board("odd", image(&[0xBF00, 0x4701], &STOP)), Time::from_us(50));
    assert_eq!((error.pc, error.refusal), (0x0800_0202, Refusal::Unpredictable { word: 0x4701 }));
    let text = error.to_string();
    assert!(text.starts_with("odd: UNPREDICTABLE instruction 4701h at 08000202h"), "{text}");
}

#[test]
fn memory_that_the_part_lacks_is_refused_too() {
    let error = refused(board("lost", image(&copy(0x6000_0000, RAM), &STOP)), Time::from_us(50));
    assert_eq!((error.address, error.pc), (0x6000_0000, 0x0800_0208));
}

#[test]
fn a_peripheral_without_clock_is_refused() {
    let error = refused(board("hasty", image(&store(GPIOB, 0), &STOP)), Time::from_us(50));
    assert_eq!((error.address, error.refusal), (GPIOB, Refusal::ClockOff));
}

#[test]
fn a_fault_without_a_handler_that_helps_counts_as_a_panic() {
    // UDF #0 after reset, B . as HardFault handler.
    let board = flown(board("faulty", image(&[0xDE00], &STOP)), Time::from_ms(1));
    assert_eq!(*board.state(), State::Stuck);
    assert_eq!((board.counters().panics, board.counters().lockups), (1, 0));
}

/// Returns a handler that counts its entries in `RAM`.
fn counting_handler() -> Vec<u16> {
    [&load(0, RAM)[..], &[0x6801, 0x3101, 0x6001], &RETURN].concat() // LDR r1, [r0]; ADDS r1, #1; STR r1, [r0]
}

/// SysTick every 1000 cycles of 16 MHz: 16 a millisecond, its first after 1000 and one for the reload (DDI 0403 B3.3.1).
#[test]
fn systick_wakes_a_sleeping_core_at_its_cycle() {
    for (control, expected) in [(0b111, 15), (0b101, 0)] {
        let start =
            [store(RAM, 0), store(SYST_RVR, 999), store(SYST_CVR, 0), store(SYST_CSR, control)].concat();
        let program = [start, SLEEP.to_vec()];
        let program = image(&program.concat(), &counting_handler());
        let mut board = flown(board("ticking", program), Time::from_us(999));
        assert_eq!(word(&board, RAM), expected, "SYST_CSR {control:b}b");
        assert!(board.counters().instructions < 300, "the cycles between are skipped");
        board.run_until(Time::from_us(1010)).unwrap();
        assert_eq!(word(&board, RAM), if control & 2 == 0 { 0 } else { expected + 1 });
    }
}

/// Given a core that waits 16 us for its flash, when the store is done, then SysTick has counted 256 cycles of 16 MHz.
#[test]
fn systick_counts_while_the_core_waits_for_flash() {
    const FLASH: u32 = 0x4002_3C00;
    let program = [
        store(FLASH + 0x04, 0x4567_0123),
        store(FLASH + 0x04, 0xCDEF_89AB),
        store(FLASH + 0x10, 0x201),
        store(SYST_RVR, 0xFF_FFFF),
        store(SYST_CVR, 0),
        store(SYST_CSR, 0b101),
        copy(SYST_CVR, RAM),
        store(0x080E_0000, 0),
        copy(SYST_CVR, RAM + 4),
        STOP.to_vec(),
    ];
    let board = flown(board("waiting", image(&program.concat(), &STOP)), Time::from_us(100));
    let passed = word(&board, RAM) - word(&board, RAM + 4);
    assert!((256..256 + 60).contains(&passed), "{passed} cycles");
}

#[test]
fn a_fault_in_the_fault_handler_locks_up() {
    let board = flown(board("faulty", image(&[0xDE00], &[0xDE00])), Time::from_ms(1));
    assert_eq!(*board.state(), State::LockedUp);
    assert_eq!(board.counters().lockups, 1);
}

#[test]
fn a_system_reset_starts_the_program_again_and_says_so_in_csr() {
    // A word in RAM survives the reset: the first pass resets, the second copies RCC_CSR.
    let program = [
        &load(0, RAM)[..],
        &load(2, 0x600D_CAFE),
        &[0x6801, 0x4291, 0xD00A], // LDR r1, [r0]; CMP r1, r2; BEQ over the reset
        &[0x6002],                 // STR r2, [r0]
        &store(0xE000_ED0C, 0x05FA_0004),
        &STOP,
        &copy(RCC + 0x74, RAM + 4),
        &STOP,
    ]
    .concat();
    let board = flown(board("phoenix", image(&program, &STOP)), Time::from_us(100));
    assert_eq!(board.counters().system_resets, 1);
    // Power-on flags and brown-out, pin, software (RM0090 7.3.21).
    assert_eq!(word(&board, RAM + 4), 0x1E00_0000);
}

#[test]
fn power_off_forgets_ram_and_reset_does_not() {
    let program = [&load(0, RAM)[..], &[0x6801, 0x3101, 0x6001], &STOP].concat(); // RAM word += 1
    let mut board = flown(board("counting", image(&program, &STOP)), Time::from_us(50));
    let first = word(&board, RAM);
    board.reset();
    board.run_until(Time::from_us(100)).unwrap();
    assert_eq!(word(&board, RAM), first + 1);
    board.power(false);
    board.power(true);
    board.run_until(Time::from_us(150)).unwrap();
    assert_eq!(word(&board, RAM), first);
}

/// SLEEPDEEP is bit 2 of SCR (DDI 0403 B3.2.7).
#[test]
fn a_sleep_that_would_be_stop_is_refused_at_its_instruction() {
    let scr = store(0xE000_ED10, 1 << 2);
    let error = refused(board("stop", image(&[&scr[..], &SLEEP].concat(), &STOP)), Time::from_ms(1));
    assert_eq!(error.refusal, Refusal::DeepSleep);
    let text = error.to_string();
    assert!(text.contains("WFI or WFE at 0800021"), "{text}");
    assert!(text.contains("Stop and Standby are not modelled, clear SLEEPDEEP in SCR"), "{text}");
}

/// Given a program that logs by RTT without defmt, when it writes lines of text, then each whole line is in the log; a reset ends the
/// last one.
#[test]
fn rtt_without_defmt_is_shown_as_text() {
    let (block, buffer) = (RAM + 0x100, RAM + 0x200);
    let words = |at: u32, bytes: &[u8]| -> Vec<u16> {
        let words = bytes.chunks(4).map(|chunk| {
            let mut word = [0; 4];
            word[..chunk.len()].copy_from_slice(chunk);
            u32::from_le_bytes(word)
        });
        (at..).step_by(4).zip(words).flat_map(|(at, word)| store(at, word)).collect()
    };
    let text = b"one line\r\nand another\nhalf a";
    let program = [
        words(block, b"SEGGER RTT\0\0\0\0\0\0\x01"),
        words(buffer, text),
        store(block + 28, buffer).to_vec(),
        store(block + 32, 64).to_vec(),
        store(block + 40, 0).to_vec(),
        store(block + 36, text.len() as u32).to_vec(),
        STOP.to_vec(),
    ]
    .concat();
    let with_log = Arc::into_inner(image(&program, &STOP)).expect("nobody shares it");
    let with_log = with_log.with_symbol("_SEGGER_RTT", Symbol { address: block, size: 48 });
    let mut board = flown(board("talking", Arc::new(with_log)), Time::from_us(100));
    let lines = |board: &mut EmulatedBoard| -> Vec<_> {
        board.take_log().into_iter().map(|line| (line.level, line.text)).collect()
    };
    assert_eq!(lines(&mut board), [(None, "one line".to_owned()), (None, "and another".to_owned())]);
    board.reset();
    board.run_until(Time::from_us(200)).unwrap();
    assert_eq!(lines(&mut board)[0], (None, "half a".to_owned()));
    assert_eq!(board.counters().malformed_logs, 0);
}

/// Given a load or store at a reserved address, then the bus raises a fault at that address (BFSR 82h: precise, address
/// valid), and the program continues in its handler. The same holds for a fetch from CCM, which the instruction bus
/// does not reach (RM0090 2.3.1).
#[test]
fn reserved_address_is_a_bus_fault_that_a_program_survives() {
    // Enables BusFault; CFSR and BFAR go to RAM.
    let enable = store(0xE000_ED24, 1 << 17);
    let handler = [copy(0xE000_ED28, RAM), copy(0xE000_ED38, RAM + 4), STOP.to_vec()].concat();
    let flown = |model, program: &[u16]| {
        let program = [&enable[..], program, &STOP].concat();
        let config = BoardConfig { model, ..board("lost", image(&program, &handler)) };
        let board = flown(config, Time::from_us(50));
        assert_eq!((board.state(), board.counters().panics), (&State::Running, 0), "{model:?}");
        words(&board, RAM)
    };
    for (model, reserved) in [
        (
            Model::shipped("pyboard-v11"),
            [0x0010_0000, 0x0810_0000, 0x1001_0000, 0x2002_0000, 0x4000_7800, 0xA000_1000],
        ),
        (
            Model::shipped("nucleo-f446re"),
            [0x0008_0000, 0x0808_0000, 0x1000_0000, 0x4002_2000, 0x5006_0800, 0xA000_2000],
        ),
    ] {
        for address in reserved {
            assert_eq!(flown(model, &copy(address, RAM + 8)), [0x8200, address], "{model:?}: load");
            assert_eq!(flown(model, &store(address, 1)), [0x8200, address], "{model:?}: store");
        }
    }
    // MOV pc, r2: IBUSERR, without an address.
    let [status, _] = flown(Model::shipped("pyboard-v11"), &[&load(2, 0x1000_0000)[..], &[0x4697]].concat());
    assert_eq!(status, 0x0100);
}

/// Given a store to flash at its mapping from zero on, then the board stops, and its message names a store and the
/// flash.
#[test]
fn store_to_address_zero_stops_the_board_as_a_store() {
    let error = refused(board("null", image(&store(0, 1), &STOP)), Time::from_us(50));
    assert_eq!((error.address, error.write, error.refusal), (0, true, Refusal::Unmodelled));
    assert_eq!(error.pc, 0x0800_0210);
    let text = error.to_string();
    assert!(text.contains("null: store to flash at zero + 0h (00000000h)"), "{text}");
}

/// Given parts of the memory map that exist but are not modelled, then a load or store stops the board, also if the
/// program would survive a bus fault.
#[test]
fn memory_without_a_model_stops_the_board_with_its_name() {
    for (address, name) in [
        (0x1FFF_0000, "system memory + 0h"),
        (0x1FFF_7800, "OTP area + 0h"),
        (0x4002_4000, "BKPSRAM + 0h"),
        (0x6000_0000, "external memory + 0h"),
        (0xA000_0000, "FSMC + 0h"),
    ] {
        for (access, write) in [(copy(address, RAM), false), (store(address, 1), true)] {
            let program = [store(0xE000_ED24, 1 << 17), access].concat();
            let error = refused(board("lost", image(&program, &RETURN)), Time::from_us(50));
            assert_eq!((error.address, error.write, error.refusal), (address, write, Refusal::Unmodelled));
            assert!(error.to_string().contains(name), "{error}");
        }
    }
}

/// Given a stack that grows below CCM (F405) or RAM (F446), then the bus raises a fault, and the fault handler runs on
/// another stack, because the frame is lost.
#[test]
fn stack_that_grows_below_memory_is_a_fault_of_the_program() {
    for (model, bottom) in
        [(Model::shipped("pyboard-v11"), 0x1000_0000), (Model::shipped("nucleo-f446re"), RAM)]
    {
        // MOV sp, r2; PUSH {r0-r7}; B .-2
        let program = [&load(2, bottom + 0x28)[..], &[0x4695, 0xB4FF, 0xE7FD]].concat();
        // MOV r3, sp; r2 = RAM + 1000h; MOV sp, r2; PUSH {r3}; B .
        let handler = [&[0x466B][..], &load(2, RAM + 0x1000), &[0x4695, 0xB408], &STOP].concat();
        let config = BoardConfig { model, ..board("deep", image(&program, &handler)) };
        let board = flown(config, Time::from_us(50));
        assert_eq!((board.state(), board.counters().panics), (&State::Stuck, 1), "{model:?}");
        // 8 registers fit, the next 8 do not: the frame of 32 bytes is below the stack pointer of the second PUSH.
        let stack = word(&board, RAM + 0xFFC);
        assert!(stack < bottom, "{model:?}: {stack:08X}h");
    }
}
