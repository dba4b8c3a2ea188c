//! Peripherals of a board that a test accesses register by register.

use super::Peripherals;
use crate::mmio::{Now, Refusal, Width};
use crate::model::Model;
use crate::wire::time::Time;

pub(super) const RCC: u32 = 0x4002_3800;

/// Peripherals on HSI (16 MHz), and their time.
pub(super) struct Bench {
    pub peripherals: Peripherals,
    pub cycle: u64,
}

impl Bench {
    pub fn of(model: Model) -> Bench {
        Bench { peripherals: Peripherals::new(model, 0), cycle: 0 }
    }

    pub fn pyboard() -> Bench {
        Bench::of(Model::shipped("pyboard-v11"))
    }

    pub fn now(&self) -> Now {
        Now { cycle: self.cycle, time: Time::ZERO }
    }

    pub fn load(&mut self, address: u32, width: Width) -> Result<u32, Refusal> {
        self.peripherals.read(self.now(), address, width)
    }

    pub fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), Refusal> {
        self.peripherals.write(self.now(), address, width, value)
    }

    /// Loads a word.
    #[track_caller]
    pub fn read(&mut self, address: u32) -> u32 {
        self.load(address, Width::Word).unwrap_or_else(|refusal| panic!("{address:08X}h: {refusal}"))
    }

    /// Stores a word.
    #[track_caller]
    pub fn write(&mut self, address: u32, value: u32) {
        self.set_up([(address, value)]);
    }

    /// Stores words at these addresses.
    #[track_caller]
    pub fn set_up<const N: usize>(&mut self, registers: [(u32, u32); N]) {
        for (address, value) in registers {
            let done = self.store(address, Width::Word, value);
            done.unwrap_or_else(|refusal| panic!("{address:08X}h: {refusal}"));
        }
    }

    /// Interrupt lines that are raised.
    pub fn irqs(&mut self) -> Vec<u32> {
        let levels = self.peripherals.irq_levels(self.now());
        (0..96).filter(|irq| levels[*irq as usize / 32] >> (irq % 32) & 1 == 1).collect()
    }
}
