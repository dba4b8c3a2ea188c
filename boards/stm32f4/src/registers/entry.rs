//! Registers of the table: address, bits and value.

use core::sync::atomic::{AtomicU32, Ordering};

use super::count;

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

    /// Returns the address.
    pub(crate) fn address(&self) -> u32 {
        self.place & !FLAGS
    }

    /// Reads the value to keep, if it has one.
    pub(crate) fn keep(&self) {
        if let Some(kept) = self.kept_value() {
            kept.store(self.read(), Ordering::Relaxed);
        }
    }

    fn pointer(&self) -> *mut u32 {
        self.address() as *mut u32
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
    pub(crate) fn mend(&self) -> bool {
        let wanted = self.kept_value().map_or(self.value, |kept| kept.load(Ordering::Relaxed));
        if !self.differs(wanted) {
            return true;
        }
        if self.kept_value().is_some() && checksum() != CHECK.load(Ordering::Relaxed) {
            // The upset struck the copy.
            self.keep();
            seal();
            return true;
        }
        if self.place & RESETS != 0 {
            return false;
        }
        count(self.address());
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

/// Seals the values that were kept, at the end of the start-up.
pub(crate) fn seal() {
    CHECK.store(checksum(), Ordering::Relaxed);
}

/// Returns whether the values were kept.
pub(crate) fn is_sealed() -> bool {
    CHECK.load(Ordering::Relaxed) != 0
}
