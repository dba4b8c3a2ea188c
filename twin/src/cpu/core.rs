//! The core: its state, its construction, and one step of it.

mod access;

use std::ops::Range;

use crate::cpu::bus::{Bus, BusError};
use crate::cpu::cache::{Cache, Code};
use crate::cpu::cycles;
use crate::cpu::decode;
use crate::cpu::fpu::Fpu;
use crate::cpu::instruction::{Decoded, InBlock, Instruction};
use crate::cpu::registers::{Control, EPSR_T, Flags, Masks};
use crate::cpu::system::debug::Debug;
use crate::cpu::system::fpb::{Fpb, Replacement};
use crate::cpu::system::mpu::Mpu;
use crate::cpu::system::nvic::Nvic;
use crate::cpu::system::scb::{HFSR_VECTTBL, Scb};
use crate::cpu::system::systick::SysTick;
use crate::cpu::trap::{SYSTICK, Sleep, Trap};

/// BKPT 0.
const BKPT: u16 = 0xBE00;

/// Reaction to an UNPREDICTABLE encoding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Unpredictable {
    /// Stop with [`Stop::Unpredictable`].
    #[default]
    Stop,
    /// Raise a UsageFault with UNDEFINSTR. For flights that flip bits of code.
    UsageFault,
}

/// Properties that differ between parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Config {
    /// Addresses of code that changes only when [`Core::invalidate`] is called: flash. A multiple of 256 bytes.
    pub code: Range<u32>,
    /// Vector table after a reset (VTOR), a multiple of 128.
    pub vector_table: u32,
    /// Core cycles per cycle of the external reference clock of SysTick. At least 1.
    pub systick_reference: u32,
    /// SYST_CALIB as the maker of the part wired it.
    pub systick_calibration: u32,
    /// Treatment of UNPREDICTABLE encodings.
    pub unpredictable: Unpredictable,
}

impl Config {
    /// STM32F4: flash at 0800_0000h, which also answers at zero; SysTick reference HCLK/8 and its calibration value (RM0090,
    /// "SysTick calibration value register").
    ///
    /// `flash_bytes` is the size of the flash.
    #[must_use]
    pub const fn stm32f4(flash_bytes: u32) -> Self {
        Config {
            code: 0x0800_0000..0x0800_0000 + flash_bytes,
            vector_table: 0x0800_0000,
            systick_reference: 8,
            systick_calibration: 18_750,
            unpredictable: Unpredictable::Stop,
        }
    }
}

/// One step of the core: an instruction, an exception entry, a reset sequence, or a cycle of sleep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// Cycles that passed, waits of the bus included.
    pub cycles: u32,
    /// The core sleeps. More steps change nothing until an exception becomes pending or [`Core::systick_event`] comes.
    pub asleep: bool,
}

/// Reason for which the core does not continue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// A debugger is attached and the next instruction is BKPT, which has not run.
    Breakpoint {
        /// Address of the instruction.
        address: u32,
        /// Its constant, 0 to 255.
        immediate: u8,
    },
    /// The program asked for a system reset (AIRCR.SYSRESETREQ). The step is complete.
    ResetRequest,
    /// The next instruction is UNPREDICTABLE. It has not run.
    Unpredictable {
        /// Address of the instruction.
        address: u32,
        /// Its encoding: the half-word, or the first half-word above the second.
        word: u32,
    },
    /// The next instruction accesses a system register that this model does not have. It has not run.
    Unmodelled {
        /// Address of the instruction.
        instruction: u32,
        /// Address of the register.
        address: u32,
        /// Store, not load.
        write: bool,
    },
}

/// Result of [`Core::run`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Steps taken.
    pub steps: u64,
    /// The core sleeps.
    pub asleep: bool,
    /// Reason for which the core does not continue. `None`: the budget is used, the core sleeps, or the bus asked for a
    /// pause.
    pub stop: Option<Stop>,
}

/// An exception or stop prevents the rest of an instruction. [`Core::raised`] holds the cause.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Raised;

/// Result of what may raise.
pub(in crate::cpu) type Result<T = (), E = Raised> = std::result::Result<T, E>;

