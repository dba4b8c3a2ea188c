//! Exception return: EXC_RETURN, tail-chaining and unstacking (B1.5.8, B1.5.12).

use super::entry::{BASIC_FRAME, EXTENDED_FRAME, NO_FP, PADDED};
use crate::cpu::bus::{Bus, Width};
use crate::cpu::core::{Core, Raised, Result};
use crate::cpu::cycles;
use crate::cpu::fpu::FRAME_WORDS;
use crate::cpu::registers::IPSR;
use crate::cpu::system::mpu::Access;
use crate::cpu::system::scb::{CCR_NONBASETHRDENA, CCR_STKALIGN, SCR_SLEEPONEXIT};
use crate::cpu::trap::{BUS_FAULT, INVPC, MEM_MANAGE, MUNSTKERR, NMI, Sleep, Trap, UNSTKERR, USAGE_FAULT};

/// Mode and stack after a return, from the low four bits of EXC_RETURN.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Target {
    Handler,
    MainThread,
    ProcessThread,
}

/// A frame without its FPU registers.
struct Frame {
    words: [u32; 8],
    address: u32,
}

impl Core {
    /// Returns from the current exception as selected by `value`, an EXC_RETURN.
    pub(in crate::cpu) fn exception_return<B: Bus>(&mut self, bus: &mut B, value: u32) {
        let returning = self.ipsr;
        let nested = self.nvic.active.count() > 1;
        let was_active = self.nvic.active.contains(returning);
        self.deactivate(returning);
        let target = match value & 0xF {
            0b0001 => Some(Target::Handler),
            0b1001 => Some(Target::MainThread),
            0b1101 => Some(Target::ProcessThread),
            _ => None,
        };
        let forbids_thread = nested && self.scb.ccr & CCR_NONBASETHRDENA == 0;
        let target = target.filter(|&target| was_active && (target == Target::Handler || !forbids_thread));
        let Some(target) = target else {
            self.chain_fault(bus, USAGE_FAULT, INVPC, value);
            return;
        };
        if let Some(next) = self.preempting() {
            self.spent += cycles::TAIL_CHAIN;
            self.take(bus, next, value);
            return;
        }
        self.spent += cycles::RETURN;
        match self.unstack(bus, target, value) {
            Ok(frame) => self.resume_context(bus, target, value, &frame, nested),
            Err(Raised) => match self.raised.take() {
                Some(Trap::DataAccess(_)) => self.chain_fault(bus, MEM_MANAGE, MUNSTKERR, value),
                Some(Trap::Usage(bits)) => self.chain_fault(bus, USAGE_FAULT, bits, value),
                _ => self.chain_fault(bus, BUS_FAULT, UNSTKERR, value),
            },
        }
    }

    fn deactivate(&mut self, exception: u16) {
        self.nvic.active.set(exception, false);
        if exception != NMI {
            self.masks.faultmask = false;
        }
        // A line that is still high makes its interrupt pending again.
        if self.nvic.lines.contains(exception) {
            self.pend(exception);
        }
    }

    /// Enters the handler of a fault that the return raised, with the frame still on the stack.
    fn chain_fault<B: Bus>(&mut self, bus: &mut B, exception: u16, bits: u32, value: u32) {
        self.spent += cycles::TAIL_CHAIN;
        match self.fault(exception, bits) {
            Some(exception) => self.take(bus, exception, 0xF000_0000 | value),
            None => self.lock_up(),
        }
    }

    /// Reads the frame, and the FPU registers if it has some.
    fn unstack<B: Bus>(&mut self, bus: &mut B, target: Target, value: u32) -> Result<Frame> {
        let (main, process) = self.stack_pointers();
        let address = if target == Target::ProcessThread { process } else { main };
        let privileged = target == Target::Handler || !self.control.unprivileged;
        let mut words = [0; 8];
        self.unstack_words(bus, address, &mut words, privileged)?;
        if value & NO_FP == 0 && !self.fpu.keep_deferred() {
            self.check_fpu(privileged)?;
            self.spent += FRAME_WORDS * cycles::ACCESS;
            let mut fp_words = [0; FRAME_WORDS as usize];
            self.unstack_words(bus, address.wrapping_add(BASIC_FRAME), &mut fp_words, privileged)?;
            self.fpu.set_frame(&fp_words);
        }
        Ok(Frame { words, address })
    }

    fn unstack_words<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        words: &mut [u32],
        privileged: bool,
    ) -> Result {
        let negative = self.execution_priority() < 0;
        for (word, at) in words.iter_mut().zip((address..).step_by(4)) {
            if !self.mpu.permits(at, Access::Read, privileged, negative) {
                return Err(self.raise(Trap::DataAccess(at)));
            }
            *word = self.load_bus(bus, at, Width::Word)?;
        }
        Ok(())
    }

    /// Continues with the context that the frame describes.
    fn resume_context<B: Bus>(
        &mut self,
        bus: &mut B,
        target: Target,
        value: u32,
        frame: &Frame,
        nested: bool,
    ) {
        let [r0, r1, r2, r3, r12, lr, pc, xpsr] = frame.words;
        (self.r[0], self.r[1], self.r[2], self.r[3]) = (r0, r1, r2, r3);
        self.r[12] = r12;
        if (target == Target::Handler) != (xpsr & IPSR != 0) {
            // The frame names an exception in Thread mode, or none in Handler mode. It stays on the stack.
            self.chain_fault(bus, USAGE_FAULT, INVPC, value);
            return;
        }
        let extended = value & NO_FP == 0;
        let aligns = extended || self.scb.ccr & CCR_STKALIGN != 0;
        let padding = if aligns && xpsr & PADDED != 0 { 4 } else { 0 };
        let top = frame.address.wrapping_add(if extended { EXTENDED_FRAME } else { BASIC_FRAME }) | padding;
        let (main, process) = self.stack_pointers();
        self.r[14] = lr;
        self.set_xpsr(xpsr);
        self.control.fp_active = extended;
        self.control.process_stack = target == Target::ProcessThread;
        match target {
            Target::ProcessThread => self.set_stack_pointers(main, top),
            _ => self.set_stack_pointers(top, process),
        }
        self.next = pc & !1;
        self.exclusive = false;
        self.event = true;
        self.attention = 0;
        if target != Target::Handler && !nested && self.scb.scr & SCR_SLEEPONEXIT != 0 {
            self.fall_asleep(Sleep::ForInterrupt);
        }
    }
}
