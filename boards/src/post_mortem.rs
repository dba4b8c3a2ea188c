//! End of a program, and what is left of it to the next one.
//!
//! A program that ends puts both controllers into reset first: otherwise they would go on acknowledging frames. Init mode would
//! not do: a controller enters it only at the end of a frame, and its clock may be wrong by then. With the feature `full` the
//! program then writes a [`record`].

#[cfg(feature = "full")]
mod record;

#[cfg(feature = "full")]
use core::cell::UnsafeCell;
#[cfg(feature = "full")]
use core::mem::MaybeUninit;
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
/// More than can be in a row: what RAM holds after another program.
const MOST_IN_A_ROW: u32 = 20;

/// Bytes of the stack of a handler of faults. Without a record the stack is not needed any more: a handler begins at its
/// top.
pub const FAULT_STACK_SIZE: usize = if cfg!(feature = "full") { 256 } else { 0 };

/// For the handler of faults alone, since the stack may be what is lost.
#[cfg(feature = "full")]
#[repr(C, align(8))]
pub struct FaultStack(UnsafeCell<MaybeUninit<[u8; FAULT_STACK_SIZE]>>);

// SAFETY: only a handler that never returns works on it.
#[cfg(feature = "full")]
unsafe impl Sync for FaultStack {}

/// Stack of the handlers of faults.
// SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM.
#[cfg(feature = "full")]
#[unsafe(link_section = ".uninit.FAULT_STACK")]
pub static FAULT_STACK: FaultStack = FaultStack(UnsafeCell::new(MaybeUninit::uninit()));

#[cfg(not(feature = "full"))]
unsafe extern "C" {
    #[link_name = "_stack_start"]
    /// Top of the stack.
    pub static FAULT_STACK: u8;
}

/// Resets in a row for a cause.
// SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM. The bits of a u32 may be any.
#[unsafe(link_section = ".uninit.ROW")]
static ROW: AtomicU32 = AtomicU32::new(0);

#[cfg(feature = "full")]
pub(crate) use record::runs;

/// Without a record, nothing needs to know the task that runs.
#[cfg(not(feature = "full"))]
pub(crate) fn runs(_task: u32) {}

/// Resets from now on are not in a row with those before.
pub(crate) fn trust() {
    ROW.store(0, Ordering::Relaxed);
}

/// Takes what is known of the end of the program before this one. Once, before tasks run. Also returns whether power failed since,
/// or the reset pin was pulled: every reset pulls it, so that its flag alone says nothing (RM0090 7.1.1).
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
        defmt::error!(
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

/// Ends the program: silence, record, reset. With a debugger attached it stops there instead. `frame`: where the exception
/// stacked the registers of what it interrupted.
pub(crate) extern "C" fn end(frame: u32, cause: u32) -> ! {
    RCC.apb1rstr().modify(|w| {
        w.set_can1rst(true);
        w.set_can2rst(true);
    });
    #[cfg(feature = "full")]
    record::write(frame, cause);
    #[cfg(not(feature = "full"))]
    let _ = (frame, cause);
    if DCB::is_debugger_attached() {
        loop {
            cortex_m::asm::bkpt();
        }
    }
    SCB::sys_reset()
}

/// Ends the program after a fault. For the handler of HardFault, on a stack of its own. `frame`: see [`end`].
pub extern "C" fn on_fault(frame: u32) -> ! {
    end(frame, PostMortem::FAULT.into())
}

/// Ends the program: the oscillator stopped. For the handler of the NMI, which the clock security system raises alone (RM0090
/// 7.2.7), on a stack of its own.
pub extern "C" fn on_oscillator(frame: u32) -> ! {
    end(frame, PostMortem::OSCILLATOR.into())
}
