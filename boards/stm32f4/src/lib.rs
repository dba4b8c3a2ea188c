//! Chip support for STM32F4 parts with two bxCAN controllers that reach 168 MHz: F405, F407, F415, F417, F427, F429, F437, F439,
//! F446, F469 and F479.
//!
//! F412, F413 and F423 reach 100 MHz at most. They cannot run APB1 at 42 MHz and its timers at 84 MHz, on which all bit
//! timings of this crate depend. F401, F410 and F411 have no CAN controller.
//!
//! A board is a crate of its own, in any repository. It lists an oscillator and pins by the macro `board!`.
//! `Board::new` takes and returns only what the protocol needs. Timers, pins and converters that it does not use remain
//! available to the application.
//!
//! ```ignore (an image)
//! // `board` is the crate of the board.
//! type MyBoard = ecss_can_stm32f4::Board<board::Spec>;
//!
//! let p = ecss_can_stm32f4::start::<board::Spec>();
//! let board = MyBoard::new(board::take!(p), BIT_TIMING, ecss_can_runtime::Irqs);
//! let i2c = I2c::new_blocking(p.I2C1, p.PB6, p.PB7, Default::default());
//! ```
//!
//! The crate defines no handler of panics or exceptions and no symbol of the linker. `ecss-can-runtime` provides them. An
//! image without `ecss-can-runtime` does this itself:
//!
//! - it binds the six interrupts of both controllers to `ReceiveHandler`, `TransmitHandler` and `StatusHandler`;
//! - it calls `exceptions::on_tick` in its handler of SysTick; otherwise the watchdog resets the chip after a few seconds;
//! - it should call `exceptions::on_fault` in its handler of HardFault and `exceptions::on_panic` in that of panics, so that the
//!   controllers fall silent and there is a record;
//! - it selects a time driver of embassy-stm32 and its feature `rt`, a critical section and a panic handler.
//!
//! No protocol code above this crate names a register or a pin. All `unsafe` of the project is in this crate and in
//! `ecss-can-runtime`. On the host only the parts that need no hardware are compiled, for tests.
//!
//! Related crates: [`ecss-can`](https://docs.rs/ecss-can), [`ecss-can-runtime`](https://docs.rs/ecss-can-runtime),
//! [`ecss-can-memory`](https://docs.rs/ecss-can-memory), [`can-twin`](https://docs.rs/can-twin).

#![cfg_attr(target_os = "none", no_std)]
#![deny(unsafe_op_in_unsafe_fn)]
#![deny(clippy::undocumented_unsafe_blocks)]
#![warn(missing_docs)]

#[cfg(target_os = "none")]
#[macro_use]
mod log;

#[cfg(any(test, target_os = "none"))]
mod bxcan;
mod clocks;
#[cfg(any(not(target_os = "none"), feature = "full"))]
mod crc;
mod declare;
#[cfg(any(test, target_os = "none"))]
mod program;
#[cfg(any(not(target_os = "none"), feature = "full"))]
pub mod store;
pub mod straps;
mod timing;

#[cfg(target_os = "none")]
mod alternate;
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
#[cfg(all(target_os = "none", feature = "full"))]
mod core_registers;
#[cfg(target_os = "none")]
mod edges;
#[cfg(target_os = "none")]
mod fault_stack;
#[cfg(target_os = "none")]
mod minimal;
#[cfg(target_os = "none")]
mod one_controller;
#[cfg(target_os = "none")]
mod post_mortem;
#[cfg(target_os = "none")]
mod protection;
#[cfg(all(target_os = "none", feature = "full"))]
mod pulse;
#[cfg(all(target_os = "none", feature = "full"))]
mod register_table;
#[cfg(target_os = "none")]
mod registers;
#[cfg(all(target_os = "none", feature = "full"))]
mod retained;
#[cfg(all(target_os = "none", feature = "full"))]
mod spare;
#[cfg(target_os = "none")]
mod spec;
#[cfg(target_os = "none")]
mod stamping;
#[cfg(target_os = "none")]
mod supervisor;
#[cfg(target_os = "none")]
mod tick;
#[cfg(all(target_os = "none", feature = "full"))]
mod time_driver;

/// Functions for the handlers of core exceptions.
#[cfg(target_os = "none")]
pub mod exceptions {
    pub use crate::fault_stack::{FAULT_STACK, FAULT_STACK_SIZE};
    pub use crate::post_mortem::{ReadLog, on_fault, on_oscillator, on_panic};
    pub use crate::tick::on_tick;
}

/// Diagnostics of the running image. A debugger or an emulator finds it by the name of this static.
#[cfg(target_os = "none")]
pub static DIAGNOSTICS: ecss_can::runner::Diagnostics = ecss_can::runner::Diagnostics::new();

/// Resets the chip.
#[cfg(target_os = "none")]
pub fn reset() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}

pub use clocks::{ClockError, Clocks, Oscillator, OscillatorKind, TIMERS};
pub use timing::{ControllerTiming, LIMITS, PCLK1, bit_timing};

#[cfg(target_os = "none")]
pub use {
    bxcan::{
        CanLines, Controller, ControllerInterrupts, Port, ReceiveHandler, StatusHandler, TransmitHandler,
    },
    clock::Uptime,
    clock_tree::{ClockFault, accelerate, brown_out_level, check_clock, start},
    common::{CanInterrupts, Leds},
    ecss_can::types::PerBus,
    edges::{CaptureChannel, CaptureStream, EdgeInput},
    minimal::MinimalBoard,
    one_controller::{OneControllerBoard, SharedPort, TransceiverPin},
    program::mend_program,
    spec::{BoardSpec, PulseOutput, Wiring, clocks_of},
    supervisor::{Supervised, supervised},
};

#[cfg(all(target_os = "none", feature = "full"))]
pub use {
    board::Board,
    bxcan::{CaptureFault, ControllerFault, LineFault},
    program::check_program,
    pulse::{Pulse, TooLate},
    supervisor::{Duty, supervise},
};
