//! The core library `rsemu`, version 0.0.7, unmodified, as the follower of a lock-step.
//!
//! Its memories are its own. What lies outside of them it takes from a [`Tape`] that the leader recorded.
//!
//! Its exception entry stacks xPSR without ITSTATE, so that an interrupt inside an IT block makes the rest of the block
//! unconditional, and its exception return advances the ITSTATE it has just restored when the returning instruction
//! stands in an IT block of the handler. Both are put right here from outside, after the step.
//!
//! So are the cycles of exceptions: the library charges each access to the stack on top of a figure that contains them.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use rsemu::core::space::{AddressSpace, MemAttrs, MemOps, MemResult, Perms, RamStore, Region};
use rsemu::core::state::{ChunkReader, MachineShape, StateReader, StateWriter};
use rsemu::core::{BusError, Device, ResetKind};
use rsemu::cpu::arm::v7m::sys::Exception;
use rsemu::cpu::arm::v7m::{ArmV7m, Config, Regs, xpsr};

use twin_core::View;

use crate::model::{FLASH_BASE, Part};

/// One access to the world outside of the memories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Access {
    pub address: u32,
    pub bytes: u32,
    pub write: bool,
    /// What was stored, or loaded unless the access was refused.
    pub value: Option<u32>,
}

/// What the leader did in its step.
#[derive(Debug, Default)]
pub(super) struct Recorded {
    pub accesses: VecDeque<Access>,
    /// Reads of flash while the accelerator may show old lines: address, bytes, value.
    pub flash: VecDeque<(u32, u32, u32)>,
    /// An access of the follower that the leader did not make.
    pub problem: Option<String>,
}

/// The record of one step.
pub(super) type Tape = Mutex<Recorded>;

const CCM_BASE: u32 = 0x1000_0000;
const RAM_BASE: u32 = 0x2000_0000;
const RAM_LEN: u32 = 128 << 10;
/// Where RM0090 figure 2 puts peripherals, the system memory with the device signature, and DBGMCU.
const WINDOWS: [(u32, u32); 4] =
    [(0x4000_0000, 512 << 10), (0x5000_0000, 256 << 20), (0x1FFF_0000, 64 << 10), (0xE004_2000, 0x1000)];
/// RAM after power-on holds no zeros: programs that rely on them must not fly by luck.
const RAM_AT_POWER_ON: u8 = 0xA5;

/// TICKINT of SYST_CSR (DDI 0403 B3.3.3).
const SYST_TICKINT: u32 = 1 << 1;
/// Cycles that the library charges too much for an exception entry: it takes 12 in all, the stacking of 8 words included (ARM,
/// "Cortex-M3 and M4 interrupt latency": 12 with memory without wait states).
const EXCESS_OF_ENTRY: u64 = 8;
/// And for an exception return, which takes 12 in all (the same), the instruction included.
const EXCESS_OF_RETURN: u64 = 7;
/// A return charges at least so many; one that goes on with the next handler at once (tail-chaining) charges 7.
const CHARGED_FOR_RETURN: u64 = 19;
/// ENABLE of SYST_CSR (DDI 0403 B3.3.3), CYCCNTENA of DWT_CTRL (C1.8.7).
const SYST_ENABLE: u32 = 1;
const DWT_CYCCNTENA: u32 = 1;
/// Places of bools in a saved state.
const ASLEEP: usize = 96;
const EVENT: usize = 97;
const RESET_PENDING: usize = 98;
const LOCKED_UP: usize = 99;
const HAS_EXCLUSIVE: usize = 100;
/// Words from a stack frame's base to the return address and to xPSR (DDI 0403 B1.5.6).
const FRAME_PC: u32 = 6;
const FRAME_XPSR: u32 = 7;

/// One peripheral window of the core's address space.
#[derive(Debug)]
struct Window {
    base: u32,
    tape: Arc<Tape>,
}

