//! A board for tests: flash at 0800_0000h, RAM at 2000_0000h, a few words of a peripheral at 4000_0000h.

use twin_core::{Bus, BusError, Config, Core, Registers, Step, Stop, Width};

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

const NVIC_ISER: u32 = 0xE000_E100;
const NVIC_IPR: u32 = 0xE000_E400;

pub const N: u32 = 1 << 31;
pub const Z: u32 = 1 << 30;
pub const C: u32 = 1 << 29;
pub const V: u32 = 1 << 28;
pub const Q: u32 = 1 << 27;

/// Memories, and a record of the accesses to them.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    pub flash: Vec<u8>,
    pub ram: Vec<u8>,
    pub peripheral: [u32; 8],
    /// Addresses and widths of loads and stores.
    pub accesses: Vec<(u32, Width, bool)>,
    pub waits: u32,
    /// Fetches show the content of the flash, not an outdated line of a cache.
    pub is_settled: bool,
}

impl Memory {
    fn bytes(&mut self, address: u32, width: Width) -> Option<&mut [u8]> {
        let (base, bytes) = match address >> 28 {
            0 => (FLASH, &mut self.flash),
            2 => (RAM, &mut self.ram),
            _ => return None,
        };
        let at = address.checked_sub(base)? as usize;
        bytes.get_mut(at..at + width.bytes() as usize)
    }

    fn word(bytes: &[u8]) -> u32 {
        bytes.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte))
    }

    /// Loads without a trace.
    pub fn peek(&mut self, address: u32, width: Width) -> Option<u32> {
        self.bytes(address, width).map(|bytes| Self::word(bytes))
    }

    /// Stores without a trace, also to flash.
    pub fn poke(&mut self, address: u32, width: Width, value: u32) {
        let bytes = self.bytes(address, width).expect("flash or RAM");
        bytes.copy_from_slice(&value.to_le_bytes()[..width.bytes() as usize]);
    }

    pub fn poke_code(&mut self, address: u32, code: &[u16]) {
        for (at, &half) in (address..).step_by(2).zip(code) {
            self.poke(at, Width::Half, u32::from(half));
        }
    }
}

impl Bus for Memory {
    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        self.peek(address, Width::Half).map(|half| half as u16).ok_or(BusError)
    }

    fn is_settled(&self) -> bool {
        self.is_settled
    }

    fn load(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        assert_eq!(address % width.bytes(), 0, "accesses are aligned");
        self.accesses.push((address, width, false));
        if address & !0x1F == PERIPHERAL {
            return Ok(self.peripheral[(address as usize & 0x1F) / 4]);
        }
        self.peek(address, width).ok_or(BusError)
    }

    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        assert_eq!(address % width.bytes(), 0, "accesses are aligned");
        self.accesses.push((address, width, true));
        if address & !0x1F == PERIPHERAL {
            self.peripheral[(address as usize & 0x1F) / 4] = value;
            return Ok(());
        }
        if address >> 28 == 0 {
            return Err(BusError);
        }
        self.poke_checked(address, width, value)
    }

    fn take_waits(&mut self) -> u32 {
        std::mem::take(&mut self.waits)
    }
}

impl Memory {
    fn poke_checked(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        let bytes = self.bytes(address, width).ok_or(BusError)?;
        bytes.copy_from_slice(&value.to_le_bytes()[..width.bytes() as usize]);
        Ok(())
    }
}

/// A core with its memories.
#[derive(Clone, Debug, PartialEq)]
pub struct Board {
    pub core: Core,
    pub memory: Memory,
}

impl Board {
    /// A board whose program stands at [`CODE`], after the reset sequence. Every handler is `B .`.
    pub fn new(program: &[u16]) -> Self {
        Self::with_config(program, Config::stm32f4(FLASH_BYTES))
    }

    /// A board whose interrupts 0 and 1 are enabled at these priorities.
    pub fn with_priorities(program: &[u16], first: u8, second: u8) -> Self {
        let mut board = Self::new(program);
        board.store(NVIC_ISER, 0b11);
        board.store(NVIC_IPR, u32::from_le_bytes([first, second, 0, 0]));
        board
    }

    pub fn with_config(program: &[u16], config: Config) -> Self {
        let mut memory = Memory {
            flash: vec![0xFF; FLASH_BYTES as usize],
            ram: vec![0; RAM_BYTES as usize],
            peripheral: [0; 8],
            accesses: Vec::new(),
            waits: 0,
            is_settled: true,
        };
        memory.poke(FLASH, Width::Word, STACK);
        memory.poke(FLASH + 4, Width::Word, CODE | 1);
        for exception in 2..64 {
            let handler = HANDLERS + 32 * exception;
            memory.poke(FLASH + 4 * exception, Width::Word, handler | 1);
            memory.poke_code(handler, &[0xE7FE]);
        }
        memory.poke_code(CODE, program);
        let mut board = Board { core: Core::new(config), memory };
        board.step();
        assert_eq!(board.core.pc(), CODE);
        board
    }

    /// Puts the code of the handler of an exception.
    pub fn handler(&mut self, exception: u32, code: &[u16]) {
        self.memory.poke_code(HANDLERS + 32 * exception, code);
    }

    /// One step that does not stop.
    pub fn step(&mut self) -> Step {
        self.try_step().expect("the core goes on")
    }

    pub fn try_step(&mut self) -> Result<Step, Stop> {
        self.core.step(&mut self.memory)
    }

    /// Some steps, and the registers afterwards.
    pub fn steps(&mut self, count: usize) -> Registers {
        for _ in 0..count {
            self.step();
        }
        self.core.registers()
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

    pub fn word(&mut self, address: u32) -> u32 {
        self.memory.peek(address, Width::Word).expect("flash or RAM")
    }

    /// Writes a system register as a program does: by a store that runs from RAM.
    pub fn store(&mut self, address: u32, value: u32) {
        let before = self.core.registers();
        // STR r1, [r0]
        self.memory.poke_code(RAM + 0x3FF0, &[0x6001]);
        self.set(|registers| {
            (registers.r[0], registers.r[1], registers.r[15]) = (address, value, RAM + 0x3FF0);
            registers.xpsr = 1 << 24;
        });
        self.step();
        self.core.set_registers(&before);
    }

    /// Reads a system register as a program does.
    pub fn load(&mut self, address: u32) -> u32 {
        let before = self.core.registers();
        // LDR r1, [r0]
        self.memory.poke_code(RAM + 0x3FF0, &[0x6801]);
        self.set(|registers| {
            (registers.r[0], registers.r[15]) = (address, RAM + 0x3FF0);
            registers.xpsr = 1 << 24;
        });
        let value = self.steps(1).r[1];
        self.core.set_registers(&before);
        value
    }
}
