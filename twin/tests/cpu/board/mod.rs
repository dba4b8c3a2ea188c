//! A board for tests: flash at 0800_0000h, RAM at 2000_0000h, a few words of a peripheral at 4000_0000h.

mod memory;
mod registers;

use can_twin::cpu::{Bus, BusError, Config, Core, Registers, Step, Stop, Width};
pub use memory::{Memory, Piece, Random};
pub use registers::*;

pub const FLASH: u32 = 0x0800_0000;
pub const FLASH_BYTES: u32 = 0x1000;
pub const RAM: u32 = 0x2000_0000;
pub const RAM_BYTES: u32 = 0x4000;
pub const PERIPHERAL: u32 = 0x4000_0000;
/// Main stack pointer after a reset.
pub const STACK: u32 = RAM + 0x2000;
/// First instruction after a reset.
pub const CODE: u32 = FLASH + 0x400;
/// The handler of exception n begins at `HANDLERS + 32 * n`.
pub const HANDLERS: u32 = FLASH + 0x800;
/// Address without memory.
pub const NOWHERE: u32 = 0x6000_0000;

/// Memories, and a record of the accesses to them.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardBus {
    pub memory: Memory,
    /// Addresses and widths of loads and stores.
    pub accesses: Vec<(u32, Width, bool)>,
    pub waits: u32,
    /// Fetches show the content of the flash, not an outdated line of a cache.
    pub is_settled: bool,
}

impl BoardBus {
    fn record(&mut self, address: u32, width: Width, writes: bool) {
        assert_eq!(address % width.bytes(), 0, "accesses are aligned");
        self.accesses.push((address, width, writes));
    }
}

impl Bus for BoardBus {
    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        self.memory.fetch(address)
    }

    fn is_settled(&self) -> bool {
        self.is_settled
    }

    fn load(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        self.record(address, width, false);
        self.memory.load(address, width)
    }

    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        self.record(address, width, true);
        self.memory.store(address, width, value)
    }

    fn take_waits(&mut self) -> u32 {
        std::mem::take(&mut self.waits)
    }
}

/// A core with its memories.
#[derive(Clone, Debug, PartialEq)]
pub struct Board {
    pub core: Core,
    pub bus: BoardBus,
}

impl Board {
    /// A board whose program stands at [`CODE`], after the reset sequence. Every handler is `B .`.
    pub fn new(program: &[u16]) -> Self {
        Self::with_config(program, Config::stm32f4(FLASH_BYTES))
    }

    /// A board whose first interrupts are enabled at these priorities.
    pub fn with_interrupts(program: &[u16], priorities: &[u8]) -> Self {
        let mut board = Self::new(program);
        board.store(NVIC_ISER, (1 << priorities.len()) - 1);
        for (four, register) in priorities.chunks(4).zip((NVIC_IPR..).step_by(4)) {
            board.store(register, four.iter().rev().fold(0, |word, &one| word << 8 | u32::from(one)));
        }
        board
    }

    pub fn with_config(program: &[u16], config: Config) -> Self {
        let ram = vec![0; RAM_BYTES as usize];
        let mut memory = Memory::writable([(RAM, ram), (PERIPHERAL, vec![0; 32])]);
        let flash = vec![0xFF; FLASH_BYTES as usize];
        memory.0.push(Piece { from: FLASH, content: flash, is_writable: false });
        memory.poke_words(FLASH, [STACK, CODE | 1]);
        for exception in 2..64 {
            let handler = HANDLERS + 32 * exception;
            memory.poke(FLASH + 4 * exception, Width::Word, handler | 1);
            memory.poke_code(handler, &[0xE7FE]);
        }
        memory.poke_code(CODE, program);
        let bus = BoardBus { memory, accesses: Vec::new(), waits: 0, is_settled: true };
        let mut board = Board { core: Core::new(config), bus };
        board.step();
        assert_eq!(board.core.pc(), CODE);
        board
    }

    /// Puts the code of the handler of an exception.
    pub fn handler(&mut self, exception: u32, code: &[u16]) {
        self.bus.memory.poke_code(HANDLERS + 32 * exception, code);
    }

    /// Runs one step that does not stop.
    pub fn step(&mut self) -> Step {
        self.try_step().expect("the core goes on")
    }

    pub fn try_step(&mut self) -> Result<Step, Stop> {
        self.core.step(&mut self.bus)
    }

    /// Some steps, and the registers afterwards.
    pub fn steps(&mut self, count: usize) -> Registers {
        for _ in 0..count {
            self.step();
        }
        self.core.registers()
    }

    /// A step with the line of an interrupt high from now on.
    pub fn raise(&mut self, irq: u16) -> Step {
        self.core.set_irq(irq, true);
        self.step()
    }

    /// A step with the line of interrupt 0 high.
    pub fn pulse(&mut self) -> Step {
        let step = self.raise(0);
        self.core.set_irq(0, false);
        step
    }

    pub fn registers(&self) -> Registers {
        self.core.registers()
    }

    /// Changes registers between two steps.
    pub fn set(&mut self, change: impl FnOnce(&mut Registers)) {
        let mut registers = self.core.registers();
        change(&mut registers);
        self.core.set_registers(&registers);
    }

    /// Sets r0 and r1: the address and the value of [`LDR`] and [`STR`].
    pub fn set_r0_r1(&mut self, r0: u32, r1: u32) {
        self.set(|registers| registers.r[..2].copy_from_slice(&[r0, r1]));
    }

    pub fn word(&mut self, address: u32) -> u32 {
        self.bus.memory.peek(address, Width::Word).expect("memory")
    }

    pub fn start_cycle_counter(&mut self) {
        self.store(DEMCR, TRCENA);
        self.store(DWT_CTRL, 1);
    }

    /// Writes a system register as a program does: by a store that runs from RAM.
    pub fn store(&mut self, address: u32, value: u32) {
        self.run_from_ram(STR, address, value);
    }

    /// Reads a system register as a program does.
    pub fn load(&mut self, address: u32) -> u32 {
        self.run_from_ram(LDR, address, 0).r[2]
    }

    /// Runs an instruction with r0 and r1, and restores the registers.
    fn run_from_ram(&mut self, code: u16, r0: u32, r1: u32) -> Registers {
        let before = self.core.registers();
        self.bus.memory.poke_code(RAM + 0x3FF0, &[code]);
        self.set_r0_r1(r0, r1);
        self.set(|registers| (registers.r[15], registers.xpsr) = (RAM + 0x3FF0, T));
        let after = self.steps(1);
        self.core.set_registers(&before);
        after
    }
}
