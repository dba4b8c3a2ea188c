//! Data accesses: alignment, protection, bit-band aliases, system registers, then the bus (B3.1, A3.2).

use crate::bus::{Bus, Width};
use crate::core::{Core, Raised};
use crate::cycles;
use crate::system::mpu::Access;
use crate::system::scb::CCR_UNALIGN_TRP;
use crate::trap::Trap;

/// Set alone among these bits in the aliases at 2200_0000h and 4200_0000h, and in two other ranges.
const ALIAS_MASK: u32 = 0x9E00_0000;
const ALIAS: u32 = 0x0200_0000;
/// The private peripheral bus, and above.
const PRIVATE: u32 = 0xE000_0000;
/// End of the registers that the core serves itself. The board's part of the private bus follows (B3.1.1).
const PRIVATE_INTERNAL_END: u32 = 0xE004_0000;
const PRIVATE_END: u32 = 0xE010_0000;

/// The bit that a word of an alias stands for: address of the byte, and number of the bit ("Bit-banding" in the technical reference manual).
pub fn bit_band(address: u32) -> Option<(u32, u32)> {
    match address >> 24 {
        0x22 | 0x23 | 0x42 | 0x43 => {
            let offset = address & 0x01FF_FFFF;
            Some((address & 0xF000_0000 | offset >> 5, offset >> 2 & 7))
        }
        _ => None,
    }
}

impl Core {
    /// Loads with the given rights; the bits above `width` are zero.
    pub(crate) fn read<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        width: Width,
        privileged: bool,
    ) -> Result<u32, Raised> {
        self.spent += cycles::ACCESS;
        if self.is_plain(address, width) {
            return bus.load(address, width).map_err(|_| self.raise(Trap::DataBus(address)));
        }
        self.read_special(bus, address, width, privileged)
    }

    /// Stores the low bits of `value` with the given rights.
    pub(crate) fn write<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        width: Width,
        value: u32,
        privileged: bool,
    ) -> Result<(), Raised> {
        self.spent += cycles::ACCESS;
        if self.is_plain(address, width) {
            return bus.store(address, width, value).map_err(|_| self.raise(Trap::DataBus(address)));
        }
        self.write_special(bus, address, width, value, privileged)
    }

    /// Returns whether an access goes to the bus as it is.
    #[inline]
    fn is_plain(&self, address: u32, width: Width) -> bool {
        address & (width.bytes() - 1) == 0
            && address & ALIAS_MASK != ALIAS
            && address < PRIVATE
            && !self.mpu.is_enabled()
    }

    #[inline(never)]
    fn read_special<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        width: Width,
        privileged: bool,
    ) -> Result<u32, Raised> {
        self.check_alignment(address, width, false)?;
        if (PRIVATE..PRIVATE_INTERNAL_END).contains(&address) {
            return self.read_system(address, width, privileged);
        }
        self.check_access(address, width, Access::Read, privileged)?;
        let refused = Trap::DataBus(address);
        if let Some((byte, bit)) = bit_band(address) {
            let (at, bit) = containing(byte, bit, width);
            let value = bus.load(at, width).map_err(|_| self.raise(refused))?;
            return Ok(value >> bit & 1);
        }
        if address & (width.bytes() - 1) == 0 {
            return bus.load(address, width).map_err(|_| self.raise(refused));
        }
        let mut value = 0;
        for byte in 0..width.bytes() {
            let at = address.wrapping_add(byte);
            let loaded = bus.load(at, Width::Byte).map_err(|_| self.raise(Trap::DataBus(at)))?;
            value |= loaded << (8 * byte);
        }
        Ok(value)
    }

    #[inline(never)]
    fn write_special<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        width: Width,
        value: u32,
        privileged: bool,
    ) -> Result<(), Raised> {
        self.check_alignment(address, width, false)?;
        if (PRIVATE..PRIVATE_INTERNAL_END).contains(&address) {
            return self.write_system(address, width, value, privileged);
        }
        self.check_access(address, width, Access::Write, privileged)?;
        let refused = Trap::DataBus(address);
        if let Some((byte, bit)) = bit_band(address) {
            self.spent += cycles::BIT_BAND_READ;
            let (at, bit) = containing(byte, bit, width);
            let old = bus.load(at, width).map_err(|_| self.raise(refused))?;
            let new = old & !(1 << bit) | (value & 1) << bit;
            return bus.store(at, width, new).map_err(|_| self.raise(refused));
        }
        if address & (width.bytes() - 1) == 0 {
            return bus.store(address, width, value).map_err(|_| self.raise(refused));
        }
        for byte in 0..width.bytes() {
            let at = address.wrapping_add(byte);
            bus.store(at, Width::Byte, value >> (8 * byte) & 0xFF)
                .map_err(|_| self.raise(Trap::DataBus(at)))?;
        }
        Ok(())
    }

    /// Refuses an unaligned access where the instruction, CCR.UNALIGN_TRP or the private bus does (A3.2.1).
    #[inline]
    pub(crate) fn check_alignment(&mut self, address: u32, width: Width, always: bool) -> Result<(), Raised> {
        let traps =
            || always || self.scb.ccr & CCR_UNALIGN_TRP != 0 || (PRIVATE..PRIVATE_END).contains(&address);
        if address & (width.bytes() - 1) != 0 && traps() {
            return Err(self.raise(Trap::UNALIGNED));
        }
        Ok(())
    }

    /// Asks the MPU about the first byte, and about the word of the last one if that is another. Regions begin at words.
    fn check_access(
        &mut self,
        address: u32,
        width: Width,
        access: Access,
        privileged: bool,
    ) -> Result<(), Raised> {
        let end = address.wrapping_add(width.bytes() - 1) & !3;
        let last = if end == address & !3 { address } else { end };
        let negative = self.execution_priority() < 0;
        for at in [address, last] {
            if !self.mpu.permits(at, access, privileged, negative) {
                return Err(self.raise(Trap::DataAccess(at)));
            }
        }
        Ok(())
    }

    /// Returns whether code at `address` may run by the default memory map (B3.1) and the MPU.
    pub(crate) fn may_execute(&self, address: u32) -> bool {
        let negative = self.mpu.is_enabled() && self.execution_priority() < 0;
        !(PRIVATE..).contains(&address)
            && self.mpu.permits(address, Access::Execute, self.is_privileged(), negative)
    }
}

/// Aligned address and number of the bit for an access of `width`.
fn containing(byte: u32, bit: u32, width: Width) -> (u32, u32) {
    let within = byte & (width.bytes() - 1);
    (byte - within, 8 * within + bit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aliases_name_bits_of_the_first_mebibyte() {
        assert_eq!(bit_band(0x2200_0000), Some((0x2000_0000, 0)));
        assert_eq!(bit_band(0x23FF_FFFC), Some((0x200F_FFFF, 7)));
        assert_eq!(bit_band(0x4200_0000 + 0x2_0014 * 32 + 5 * 4), Some((0x4002_0014, 5)));
        assert_eq!(bit_band(0x2000_0000), None);
        assert_eq!(bit_band(0x2400_0000), None);
    }

    #[test]
    fn word_access_finds_the_bit_in_its_word() {
        assert_eq!(containing(0x2000_0003, 7, Width::Word), (0x2000_0000, 31));
        assert_eq!(containing(0x2000_0003, 7, Width::Byte), (0x2000_0003, 7));
    }
}