impl Window {
    fn replay(&self, offset: u64, bytes: usize, write: Option<u32>) -> Result<u32, BusError> {
        let address = self.base.wrapping_add(offset as u32);
        let mut tape = self.tape.lock().expect("no panic under this lock");
        let front = tape.accesses.pop_front();
        let same = front.is_some_and(|front| {
            front.address == address
                && front.bytes == bytes as u32
                && front.write == write.is_some()
                && (write.is_none() || front.value.is_none() || front.value == write)
        });
        if !same {
            let write = write.map(|value| format!("{value:X}h"));
            tape.problem.get_or_insert(format!("{address:X}h {bytes} {write:?} for {front:X?}"));
            return Err(BusError::Unassigned);
        }
        front.and_then(|front| front.value).ok_or(BusError::Unassigned)
    }
}

impl MemOps for Window {
    fn read(&self, offset: u64, dst: &mut [u8], _attrs: MemAttrs) -> MemResult {
        let value = self.replay(offset, dst.len(), None)?;
        dst.copy_from_slice(&value.to_le_bytes()[..dst.len()]);
        Ok(())
    }

    fn write(&self, offset: u64, src: &[u8], _attrs: MemAttrs) -> MemResult {
        let mut word = [0; 4];
        word[..src.len()].copy_from_slice(src);
        self.replay(offset, src.len(), Some(u32::from_le_bytes(word))).map(|_| ())
    }
}

/// Flash as the core reads it.
#[derive(Debug)]
struct FlashMemory {
    base: u32,
    store: Arc<RamStore>,
    tape: Arc<Tape>,
}

impl MemOps for FlashMemory {
    fn read(&self, offset: u64, dst: &mut [u8], _attrs: MemAttrs) -> MemResult {
        let mut tape = self.tape.lock().expect("no panic under this lock");
        let here = (self.base.wrapping_add(offset as u32), dst.len() as u32);
        if let Some(&(address, bytes, value)) = tape.flash.front()
            && (address, bytes) == here
        {
            tape.flash.pop_front();
            dst.copy_from_slice(&value.to_le_bytes()[..dst.len()]);
            return Ok(());
        }
        self.store.read_at(offset, dst)
    }

    fn write(&self, _offset: u64, _src: &[u8], _attrs: MemAttrs) -> MemResult {
        Err(BusError::Protected)
    }
}

/// A Cortex-M4F with the memories of its part.
pub(super) struct Follower {
    pub cpu: ArmV7m,
    flash: Arc<RamStore>,
    ram: Arc<RamStore>,
    ccm: Arc<RamStore>,
    ccm_len: u32,
    /// The cycle up to which SysTick has counted.
    cycle: u64,
    asleep: bool,
    /// Cycles that SysTick has counted and that did not pass.
    systick_ahead: u64,
    /// xPSR before the next step.
    xpsr: u32,
}

