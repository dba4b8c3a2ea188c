//! The address space of a part, as its core sees it: flash, RAM, CCM, and peripherals behind the [`Link`].
//!
//! Flash is read through the accelerator, which counts waits and may answer with a stale line. Stores to flash go to the interface that
//! programs it. Code does not run from CCM, which is connected to the data bus alone (RM0090 2.3.1).

use std::ops::Range;
use std::sync::Arc;

use twin_core::{Bus, BusError, Width};

use super::NotMemory;
use crate::accelerator::{LINE, Purpose};
use crate::link::Link;
use crate::mmio;
use crate::model::{FLASH_BASE, Part};

const CCM_BASE: u32 = 0x1000_0000;
const RAM_BASE: u32 = 0x2000_0000;
const RAM_BYTES: usize = 128 << 10;
/// Content of RAM after power-on. Not zero, so that a program that relies on zeros does not work by chance.
const RAM_AT_POWER_ON: u8 = 0xA5;

/// Returns whether a peripheral, the system memory with the device signature, or DBGMCU lies at `address` (RM0090 figure 2).
fn is_peripheral(address: u32) -> bool {
    matches!(
        address,
        0x4000_0000..0x4008_0000 | 0x5000_0000..0x6000_0000 | 0x1FFF_0000..0x2000_0000 | 0xE004_2000..0xE004_3000
    )
}

/// Memories of one part, and its way to the peripherals.
pub(super) struct Memories {
    flash: Vec<u8>,
    ram: Vec<u8>,
    ccm: Vec<u8>,
    link: Arc<Link>,
}

/// A memory that answers with its content at once.
#[derive(Clone, Copy)]
enum Place {
    Ram(usize),
    Ccm(usize),
}

impl Memories {
    /// Memories after power-on. `image` is the content of flash from 0800 0000h on; the rest is erased.
    ///
    /// # Panics
    /// The image is larger than the flash.
    pub fn new(part: Part, image: &[u8], link: Arc<Link>) -> Self {
        let mut flash = vec![0xFF; part.flash_bytes() as usize];
        flash[..image.len()].copy_from_slice(image);
        Memories {
            flash,
            ram: vec![RAM_AT_POWER_ON; RAM_BYTES],
            ccm: vec![RAM_AT_POWER_ON; part.ccm_bytes() as usize],
            link,
        }
    }

    /// What the core is connected to.
    pub fn link(&self) -> &Link {
        &self.link
    }

    /// Offset in flash of an address at 0800 0000h, or at 0: BOOT0 is low.
    fn flash_offset(&self, address: u32) -> Option<usize> {
        [address.wrapping_sub(FLASH_BASE), address]
            .into_iter()
            .map(|offset| offset as usize)
            .find(|&offset| offset < self.flash.len())
    }

    #[inline]
    fn place(&self, address: u32) -> Option<Place> {
        let offset = address.wrapping_sub(RAM_BASE) as usize;
        if offset < RAM_BYTES {
            return Some(Place::Ram(offset));
        }
        let offset = address.wrapping_sub(CCM_BASE) as usize;
        (offset < self.ccm.len()).then_some(Place::Ccm(offset))
    }

    /// Reads flash as the core does. Accesses are aligned, so they stay within a line.
    fn read_flash(&self, purpose: Purpose, offset: usize, width: Width) -> Result<u32, BusError> {
        let stale = self.link.accelerator().read(purpose, offset as u32, || self.link.now().cycle);
        match stale {
            Some(line) => get(&line, offset % LINE as usize, width),
            None => get(&self.flash, offset, width),
        }
    }

    fn read_peripheral(&self, address: u32, width: Width) -> Result<u32, BusError> {
        if !is_peripheral(address) {
            return Err(BusError);
        }
        self.link.read(address, width_of(width)).map_err(|_| BusError)
    }

    fn slice(&self, address: u32, bytes: usize) -> Option<&[u8]> {
        match self.place(address) {
            Some(Place::Ram(offset)) => self.ram.get(offset..offset + bytes),
            Some(Place::Ccm(offset)) => self.ccm.get(offset..offset + bytes),
            None => {
                let offset = address.checked_sub(FLASH_BASE)? as usize;
                self.flash.get(offset..offset.checked_add(bytes)?)
            }
        }
    }

    /// Copies from flash at 0800 0000h, RAM or CCM without side effects.
    pub fn copy_out(&self, address: u32, bytes: &mut [u8]) -> Result<(), NotMemory> {
        bytes.copy_from_slice(self.slice(address, bytes.len()).ok_or(NotMemory(address))?);
        Ok(())
    }

