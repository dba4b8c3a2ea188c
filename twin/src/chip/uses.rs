//! Uses of RAM, registers and FPU: above all, whether the core reads a byte before it writes it.

use std::collections::BTreeSet;

use super::Chip;
use crate::cpu::{Bus, BusError};
use crate::memory::{Memory, Place};
use crate::mmio::Width;
use crate::peripherals::{Ram, RegisterUses};

/// First use of a byte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Use {
    /// The core did not access it.
    #[default]
    None,
    /// The core or DMA read it, and may have written it later.
    Read,
    /// The core wrote it, and may have read it later.
    Written,
}

/// Uses in a span of time: the first ones of RAM and CCM, accesses to peripherals, active filters of CAN, and whether the FPU was used.
/// Stores of DMA to RAM are not recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Uses {
    ram: Vec<Use>,
    ccm: Vec<Use>,
    /// Words of peripherals that the core or DMA accessed.
    registers: BTreeSet<u32>,
    uses_fpu: bool,
    /// A bit for each filter bank of CAN that was active.
    active_filters: u32,
}

impl Uses {
    pub(crate) fn new(chip: &Chip) -> Uses {
        let part = chip.peripherals.part;
        let none = |bytes: u32| vec![Use::None; bytes as usize];
        Uses {
            ram: none(part.ram_bytes()),
            ccm: none(part.ccm_bytes()),
            registers: BTreeSet::new(),
            uses_fpu: false,
            active_filters: 0,
        }
    }

    fn bytes(&mut self, place: Option<Place>, width: Width) -> Option<&mut [Use]> {
        let (memory, offset) = match place? {
            Place::Ram(offset) => (&mut self.ram, offset),
            Place::Ccm(offset) => (&mut self.ccm, offset),
            Place::Flash(_) => return None,
        };
        memory.get_mut(offset..offset + width.bytes() as usize)
    }

    /// Notes an access of the core.
    fn note_access(&mut self, place: Option<Place>, address: u32, width: Width, first: Use) {
        match place {
            None => self.note_register(address),
            place => self.note(place, width, first),
        }
    }

    fn note_register(&mut self, address: u32) {
        self.registers.insert(address & !3);
    }

    /// Notes whether the core used the FPU.
    pub(crate) fn note_fpu(&mut self, uses_fpu: bool) {
        self.uses_fpu |= uses_fpu;
    }

    /// Notes the filter banks of CAN that were active.
    pub(crate) fn note_filters(&mut self, active: u32) {
        self.active_filters |= active;
    }

    /// Returns whether the core used the FPU, or stacked its registers.
    pub(crate) fn uses_fpu(&self) -> bool {
        self.uses_fpu
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
        self.registers.extend(&later.registers);
        self.uses_fpu |= later.uses_fpu;
        self.active_filters |= later.active_filters;
    }
}

impl RegisterUses for Uses {
    fn touches(&self, addresses: std::ops::Range<u32>) -> bool {
        self.registers.range(addresses).next().is_some()
    }

    fn activates(&self, bank: u32) -> bool {
        self.active_filters >> bank & 1 == 1
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
        self.uses.note_access(self.chip.memory.place(address), address, width, Use::Read);
        self.chip.load(address, width)
    }

    fn vector(&mut self, address: u32) -> Result<u32, BusError> {
        self.uses.note(self.chip.memory.place(address), Width::Word, Use::Read);
        self.chip.vector(address)
    }

    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        self.uses.note_access(self.chip.memory.place(address), address, width, Use::Written);
        self.chip.store(address, width, value)
    }

    fn take_waits(&mut self) -> u32 {
        self.chip.take_waits()
    }

    fn yields(&self) -> bool {
        self.chip.yields()
    }
}

/// Memory for DMA whose uses are recorded.
pub(crate) struct WatchedRam<'a> {
    pub memory: &'a mut Memory,
    pub uses: Option<&'a mut Uses>,
}

impl Ram for WatchedRam<'_> {
    fn load(&mut self, address: u32, bytes: &mut [u8]) -> bool {
        if let Some(uses) = &mut self.uses {
            for address in (address..).take(bytes.len()) {
                uses.note(self.memory.place(address), Width::Byte, Use::Read);
            }
        }
        Ram::load(self.memory, address, bytes)
    }

    fn store(&mut self, address: u32, bytes: &[u8]) -> bool {
        Ram::store(self.memory, address, bytes)
    }

    fn moves(&mut self, register: u32) {
        if let Some(uses) = &mut self.uses {
            uses.note_register(register);
        }
    }
}
