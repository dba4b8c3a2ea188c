//! The memories of a chip: flash, RAM and CCM.

use std::ops::Range;
use std::sync::Arc;

use crate::mmio::Width;
use crate::model::{FLASH_BASE, RAM_AT_POWER_ON};
use crate::part::Part;
use crate::peripherals::Ram;

const CCM_BASE: u32 = 0x1000_0000;
const RAM_BASE: u32 = 0x2000_0000;
/// Size in bytes of the region of RAM. An access behind the end of RAM in this region is a bus fault. It is a constant
/// because each access is compared with it (row twin.host_instructions).
const RAM_REGION: usize = 512 << 20;

/// An access outside of flash and RAM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotMemory(
    /// The first address of the access.
    pub u32,
);

/// Memories of one chip. Copies share their flash until one of them changes it.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    flash: Arc<Vec<u8>>,
    ram: Box<[u8]>,
    ccm: Box<[u8]>,
}

/// A place in one of the memories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Ram(usize),
    Ccm(usize),
    Flash(usize),
}

impl Memory {
    /// Memories after power-on. `image` is the content of flash from 0800 0000h on; the rest is erased.
    ///
    /// # Panics
    /// The image is larger than the flash.
    pub fn new(part: Part, image: &[u8]) -> Self {
        let mut flash = vec![0xFF; part.flash_bytes() as usize];
        flash[..image.len()].copy_from_slice(image);
        Memory {
            flash: Arc::new(flash),
            ram: vec![RAM_AT_POWER_ON; part.ram_bytes() as usize].into(),
            ccm: vec![RAM_AT_POWER_ON; part.ccm_bytes() as usize].into(),
        }
    }

    /// Loses power: the content of RAM and CCM becomes undefined, flash keeps its content.
    pub fn lose_power(&mut self) {
        self.ram.fill(RAM_AT_POWER_ON);
        self.ccm.fill(RAM_AT_POWER_ON);
    }

    /// Returns the memory at an address. A place behind the end of RAM causes a bus fault. Flash is at 0800 0000h and,
    /// because BOOT0 is low, also at 0.
    #[inline]
    pub fn place(&self, address: u32) -> Option<Place> {
        let offset = address.wrapping_sub(RAM_BASE) as usize;
        if offset < RAM_REGION {
            return Some(Place::Ram(offset));
        }
        let offset = address.wrapping_sub(CCM_BASE) as usize;
        if offset < self.ccm.len() {
            return Some(Place::Ccm(offset));
        }
        [address.wrapping_sub(FLASH_BASE), address]
            .into_iter()
            .map(|offset| offset as usize)
            .find(|&offset| offset < self.flash.len())
            .map(Place::Flash)
    }

    /// Loads from a place that is aligned to `width`.
    #[inline]
    pub fn load(&self, place: Place, width: Width) -> Option<u32> {
        let (memory, offset): (&[u8], usize) = match place {
            Place::Ram(offset) => (&self.ram, offset),
            Place::Ccm(offset) => (&self.ccm, offset),
            Place::Flash(offset) => (&self.flash, offset),
        };
        load(memory, offset, width)
    }

    /// Stores the low bits of `value` to a place in RAM or CCM that is aligned to `width`. `None`: the place is in flash, or
    /// behind the end of RAM.
    #[inline]
    pub fn store(&mut self, place: Place, width: Width, value: u32) -> Option<()> {
        let (memory, offset) = match place {
            Place::Ram(offset) => (&mut self.ram, offset),
            Place::Ccm(offset) => (&mut self.ccm, offset),
            Place::Flash(_) => return None,
        };
        let [a, b, c, d] = value.to_le_bytes();
        // Lengths that are known to the compiler improve the row twin.host_instructions.
        match (width, memory.get_mut(offset..offset + width.bytes() as usize)?) {
            (Width::Byte, [p]) => *p = a,
            (Width::Half, [p, q]) => (*p, *q) = (a, b),
            (Width::Word, [p, q, r, s]) => (*p, *q, *r, *s) = (a, b, c, d),
            _ => return None,
        }
        Some(())
    }

    /// Returns whether flash is equal to that of another chip, and each byte of RAM and CCM for which `counts` is true.
    pub fn continues_as(&self, other: &Memory, counts: impl Fn(u32) -> bool) -> bool {
        let is_equal = |here: &[u8], there: &[u8], base: u32| {
            let differs = |(_, (here, there)): &(u32, (&u8, &u8))| here != there;
            here.len() == there.len()
                && (base..).zip(here.iter().zip(there)).filter(differs).all(|(address, _)| !counts(address))
        };
        (Arc::ptr_eq(&self.flash, &other.flash) || self.flash == other.flash)
            && is_equal(&self.ram, &other.ram, RAM_BASE)
            && is_equal(&self.ccm, &other.ccm, CCM_BASE)
    }

    /// Copies from flash, RAM or CCM.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves the memory in which it begins.
    pub fn copy_out(&self, address: u32, bytes: &mut [u8]) -> Result<(), NotMemory> {
        let (memory, offset): (&[u8], usize) = match self.place(address) {
            Some(Place::Ram(offset)) => (&self.ram, offset),
            Some(Place::Ccm(offset)) => (&self.ccm, offset),
            Some(Place::Flash(offset)) if address >= FLASH_BASE => (&self.flash, offset),
            _ => return Err(NotMemory(address)),
        };
        let end = offset.checked_add(bytes.len()).ok_or(NotMemory(address))?;
        bytes.copy_from_slice(memory.get(offset..end).ok_or(NotMemory(address))?);
        Ok(())
    }

