//! First use of each byte of RAM by the core: whether it is read before it is written.

use super::Chip;
use crate::cpu::{Bus, BusError};
use crate::memory::Place;
use crate::mmio::Width;

/// First use of a byte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Use {
    /// The core did not access it.
    #[default]
    None,
    /// The core read it, and may have written it later.
    Read,
    /// The core wrote it, and may have read it later.
    Written,
}

/// First uses of RAM and CCM in a span of time. Accesses by DMA are not recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Uses {
    ram: Vec<Use>,
    ccm: Vec<Use>,
}

impl Uses {
    pub(crate) fn new(chip: &Chip) -> Uses {
        let part = chip.peripherals.part;
        let none = |bytes: u32| vec![Use::None; bytes as usize];
        Uses { ram: none(part.ram_bytes()), ccm: none(part.ccm_bytes()) }
    }

    fn bytes(&mut self, place: Option<Place>, width: Width) -> Option<&mut [Use]> {
        let (memory, offset) = match place? {
            Place::Ram(offset) => (&mut self.ram, offset),
            Place::Ccm(offset) => (&mut self.ccm, offset),
            Place::Flash(_) => return None,
        };
        memory.get_mut(offset..offset + width.bytes() as usize)
    }

    fn note(&mut self, place: Option<Place>, width: Width, first: Use) {
        for byte in self.bytes(place, width).into_iter().flatten() {
            if *byte == Use::None {
                *byte = first;
            }
        }
    }

    /// Returns the first use of the byte at `address`; [`Use::None`] outside of RAM and CCM.
    pub fn at(&self, address: u32) -> Use {
        let of = |memory: &[Use], base: u32| memory.get(address.wrapping_sub(base) as usize).copied();
        of(&self.ram, 0x2000_0000).or_else(|| of(&self.ccm, 0x1000_0000)).unwrap_or_default()
    }

    /// Adds the uses of the time that follows.
    pub fn then(&mut self, later: &Uses) {
        let all = self.ram.iter_mut().zip(&later.ram).chain(self.ccm.iter_mut().zip(&later.ccm));
        for (first, later) in all.filter(|(first, _)| **first == Use::None) {
            *first = *later;
        }
    }
}

/// The bus of a chip whose uses of RAM are recorded.
pub(crate) struct Watching<'a> {
    pub chip: &'a mut Chip,
    pub uses: &'a mut Uses,
}

impl Bus for Watching<'_> {
    fn begin(&mut self, cycle: u64) {
        self.chip.begin(cycle);
    }

    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        self.uses.note(self.chip.memory.place(address), Width::Half, Use::Read);
        self.chip.fetch(address)
    }

    fn refetch(&mut self, address: u32) {
        self.chip.refetch(address);
    }

    fn is_settled(&self) -> bool {
        self.chip.is_settled()
    }

    fn load(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        self.uses.note(self.chip.memory.place(address), width, Use::Read);
        self.chip.load(address, width)
    }

    fn vector(&mut self, address: u32) -> Result<u32, BusError> {
        self.uses.note(self.chip.memory.place(address), Width::Word, Use::Read);
        self.chip.vector(address)
    }

    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        self.uses.note(self.chip.memory.place(address), width, Use::Written);
        self.chip.store(address, width, value)
    }

    fn take_waits(&mut self) -> u32 {
        self.chip.take_waits()
    }

    fn yields(&self) -> bool {
        self.chip.yields()
    }
}