/// A Cortex-M4F.
///
/// The state is plain data: a clone continues exactly as the original. Decoded instructions do not count in comparisons.
#[derive(Clone, Debug, PartialEq)]
pub struct Core {
    pub(in crate::cpu) config: Config,
    /// R0 to R15. R13 is the stack pointer in use. R15 is the next instruction, and during an instruction its address plus 4.
    pub(in crate::cpu) r: [u32; 16],
    /// The stack pointer that is not in use.
    pub(in crate::cpu) other_sp: u32,
    pub(in crate::cpu) flags: Flags,
    /// T, IT and ICI at their places in xPSR.
    pub(in crate::cpu) epsr: u32,
    /// Number of the current exception, 0 in Thread mode.
    pub(in crate::cpu) ipsr: u16,
    pub(in crate::cpu) control: Control,
    pub(in crate::cpu) masks: Masks,
    pub(in crate::cpu) fpu: Fpu,
    /// The exclusive monitor: a load-exclusive has marked memory.
    pub(in crate::cpu) exclusive: bool,
    /// The event register (B1.5.18).
    pub(in crate::cpu) event: bool,
    pub(in crate::cpu) sleep: Sleep,
    pub(in crate::cpu) locked_up: bool,
    pub(in crate::cpu) reset_pending: bool,
    /// Cycles since power-on.
    pub(in crate::cpu) cycle: u64,
    /// The cycle from which on [`Core::attend`] has something to do: 0 for at once.
    pub(in crate::cpu) attention: u64,
    pub(in crate::cpu) nvic: Nvic,
    pub(in crate::cpu) scb: Scb,
    pub(in crate::cpu) systick: SysTick,
    pub(in crate::cpu) debug: Debug,
    pub(in crate::cpu) fpb: Fpb,
    pub(in crate::cpu) mpu: Mpu,
    /// During an instruction: address of the next one.
    pub(in crate::cpu) next: u32,
    /// During a step: its cycles so far.
    pub(in crate::cpu) spent: u32,
    /// During an instruction: the first register of a continued load or store multiple (B1.5.10), 0 for its beginning.
    pub(in crate::cpu) resume: u8,
    pub(in crate::cpu) raised: Option<Trap>,
    cache: Cache,
}

impl Core {
    /// A core after power-on. The first step is the reset sequence.
    #[must_use]
    pub fn new(config: Config) -> Self {
        let cache = Cache::new(&config.code);
        let mut core = Core {
            r: [0; 16],
            other_sp: 0,
            flags: Flags::default(),
            epsr: EPSR_T,
            ipsr: 0,
            control: Control::default(),
            masks: Masks::default(),
            fpu: Fpu::default(),
            exclusive: false,
            event: false,
            sleep: Sleep::Awake,
            locked_up: false,
            reset_pending: true,
            cycle: 0,
            attention: 0,
            nvic: Nvic::default(),
            scb: Scb::new(config.vector_table),
            systick: SysTick::new(config.systick_reference),
            debug: Debug::default(),
            fpb: Fpb::default(),
            mpu: Mpu::default(),
            next: 0,
            spent: 0,
            resume: 0,
            raised: None,
            cache,
            config,
        };
        core.reset();
        core
    }

    /// Returns the content of [`Config::code`] that is decoded, for another core with the same content.
    #[must_use]
    pub fn code(&self) -> Code {
        self.cache.code()
    }

    /// Takes the decoded content of [`Config::code`]. Cores with the same content share it until it changes.
    pub fn share(&mut self, code: &Code) {
        self.cache.share(code);
    }

    /// System reset. The next step is the reset sequence. Cycles, an attached debugger, DEMCR, the FPB and the levels of the
    /// interrupt lines stay.
    pub fn reset(&mut self) {
        self.control = Control::default();
        self.masks = Masks::default();
        self.fpu = Fpu { s: self.fpu.s, is_used: self.fpu.is_used, ..Fpu::default() };
        self.exclusive = false;
        self.event = false;
        self.sleep = Sleep::Awake;
        self.locked_up = false;
        self.reset_pending = true;
        self.nvic.reset();
        self.scb = Scb::new(self.config.vector_table);
        self.systick = SysTick::new(self.config.systick_reference);
        self.mpu = Mpu::default();
        self.debug.reset();
        (self.flags, self.epsr, self.ipsr) = (Flags::default(), EPSR_T, 0);
        self.raised = None;
        self.attention = 0;
    }

    /// Reads stack pointer and first instruction from the vector table (B1.5.5).
    fn reset_sequence<B: Bus>(&mut self, bus: &mut B) {
        self.reset_pending = false;
        let table = self.scb.vtor;
        let (sp, pc) = (bus.vector(table), bus.vector(table.wrapping_add(4)));
        self.r[14] = u32::MAX;
        match (sp, pc) {
            (Ok(sp), Ok(pc)) => {
                self.r[13] = sp & !3;
                self.other_sp = 0;
                self.r[15] = pc & !1;
                self.epsr = if pc & 1 == 1 { EPSR_T } else { 0 };
            }
            _ => {
                self.scb.hfsr |= HFSR_VECTTBL;
                self.lock_up();
            }
        }
        self.spent = cycles::RESET;
    }

