//! Data accesses: alignment, protection, bit-band aliases, system registers, then the bus (B3.1, A3.2).

use crate::cpu::bus::{Bus, Width};
use crate::cpu::core::{Core, Result};
use crate::cpu::cycles;
use crate::cpu::system::mpu::Access;
use crate::cpu::system::scb::CCR_UNALIGN_TRP;
use crate::cpu::trap::Trap;

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

/// A load or store: where, of which width, and with which rights.
#[derive(Clone, Copy)]
pub struct Place {
    pub address: u32,
    pub width: Width,
    pub privileged: bool,
}

impl Core {
    /// Loads with the given rights; the bits above `width` are zero.
    pub(in crate::cpu) fn read<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        width: Width,
        privileged: bool,
    ) -> Result<u32> {
        self.spent += cycles::ACCESS;
        if !self.fpb.is_enabled() && self.is_plain(Place { address, width, privileged }, Access::Read) {
            return bus.load(address, width).map_err(|_| self.raise(Trap::DataBus(address)));
        }
        self.access_special(bus, Place { address, width, privileged }, None)
    }

    /// Stores the low bits of `value` with the given rights.
    #[inline(always)]
    pub(in crate::cpu) fn write<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        width: Width,
        value: u32,
        privileged: bool,
    ) -> Result {
        self.spent += cycles::ACCESS;
        if self.is_plain(Place { address, width, privileged }, Access::Write) {
            return bus.store(address, width, value).map_err(|_| self.raise(Trap::DataBus(address)));
        }
        self.access_special(bus, Place { address, width, privileged }, Some(value)).map(|_| ())
    }

    /// Loads words of an aligned block.
    pub(in crate::cpu) fn read_words<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        words: &mut [u32],
    ) -> Result {
        self.check_alignment(address, Width::Word, true)?;
        let privileged = self.is_privileged();
        for (word, n) in words.iter_mut().zip(0..) {
            *word = self.read(bus, address.wrapping_add(4 * n), Width::Word, privileged)?;
        }
        Ok(())
    }

    /// Stores words to an aligned block.
    pub(in crate::cpu) fn write_words<B: Bus>(&mut self, bus: &mut B, address: u32, words: &[u32]) -> Result {
        self.check_alignment(address, Width::Word, true)?;
        let privileged = self.is_privileged();
        for (&word, n) in words.iter().zip(0..) {
            self.write(bus, address.wrapping_add(4 * n), Width::Word, word, privileged)?;
        }
        Ok(())
    }

    pub(in crate::cpu) fn load_bus<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        width: Width,
    ) -> Result<u32> {
        bus.load(address, width).map_err(|_| self.raise(Trap::DataBus(address)))
    }

    pub(in crate::cpu) fn store_bus<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result {
        bus.store(address, width, value).map_err(|_| self.raise(Trap::DataBus(address)))
    }

    /// Returns whether an access goes to the bus as it is.
    #[inline]
    fn is_plain(&self, at: Place, access: Access) -> bool {
        let Place { address, width, privileged } = at;
        let is_granted = || !self.mpu.is_enabled() || privileged && self.mpu.grants(address, access);
        width.aligns(address) && address & ALIAS_MASK != ALIAS && address < PRIVATE && is_granted()
    }

    /// An access that is not plain. `stored` is the value of a store; a load answers with its own.
    #[inline(never)]
    fn access_special<B: Bus>(&mut self, bus: &mut B, at: Place, stored: Option<u32>) -> Result<u32> {
        let Place { address, width, .. } = at;
        self.check_alignment(address, width, false)?;
        if (PRIVATE..PRIVATE_INTERNAL_END).contains(&address) {
            return match stored {
                Some(value) => self.write_system(at, value).map(|()| value),
                None => self.read_system(at),
            };
        }
        self.check_access(at, if stored.is_some() { Access::Write } else { Access::Read })?;
        if let Some((byte, bit)) = bit_band(address) {
            return self.access_bit(bus, at, stored, containing(byte, bit, width));
        }
        // The core splits an unaligned access into bytes.
        let part = if width.aligns(address) { width } else { Width::Byte };
        let mut loaded = 0;
        for offset in (0..width.bytes()).step_by(part.bytes() as usize) {
            let (address, shift) = (address.wrapping_add(offset), 8 * offset);
            match stored {
                Some(value) => self.store_bus(bus, address, part, value >> shift & part.mask())?,
                None => {
                    let address = if part == width { self.fpb.data(address) } else { address };
                    loaded |= self.load_bus(bus, address, part)? << shift;
                }
            }
        }
        Ok(loaded)
    }

    /// An access by an alias to one bit: the number of the bit at an aligned address.
    fn access_bit<B: Bus>(
        &mut self,
        bus: &mut B,
        alias: Place,
        stored: Option<u32>,
        (address, bit): (u32, u32),
    ) -> Result<u32> {
        let refused = Trap::DataBus(alias.address);
        if stored.is_some() {
            self.spent += cycles::BIT_BAND_READ;
        }
        let old = bus.load(address, alias.width).map_err(|_| self.raise(refused))?;
        if let Some(value) = stored {
            let new = old & !(1 << bit) | (value & 1) << bit;
            bus.store(address, alias.width, new).map_err(|_| self.raise(refused))?;
        }
        Ok(old >> bit & 1)
    }

    /// Refuses an unaligned access where the instruction, CCR.UNALIGN_TRP or the private bus does (A3.2.1).
    #[inline]
    pub(in crate::cpu) fn check_alignment(&mut self, address: u32, width: Width, always: bool) -> Result {
        let traps =
            || always || self.scb.ccr & CCR_UNALIGN_TRP != 0 || (PRIVATE..PRIVATE_END).contains(&address);
        if !width.aligns(address) && traps() {
            return Err(self.raise(Trap::UNALIGNED));
        }
        Ok(())
    }

    /// Asks the MPU about the first byte, and about the word of the last one if that is another. Regions begin at words.
    fn check_access(&mut self, at: Place, access: Access) -> Result {
        let Place { address, width, privileged } = at;
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
    #[inline] // row `twin.host_instructions`
    pub(in crate::cpu) fn may_execute(&self, address: u32) -> bool {
        self.mpu.grants(address, Access::Execute) && self.is_privileged() || self.permits_execution(address)
    }

    #[inline(never)] // row `twin.host_instructions`
    fn permits_execution(&self, address: u32) -> bool {
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