    /// Copies into RAM or CCM without side effects.
    pub fn copy_in(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        let (memory, offset) = match self.place(address) {
            Some(Place::Ram(offset)) => (&mut self.ram, offset),
            Some(Place::Ccm(offset)) => (&mut self.ccm, offset),
            None => return Err(NotMemory(address)),
        };
        memory.get_mut(offset..offset + bytes.len()).ok_or(NotMemory(address))?.copy_from_slice(bytes);
        Ok(())
    }

    /// Changes flash. Returns the addresses that hold new content.
    pub fn program(&mut self, address: u32, bytes: &[u8]) -> Result<Range<u32>, NotMemory> {
        let offset = address.checked_sub(FLASH_BASE).ok_or(NotMemory(address))? as usize;
        self.flash.get_mut(offset..offset + bytes.len()).ok_or(NotMemory(address))?.copy_from_slice(bytes);
        Ok(address..address + bytes.len() as u32)
    }

    /// Returns the half-word at `address` without side effects, if flash or RAM is there.
    pub fn half_at(&self, address: u32) -> Option<u16> {
        let &[low, high] = self.slice(address, 2)? else { return None };
        Some(u16::from_le_bytes([low, high]))
    }

    /// Returns the word at `address` without side effects, if flash or RAM is there.
    pub fn word_at(&self, address: u32) -> Option<u32> {
        let &[a, b, c, d] = self.slice(address, 4)? else { return None };
        Some(u32::from_le_bytes([a, b, c, d]))
    }
}

impl Bus for Memories {
    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        let half = match self.place(address) {
            Some(Place::Ram(offset)) => get(&self.ram, offset, Width::Half),
            Some(Place::Ccm(_)) => Err(BusError),
            None => match self.flash_offset(address) {
                Some(offset) => self.read_flash(Purpose::Fetch, offset, Width::Half),
                None => self.read_peripheral(address, Width::Half),
            },
        };
        half.map(|half| half as u16)
    }

    #[inline]
    fn refetch(&mut self, address: u32) {
        let offset = address.wrapping_sub(FLASH_BASE);
        self.link.accelerator().read(Purpose::Fetch, offset, || self.link.now().cycle);
    }

    #[inline]
    fn is_settled(&self) -> bool {
        !self.link.accelerator().is_stale()
    }

    #[inline]
    fn load(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        match self.place(address) {
            Some(Place::Ram(offset)) => get(&self.ram, offset, width),
            Some(Place::Ccm(offset)) => get(&self.ccm, offset, width),
            None => match self.flash_offset(address) {
                Some(offset) => self.read_flash(Purpose::Load, offset, width),
                None => self.read_peripheral(address, width),
            },
        }
    }

    fn vector(&mut self, address: u32) -> Result<u32, BusError> {
        match self.flash_offset(address) {
            Some(offset) => self.read_flash(Purpose::Vector, offset, Width::Word),
            None => self.load(address, Width::Word),
        }
    }

    #[inline]
    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        match self.place(address) {
            Some(Place::Ram(offset)) => put(&mut self.ram, offset, width, value),
            Some(Place::Ccm(offset)) => put(&mut self.ccm, offset, width, value),
            None => {
                let in_flash = (address.wrapping_sub(FLASH_BASE) as usize) < self.flash.len();
                if !in_flash && !is_peripheral(address) {
                    return Err(BusError);
                }
                self.link.write(address, width_of(width), value).map_err(|_| BusError)
            }
        }
    }

    #[inline]
    fn take_waits(&mut self) -> u32 {
        self.link.accelerator().take_waits()
    }
}

#[inline]
fn get(memory: &[u8], offset: usize, width: Width) -> Result<u32, BusError> {
    match *memory.get(offset..offset + width.bytes() as usize).ok_or(BusError)? {
        [a] => Ok(u32::from(a)),
        [a, b] => Ok(u32::from(u16::from_le_bytes([a, b]))),
        [a, b, c, d] => Ok(u32::from_le_bytes([a, b, c, d])),
        _ => Err(BusError),
    }
}

#[inline]
fn put(memory: &mut [u8], offset: usize, width: Width, value: u32) -> Result<(), BusError> {
    let bytes = width.bytes() as usize;
    let place = memory.get_mut(offset..offset + bytes).ok_or(BusError)?;
    place.copy_from_slice(&value.to_le_bytes()[..bytes]);
    Ok(())
}

fn width_of(width: Width) -> mmio::Width {
    match width {
        Width::Byte => mmio::Width::Byte,
        Width::Half => mmio::Width::Half,
        Width::Word => mmio::Width::Word,
    }
}
