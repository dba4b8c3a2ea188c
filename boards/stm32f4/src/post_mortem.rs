//! End of a program, and the record that it leaves for the next start.
//!
//! A program that ends puts both controllers into reset first: otherwise they would continue to acknowledge frames.
//! Init mode is not sufficient: a controller enters it only at the end of a frame, and its clock may be wrong by then.
//! With the feature `full` the program then writes a [`record`].

#[cfg(feature = "full")]
mod record;

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::{DCB, SCB};
use ecss_can::emcy::PostMortem;
#[cfg(feature = "full")]
use embassy_stm32::pac::FLASH;
use embassy_stm32::pac::RCC;

/// Flags of RCC_CSR (RM0090 7.3.21).
const BORRSTF: u32 = 1 << 25;
const PORRSTF: u32 = 1 << 27;
const SFTRSTF: u32 = 1 << 28;
const IWDGRSTF: u32 = 1 << 29;
const WWDGRSTF: u32 = 1 << 30;
/// Upper limit of resets in a row. A larger number is not a count but the content of RAM after another program.
const MOST_IN_A_ROW: u32 = 20;

/// Fills the buffer with the newest bytes of the log, the newest one last. Bytes that it does not write stay zero.
pub type ReadLog = fn(&mut [u8]);

/// Number of resets in a row.
// SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM. The bits of a u32 may be any.
#[unsafe(link_section = ".uninit.ROW")]
static ROW: AtomicU32 = AtomicU32::new(0);

#[cfg(feature = "full")]
pub(crate) use record::runs;

/// Does nothing: without a record the running task is not recorded.
#[cfg(not(feature = "full"))]
pub(crate) fn runs(_task: u32) {}

/// Restarts the count of resets in a row.
pub(crate) fn trust() {
    ROW.store(0, Ordering::Relaxed);
}

/// Takes the cause and record of the last reset. Call it once, before tasks run. Also returns whether power failed
/// since, or the reset pin was pulled from outside. Every reset pulls the pin, so its flag alone is not sufficient
/// (RM0090 7.1.1).
#[inline(never)] // a small stack frame of its own, reached by short instructions
pub(crate) fn take() -> (PostMortem, bool) {
    let flags = RCC.csr().read().0;
    RCC.csr().modify(|w| w.set_rmvf(true));
    let is_from_outside = flags & (PORRSTF | BORRSTF) != 0 || flags & (SFTRSTF | IWDGRSTF | WWDGRSTF) == 0;
    let mut found = found(flags);
    let before = if flags & (PORRSTF | BORRSTF) != 0 { 0 } else { ROW.load(Ordering::Relaxed) };
    if before < MOST_IN_A_ROW {
        found.row = before as u8;
    }
    if found.cause != PostMortem::NONE {
        found.row += 1;
        let PostMortem { cause, row, pc, task, .. } = found;
        error!(
            "last reset: cause {=u8}, {=u8} in a row, at {=u32:08X}h, task {=[u8; 4]:a}",
            cause,
            row,
            pc,
            task.to_le_bytes()
        );
    }
    ROW.store(found.row.into(), Ordering::Relaxed);
    (found, is_from_outside)
}

/// Returns the cause of a reset with these flags, and the record if there is one.
#[cfg(feature = "full")]
fn found(flags: u32) -> PostMortem {
    let record = record::take(flags & (PORRSTF | BORRSTF) == 0);
    let task = record::take_running();
    if flags & PORRSTF != 0 {
        PostMortem::default()
    } else if flags & BORRSTF != 0 {
        PostMortem {
            cause: PostMortem::BROWN_OUT,
            pc: FLASH.optcr().read().bor_lev().into(),
            ..PostMortem::default()
        }
    } else if let Some(record) = record {
        PostMortem { task, ..record }
    } else if flags & IWDGRSTF != 0 {
        PostMortem { cause: PostMortem::WATCHDOG, task, ..PostMortem::default() }
    } else {
        PostMortem::default()
    }
}

/// Returns the cause of a reset with these flags. A fault ends by a reset of the program.
#[cfg(not(feature = "full"))]
fn found(flags: u32) -> PostMortem {
    let cause = match flags & (PORRSTF | BORRSTF | SFTRSTF | IWDGRSTF) {
        SFTRSTF => PostMortem::FAULT,
        IWDGRSTF => PostMortem::WATCHDOG,
        _ => PostMortem::NONE,
    };
    PostMortem { cause, ..PostMortem::default() }
}

/// Ends the program: silences the controllers, writes the record, resets the chip. With a debugger attached it stops
/// instead of the reset. `log` copies the end of the log into the record. `frame`: address at which the exception
/// stacked the registers of the interrupted code. With `None` the record has no program counter.
#[cfg_attr(not(feature = "full"), expect(unused_variables, reason = "used by the record only"))]
pub(crate) fn end(frame: Option<u32>, cause: u8, log: ReadLog) -> ! {
    RCC.apb1rstr().modify(|w| {
        w.set_can1rst(true);
        w.set_can2rst(true);
    });
    #[cfg(feature = "full")]
    record::write(frame, cause, log);
    if DCB::is_debugger_attached() {
        loop {
            cortex_m::asm::bkpt();
        }
    }
    SCB::sys_reset()
}

/// Ends the program after a fault. Call it from the handler of HardFault, on a separate stack. `frame`: address at
/// which the exception stacked the registers of the interrupted code. With `None` the record has no program counter.
/// `log` reads the log, see [`ReadLog`].
#[inline(always)] // called from one place of an image
pub fn on_fault(frame: Option<u32>, log: ReadLog) -> ! {
    end(frame, PostMortem::FAULT, log)
}

/// Ends the program after a panic. Call it from a panic handler that does not end in a fault.
pub fn on_panic(log: ReadLog) -> ! {
    cortex_m::interrupt::disable();
    end(None, PostMortem::PANIC, log)
}

/// Ends the program because the oscillator stopped. Call it from the handler of the NMI, which only the clock security
/// system raises (RM0090 7.2.7), on a separate stack. Arguments: see [`on_fault`].
#[inline(always)] // called from one place of an image
pub fn on_oscillator(frame: Option<u32>, log: ReadLog) -> ! {
    end(frame, PostMortem::OSCILLATOR, log)
}
