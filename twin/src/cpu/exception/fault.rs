//! Faults, calls and stops that end an instruction early, and the exceptions that they become (B1.5.14, B1.5.15).

use crate::cpu::bus::Bus;
use crate::cpu::core::{Core, Raised, Stop, Unpredictable};
use crate::cpu::cycles;
use crate::cpu::registers::EPSR_T;
use crate::cpu::system::debug::DFSR_BKPT;
use crate::cpu::system::scb::{HFSR_DEBUGEVT, HFSR_FORCED};
use crate::cpu::trap::{
    BFARVALID, BUS_FAULT, DACCVIOL, DEBUG_MONITOR, HARD_FAULT, IACCVIOL, IBUSERR, MEM_MANAGE, MMARVALID,
    PRECISERR, SV_CALL, Trap, UNDEFINSTR, USAGE_FAULT,
};

/// PC of a locked-up core (B1.5.15).
const LOCK_UP_ADDRESS: u32 = 0xFFFF_FFFE;

impl Core {
    /// Turns the cause that ended the instruction at `pc` into an exception or a stop.
    pub(in crate::cpu) fn take_trap<B: Bus>(&mut self, bus: &mut B, pc: u32) -> Result<(), Stop> {
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
            Trap::Breakpoint(immediate) if self.debug.attached => {
                self.cycle += u64::from(cycles::IDLE);
                return Err(Stop::Breakpoint { address: pc, immediate });
            }
            Trap::Breakpoint(_) => self.break_without_debugger(),
            Trap::SupervisorCall => {
                self.enter(bus, SV_CALL, self.next);
                return Ok(());
            }
            Trap::RefusedCall => self.escalated(SV_CALL),
            Trap::Unpredictable => self.fault(USAGE_FAULT, UNDEFINSTR),
            Trap::Usage(bits) => self.fault(USAGE_FAULT, bits),
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
    pub(in crate::cpu) fn call_supervisor(&mut self) -> Raised {
        let can_preempt = self.priority(SV_CALL) < self.execution_priority();
        self.raise(if can_preempt { Trap::SupervisorCall } else { Trap::RefusedCall })
    }

    /// Notes a fault in CFSR and finds its exception; `None`: the core locks up.
    pub(super) fn fault(&mut self, exception: u16, bits: u32) -> Option<u16> {
        self.scb.cfsr |= bits;
        self.escalated(exception)
    }

    /// The exception itself, or HardFault if it is disabled or its priority does not suffice (B1.5.14, "Priority escalation").
    pub(super) fn escalated(&mut self, exception: u16) -> Option<u16> {
        self.or_hard_fault(exception, HFSR_FORCED)
    }

    /// BKPT without halting debug: DebugMonitor, or HardFault (C1.6.1).
    fn break_without_debugger(&mut self) -> Option<u16> {
        self.debug.dfsr |= DFSR_BKPT;
        self.or_hard_fault(DEBUG_MONITOR, HFSR_DEBUGEVT)
    }

    /// The exception if it is enabled and preempts, or HardFault with a `reason` in HFSR; `None`: the core locks up.
    fn or_hard_fault(&mut self, exception: u16, reason: u32) -> Option<u16> {
        if self.can_preempt(exception) {
            return Some(exception);
        }
        self.scb.hfsr |= reason;
        (self.execution_priority() > -1).then_some(HARD_FAULT)
    }

    /// Returns whether an exception is enabled and of a higher priority than the running code.
    pub(in crate::cpu) fn can_preempt(&self, exception: u16) -> bool {
        self.nvic.enabled.contains(exception) && self.priority(exception) < self.execution_priority()
    }

    /// A fault at a priority that no handler preempts. Only NMI and reset end a lock-up.
    pub(in crate::cpu) fn lock_up(&mut self) {
        self.locked_up = true;
        self.r[15] = LOCK_UP_ADDRESS;
        self.next = LOCK_UP_ADDRESS;
        self.epsr = EPSR_T;
        self.attention = 0;
    }
}
