//! Object 2032h: how the previous run of the program ended.

use super::ErrorCode;
use crate::od::{Objects, Record};

/// End of the previous run of the program, as its board recorded it.
#[doc(alias = "2032h")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct PostMortem {
    /// Cause
    ///
    /// 0 none: power-on, a command or the reset pin. 1 panic, 2 fault, 3 stack overflow, 4 task that did not answer, 5
    /// watchdog, 6 brown-out, 7 oscillator, 8 register, 9 time base.
    #[sub(1, ro)]
    pub cause: u8,
    /// Resets in a row
    ///
    /// Those for a cause, each before 60 s of uptime. Zero after power-on.
    #[sub(2, ro)]
    pub row: u8,
    /// Program counter
    ///
    /// Zero where it is unknown. After a brown-out its level: BOR_LEV of the option bytes.
    #[sub(3, ro)]
    pub pc: u32,
    /// Task
    ///
    /// First four characters of the name of the task that was polled last, the first one in the lowest byte; zero if
    /// none was. With the cause register its address, with the cause time base the counter: `TIM2`, `TIM5` or `SYST`.
    #[sub(4, ro)]
    pub task: u32,
    /// Dump
    ///
    /// Return addresses on the stack, the innermost first, 4 bytes each; then the newest bytes of the log.
    #[sub(5, ro)]
    pub dump: &'static [u8],
}

impl PostMortem {
    /// Value of `cause`: none.
    pub const NONE: u8 = 0;
    /// Value of `cause`: panic.
    pub const PANIC: u8 = 1;
    /// Value of `cause`: fault of the processor.
    pub const FAULT: u8 = 2;
    /// Value of `cause`: stack overflow.
    pub const STACK_OVERFLOW: u8 = 3;
    /// Value of `cause`: a task did not answer in time.
    pub const LATE_TASK: u8 = 4;
    /// Value of `cause`: the watchdog expired while interrupts were off.
    pub const WATCHDOG: u8 = 5;
    /// Value of `cause`: the supply voltage fell below its threshold.
    pub const BROWN_OUT: u8 = 6;
    /// Value of `cause`: the oscillator stopped.
    pub const OSCILLATOR: u8 = 7;
    /// Value of `cause`: a register in use was lost that cannot be mended. `task` is its address.
    pub const REGISTER: u8 = 8;
    /// Value of `cause`: one of several counters of time stopped, jumped or had another rate.
    pub const TIME_BASE: u8 = 9;

    /// Returns code and manufacturer-specific bytes of the emergency that reports it: the cause and the program
    /// counter, little-endian. `None` without a cause.
    pub(crate) const fn emergency(&self) -> Option<(ErrorCode, [u8; 5])> {
        let code = match self.cause {
            Self::NONE => return None,
            Self::BROWN_OUT => ErrorCode::VOLTAGE_INSIDE,
            Self::OSCILLATOR | Self::REGISTER | Self::TIME_BASE => ErrorCode::HARDWARE,
            _ => ErrorCode::SOFTWARE_INTERNAL,
        };
        let [a, b, c, d] = self.pc.to_le_bytes();
        Some((code, [self.cause, a, b, c, d]))
    }
}

/// Object of the last reset (2032h).
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct PostMortemObjects {
    /// Post-mortem record
    ///
    /// How the program before this one ended. Reported by one emergency after the boot-up message.
    #[object(0x2032, record)]
    pub record: PostMortem,
}
