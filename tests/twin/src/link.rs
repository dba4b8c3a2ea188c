//! The seam between a running core and its peripherals.
//!
//! The core is in use while an instruction runs, so a peripheral never calls back into it. The link notes that the program
//! accessed a peripheral (`touched`), and the board follows up after the step.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};

use can_wire::time::Time;

use crate::accelerator::{Accelerator, FlashTiming};
use crate::mmio::{Now, Refusal, Width};
use crate::model::Part;
use crate::peripherals::Peripherals;

/// An access that the board refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RefusedAccess {
    /// What the program asked for.
    pub address: u32,
    /// Load or store.
    pub write: bool,
    /// Why not.
    pub refusal: Refusal,
}

/// Shared by one core and its board. One thread uses it at a time.
#[derive(Debug)]
pub struct Link {
    cycle: AtomicU64,
    time: AtomicU64,
    touched: AtomicBool,
    peripherals: Mutex<Peripherals>,
    refused: Mutex<Option<RefusedAccess>>,
    accelerator: Accelerator,
    part: Part,
}

impl Link {
    /// A link to these peripherals, at time zero; `timing` is how much time their flash takes.
    pub fn new(peripherals: Peripherals, timing: FlashTiming) -> Self {
        Link {
            accelerator: Accelerator::new(timing, peripherals.part().flash_bytes()),
            cycle: AtomicU64::new(0),
            time: AtomicU64::new(0),
            touched: AtomicBool::new(false),
            part: peripherals.part(),
            peripherals: Mutex::new(peripherals),
            refused: Mutex::new(None),
        }
    }

    /// Tells the peripherals what time the next instruction runs at.
    pub fn set_now(&self, now: Now) {
        self.cycle.store(now.cycle, Ordering::Relaxed);
        self.time.store(now.time.0, Ordering::Relaxed);
    }

    pub(crate) fn now(&self) -> Now {
        Now { cycle: self.cycle.load(Ordering::Relaxed), time: Time(self.time.load(Ordering::Relaxed)) }
    }

    /// Whether the program accessed a peripheral since the last call.
    pub fn take_touched(&self) -> bool {
        // A plain load first: nearly every step leaves it false.
        self.touched.load(Ordering::Relaxed) && self.touched.swap(false, Ordering::Relaxed)
    }

    /// The first refused access since the last call.
    pub fn take_refused(&self) -> Option<RefusedAccess> {
        self.refused.lock().expect("no panic under this lock").take()
    }

    /// The peripherals.
    pub fn peripherals(&self) -> MutexGuard<'_, Peripherals> {
        self.peripherals.lock().expect("no panic under this lock")
    }

    /// What the core's reads of flash go through.
    pub(crate) fn accelerator(&self) -> &Accelerator {
        &self.accelerator
    }

    /// A load by the core.
    pub(crate) fn read(&self, address: u32, width: Width) -> Result<u32, Refusal> {
        self.touched.store(true, Ordering::Relaxed);
        let result = self.peripherals().read(self.now(), address, width);
        result.inspect_err(|&refusal| self.refuse(address, false, refusal))
    }

    /// A store by the core.
    pub(crate) fn write(&self, address: u32, width: Width, value: u32) -> Result<(), Refusal> {
        self.touched.store(true, Ordering::Relaxed);
        let mut peripherals = self.peripherals();
        let result = peripherals.write(self.now(), address, width, value);
        if let Some(acr) = peripherals.flash().take_acr() {
            self.accelerator.set(acr);
        }
        drop(peripherals);
        result.inspect_err(|&refusal| self.refuse(address, true, refusal))
    }

    fn refuse(&self, address: u32, write: bool, refusal: Refusal) {
        if self.part.is_reserved(address) {
            return;
        }
        let mut first = self.refused.lock().expect("no panic under this lock");
        first.get_or_insert(RefusedAccess { address, write, refusal });
    }
}
