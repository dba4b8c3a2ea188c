//! Banks of acceptance filters. Those of both controllers are registers of CAN1 (RM0090 32.7.4).

use ecss_can::link::port::Filter;
use embassy_stm32::pac;

use super::controller::BANKS;
use super::filters::half_bank;
use crate::registers;

/// Sets all banks to 16-bit masks into the first FIFO, and assigns half of them to each controller. Does nothing if they are set
/// already: they are not after a reset or a flipped bit. Neither controller receives during the change (RM0090 32.9.4).
/// Returns whether they were not.
pub(super) fn prepare() -> bool {
    let block = pac::CAN1;
    let fmr = block.fmr().read();
    let kinds = block.fm1r().read().0 | block.fs1r().read().0 | block.ffa1r().read().0;
    if kinds == 0 && !fmr.finit() && fmr.can2sb() == BANKS as u8 {
        return false;
    }
    block.fmr().modify(|w| {
        w.set_finit(true);
        w.set_can2sb(BANKS as u8);
    });
    block.fm1r().write(|w| w.0 = 0);
    block.fs1r().write(|w| w.0 = 0);
    block.ffa1r().write(|w| w.0 = 0);
    block.fmr().modify(|w| w.set_finit(false));
    true
}

/// Writes a filter of the controller whose banks begin with `first`; it has `filters`, two in each bank.
pub(super) fn write(first: usize, filters: usize, number: usize, filter: Filter) {
    let (block, bank) = (pac::CAN1, first + number / 2);
    if bank >= 2 * BANKS {
        return;
    }
    let (registers, half) = (block.fb(bank), half_bank(filter));
    let held = [registers.fr1().read().0, registers.fr2().read().0];
    let mut wanted = held;
    wanted[number % 2] = half;
    // With an odd number of filters the second half repeats the last filter: an empty half would admit identifier 0.
    if number + 1 == filters {
        wanted[1] = half;
    }
    if wanted == held && block.fa1r().read().fact(bank) {
        return;
    }
    // A bank that is not active may be written while the others work (RM0090 32.7.4).
    block.fa1r().modify(|w| w.set_fact(bank, false));
    registers.fr1().write(|w| w.0 = wanted[0]);
    registers.fr2().write(|w| w.0 = wanted[1]);
    block.fa1r().modify(|w| w.set_fact(bank, true));
}

/// Mends what all banks share, and which banks of the controller are active. A bank that must not be active admits frames of any
/// kind.
pub(super) fn mend(first: usize, filters: usize) {
    let block = pac::CAN1;
    if prepare() {
        registers::count(block.fmr().as_ptr() as u32);
    }
    let of = |banks: usize| ((1_u32 << banks) - 1) << first;
    let (all, wanted) = (of(BANKS), of(filters.div_ceil(2).min(BANKS)));
    let active = block.fa1r().read().0;
    if active & all != wanted {
        block.fa1r().write(|w| w.0 = active & !all | wanted);
        registers::count(block.fa1r().as_ptr() as u32);
    }
}
