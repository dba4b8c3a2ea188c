//! Decoding and execution are total: no encoding panics, and each runs, faults, or stops with its own word.

mod board;

use board::{Board, CODE, RAM};
use twin_core::{Config, Stop, Unpredictable};

/// A small generator of random numbers (xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) as u32
    }
}

/// Runs one encoding from a random state. An error says that no time passed or that the stop names another word.
fn run(board: &mut Board, random: &mut Random, code: [u16; 2]) -> Result<(), String> {
    let mut fresh = board.clone();
    fresh.memory.poke_code(CODE, &code);
    fresh.core.invalidate(CODE..CODE + 4);
    fresh.set(|registers| {
        for register in &mut registers.r[..13] {
            *register = match random.next() % 4 {
                0 => random.next(),
                1 => random.next() % 64,
                _ => RAM + random.next() % 0x2000,
            };
        }
        for register in &mut registers.s {
            *register = random.next();
        }
        registers.fpscr = random.next();
        registers.xpsr = random.next() & 0xF80F_0000 | 1 << 24;
    });
    match fresh.try_step() {
        Ok(step) if step.cycles == 0 => Err("no time passed".into()),
        Ok(_) | Err(Stop::ResetRequest | Stop::Unmodelled { .. }) => Ok(()),
        Err(Stop::Unpredictable { address, word }) => {
            let whole = u32::from(code[0]) << 16 | u32::from(code[1]);
            let expected = if code[0] >= 0xE800 { whole } else { u32::from(code[0]) };
            if (address, word) == (CODE, expected) { Ok(()) } else { Err(format!("reported {word:08X}")) }
        }
        Err(stop) => Err(format!("{stop:?}")),
    }
}

/// A board that may use its FPU.
fn board() -> Board {
    let mut board = Board::new(&[]);
    board.store(0xE000_ED88, 0x00F0_0000);
    board.memory.accesses.clear();
    board
}

#[test]
fn every_half_word_runs_faults_or_stops() {
    let mut board = board();
    let mut random = Random(0x1234_5678_9ABC_DEF1);
    for first in 0..=0xFFFF {
        let code = [first, random.next() as u16];
        run(&mut board, &mut random, code).unwrap_or_else(|error| panic!("{code:04X?}: {error}"));
    }
}

#[test]
fn a_million_random_words_run_fault_or_stop() {
    let mut board = board();
    let mut random = Random(0x0DDB_1A5E_5BAD_5EED);
    for _ in 0..1_000_000 {
        let code = [(0xE800 + random.next() % 0x1800) as u16, random.next() as u16];
        run(&mut board, &mut random, code).unwrap_or_else(|error| panic!("{code:04X?}: {error}"));
    }
}

#[test]
fn unpredictable_encoding_raises_usage_fault_if_configured() {
    let config = Config { unpredictable: Unpredictable::UsageFault, ..Config::stm32f4(board::FLASH_BYTES) };
    // BX with a bit set that has to be zero.
    let mut board = Board::with_config(&[0x4701], config);
    board.step();
    assert_eq!(board.core.exception(), 3, "UsageFault is not enabled");
    assert_eq!(board.load(0xE000_ED28), 1 << 16, "UNDEFINSTR");

    let mut board = Board::new(&[0x4701]);
    assert_eq!(board.try_step(), Err(Stop::Unpredictable { address: CODE, word: 0x4701 }));
}

/// Random code with random interrupts, from RAM and flash, privileged or not.
#[test]
fn random_programs_with_interrupts_run_or_lock_up() {
    let mut random = Random(0x005E_ED0F_7E57);
    let mut lock_ups = 0;
    for _ in 0..300 {
        let config =
            Config { unpredictable: Unpredictable::UsageFault, ..Config::stm32f4(board::FLASH_BYTES) };
        let program: Vec<u16> = (0..256).map(|_| random.next() as u16).collect();
        let mut board = Board::with_config(&program, config);
        board.store(0xE000_ED88, 0x00F0_0000);
        board.store(0xE000_ED24, 7 << 16);
        board.store(0xE000_E100, random.next());
        board.store(0xE000_E400, random.next());
        board.store(0xE000_E404, random.next());
        for exception in 2..48 {
            // Two random instructions, then the return.
            board.handler(exception, &[random.next() as u16 % 0xE800, random.next() as u16 % 0xE800, 0x4770]);
        }
        for (at, _) in (RAM..).step_by(4).zip(0..0x400) {
            board.memory.poke(at, twin_core::Width::Word, random.next());
        }
        for _ in 0..500 {
            board.core.set_irq((random.next() % 97) as u16, random.next().is_multiple_of(2));
            match board.try_step() {
                Ok(step) => assert!(step.cycles > 0),
                Err(Stop::ResetRequest) => board.core.reset(),
                // Goes on behind the instruction.
                Err(Stop::Unmodelled { instruction, .. }) => {
                    board.set(|registers| registers.r[15] = instruction + 2);
                }
                Err(stop) => panic!("{stop:?}"),
            }
            if board.core.is_locked_up() {
                lock_ups += 1;
                board.core.reset();
            }
            board.memory.accesses.clear();
        }
    }
    assert!(lock_ups > 0, "some programs destroy their stack");
}