impl Follower {
    pub(super) fn new(part: Part, image: &[u8], tape: Arc<Tape>, cycle: u64) -> Self {
        let ccm_len = part.ccm_bytes();
        let flash_len = part.flash_bytes();
        let flash = Arc::new(RamStore::new(u64::from(flash_len)));
        flash.fill(0, u64::from(flash_len), 0xFF).expect("the whole store");
        flash.write_at(0, image).expect("the image fits");
        let ram = Arc::new(RamStore::new(u64::from(RAM_LEN)));
        let ccm = Arc::new(RamStore::new(u64::from(ccm_len)));
        for (store, len) in [(&ram, RAM_LEN), (&ccm, ccm_len)] {
            store.fill(0, u64::from(len), RAM_AT_POWER_ON).expect("the whole store");
        }

        let space = AddressSpace::new("stm32f4", 32);
        {
            let mut map = space.topology();
            let disjoint = "the memory map has no overlaps";
            // BOOT0 low: flash also answers at zero.
            for base in [0, FLASH_BASE] {
                let memory = Arc::new(FlashMemory { base, store: flash.clone(), tape: tape.clone() });
                let region = Region::io("flash", u64::from(flash_len), memory);
                map.map_with_perms(region, u64::from(base), Perms::RX).expect(disjoint);
            }
            // Loads and fetches go to the memory, stores to the interface that programs it.
            let program = Arc::new(Window { base: FLASH_BASE, tape: tape.clone() });
            let region = Region::io("flash interface", u64::from(flash_len), program);
            map.map_with_perms(region, u64::from(FLASH_BASE), Perms::WRITE).expect(disjoint);
            map.map(Region::ram("ram", ram.clone()), u64::from(RAM_BASE)).expect(disjoint);
            // CCM hangs on the data bus alone: no code runs there.
            if ccm_len > 0 {
                let region = Region::ram("ccm", ccm.clone());
                map.map_with_perms(region, u64::from(CCM_BASE), Perms::RW).expect(disjoint);
            }
            for (base, len) in WINDOWS {
                let window = Arc::new(Window { base, tape: tape.clone() });
                map.map(Region::io("peripherals", u64::from(len), window), u64::from(base)).expect(disjoint);
            }
        }

        let config = Config::CORTEX_M4F.with_priority_bits(4).with_reset_vtor(FLASH_BASE);
        let cpu = ArmV7m::new(config);
        cpu.attach_space(Arc::new(space));
        let xpsr = cpu.xpsr();
        Follower { cpu, flash, ram, ccm, ccm_len, cycle, systick_ahead: 0, asleep: false, xpsr }
    }

    fn ram_at(&self, address: u32, len: usize) -> Option<(&RamStore, u64)> {
        [(RAM_BASE, RAM_LEN, &self.ram), (CCM_BASE, self.ccm_len, &self.ccm)].into_iter().find_map(
            |(base, size, store)| {
                let offset = address.checked_sub(base)?;
                (u64::from(offset) + len as u64 <= u64::from(size)).then_some((&**store, u64::from(offset)))
            },
        )
    }

    /// SysTick counts cycles that passed outside of steps; CYCCNT counts those awake.
    fn count(&mut self, cycles: u64) {
        let asleep = self.asleep;
        self.cpu.with_sys(|sys| {
            if !asleep {
                sys.tick_cyccnt(cycles);
            }
            if sys.tick_systick(cycles) && sys.syst_csr & SYST_TICKINT != 0 {
                sys.set_pending(Exception::SYSTICK, true);
            }
        });
    }

    /// Takes cycles back from the counters, which have counted them. SysTick waits with it until it does not have to cross its
    /// reload value.
    fn take_back(&mut self, cycles: u64) {
        let ahead = self.systick_ahead + cycles;
        self.systick_ahead = self.cpu.with_sys(|sys| {
            if sys.dwt_ctrl & DWT_CYCCNTENA != 0 {
                sys.dwt_cyccnt = sys.dwt_cyccnt.wrapping_sub(cycles as u32);
            }
            if sys.syst_csr & SYST_ENABLE == 0 {
                return 0;
            }
            let count = u64::from(sys.syst_cvr) + ahead;
            if sys.syst_cvr == 0 || count > u64::from(sys.syst_rvr) {
                return ahead;
            }
            sys.syst_cvr = count as u32;
            0
        });
    }

    fn word(&self, address: u32) -> Option<u32> {
        let mut bytes = [0; 4];
        match self.ram_at(address, 4) {
            Some((store, offset)) => store.read_at(offset, &mut bytes).ok()?,
            None => self.flash.read_at(u64::from(address.checked_sub(FLASH_BASE)?), &mut bytes).ok()?,
        }
        Some(u32::from_le_bytes(bytes))
    }

    /// The frame that the current exception's entry stacked; valid right after the entry.
    fn frame(&self) -> u32 {
        const SPSEL: u32 = 1 << 2;
        if self.cpu.reg(14) & SPSEL != 0 { self.cpu.psp() } else { self.cpu.msp() }
    }

