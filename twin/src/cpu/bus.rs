//! The bus: memories and peripherals around a core.

/// Width of a data access.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Width {
    /// 8 bits.
    Byte,
    /// 16 bits.
    Half,
    /// 32 bits.
    Word,
}

impl Width {
    /// Number of bytes: 1, 2 or 4.
    #[must_use]
    #[inline]
    pub const fn bytes(self) -> u32 {
        match self {
            Width::Byte => 1,
            Width::Half => 2,
            Width::Word => 4,
        }
    }

    /// Returns whether an access of this width is aligned.
    #[inline]
    pub(in crate::cpu) const fn aligns(self, address: u32) -> bool {
        address & (self.bytes() - 1) == 0
    }

    /// The bits of a value of this width.
    #[inline]
    pub(in crate::cpu) const fn mask(self) -> u32 {
        u32::MAX >> (32 - 8 * self.bytes())
    }
}

/// The bus refused an access. The core raises a BusFault (DDI 0403 B1.5.14).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BusError;

/// Memories and peripherals of a board, as one core sees them.
///
/// The core serves 0xE000_0000 to 0xE003_FFFF itself and resolves the bit-band aliases; these accesses do not reach the bus. Every
/// data access that reaches the bus is aligned to its width. The core splits an unaligned access into bytes.
pub trait Bus {
    /// Announces the next instruction, exception entry or reset. All accesses up to the next call belong to it.
    ///
    /// `cycle` is the cycle at which it begins.
    fn begin(&mut self, cycle: u64) {
        let _ = cycle;
    }

    /// Returns the half-word of code at an even address.
    ///
    /// # Errors
    /// [`BusError`] if no code can be read there. The core raises a BusFault with IBUSERR.
    fn fetch(&mut self, address: u32) -> Result<u16, BusError>;

    /// Counts the fetch of a half-word in [`Config::code`](crate::cpu::Config::code) that the core has decoded before.
    fn refetch(&mut self, address: u32) {
        let _ = address;
    }

    /// Returns whether fetches in [`Config::code`](crate::cpu::Config::code) read what the memory holds.
    ///
    /// A cache in front of the memory may show outdated lines. While it does, return `false`: the core then fetches and decodes each
    /// instruction anew and keeps nothing of it.
    fn is_settled(&self) -> bool {
        true
    }

    /// Loads from an address aligned to `width`. The bits above `width` are zero.
    ///
    /// # Errors
    /// [`BusError`] if nothing answers. The core raises a BusFault with PRECISERR.
    fn load(&mut self, address: u32, width: Width) -> Result<u32, BusError>;

    /// Loads an entry of the vector table.
    ///
    /// # Errors
    /// [`BusError`] if nothing answers. The core raises a HardFault with VECTTBL.
    fn vector(&mut self, address: u32) -> Result<u32, BusError> {
        self.load(address, Width::Word)
    }

    /// Stores the low bits of `value` to an address aligned to `width`.
    ///
    /// # Errors
    /// [`BusError`] if nothing accepts the store. The core raises a BusFault with PRECISERR.
    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError>;

    /// Returns the cycles that the accesses since the last call had to wait, and forgets them.
    fn take_waits(&mut self) -> u32 {
        0
    }

    /// Asks [`Core::run`](crate::cpu::Core::run) to return after the current instruction.
    fn yields(&self) -> bool {
        false
    }
}
