//! The table, and what follows when a register differs.

use core::sync::atomic::{AtomicU32, Ordering};

use ecss_can::emcy::PostMortem;
use ecss_can::node::Upsets;
use embassy_stm32::pac;
use embassy_stm32::pac::can::Can;

use crate::post_mortem::{self, ReadLog};
use crate::{capture, clock_tree, core_registers, time_driver};

/// Upsets of this board, for its node.
pub(crate) static UPSETS: Upsets = Upsets::new();

/// Flags in the lowest bits of an address: the board is reset if the register differs, and its value is in [`KEPT`].
const RESETS: u32 = 1 << 0;
const IS_KEPT: u32 = 1 << 1;
const FLAGS: u32 = RESETS | IS_KEPT;

/// A register, the bits of it that are compared, and their value.
pub(crate) struct Register {
    /// Address and flags.
    place: u32,
    mask: u32,
    /// The value, or the place in [`KEPT`].
    value: u32,
}

/// Registers whose value others choose: oscillator, part, wiring, HAL. It is read after start-up.
#[derive(Clone, Copy)]
pub(crate) enum Kept {
    PllSettings,
    ClockSettings,
    PortClocks,
    TimerClocks,
    BusClocks,
    FlashAccess,
    Tick,
    Vectors,
    Last,
}

const KEPT_REGISTERS: usize = Kept::Last as usize;

/// Values read after start-up, and their checksum, zero before.
static KEPT: [AtomicU32; KEPT_REGISTERS] = [const { AtomicU32::new(0) }; KEPT_REGISTERS];
static CHECK: AtomicU32 = AtomicU32::new(0);

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

impl Register {
    /// Bits of a register that have this value.
    pub(crate) const fn of(address: u32, mask: u32, value: u32) -> Register {
        Register { place: address, mask, value }
    }

    /// Bits of a register that keep the value that they have after start-up.
    pub(crate) const fn kept(address: u32, mask: u32, place: Kept) -> Register {
        Register { place: address | IS_KEPT, mask, value: place as u32 }
    }

    /// The board is reset if the bits differ.
    pub(crate) const fn or_reset(self) -> Register {
        Register { place: self.place | RESETS, ..self }
    }

    fn pointer(&self) -> *mut u32 {
        (self.place & !FLAGS) as *mut u32
    }

    fn read(&self) -> u32 {
        // SAFETY: the tables list registers of the chip and of its core, whose bits may be read at any time.
        unsafe { self.pointer().read_volatile() }
    }

    fn kept_value(&self) -> Option<&'static AtomicU32> {
        if self.place & IS_KEPT != 0 { KEPT.get(self.value as usize) } else { None }
    }

    fn differs(&self, wanted: u32) -> bool {
        (self.read() ^ wanted) & self.mask != 0
    }

    /// Compares the bits and mends them. Returns `false` if the board has to be reset.
    fn mend(&self) -> bool {
        let wanted = self.kept_value().map_or(self.value, |kept| kept.load(Ordering::Relaxed));
        if !self.differs(wanted) {
            return true;
        }
        if self.kept_value().is_some() && checksum() != CHECK.load(Ordering::Relaxed) {
            // The upset struck the copy.
            keep();
            return true;
        }
        if self.place & RESETS != 0 {
            return false;
        }
        super::count(self.place & !FLAGS);
        let value = self.read() & !self.mask | wanted & self.mask;
        // SAFETY: the value is that of start-up, so that the register works as its owner expects. This interrupt has the highest
        // priority, and owners change other bits of these registers in critical sections only.
        unsafe { self.pointer().write_volatile(value) };
        !self.differs(wanted)
    }
}

fn checksum() -> u32 {
    KEPT.iter().fold(0, |sum, kept| sum.rotate_left(1) ^ kept.load(Ordering::Relaxed))
}

/// Reads the values to keep, at the end of the start-up. From now on registers are compared.
pub(crate) fn keep() {
    for register in OWNERS.iter().copied().flatten() {
        if let Some(kept) = register.kept_value() {
            kept.store(register.read(), Ordering::Relaxed);
        }
    }
    CHECK.store(checksum(), Ordering::Relaxed);
}

/// Compares the registers of the next owner. Call it from the supervisor's tick. Arguments: see
/// [`on_tick`](crate::supervisor::on_tick).
pub(crate) fn on_tick(frame: Option<u32>, log: ReadLog) {
    let turn = NEXT.load(Ordering::Relaxed);
    NEXT.store(turn.wrapping_add(1), Ordering::Relaxed);
    let Some(owned) = OWNERS.get(turn as usize % OWNERS.len()) else { return };
    if CHECK.load(Ordering::Relaxed) == 0 {
        return; // start-up has not ended
    }
    let lost = owned.iter().find(|register| !register.mend()).map(|register| register.place & !FLAGS);
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