    /// Puts the IT bits that the library dropped into the frame it stacked.
    fn restore_stacked_itstate(&mut self, it_bits: u32) {
        let at = self.frame().wrapping_add(FRAME_XPSR * 4);
        // A frame outside RAM has raised a stacking fault already.
        if let Some(stacked) = self.word(at) {
            self.write_memory(at, &(stacked | it_bits).to_le_bytes());
        }
    }

    /// After a return from inside a handler's IT block, takes ITSTATE from the frame just popped: the one right below
    /// the stack pointer whose registers are those of the core.
    fn restore_returned_itstate(&mut self) {
        let regs = self.cpu.regs();
        let expected = [regs.r[0], regs.r[1], regs.r[2], regs.r[3], regs.r[12], regs.r[14], regs.r[15]];
        for (size, padding) in [(0x20, 0), (0x20, 4), (0x68, 0), (0x68, 4)] {
            let frame = regs.r[13].wrapping_sub(size + padding);
            let popped = (0..=FRAME_PC).zip(expected).all(|(k, r)| {
                let clear = if k == FRAME_PC { 1 } else { 0 };
                self.word(frame.wrapping_add(k * 4)).is_some_and(|w| w & !clear == r)
            });
            let Some(stacked) = self.word(frame.wrapping_add(FRAME_XPSR * 4)) else { continue };
            if popped && (stacked >> 9 & 1 == 1) == (padding != 0) {
                self.cpu.set_xpsr(regs.xpsr & !xpsr::IT_MASK | stacked & xpsr::IT_MASK);
                return;
            }
        }
    }

    /// SysTick and the cycle counter count up to `now`, when the next step begins.
    pub(super) fn advance(&mut self, now: u64) {
        if now > self.cycle {
            self.count(now - self.cycle);
        }
        self.cycle = self.cycle.max(now);
    }

    /// One step. Returns its cycles without waits.
    pub(super) fn step(&mut self) -> u64 {
        let before = self.xpsr;
        let charged = self.cpu.step();
        self.xpsr = self.cpu.xpsr();
        let (was, is) = (before & xpsr::EXCEPTION, self.xpsr & xpsr::EXCEPTION);
        let mut excess = 0;
        if was != is {
            // An exception that is still active was pre-empted; one that is not has returned.
            let pre_empted = was == 0 || self.cpu.with_sys(|sys| sys.is_active(Exception(was as u16)));
            excess = match pre_empted {
                true => EXCESS_OF_ENTRY,
                false if charged >= CHARGED_FOR_RETURN => EXCESS_OF_RETURN,
                false => 0,
            };
            if before & xpsr::IT_MASK != 0 {
                if pre_empted {
                    self.restore_stacked_itstate(before & xpsr::IT_MASK);
                } else {
                    self.restore_returned_itstate();
                }
                self.xpsr = self.cpu.xpsr();
            }
        }
        let cycles = charged - excess;
        self.cycle += cycles;
        if excess > 0 || self.systick_ahead > 0 {
            self.take_back(excess);
        }
        self.asleep = cycles == 1 && self.cpu.is_asleep();
        cycles
    }

    /// Adopts the leader's time after a step: what was charged beyond it is taken back, what is missing counts with the next step.
    pub(super) fn settle(&mut self, cycle: u64) {
        if self.cycle > cycle {
            self.take_back(self.cycle - cycle);
            self.cycle = cycle;
        }
    }

    pub(super) fn reset(&mut self) {
        self.cpu.reset(ResetKind::Cold);
        self.xpsr = self.cpu.xpsr();
        self.asleep = false;
        self.systick_ahead = 0;
    }

    pub(super) fn skip_to(&mut self, cycle: u64) {
        self.cycle = cycle;
    }

