//! The chip around its core: memories, flash accelerator, peripherals and clock, as accessed by the core's bus.
//!
//! Flash is read through the accelerator, which counts waits and may show an outdated line. Stores to flash go to the
//! interface that programs it. Code does not run from CCM, which is connected to the data bus only (RM0090 2.3.1).
//!
//! The inlining attributes here, in `memory` and in `accelerator` serve the row `twin.host_instructions` of `cargo xtask bench`.

mod tolerance;
mod uses;

pub use uses::{Use, Uses};
pub(crate) use uses::{WatchedRam, Watching};

use crate::accelerator::{Accelerator, FlashTiming, LINE, Purpose};
use crate::clock::BoardClock;
use crate::cpu::{Bus, BusError};
use crate::crystal::Crystal;
use crate::memory::{Memory, Place, load};
use crate::mmio::{Now, Refusal, RefusedAccess, Width};
use crate::model::FLASH_BASE;
use crate::peripherals::{Peripherals, is_reserved};

/// Offset of the vector of HardFault in a vector table, which begins at a multiple of 128 (DDI 0403E B1.5.2, B3.2.5).
const HARD_FAULT_VECTOR: u32 = 12;
const TABLE_ALIGNMENT: u32 = 128;

/// A chip without its core.
#[derive(Clone, Debug)]
pub(crate) struct Chip {
    pub memory: Memory,
    pub accelerator: Accelerator,
    pub peripherals: Peripherals,
    pub clock: BoardClock,
    /// Cycle at which the present instruction began.
    cycle: u64,
    /// The board has to update its state after the present instruction.
    pub needs_attention: bool,
    /// The first access that was refused.
    pub refused: Option<RefusedAccess>,
    /// Answers as the part where the model refuses a correct program.
    pub is_tolerant: bool,
}

/// Returns whether a peripheral, the system memory with the device signature, or DBGMCU lies at `address` (RM0090 figure 2).
fn is_peripheral(address: u32) -> bool {
    matches!(
        address,
        0x4000_0000..0x4008_0000 | 0x5000_0000..0x6000_0000 | 0x1FFF_0000..0x2000_0000 | 0xE004_2000..0xE004_3000
    )
}

impl Chip {
    /// A chip at time zero. `image`: the content of its flash.
    pub fn new(peripherals: Peripherals, image: &[u8], timing: FlashTiming, crystal: Crystal) -> Self {
        let part = peripherals.part;
        Chip {
            memory: Memory::new(part, image),
            accelerator: Accelerator::new(timing, part.flash_bytes()),
            peripherals,
            clock: BoardClock::new(crystal),
            cycle: 0,
            needs_attention: false,
            refused: None,
            is_tolerant: false,
        }
    }

    /// The instant of an access.
    fn now(&self) -> Now {
        Now { cycle: self.cycle, time: self.clock.time_at(self.cycle) }
    }

    /// Reads flash as the core does. Accesses are aligned, so they stay within a line.
    fn read_flash(&mut self, purpose: Purpose, offset: usize, width: Width) -> Result<u32, BusError> {
        let value = match self.accelerator.read(purpose, offset as u32, self.cycle) {
            Some(line) => load(&line, offset % LINE as usize, width),
            None => self.memory.load(Place::Flash(offset), width),
        };
        value.ok_or(BusError)
    }

    fn read_peripheral(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        let result = if is_peripheral(address) {
            self.peripherals.read(self.now(), address, width)
        } else {
            Err(Refusal::Unmodelled)
        };
        self.needs_attention |= self.peripherals.take_change();
        match result {
            Err(refusal) if self.tolerates(address, false, refusal) => Ok(0),
            result => result.map_err(|refusal| self.refuse(address, false, refusal)),
        }
    }

    fn write_peripheral(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        // Stores to flash go to its interface, but not at the mapping from zero on.
        let is_flash = matches!(self.memory.place(address), Some(Place::Flash(_)) if address >= FLASH_BASE);
        let result = if is_peripheral(address) || is_flash {
            self.peripherals.write(self.now(), address, width, value)
        } else {
            Err(Refusal::Unmodelled)
        };
        self.needs_attention |= self.peripherals.take_change();
        if let Some(acr) = self.peripherals.flash.take_acr() {
            self.accelerator.set(acr);
        }
        match result {
            Err(refusal) if self.tolerates(address, true, refusal) => Ok(()),
            result => result.map_err(|refusal| self.refuse(address, true, refusal)),
        }
    }

    /// Records a refused access, at which the board stops. A reserved address causes a bus fault on the real part too;
    /// there the program continues in its handler.
    #[cold]
    fn refuse(&mut self, address: u32, write: bool, refusal: Refusal) -> BusError {
        if !is_reserved(self.peripherals.part, address) {
            self.needs_attention = true;
            self.refused.get_or_insert(RefusedAccess { address, write, refusal });
        }
        BusError
    }
}

impl Bus for Chip {
    #[inline]
    fn begin(&mut self, cycle: u64) {
        self.cycle = cycle;
    }

    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        let half = match self.memory.place(address) {
            Some(Place::Flash(offset)) => self.read_flash(Purpose::Fetch, offset, Width::Half),
            Some(Place::Ccm(_)) => Err(BusError),
            Some(place) => self.memory.load(place, Width::Half).ok_or(BusError),
            None => self.read_peripheral(address, Width::Half),
        };
        half.map(|half| half as u16)
    }

    #[inline]
    fn refetch(&mut self, address: u32) {
        self.accelerator.count(Purpose::Fetch, address.wrapping_sub(FLASH_BASE), self.cycle);
    }

    #[inline]
    fn is_settled(&self) -> bool {
        !self.accelerator.is_stale()
    }

    #[inline]
    fn load(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        match self.memory.place(address) {
            Some(Place::Flash(offset)) => self.read_flash(Purpose::Load, offset, width),
            Some(place) => self.memory.load(place, width).ok_or(BusError),
            None => self.read_peripheral(address, width),
        }
    }

    fn vector(&mut self, address: u32) -> Result<u32, BusError> {
        self.needs_attention |= address % TABLE_ALIGNMENT == HARD_FAULT_VECTOR;
        match self.memory.place(address) {
            Some(Place::Flash(offset)) => self.read_flash(Purpose::Vector, offset, Width::Word),
            _ => self.load(address, Width::Word),
        }
    }

    #[inline]
    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        match self.memory.place(address) {
            Some(Place::Flash(_)) | None => self.write_peripheral(address, width, value),
            Some(place) => self.memory.store(place, width, value).ok_or(BusError),
        }
    }

    #[inline]
    fn take_waits(&mut self) -> u32 {
        self.accelerator.take_waits()
    }

    #[inline]
    fn yields(&self) -> bool {
        self.needs_attention
    }
}
