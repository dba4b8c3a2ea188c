//! Decoding and execution are total: each encoding is executed, or raises a UsageFault, or is UNPREDICTABLE.
//!
//! Of an UNPREDICTABLE encoding the core stops with its word, or raises a UsageFault where the Config asks for it.

use can_twin::cpu::{Config, Registers, Stop, Unpredictable};

use crate::board::*;

/// Two boards that differ in their treatment of UNPREDICTABLE encodings. Both may use their FPU and have all fault handlers.
struct Boards {
    stopping: Board,
    faulting: Board,
    random: Random,
}

/// Number of encodings by outcome.
#[derive(Debug, Default, PartialEq, Eq)]
struct Outcomes {
    /// The instruction was executed, an access was refused, or it called an exception.
    executed: u32,
    /// UsageFault with either setting of the Config.
    usage_fault: u32,
    /// UNPREDICTABLE.
    stopped: u32,
}

impl Boards {
    fn new(seed: u64) -> Self {
        let prepared = |unpredictable| {
            let mut board = Board::with_config(&[], Config { unpredictable, ..Config::stm32f4(FLASH_BYTES) });
            board.store(CPACR, FPU_FOR_ALL);
            board.store(SHCSR, ALL_FAULTS);
            board.bus.accesses.clear();
            board
        };
        Boards {
            stopping: prepared(Unpredictable::Stop),
            faulting: prepared(Unpredictable::UsageFault),
            random: Random(seed),
        }
    }

    /// Random registers. Three in four core registers are small or point to RAM.
    fn state(&mut self, before: Registers) -> Registers {
        let mut next = || self.random.next();
        let mut state = before;
        for register in &mut state.r[..13] {
            *register = match next() % 4 {
                0 => next(),
                1 => next() % 64,
                _ => RAM + next() % 0x2000,
            };
        }
        state.s.fill_with(&mut next);
        state.fpscr = next() & 0xF7C0_009F;
        state.xpsr = next() & 0xF80F_0000 | 1 << 24;
        state
    }

    /// Runs one encoding from a random state on one board, and on the other as well if it is UNPREDICTABLE.
    fn run(&mut self, code: [u16; 2], outcomes: &mut Outcomes) {
        let state = self.state(self.stopping.registers());
        let mut board = loaded(&self.stopping, code, &state);
        match board.try_step() {
            Ok(step) => {
                assert!(step.cycles > 0, "{code:04X?}: no time passed");
                assert!(!board.core.is_locked_up(), "{code:04X?}");
                match board.core.exception() {
                    // The access was refused, SVC, or BKPT without a debugger.
                    0 | 4 | 5 | 11 => outcomes.executed += 1,
                    3 if code[0] >> 8 == 0xBE => outcomes.executed += 1,
                    6 => {
                        assert_ne!(board.load(CFSR) >> 16, 0, "{code:04X?}: UsageFault without a cause");
                        assert_eq!(return_address(&mut board), CODE, "{code:04X?}: UsageFault elsewhere");
                        outcomes.usage_fault += 1;
                    }
                    other => panic!("{code:04X?}: exception {other}"),
                }
            }
            Err(Stop::ResetRequest | Stop::Unmodelled { .. }) => outcomes.executed += 1,
            Err(Stop::Unpredictable { address, word }) => {
                let whole = u32::from(code[0]) << 16 | u32::from(code[1]);
                let expected = if code[0] >= 0xE800 { whole } else { u32::from(code[0]) };
                assert_eq!((address, word), (CODE, expected), "{code:04X?}");
                assert_eq!(board.registers(), state, "{code:04X?}: it has not run");
                outcomes.stopped += 1;

                let mut board = loaded(&self.faulting, code, &state);
                assert!(board.step().cycles > 0);
                assert_eq!((board.core.exception(), return_address(&mut board)), (6, CODE), "{code:04X?}");
                assert_eq!(board.load(CFSR), UNDEFINSTR, "{code:04X?}");
            }
            Err(stop) => panic!("{code:04X?}: {stop:?}"),
        }
    }
}

/// Return address in the frame of a handler that has just been entered.
fn return_address(board: &mut Board) -> u32 {
    let frame = board.registers().r[13];
    board.word(frame + 24)
}

fn loaded(board: &Board, code: [u16; 2], state: &Registers) -> Board {
    let mut board = board.clone();
    board.bus.memory.poke_code(CODE, &code);
    board.core.invalidate(CODE..CODE + 4);
    board.core.set_registers(state);
    board
}

#[test]
fn every_half_word_runs_faults_or_stops() {
    let mut boards = Boards::new(0x1234_5678_9ABC_DEF1);
    let mut outcomes = Outcomes::default();
    for first in 0..=0xFFFF {
        let code = [first, boards.random.next() as u16];
        boards.run(code, &mut outcomes);
    }
    assert_eq!(outcomes, Outcomes { executed: 56_317, usage_fault: 8_201, stopped: 1_018 });
}

#[test]
fn a_million_random_words_run_fault_or_stop() {
    let mut boards = Boards::new(0x0DDB_1A5E_5BAD_5EED);
    let mut outcomes = Outcomes::default();
    for _ in 0..1_000_000 {
        let first = (0xE800 + boards.random.next() % 0x1800) as u16;
        let code = [first, boards.random.next() as u16];
        boards.run(code, &mut outcomes);
    }
    assert_eq!(outcomes, Outcomes { executed: 231_204, usage_fault: 665_633, stopped: 103_163 });
}

#[test]
fn unpredictable_encoding_raises_usage_fault_if_configured() {
    let config = Config { unpredictable: Unpredictable::UsageFault, ..Config::stm32f4(FLASH_BYTES) };
    // BX with a bit set that has to be zero.
    let mut board = Board::with_config(&[0x4701], config);
    board.step();
    assert_eq!(board.core.exception(), 3, "UsageFault is not enabled");
    assert_eq!(board.load(CFSR), UNDEFINSTR);

    let mut board = Board::new(&[0x4701]);
    assert_eq!(board.try_step(), Err(Stop::Unpredictable { address: CODE, word: 0x4701 }));
}

/// Random code with random interrupts, from RAM and flash, privileged or not.
#[test]
fn random_programs_with_interrupts_run_or_lock_up() {
    let mut random = Random(0x005E_ED0F_7E57);
    let mut lock_ups = 0;
    for _ in 0..300 {
        let config = Config { unpredictable: Unpredictable::UsageFault, ..Config::stm32f4(FLASH_BYTES) };
        let program: Vec<u16> = (0..256).map(|_| random.next() as u16).collect();
        let mut board = Board::with_config(&program, config);
        board.store(CPACR, FPU_FOR_ALL);
        board.store(SHCSR, ALL_FAULTS);
        board.store(NVIC_ISER, random.next());
        board.store(NVIC_IPR, random.next());
        board.store(0xE000_E404, random.next());
        for exception in 2..48 {
            // Two random instructions, then the return.
            board.handler(exception, &[random.next() as u16 % 0xE800, random.next() as u16 % 0xE800, 0x4770]);
        }
        for (at, _) in (RAM..).step_by(4).zip(0..0x400) {
            board.bus.memory.poke(at, can_twin::cpu::Width::Word, random.next());
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
            board.bus.accesses.clear();
        }
    }
    assert!(lock_ups > 0, "some programs destroy their stack");
}
