//! Board support: two CAN ports, a clock, LEDs and straps.
//!
//! A board is one module and one feature. `Board::new` hands out everything that the protocol needs of it, and takes only
//! that: timers, pins and converters that it does not use stay with the application.
//!
//! ```ignore (a board's code)
//! let p = boards::start();
//! let board = Board::new(boards::take!(p), BIT_TIMING, boards_runtime::Irqs);
//! let i2c = I2c::new_blocking(p.I2C1, p.PB6, p.PB7, Default::default());
//! ```
//!
//! Nothing of the protocol above this crate names a register or a pin. All `unsafe` of the project is here and in
//! `boards-runtime`. On the host only the parts that need no hardware are compiled, so that they can be tested there.

#![cfg_attr(target_os = "none", no_std)]
#![deny(unsafe_op_in_unsafe_fn)]
#![deny(clippy::undocumented_unsafe_blocks)]
#![warn(missing_docs)]

#[cfg(any(test, target_os = "none"))]
mod bxcan;
#[cfg(any(not(target_os = "none"), feature = "full"))]
pub mod store;
pub mod straps;
mod timing;

pub use timing::{LIMITS, PCLK1, bit_timing};

#[cfg(all(target_os = "none", feature = "full"))]
mod board;
#[cfg(all(target_os = "none", feature = "full"))]
mod capture;
#[cfg(target_os = "none")]
mod clock;
#[cfg(target_os = "none")]
mod clock_tree;
#[cfg(target_os = "none")]
mod common;
#[cfg(target_os = "none")]
mod minimal;
#[cfg(all(target_os = "none", feature = "nucleo-f446re"))]
mod nucleo_f446re;
#[cfg(target_os = "none")]
mod one_controller;
#[cfg(target_os = "none")]
mod post_mortem;
#[cfg(all(target_os = "none", feature = "full"))]
mod pulse;
#[cfg(all(target_os = "none", feature = "pyboard-v11"))]
mod pyboard_v11;
#[cfg(all(target_os = "none", feature = "full"))]
mod retained;
#[cfg(all(target_os = "none", feature = "full"))]
mod spare;
#[cfg(target_os = "none")]
mod stamping;
#[cfg(target_os = "none")]
mod supervisor;
#[cfg(target_os = "none")]
mod wiring;

#[cfg(all(target_os = "none", feature = "nucleo-f446re"))]
pub use nucleo_f446re::Resources;
#[cfg(all(target_os = "none", feature = "nucleo-f446re"))]
use nucleo_f446re::{OSCILLATOR, PREDIV};
#[cfg(all(target_os = "none", feature = "pyboard-v11"))]
pub use pyboard_v11::Resources;
#[cfg(all(target_os = "none", feature = "pyboard-v11"))]
use pyboard_v11::{OSCILLATOR, PREDIV};

/// Handlers of exceptions of the core. `boards-runtime` puts them into the vector table.
#[cfg(target_os = "none")]
pub mod exceptions {
    pub use crate::post_mortem::{FAULT_STACK, FAULT_STACK_SIZE, on_fault, on_oscillator};
    pub use crate::supervisor::on_tick;
}

#[cfg(target_os = "none")]
mod image {
    use ecss_can::runner::Telltale;

    /// What a debugger or an emulator reads of the running image, by this symbol.
    // SAFETY: no other symbol of an image has this name.
    #[unsafe(no_mangle)]
    pub static TELLTALE: Telltale = Telltale::new();

    /// Reset the chip.
    pub fn reset() -> ! {
        cortex_m::peripheral::SCB::sys_reset()
    }
}

#[cfg(target_os = "none")]
pub use {
    bxcan::{ControllerInterrupts, Port, ReceiveHandler, StatusHandler, TransmitHandler},
    clock::Uptime,
    clock_tree::{ClockFault, accelerate, brown_out_level, check_clock, start},
    common::{CanInterrupts, Leds},
    image::TELLTALE,
    image::reset,
    minimal::MinimalBoard,
    one_controller::{OneControllerBoard, SharedPort, TransceiverPin},
    supervisor::{Supervised, supervised},
};

#[cfg(all(target_os = "none", feature = "full"))]
pub use {
    board::Board,
    bxcan::{CaptureFault, ControllerFault, LineFault},
    pulse::{Pulse, TooLate},
};