    /// Copies into RAM or CCM.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves the memory in which it begins.
    pub fn copy_in(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        let (memory, offset) = match self.place(address) {
            Some(Place::Ram(offset)) => (&mut self.ram, offset),
            Some(Place::Ccm(offset)) => (&mut self.ccm, offset),
            _ => return Err(NotMemory(address)),
        };
        memory.get_mut(offset..offset + bytes.len()).ok_or(NotMemory(address))?.copy_from_slice(bytes);
        Ok(())
    }

    /// Writes content into flash, from 0800 0000h on. Returns the addresses that hold new content.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves flash.
    pub fn program(&mut self, address: u32, bytes: &[u8]) -> Result<Range<u32>, NotMemory> {
        let offset = address.checked_sub(FLASH_BASE).ok_or(NotMemory(address))? as usize;
        let range = offset..offset + bytes.len();
        if range.end > self.flash.len() {
            return Err(NotMemory(address));
        }
        Arc::make_mut(&mut self.flash)[range].copy_from_slice(bytes);
        Ok(address..address + bytes.len() as u32)
    }

    /// Returns the word at `address`, if memory is there.
    pub fn word_at(&self, address: u32) -> Option<u32> {
        let mut bytes = [0; 4];
        self.copy_out(address, &mut bytes).ok()?;
        Some(u32::from_le_bytes(bytes))
    }
}

/// Loads from `memory`. `None`: the access leaves it.
#[inline]
pub(crate) fn load(memory: &[u8], offset: usize, width: Width) -> Option<u32> {
    match *memory.get(offset..offset + width.bytes() as usize)? {
        [a] => Some(u32::from(a)),
        [a, b] => Some(u32::from(u16::from_le_bytes([a, b]))),
        [a, b, c, d] => Some(u32::from_le_bytes([a, b, c, d])),
        _ => None,
    }
}

/// The memory ports of the DMA controllers. DMA does not reach CCM, which is connected only to the data bus of the core
/// (RM0090 2.3.1).
impl Ram for Memory {
    fn load(&mut self, address: u32, bytes: &mut [u8]) -> bool {
        !matches!(self.place(address), Some(Place::Ccm(_))) && self.copy_out(address, bytes).is_ok()
    }

    fn store(&mut self, address: u32, bytes: &[u8]) -> bool {
        matches!(self.place(address), Some(Place::Ram(_))) && self.copy_in(address, bytes).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::part;

    const FLASH_BYTES: u32 = 1 << 20;

    fn memory() -> Memory {
        Memory::new(part("STM32F405RG"), &[1, 2, 3, 4])
    }

    #[test]
    fn flash_answers_at_its_base_and_at_zero() {
        let memory = memory();
        for address in [FLASH_BASE, 0] {
            let place = memory.place(address).unwrap();
            assert_eq!(memory.load(place, Width::Word), Some(0x0403_0201));
        }
        assert_eq!(memory.word_at(FLASH_BASE + FLASH_BYTES - 4), Some(u32::MAX), "erased");
        assert_eq!(memory.place(FLASH_BASE + FLASH_BYTES), None);
    }

    #[test]
    fn copies_share_flash_until_one_changes_it() {
        let original = memory();
        let mut copy = original.clone();
        assert!(Arc::ptr_eq(&original.flash, &copy.flash));
        assert_eq!(copy.program(FLASH_BASE + 2, &[9]), Ok(FLASH_BASE + 2..FLASH_BASE + 3));
        assert_eq!(
            (original.word_at(FLASH_BASE), copy.word_at(FLASH_BASE)),
            (Some(0x0403_0201), Some(0x0409_0201))
        );
    }

    #[test]
    fn ranges_that_leave_a_memory_are_refused() {
        let mut memory = memory();
        assert_eq!(memory.copy_in(0x2001_FFFE, &[0; 4]), Err(NotMemory(0x2001_FFFE)));
        assert_eq!(memory.copy_in(FLASH_BASE, &[0]), Err(NotMemory(FLASH_BASE)));
        assert_eq!(memory.copy_out(0x2002_0000, &mut [0]), Err(NotMemory(0x2002_0000)));
        assert!(memory.program(FLASH_BASE + FLASH_BYTES - 1, &[0; 2]).is_err());
    }

    #[test]
    fn dma_does_not_reach_ccm_and_does_not_store_to_flash() {
        let mut memory = memory();
        let (flash, ram) = (FLASH_BASE, RAM_BASE);
        assert!(Ram::load(&mut memory, flash, &mut [0]) && Ram::load(&mut memory, ram, &mut [0]));
        assert!(!Ram::load(&mut memory, CCM_BASE, &mut [0]));
        assert!(Ram::store(&mut memory, ram, &[0]));
        assert!(!Ram::store(&mut memory, flash, &[0]) && !Ram::store(&mut memory, CCM_BASE, &[0]));
    }

    #[test]
    fn ram_does_not_keep_its_content_without_power() {
        let mut memory = memory();
        assert_eq!(memory.word_at(RAM_BASE), Some(0xA5A5_A5A5));
        memory.copy_in(RAM_BASE, &[7; 4]).unwrap();
        memory.program(FLASH_BASE, &[7]).unwrap();
        memory.lose_power();
        assert_eq!(
            (memory.word_at(RAM_BASE), memory.word_at(FLASH_BASE)),
            (Some(0xA5A5_A5A5), Some(0x0403_0207))
        );
    }
}
