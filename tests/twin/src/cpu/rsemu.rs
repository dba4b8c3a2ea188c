//! The adapter to the `rsemu` core library, version 0.0.7, used unmodified.
//!
//! Its exception entry stacks xPSR without ITSTATE, so that an interrupt inside an IT block makes the rest of the block
//! unconditional, and its exception return advances the ITSTATE it has just restored when the returning instruction
//! stands in an IT block of the handler. Both are put right here from outside, after the step.
//!
//! So are the cycles of exceptions: the library charges each access to the stack on top of a figure that contains them.

use std::sync::Arc;

use rsemu::core::space::{AddressSpace, MemAttrs, MemOps, MemResult, Perms, RamStore, Region};
use rsemu::core::{BusError, Device, ResetKind};
use rsemu::cpu::arm::v7m::sys::Exception;
use rsemu::cpu::arm::v7m::{ArmV7m, Config, xpsr};

use super::{Cpu, NotMemory, Registers, Step};
use crate::accelerator::{LINE, Purpose};
use crate::link::Link;
use crate::mmio::Width;
use crate::model::{FLASH_BASE, Part};

const CCM_BASE: u32 = 0x1000_0000;
const RAM_BASE: u32 = 0x2000_0000;
const RAM_LEN: u32 = 128 << 10;
/// Where RM0090 figure 2 puts peripherals, the system memory with the device signature, and DBGMCU.
const WINDOWS: [(u32, u32); 4] =
    [(0x4000_0000, 512 << 10), (0x5000_0000, 256 << 20), (0x1FFF_0000, 64 << 10), (0xE004_2000, 0x1000)];
/// RAM after power-on holds no zeros: programs that rely on them must not fly by luck.
const RAM_AT_POWER_ON: u8 = 0xA5;

/// Where a program's table of vectors lies, from the start of flash: 16 exceptions and up to 97 interrupts.
const VECTORS_LEN: u64 = 4 * (16 + 97);

const HARD_FAULT: u32 = 3;
/// Debug Halting Control and Status Register, which the library reads as zero, and C_DEBUGEN in it (DDI 0403 C1.6.2).
const DHCSR: u32 = 0xE000_EDF0;
const C_DEBUGEN: u32 = 1;
/// TICKINT of SYST_CSR, and ENABLE beside it (DDI 0403 B3.3.3).
const SYST_TICKINT: u32 = 1 << 1;
const SYST_WAKES: u32 = SYST_TICKINT | 1;
/// SLEEPDEEP of SCR (DDI 0403 B3.2.7).
const SCR_SLEEPDEEP: u32 = 1 << 2;
/// Cycles that the library charges too much for an exception entry: it takes 12 in all, the stacking of 8 words included (ARM,
/// "Cortex-M3 and M4 interrupt latency": 12 with memory without wait states).
const EXCESS_OF_ENTRY: u64 = 8;
/// And for an exception return, which takes 12 in all (the same), the instruction included.
const EXCESS_OF_RETURN: u64 = 7;
/// A return charges at least so many; one that goes on with the next handler at once (tail-chaining) charges 7.
const CHARGED_FOR_RETURN: u64 = 19;
/// Cycles of a taken branch: 1 + P (DDI 0439 table 3-1) with P = 2.
const TAKEN_BRANCH: u64 = 3;
/// ENABLE of SYST_CSR (DDI 0403 B3.3.3), CYCCNTENA of DWT_CTRL (C1.8.7).
const SYST_ENABLE: u32 = 1;
const DWT_CYCCNTENA: u32 = 1;
/// Words from a stack frame's base to the return address and to xPSR (DDI 0403 B1.5.6).
const FRAME_PC: u32 = 6;
const FRAME_XPSR: u32 = 7;

/// One peripheral window of the core's address space.
#[derive(Debug)]
struct Window {
    base: u32,
    link: Arc<Link>,
}

impl Window {
    fn target(&self, offset: u64, len: usize) -> Result<(u32, Width), BusError> {
        let width = match len {
            1 => Width::Byte,
            2 => Width::Half,
            4 => Width::Word,
            _ => return Err(BusError::BadAccess),
        };
        Ok((self.base + offset as u32, width))
    }
}

impl MemOps for Window {
    fn read(&self, offset: u64, dst: &mut [u8], _attrs: MemAttrs) -> MemResult {
        let (address, width) = self.target(offset, dst.len())?;
        let value = self.link.read(address, width).map_err(|_| BusError::Unassigned)?;
        dst.copy_from_slice(&value.to_le_bytes()[..dst.len()]);
        Ok(())
    }

    fn write(&self, offset: u64, src: &[u8], _attrs: MemAttrs) -> MemResult {
        let (address, width) = self.target(offset, src.len())?;
        let mut word = [0; 4];
        word[..src.len()].copy_from_slice(src);
        self.link.write(address, width, u32::from_le_bytes(word)).map_err(|_| BusError::Unassigned)
    }
}

