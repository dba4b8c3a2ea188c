//! In the place of `post_mortem.rs`: a program that ends leaves no record, only the number of resets in a row.
//!
//! A program that ends puts both controllers into reset first, so that it acknowledges no more frames.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::{DCB, SCB};
use ecss_can::emcy::PostMortem;
use embassy_stm32::pac::RCC;

/// Flags of RCC_CSR (RM0090 7.3.21).
const BORRSTF: u32 = 1 << 25;
const PORRSTF: u32 = 1 << 27;
const SFTRSTF: u32 = 1 << 28;
const IWDGRSTF: u32 = 1 << 29;
const WWDGRSTF: u32 = 1 << 30;
/// The count goes no further.
const MOST_IN_A_ROW: u32 = 20;

/// Resets in a row that no power failure and no reset pin caused.
// SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM. The bits of a u32 may be any.
#[unsafe(link_section = ".uninit.ROW")]
static ROW: AtomicU32 = AtomicU32::new(0);

/// The first task is there.
pub(crate) fn begin() {}

/// A task is polled; zero for none.
pub(crate) fn runs(_task: u32) {}

/// Resets from now on are not in a row with those before.
pub(crate) fn trust() {
    ROW.store(0, Ordering::Relaxed);
}

/// Takes what is known of the reset: how many there were in a row, and whether this one came from outside. Every reset pulls the
/// reset pin, so that its flag alone says nothing (RM0090 7.1.1).
pub(crate) fn take() -> (PostMortem, bool) {
    let flags = RCC.csr().read().0;
    RCC.csr().modify(|w| w.set_rmvf(true));
    let is_from_outside = flags & (PORRSTF | BORRSTF) != 0 || flags & (SFTRSTF | IWDGRSTF | WWDGRSTF) == 0;
    let before = ROW.load(Ordering::Relaxed);
    let row = if is_from_outside { 0 } else { before.saturating_add(1).min(MOST_IN_A_ROW) };
    ROW.store(row, Ordering::Relaxed);
    if row > 0 {
        defmt::error!("reset by the program or its watchdog, {=u32} in a row", row);
    }
    (PostMortem { row: row as u8, ..PostMortem::default() }, is_from_outside)
}

/// Ends the program: silence, reset. With a debugger attached it stops there instead.
pub(crate) extern "C" fn end(_frame: u32, _cause: u32) -> ! {
    RCC.apb1rstr().modify(|w| {
        w.set_can1rst(true);
        w.set_can2rst(true);
    });
    if DCB::is_debugger_attached() {
        loop {
            cortex_m::asm::bkpt();
        }
    }
    SCB::sys_reset()
}

/// Defines the handler of an exception after which nothing returns. The stack may be lost: it begins anew.
macro_rules! on_a_new_stack {
    ($exception:ident) => {
        // SAFETY: the vector table knows the handler by this name and no other symbol has it. It never returns, so that nothing
        // on the stack is needed again.
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        unsafe extern "C" fn $exception() -> ! {
            core::arch::naked_asm!(
                "ldr r1, =_stack_start",
                "mov sp, r1",
                "b {handler}",
                handler = sym end,
            )
        }
    };
}

on_a_new_stack!(HardFault);
// The clock security system raises it alone (RM0090 7.2.7).
on_a_new_stack!(NonMaskableInt);
