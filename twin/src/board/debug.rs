//! A debugger that halts the core, and peripherals that are frozen meanwhile (RM0090 38.16.2).

use super::{EmulatedBoard, State};

/// Reason why a debugger cannot halt the core.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HaltError {
    /// The core does not run.
    #[error("{0}: only a running core can be halted")]
    NotRunning(String),
    /// The program configured timers to stop with the core, which is not modelled.
    #[error(
        "{board}: DBGMCU freezes with {frozen:08X}h (APB1_FZ) and {frozen2:08X}h (APB2_FZ) what the model lets run: only CAN1, \
         CAN2 and IWDG can stop with the core"
    )]
    Unmodelled {
        /// Name of the board.
        board: String,
        /// Bits of DBGMCU_APB1_FZ that are not modelled.
        frozen: u32,
        /// Bits of DBGMCU_APB2_FZ that are not modelled.
        frozen2: u32,
    },
}

impl EmulatedBoard {
    /// Attaches a debugger, which sets C_DEBUGEN until power is removed. The program can read that bit, and its BKPT
    /// halts the core.
    pub fn attach_debugger(&mut self) {
        self.core.attach_debugger();
    }

    /// Halts the core as a debugger does. Peripherals continue except those that the program freezes: IWDG by
    /// DBG_IWDG_STOP, a CAN controller by its DBG_CANx_STOP together with DBF in its MCR. A frozen controller takes no
    /// part in its bus.
    ///
    /// # Errors
    /// [`HaltError`]: the core continues.
    pub fn halt(&mut self) -> Result<(), HaltError> {
        let board = self.config.name.clone();
        if self.state != State::Running {
            return Err(HaltError::NotRunning(board));
        }
        let (frozen, frozen2) = self.chip.peripherals.dbgmcu.unmodelled_freezes();
        if (frozen, frozen2) != (0, 0) {
            return Err(HaltError::Unmodelled { board, frozen, frozen2 });
        }
        self.stand_still();
        Ok(())
    }

    /// Stops the core. Frozen peripherals that the model does not stop continue.
    pub(super) fn stand_still(&mut self) {
        self.state = State::Halted;
        let now = self.now();
        self.chip.peripherals.halt(now);
        self.refresh();
    }

    /// Resumes a halted core. Has no effect on any other.
    pub fn go_on(&mut self) {
        if self.state == State::Halted {
            self.state = State::Running;
            self.core.skip_to(self.chip.clock.now().cycle);
            let now = self.now();
            self.chip.peripherals.go_on(now);
            self.refresh();
        }
    }
}