/// Flash as the core reads it: through the accelerator.
#[derive(Debug)]
struct FlashMemory {
    store: Arc<RamStore>,
    link: Arc<Link>,
}

impl MemOps for FlashMemory {
    fn read(&self, offset: u64, dst: &mut [u8], attrs: MemAttrs) -> MemResult {
        let access = match offset {
            _ if attrs.purpose.is_fetch() => Purpose::Fetch,
            0..VECTORS_LEN => Purpose::Vector,
            _ => Purpose::Load,
        };
        let stale = self.link.accelerator().read(access, offset as u32, || self.link.now().cycle);
        if let Some(line) = stale {
            let at = (offset % u64::from(LINE)) as usize;
            // Accesses are aligned, or of single bytes.
            dst.copy_from_slice(line.get(at..at + dst.len()).ok_or(BusError::BadAccess)?);
            return Ok(());
        }
        self.store.read_at(offset, dst)
    }

    fn write(&self, _offset: u64, _src: &[u8], _attrs: MemAttrs) -> MemResult {
        Err(BusError::Protected)
    }
}

/// A Cortex-M4F with the memories of its part.
pub(super) struct Core {
    cpu: ArmV7m,
    flash: Arc<RamStore>,
    ram: Arc<RamStore>,
    ccm: Arc<RamStore>,
    ccm_len: u32,
    link: Arc<Link>,
    /// The cycle up to which SysTick has counted.
    cycle: u64,
    asleep: bool,
    /// A debugger has set C_DEBUGEN.
    has_debugger: bool,
    /// Cycles that SysTick has counted and that did not pass.
    systick_ahead: u64,
    /// xPSR before the next step.
    xpsr: u32,
    bus_faults: u64,
}

impl Core {
    pub(super) fn new(part: Part, image: &[u8], link: Arc<Link>) -> Self {
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
                let memory = Arc::new(FlashMemory { store: flash.clone(), link: link.clone() });
                let region = Region::io("flash", u64::from(flash_len), memory);
                map.map_with_perms(region, u64::from(base), Perms::RX).expect(disjoint);
            }
            // Loads and fetches go to the memory, stores to the interface that programs it.
            let program = Arc::new(Window { base: FLASH_BASE, link: link.clone() });
            let region = Region::io("flash interface", u64::from(flash_len), program);
            map.map_with_perms(region, u64::from(FLASH_BASE), Perms::WRITE).expect(disjoint);
            map.map(Region::ram("ram", ram.clone()), u64::from(RAM_BASE)).expect(disjoint);
            // CCM hangs on the data bus alone: no code runs there.
            if ccm_len > 0 {
                let region = Region::ram("ccm", ccm.clone());
                map.map_with_perms(region, u64::from(CCM_BASE), Perms::RW).expect(disjoint);
            }
            for (base, len) in WINDOWS {
                let window = Arc::new(Window { base, link: link.clone() });
                map.map(Region::io("peripherals", u64::from(len), window), u64::from(base)).expect(disjoint);
            }
        }

        let config = Config::CORTEX_M4F.with_priority_bits(4).with_reset_vtor(FLASH_BASE);
        let cpu = ArmV7m::new(config);
        cpu.attach_space(Arc::new(space));
        let (cycle, xpsr) = (link.now().cycle, cpu.xpsr());
        Core {
            cpu,
            flash,
            ram,
            ccm,
            ccm_len,
            link,
            cycle,
            systick_ahead: 0,
            asleep: false,
            has_debugger: false,
            xpsr,
            bus_faults: 0,
        }
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

    /// The cycle at which SysTick next pends its exception.
    fn systick(&self) -> u64 {
        let left = self.cpu.with_sys(|sys| {
            match (sys.syst_cvr, sys.syst_rvr) {
                (_, 0) => None,
                // It reloads with the next cycle.
                (0, reload) => Some(u64::from(reload) + 1),
                (count, _) => Some(u64::from(count)),
            }
            .filter(|_| sys.syst_csr & SYST_WAKES == SYST_WAKES)
        });
        left.map_or(u64::MAX, |left| self.cycle + left)
    }

    fn branches_to_itself(&self) -> bool {
        const B_SELF: [u8; 2] = [0xFE, 0xE7];
        let mut instruction = [0; 2];
        self.read_memory(self.cpu.pc(), &mut instruction).is_ok() && instruction == B_SELF
    }

    /// The next instruction is a BKPT.
    fn is_at_breakpoint(&self) -> bool {
        self.word(self.cpu.pc()).is_some_and(|code| code & 0xFF00 == 0xBE00)
    }

    /// The register that the next instruction loads from DHCSR: LDR or LDRB with a positive offset (DDI 0403 A7.7.43, A7.7.46).
    fn loads_dhcsr(&self) -> Option<u8> {
        let code = self.word(self.cpu.pc())?;
        let (base, offset, to) = match code {
            _ if code & 0xF800 == 0x6800 => (code >> 3 & 7, (code >> 6 & 0x1F) * 4, code & 7),
            _ if code & 0xF800 == 0x7800 => (code >> 3 & 7, code >> 6 & 0x1F, code & 7),
            _ if matches!(code & 0xFFF0, 0xF8D0 | 0xF890) => (code & 0xF, code >> 16 & 0xFFF, code >> 28),
            _ => return None,
        };
        (self.cpu.reg(base as u8).wrapping_add(offset) == DHCSR).then_some(to as u8)
    }

    fn word(&self, address: u32) -> Option<u32> {
        let mut bytes = [0; 4];
        self.read_memory(address, &mut bytes).ok()?;
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
            let _ = self.write_memory(at, &(stacked | it_bits).to_le_bytes());
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
}