    pub(super) fn ram(&self) -> Vec<u8> {
        let mut bytes = vec![0; RAM_LEN as usize];
        self.ram.read_at(0, &mut bytes).expect("the whole store");
        bytes
    }

    pub(super) fn ccm(&self) -> Vec<u8> {
        let mut bytes = vec![0; self.ccm_len as usize];
        self.ccm.read_at(0, &mut bytes).expect("the whole store");
        bytes
    }

    pub(super) fn read_memory(&self, address: u32, bytes: &mut [u8]) -> bool {
        self.ram_at(address, bytes.len()).is_some_and(|(store, offset)| store.read_at(offset, bytes).is_ok())
    }

    pub(super) fn write_memory(&mut self, address: u32, bytes: &[u8]) -> bool {
        self.ram_at(address, bytes.len()).is_some_and(|(store, offset)| store.write_at(offset, bytes).is_ok())
    }

    pub(super) fn write_flash(&mut self, address: u32, bytes: &[u8]) -> bool {
        self.flash.write_at(u64::from(address - FLASH_BASE), bytes).is_ok()
    }

    /// The event register.
    pub(super) fn event(&self) -> bool {
        self.saved()[EVENT] != 0
    }

    fn saved(&self) -> Vec<u8> {
        let mut writer = StateWriter::new(MachineShape::new());
        let mut chunk = writer.chunk("core", "core", 1).expect("the first chunk");
        self.cpu.save(&mut chunk).expect("memory is there");
        let bytes = writer.to_vec().expect("memory is there");
        StateReader::new(&bytes).expect("just written").load_raw("core").expect("just written").2.to_vec()
    }

    fn patch(&self, change: impl FnOnce(&mut [u8])) {
        let mut bytes = self.saved();
        change(&mut bytes);
        self.cpu.load(&mut ChunkReader::new(&bytes)).expect("only bools changed");
    }

    pub(super) fn set_event(&mut self, event: bool) {
        self.patch(|bytes| bytes[EVENT] = event.into());
    }

    /// Adopts the state of the leader but its memories.
    pub(super) fn adopt(&mut self, registers: &twin_core::Registers, view: &View) {
        self.patch(|bytes| {
            bytes[ASLEEP] = view.asleep.into();
            bytes[EVENT] = view.event.into();
            bytes[RESET_PENDING] = 0;
            bytes[LOCKED_UP] = view.locked_up.into();
            if !view.exclusive {
                bytes[HAS_EXCLUSIVE] = 0;
            }
        });
        self.adopt_registers(registers, view);
        self.cpu.with_sys(|sys| {
            sys.active[..4].copy_from_slice(&view.active);
            sys.pending[..4].copy_from_slice(&view.pending);
            [sys.cfsr, sys.hfsr, sys.mmfar, sys.bfar] = view.faults;
            [sys.fpccr, sys.fpcar, sys.fpdscr] = view.fp;
            [sys.syst_csr, sys.syst_rvr, sys.syst_cvr] = view.systick;
            sys.dwt_cyccnt = view.cyccnt;
        });
        self.systick_ahead = 0;
    }

    pub(super) fn adopt_registers(&mut self, registers: &twin_core::Registers, view: &View) {
        let in_use_is_process = registers.xpsr & xpsr::EXCEPTION == 0 && view.control & 2 != 0;
        let (msp, psp) = match in_use_is_process {
            true => (registers.other_sp, registers.r[13]),
            false => (registers.r[13], registers.other_sp),
        };
        self.cpu.set_regs(Regs {
            r: registers.r,
            msp,
            psp,
            xpsr: registers.xpsr,
            primask: view.primask,
            faultmask: view.faultmask,
            basepri: view.basepri,
            control: view.control,
        });
        for (register, &value) in (0..).zip(&registers.s) {
            self.cpu.set_s(register, value);
        }
        self.cpu.set_fpscr(registers.fpscr);
        self.xpsr = self.cpu.xpsr();
    }
}
