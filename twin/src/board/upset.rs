//! Upsets of a board: one bit of its core, memories or peripherals is inverted, as by a particle.
//!
//! [`EmulatedBoard::flip_core`], [`flip_memory`](EmulatedBoard::flip_memory) and [`flip_register`](EmulatedBoard::flip_register) change
//! the state now; the program sees it from its next instruction on:
//!
//! ```text
//! let mut copy = spacecraft.clone();
//! let board = copy.board_mut(BoardId(1));
//! board.tolerate_upsets();
//! board.flip_register(0x4000_0028, 3)?; // TIM2.PSC
//! copy.run_until(end)?;
//! ```
//!
//! [`state_registers`](EmulatedBoard::state_registers) lists what `flip_register` accepts. [`watch_memory`](EmulatedBoard::watch_memory)
//! shows which bytes of RAM matter: an upset in a byte that is not read, or written first, has no effect.

use super::{EmulatedBoard, NotMemory};
use crate::chip::Uses;
use crate::cpu::{CoreRegister, StateRegister, Unpredictable, system_registers};
use crate::mmio::Refusal;
use crate::model::FLASH_BASE;

/// Registers of the core itself.
const SYSTEM: std::ops::Range<u32> = 0xE000_0000..0xE004_0000;

impl EmulatedBoard {
    /// Lets the chip answer as the part does where the model refuses a correct program: for flights with upsets. Peripherals without
    /// clock read zero, stray stores to flash are ignored, and an UNPREDICTABLE instruction raises a UsageFault.
    pub fn tolerate_upsets(&mut self) {
        self.chip.is_tolerant = true;
        self.core.set_unpredictable(Unpredictable::UsageFault);
    }

    /// Returns the registers of the core's peripherals and of those of the chip that have a clock, with the bits that hold state.
    pub fn state_registers(&self) -> Vec<StateRegister> {
        let mut all = self.chip.peripherals.state_registers();
        all.extend(system_registers());
        all
    }

    /// Inverts a bit of a core register. Has no effect on a bit that holds no state.
    pub fn flip_core(&mut self, register: CoreRegister, bit: u32) {
        self.core.flip(register, bit);
        self.follow_upset();
    }

    /// Inverts a bit of a register of [`EmulatedBoard::state_registers`].
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for another bit, or a mode that the model lacks; [`Refusal::ClockLimit`] and [`Refusal::Misuse`] for
    /// clocks at which the part or its flash does not work. The state is undefined then.
    pub fn flip_register(&mut self, address: u32, bit: u32) -> Result<(), Refusal> {
        if SYSTEM.contains(&address) {
            if !self.core.flip_system(address, bit) {
                return Err(Refusal::Unmodelled);
            }
        } else {
            let now = self.chip.clock.now();
            self.chip.peripherals.flip(now, address, bit)?;
            if let Some(acr) = self.chip.peripherals.flash.take_acr() {
                self.chip.accelerator.set(acr);
            }
        }
        self.follow_upset();
        Ok(())
    }

    /// Inverts bit 0 to 7 of a byte of RAM, CCM or flash.
    ///
    /// # Errors
    /// [`NotMemory`] when there is no memory.
    pub fn flip_memory(&mut self, address: u32, bit: u32) -> Result<(), NotMemory> {
        let mut bytes = self.read_memory(address, 1)?;
        bytes.iter_mut().for_each(|byte| *byte ^= 1 << (bit & 7));
        let is_flash = address.wrapping_sub(FLASH_BASE) < self.config.model.part.flash_bytes();
        if is_flash { self.write_flash(address, &bytes) } else { self.write_memory(address, &bytes) }
    }

    /// A core that sleeps looks at its state again.
    fn follow_upset(&mut self) {
        self.refresh();
        self.asleep = false;
    }

    /// Records the first use of each byte of RAM from now on, and which registers are used.
    pub fn watch_memory(&mut self) {
        self.core.take_fpu_use();
        self.chip.peripherals.can.take_active_filters();
        self.uses = Some(Box::new(Uses::new(&self.chip)));
    }

    /// Notes the use of the FPU in a recording of uses.
    pub(super) fn note_fpu(&mut self) {
        let uses_fpu = self.core.take_fpu_use();
        if let Some(uses) = &mut self.uses {
            uses.note_fpu(uses_fpu);
        }
    }

    /// Ends the recording that [`EmulatedBoard::watch_memory`] began, and returns its uses. Returns `None` if there is no recording.
    pub fn take_uses(&mut self) -> Option<Uses> {
        self.note_fpu();
        let filters = self.chip.peripherals.can.take_active_filters();
        if let Some(uses) = &mut self.uses {
            uses.note_filters(filters);
        }
        self.uses.take().map(|uses| *uses)
    }
}