impl Cpu for Core {
    fn step(&mut self) -> Step {
        let before = self.xpsr;
        let now = self.link.now().cycle.max(self.cycle);
        if now > self.cycle {
            self.count(now - self.cycle);
        }
        if self.has_debugger && self.is_at_breakpoint() {
            return Step { cycles: 1, breakpoint: true, systick: u64::MAX, ..Step::default() };
        }
        let loads = if self.has_debugger { self.loads_dhcsr() } else { None };
        let charged = self.cpu.step();
        if let Some(register) = loads {
            self.cpu.set_reg(register, self.cpu.reg(register) | C_DEBUGEN);
        }
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
        self.cycle = now + cycles;
        if excess > 0 || self.systick_ahead > 0 {
            self.take_back(excess);
        }
        // A sleeping step and the WFE that starts the sleep cost one cycle.
        self.asleep = cycles == 1 && self.cpu.is_asleep();
        // Asked only after branches that left xPSR alone: few instructions read their successor.
        let spins = cycles == TAKEN_BRANCH && self.xpsr == before && self.branches_to_itself();
        Step {
            cycles: cycles as u32 + self.link.accelerator().take_waits(),
            asleep: self.asleep,
            systick: if self.asleep || spins { self.systick() } else { u64::MAX },
            spins,
            breakpoint: false,
            hard_fault: is == HARD_FAULT && was != HARD_FAULT,
            stuck: is == HARD_FAULT && self.branches_to_itself(),
            // The store to AIRCR costs two cycles; asking after every step would double the cost of most.
            reset_request: cycles >= 2 && self.cpu.reset_requested(),
        }
    }

    fn set_irq(&mut self, irq: u16, asserted: bool) {
        self.cpu.set_irq(irq, asserted);
    }

    fn set_nmi(&mut self, asserted: bool) {
        self.cpu.set_nmi(asserted);
    }

    fn reset(&mut self) {
        self.cpu.reset(ResetKind::Cold);
        self.xpsr = self.cpu.xpsr();
        self.asleep = false;
        self.bus_faults = 0;
    }

    fn is_locked_up(&self) -> bool {
        self.cpu.is_locked_up()
    }

    fn pc(&self) -> u32 {
        self.cpu.pc()
    }

    fn return_address(&self) -> Option<u32> {
        self.word(self.frame().wrapping_add(FRAME_PC * 4))
    }

    fn take_bus_fault(&mut self) -> Option<u32> {
        let (count, address) = self.cpu.bus_faults();
        (std::mem::replace(&mut self.bus_faults, count) != count).then_some(address)
    }

    fn sleeps_deeply(&self) -> bool {
        self.cpu.with_sys(|sys| sys.scr & SCR_SLEEPDEEP != 0)
    }

    fn enable_debug(&mut self) {
        self.has_debugger = true;
    }

    fn skip_to(&mut self, cycle: u64) {
        self.cycle = cycle;
    }

    fn registers(&self) -> Registers {
        let regs = self.cpu.regs();
        Registers { r: regs.r, xpsr: regs.xpsr }
    }

    fn read_memory(&self, address: u32, bytes: &mut [u8]) -> Result<(), NotMemory> {
        if let Some((store, offset)) = self.ram_at(address, bytes.len()) {
            return store.read_at(offset, bytes).map_err(|_| NotMemory(address));
        }
        let offset = address.checked_sub(FLASH_BASE).ok_or(NotMemory(address))?;
        self.flash.read_at(u64::from(offset), bytes).map_err(|_| NotMemory(address))
    }

    fn write_memory(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        let (store, offset) = self.ram_at(address, bytes.len()).ok_or(NotMemory(address))?;
        store.write_at(offset, bytes).map_err(|_| NotMemory(address))
    }

    fn write_flash(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        let offset = address.checked_sub(FLASH_BASE).ok_or(NotMemory(address))?;
        self.flash.write_at(u64::from(offset), bytes).map_err(|_| NotMemory(address))
    }
}
