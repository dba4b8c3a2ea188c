//! Faults, calls and stops that end an instruction early, and the exceptions that they become (B1.5.14, B1.5.15).

use super::{BUS_FAULT, DEBUG_MONITOR, HARD_FAULT, MEM_MANAGE, SV_CALL, USAGE_FAULT};
use crate::bus::Bus;
use crate::core::{Core, Raised, Stop, Unpredictable};
use crate::cycles;
use crate::registers::EPSR_T;
use crate::system::debug::DFSR_BKPT;
use crate::system::scb::{HFSR_DEBUGEVT, HFSR_FORCED};

/// Bits of CFSR (B3.2.15).
const IACCVIOL: u32 = 1;
const DACCVIOL: u32 = 1 << 1;
pub const MUNSTKERR: u32 = 1 << 3;
pub const MSTKERR: u32 = 1 << 4;
pub const MLSPERR: u32 = 1 << 5;
const MMARVALID: u32 = 1 << 7;
const IBUSERR: u32 = 1 << 8;
const PRECISERR: u32 = 1 << 9;
pub const UNSTKERR: u32 = 1 << 11;
pub const STKERR: u32 = 1 << 12;
pub const LSPERR: u32 = 1 << 13;
const BFARVALID: u32 = 1 << 15;
const UNDEFINSTR: u32 = 1 << 16;
const INVSTATE: u32 = 1 << 17;
pub const INVPC: u32 = 1 << 18;
const NOCP: u32 = 1 << 19;
const UNALIGNED: u32 = 1 << 24;
const DIVBYZERO: u32 = 1 << 25;

/// PC of a locked-up core (B1.5.15).
const LOCK_UP_ADDRESS: u32 = 0xFFFF_FFFE;

/// Cause that ends an instruction before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trap {
    /// UsageFault with these bits of CFSR.
    Usage(u32),
    /// The bus refused a fetch.
    FetchBus,
    /// Execute-never, or the MPU refused a fetch.
    FetchAccess,
    /// The bus refused a load or store at this address.
    DataBus(u32),
    /// The MPU refused a load or store at this address.
    DataAccess(u32),
    /// A store of FPU registers that entry had left out raised this exception. `None`: the core locks up.
    Deferred(Option<u16>),
    /// SVC. The instruction is complete.
    SupervisorCall,
    /// SVC at a priority that its exception cannot preempt.
    RefusedCall,
    /// BKPT with its constant.
    Breakpoint(u8),
    Unpredictable,
    /// The instruction, a store to AIRCR, is complete.
    ResetRequest,
    /// A system register that is not modelled.
    Unmodelled {
        address: u32,
        write: bool,
    },
}

impl Trap {
    pub const UNDEFINED: Trap = Trap::Usage(UNDEFINSTR);
    pub const INVALID_STATE: Trap = Trap::Usage(INVSTATE);
    pub const NO_COPROCESSOR: Trap = Trap::Usage(NOCP);
    pub const UNALIGNED: Trap = Trap::Usage(UNALIGNED);
    pub const DIVIDE_BY_ZERO: Trap = Trap::Usage(DIVBYZERO);
}

impl Core {
    /// Turns the cause that ended the instruction at `pc` into an exception or a stop.
    pub(crate) fn take_trap<B: Bus>(&mut self, bus: &mut B, pc: u32) -> Result<(), Stop> {
        self.r[15] = pc;
        let exception = match self.raised.take().unwrap_or(Trap::UNDEFINED) {
            Trap::Unpredictable if self.config.unpredictable == Unpredictable::Stop => {
                let word = self.encoding(bus, pc);
                return Err(Stop::Unpredictable { address: pc, word });
            }
            Trap::Unmodelled { address, write } => {
                return Err(Stop::Unmodelled { instruction: pc, address, write });
            }
            Trap::ResetRequest => {
                self.r[15] = self.next;
                self.finish(bus);
                return Err(Stop::ResetRequest);
            }
            Trap::Breakpoint(immediate) if self.debug.is_attached() => {
                self.cycle += u64::from(cycles::IDLE);
                return Err(Stop::Breakpoint { address: pc, immediate });
            }
            Trap::Breakpoint(_) => self.break_without_debugger(),
            Trap::SupervisorCall => {
                self.enter(bus, SV_CALL, self.next);
                return Ok(());
            }
            Trap::RefusedCall => self.escalated(SV_CALL),
            Trap::Unpredictable => self.usage_fault(UNDEFINSTR),
            Trap::Usage(bits) => self.usage_fault(bits),
            Trap::FetchAccess => self.fault(MEM_MANAGE, IACCVIOL),
            Trap::Deferred(exception) => exception,
            Trap::DataAccess(address) => {
                self.scb.mmfar = address;
                self.fault(MEM_MANAGE, DACCVIOL | MMARVALID)
            }
            Trap::FetchBus => self.fault(BUS_FAULT, IBUSERR),
            Trap::DataBus(address) => {
                self.scb.bfar = address;
                self.fault(BUS_FAULT, PRECISERR | BFARVALID)
            }
        };
        match exception {
            Some(exception) => self.enter(bus, exception, pc),
            None => self.lock_up(),
        }
        Ok(())
    }

    /// Raises SVCall, or HardFault if its priority does not suffice.
    pub(crate) fn call_supervisor(&mut self) -> Raised {
        let can_preempt = self.priority(SV_CALL) < self.execution_priority();
        self.raise(if can_preempt { Trap::SupervisorCall } else { Trap::RefusedCall })
    }

    fn usage_fault(&mut self, bits: u32) -> Option<u16> {
        self.fault(USAGE_FAULT, bits)
    }

    /// Notes a fault in CFSR and finds its exception; `None`: the core locks up.
    pub(super) fn fault(&mut self, exception: u16, bits: u32) -> Option<u16> {
        self.scb.cfsr |= bits;
        self.escalated(exception)
    }

    /// The exception itself, or HardFault if it is disabled or its priority does not suffice (B1.5.14, "Priority escalation").
    pub(super) fn escalated(&mut self, exception: u16) -> Option<u16> {
        let current = self.execution_priority();
        if self.nvic.enabled.contains(exception) && self.priority(exception) < current {
            return Some(exception);
        }
        self.scb.hfsr |= HFSR_FORCED;
        (current > -1).then_some(HARD_FAULT)
    }

    /// BKPT without halting debug: DebugMonitor, or HardFault (C1.6.1).
    fn break_without_debugger(&mut self) -> Option<u16> {
        self.debug.dfsr |= DFSR_BKPT;
        let current = self.execution_priority();
        if self.nvic.enabled.contains(DEBUG_MONITOR) && self.priority(DEBUG_MONITOR) < current {
            return Some(DEBUG_MONITOR);
        }
        self.scb.hfsr |= HFSR_DEBUGEVT;
        (current > -1).then_some(HARD_FAULT)
    }

    /// A fault at a priority that no handler preempts. Only NMI and reset end a lock-up.
    pub(crate) fn lock_up(&mut self) {
        self.locked_up = true;
        self.r[15] = LOCK_UP_ADDRESS;
        self.next = LOCK_UP_ADDRESS;
        self.epsr = EPSR_T;
        self.attention = 0;
    }
}
