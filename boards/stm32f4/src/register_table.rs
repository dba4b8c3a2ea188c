//! The table of registers, and what follows when one differs.

use core::sync::atomic::{AtomicU32, Ordering};

use ecss_can::emcy::PostMortem;
use embassy_stm32::pac;
use embassy_stm32::pac::can::Can;

use crate::post_mortem::{self, ReadLog};
use crate::registers::{Register, is_sealed, seal};
use crate::{capture, clock_tree, core_registers, time_driver};

/// Registers by owner.
static OWNERS: [&[Register]; 4] =
    [&clock_tree::REGISTERS, &time_driver::REGISTERS, &core_registers::REGISTERS, &capture::REGISTERS];

/// Number of ticks, by which owners have their turn.
static NEXT: AtomicU32 = AtomicU32::new(0);
/// Frames that a FIFO holds.
const PLACES: u8 = 3;
/// Ticks in a row in which a FIFO was full.
static FULL: AtomicU32 = AtomicU32::new(0);
/// Ticks after which a FIFO that stays full is lost. Within half of them its port has enabled the interrupt again.
const PATIENCE: u32 = 10;

/// Reads the values to keep, at the end of the start-up. From now on registers are compared.
pub(crate) fn keep() {
    OWNERS.iter().copied().flatten().for_each(Register::keep);
    seal();
}

/// Compares the registers of the next owner. Call it from the supervisor's tick. Arguments: see
/// [`on_tick`](crate::exceptions::on_tick).
pub(crate) fn on_tick(frame: Option<u32>, log: ReadLog) {
    let turn = NEXT.load(Ordering::Relaxed);
    NEXT.store(turn.wrapping_add(1), Ordering::Relaxed);
    let Some(owned) = OWNERS.get(turn as usize % OWNERS.len()) else { return };
    if !is_sealed() {
        return; // start-up has not ended
    }
    let lost = owned.iter().find(|register| !register.mend()).map(Register::address);
    if let Some(address) = lost.or_else(unserved) {
        post_mortem::runs(address);
        post_mortem::end(frame, PostMortem::REGISTER, log);
    }
}

/// Returns the address of a FIFO that stays full.
fn unserved() -> Option<u32> {
    // FULL itself may be an upset.
    let is_full = |controller: &Can| controller.rfr(0).read().fmp() == PLACES;
    let Some(controller) = [pac::CAN1, pac::CAN2].into_iter().find(is_full) else {
        FULL.store(0, Ordering::Relaxed);
        return None;
    };
    let ticks = FULL.load(Ordering::Relaxed) + 1;
    FULL.store(ticks, Ordering::Relaxed);
    (ticks > PATIENCE).then(|| controller.rfr(0).as_ptr() as u32)
}