    /// Runs one instruction, exception entry, reset sequence, or cycle of sleep.
    ///
    /// # Errors
    /// [`Stop`] if the core does not continue.
    #[inline]
    pub fn step<B: Bus>(&mut self, bus: &mut B) -> Result<Step, Stop> {
        bus.begin(self.cycle);
        if self.cycle >= self.attention && self.attend(bus) {
            return Ok(self.finish(bus));
        }
        let pc = self.r[15];
        self.spent = cycles::BASE;
        match self.run_one(bus, pc) {
            Ok(()) => self.r[15] = self.next,
            Err(Raised) => self.take_trap(bus, pc)?,
        }
        Ok(self.finish(bus))
    }

    /// Steps until `budget` cycles have passed, the core sleeps or stops, or [`Bus::yields`]. Takes at least one step.
    pub fn run<B: Bus>(&mut self, bus: &mut B, budget: u64) -> Run {
        let end = self.cycle.saturating_add(budget);
        let mut steps = 0;
        loop {
            steps += 1;
            match self.step(bus) {
                Err(stop) => return Run { steps, asleep: false, stop: Some(stop) },
                Ok(step) if step.asleep || self.cycle >= end || bus.yields() => {
                    return Run { steps, asleep: step.asleep, stop: None };
                }
                Ok(_) => {}
            }
        }
    }

    /// Fetches and executes the instruction at `pc`.
    #[inline]
    fn run_one<B: Bus>(&mut self, bus: &mut B, pc: u32) -> Result {
        let known = self.cache.get(pc);
        let Decoded { instruction, size } = if known.size != 0 && bus.is_settled() {
            let last = pc.wrapping_add(u32::from(known.size) - 2);
            if self.mpu.is_enabled() && !(self.may_execute(pc) && self.may_execute(last)) {
                return Err(self.raise(Trap::FetchAccess));
            }
            bus.refetch(pc);
            if known.size == 4 {
                bus.refetch(last);
            }
            known
        } else {
            self.fetch(bus, pc)?
        };
        self.r[15] = pc.wrapping_add(4);
        self.next = pc.wrapping_add(u32::from(size));
        if self.epsr == EPSR_T {
            self.execute(bus, instruction)
        } else {
            self.execute_in_state(bus, Decoded { instruction, size })
        }
    }

    pub(in crate::cpu) fn finish<B: Bus>(&mut self, bus: &mut B) -> Step {
        let cycles = self.spent + bus.take_waits();
        self.cycle += u64::from(cycles);
        Step { cycles, asleep: self.sleep != Sleep::Awake }
    }

    /// Handles reset, exceptions and sleep before the next instruction. Answers `true` if that took the step.
    fn attend<B: Bus>(&mut self, bus: &mut B) -> bool {
        if self.reset_pending {
            self.reset_sequence(bus);
            return true;
        }
        self.spent = cycles::IDLE;
        if self.systick.expires(self.cycle) {
            self.pend(SYSTICK);
        }
        if let Some(exception) = self.preempting() {
            self.locked_up = false;
            self.sleep = Sleep::Awake;
            self.spent = 0;
            self.enter(bus, exception, self.r[15]);
            return true;
        }
        if self.locked_up || !self.wakes() {
            return true;
        }
        self.sleep = Sleep::Awake;
        self.attention = self.systick.deadline;
        false
    }

    /// Reads the instruction at `pc` from the memory.
    fn fetch<B: Bus>(&mut self, bus: &mut B, pc: u32) -> Result<Decoded> {
        let first = self.fetch_half(bus, pc)?;
        let wide = decode::is_wide(first);
        let second = if wide { self.fetch_second_half(bus, pc.wrapping_add(2))? } else { 0 };
        let decode = || if wide { decode::wide(first, second) } else { decode::narrow(first) };
        if self.cache.covers(pc) {
            let decoded = decode();
            let is_replaced = |address| self.fpb.instruction(address).is_some();
            if bus.is_settled() && !is_replaced(pc) && !(wide && is_replaced(pc.wrapping_add(2))) {
                self.cache.put(pc, decoded);
            }
            return Ok(decoded);
        }
        let word = u32::from(first) << 16 | u32::from(second);
        Ok(self.cache.get_checked(pc, word).unwrap_or_else(|| {
            let decoded = decode();
            self.cache.put_checked(pc, word, decoded);
            decoded
        }))
    }

    fn fetch_half<B: Bus>(&mut self, bus: &mut B, address: u32) -> Result<u16> {
        if !self.may_execute(address) {
            return Err(self.raise(Trap::FetchAccess));
        }
        self.read_half(bus, address).map_err(|_| self.raise(Trap::FetchBus))
    }

    /// Fetches the second half of an instruction. A breakpoint there, and not at the first half, is UNPREDICTABLE (C1.11).
    fn fetch_second_half<B: Bus>(&mut self, bus: &mut B, address: u32) -> Result<u16> {
        if self.fpb.instruction(address) == Some(Replacement::Breakpoint) {
            return Err(self.raise(Trap::Unpredictable));
        }
        self.fetch_half(bus, address)
    }

    /// Reads a half-word of an instruction, or what the FPB replaces it by.
    fn read_half<B: Bus>(&self, bus: &mut B, address: u32) -> Result<u16, BusError> {
        match self.fpb.instruction(address) {
            None => bus.fetch(address),
            Some(Replacement::Address(place)) => bus.fetch(place),
            Some(Replacement::Breakpoint) => Ok(BKPT),
        }
    }

    /// Runs an instruction while EPSR holds more than T: in an IT block, in the middle of a load or store multiple, or without T.
    fn execute_in_state<B: Bus>(&mut self, bus: &mut B, decoded: Decoded) -> Result {
        use Instruction::{Breakpoint, Multiple};
        let Decoded { instruction, size } = decoded;
        let before = self.epsr;
        if before & EPSR_T == 0 {
            return Err(self.raise(Trap::INVALID_STATE));
        }
        let state = self.itstate();
        if state & 0xF == 0 {
            if !matches!(instruction, Multiple { .. }) {
                return Err(self.raise(Trap::INVALID_STATE));
            }
            self.epsr = EPSR_T;
            self.resume = state >> 4;
            let outcome = self.execute_out_of_line(bus, instruction);
            self.resume = 0;
            return outcome.inspect_err(|_| self.epsr = before);
        }
        let narrow = size == 2;
        match instruction.in_block(narrow) {
            InBlock::Never => return Err(self.raise(Trap::Unpredictable)),
            InBlock::Last if state & 0x7 != 0 => return Err(self.raise(Trap::Unpredictable)),
            _ => {}
        }
        // A return from an exception restores EPSR, so this comes first.
        self.advance_it();
        let unconditional = matches!(instruction, Breakpoint { .. });
        if !unconditional && !self.flags.pass(state >> 4) {
            return Ok(());
        }
        let instruction = if narrow { instruction.without_flags() } else { instruction };
        let outcome = self.execute_out_of_line(bus, instruction);
        if outcome.is_err() && !matches!(self.raised, Some(Trap::SupervisorCall | Trap::ResetRequest)) {
            self.epsr = before;
        }
        outcome
    }

    /// As [`Core::execute`], which is part of [`Core::step`] for speed.
    fn execute_out_of_line<B: Bus>(&mut self, bus: &mut B, instruction: Instruction) -> Result {
        self.execute(bus, instruction)
    }

    /// Notes the cause that ends the instruction.
    #[cold]
    pub(in crate::cpu) fn raise(&mut self, trap: Trap) -> Raised {
        self.raised = Some(trap);
        Raised
    }

    /// The encoding at `address`, for a report.
    pub(in crate::cpu) fn encoding<B: Bus>(&self, bus: &mut B, address: u32) -> u32 {
        let first = self.read_half(bus, address).unwrap_or_default();
        if decode::is_wide(first) {
            let second = self.read_half(bus, address.wrapping_add(2)).unwrap_or_default();
            u32::from(first) << 16 | u32::from(second)
        } else {
            u32::from(first)
        }
    }

    /// Returns the address from which the core reads its next instruction: its own, or that of the word by which the FPB replaces it.
    /// `None` if the FPB replaces it by BKPT.
    #[must_use]
    pub fn code_address(&self) -> Option<u32> {
        let pc = self.r[15];
        match self.fpb.instruction(pc) {
            None => Some(pc),
            Some(Replacement::Address(place)) => Some(place),
            Some(Replacement::Breakpoint) => None,
        }
    }

    /// Returns whether the FPU was used since the last call.
    pub fn take_fpu_use(&mut self) -> bool {
        std::mem::take(&mut self.fpu.is_used)
    }

    /// Returns whether another core continues exactly alike from `cycle` on, until which both sleep or have run. Without `uses_fpu` it
    /// does not use the FPU, and S0 to S31 do not count.
    pub fn continues_as(&self, other: &Core, cycle: u64, uses_fpu: bool) -> bool {
        let state = |core: &Core| {
            let mut core = core.clone();
            core.advance_to(cycle);
            core.fpu.is_used = false;
            if !uses_fpu {
                core.fpu.s = [0; 32];
            }
            core
        };
        state(self) == state(other)
    }

    /// Code in a range of addresses has changed or may have: drops what was decoded there.
    pub fn invalidate(&mut self, range: Range<u32>) {
        self.cache.invalidate(range);
    }
}
