//! The twin: emulated STM32F4 boards on CAN buses, in virtual time.
//!
//! It runs the same ELF files that are flashed on boards: [`image::Image`] is the program, [`spacecraft::Spacecraft`]
//! joins any number of [`board::EmulatedBoard`]s by two wires, or as [`spacecraft::Wiring`] says. The simulation is
//! deterministic: the same configuration gives the same records, to the tick.
//!
//! # What is modelled
//!
//! * Boards with any STM32F4 that has two bxCAN and reaches 168 MHz ([`model::Part`]), by a description of part,
//!   oscillator and pins ([`description`]), in any combination. Measured against drivers are pyboard v1.1 (STM32F405)
//!   and NUCLEO-F446RE (STM32F446).
//! * The core: Cortex-M4F with FPU, NVIC, SysTick, MPU, faults and lock-up ([`cpu`]).
//! * The pins of CAN at the board's transceivers: a controller is on its bus when the program assigns these pins to it.
//!   The log reports a controller that takes part but is not connected to a transceiver.
//! * RCC with the clock tree and its gates, GPIO with alternate functions and pulls, EXTI, SYSCFG, both bxCANs with
//!   their filters ([`bxcan`]), and the registers of PWR, DBGMCU and the device signature that set-up code uses.
//! * The flash accelerator as FLASH_ACR sets it: wait states, prefetch, 64 instruction and 8 data lines, stale lines
//!   after an erase. [`board::Fittings::flash_timing`] gives ideal memory instead, or wait states without the
//!   accelerator; the module `accelerator` documents the accuracy.
//! * Flash of one bank, or of two in parts with 2 MiB, that programs and erases in the typical or the longest time of
//!   the data sheet, stalls the core, and keeps its content without power; power may fail in any of its operations
//!   ([`board::EmulatedBoard::cut_power_at`]).
//! * TIM2, TIM3 and TIM5, upwards: compare, input capture, their DMA requests; TIM5 starts TIM3, and both drive pins,
//!   at instants that [`board::EmulatedBoard::take_edges`] gives to fractions of a tick. Two of PA0 to PA3, as the
//!   board has them, follow CAN_RX of CAN1 and CAN2 over two wires ([`board::Fittings`]); a capture is the count at the
//!   instant of the edge by the board's own clock.
//! * DMA1 and DMA2 between peripheral and memory in direct mode, single or circular buffers, which takes no time.
//! * TIM1, TIM4, TIM6 to TIM14 as counters with compare and interrupts; they reach no pin.
//! * I2C1 to I2C3 as masters, with devices ([`devices::I2cDevice`]); an LM75 on I2C1 ([`board::Fittings::thermometer`]).
//! * Option bytes, programmed by FLASH_OPTCR or by a probe ([`board::EmulatedBoard::set_option_bytes`]): BOR level, write
//!   protection, watchdog of hardware, level 1 of the read-out protection.
//! * The independent watchdog on an LSI of any frequency in the data sheet.
//! * One crystal per board with an offset, drift, a change of temperature and noise of its own ([`crystal`]), which
//!   drives the core and the timers. The bit timing of CAN keeps the frequency at the instant when the clock tree was
//!   set. The crystal may be broken.
//! * Defects: bits of the CAN controllers that are stuck, exchanged capture wires, a prescaler ([`board::Defect`]).
//! * Upsets: one inverted bit of a memory, a core register or a register of a peripheral
//!   ([`board::EmulatedBoard::flip_register`]), and the first uses of RAM ([`board::Uses`]).
//! * A debugger that sets C_DEBUGEN and stops at BKPT ([`board::EmulatedBoard::attach_debugger`]).
//! * A debug probe per board that reads the log, defmt or text by RTT, and neither halts the core nor slows it, until it is pulled
//!   ([`board::EmulatedBoard::pull_probe`]).
//!
//! # What is not modelled
//!
//! * All other peripherals. A program that accesses them stops its board with an [`AccessError`](board::AccessError)
//!   that names board, function, peripheral and register; so does one that uses a peripheral whose clock is off, which
//!   the real part would ignore.
//! * Contention on the buses, and the halfwords that the core fetches ahead. Mass erase, programming by double words;
//!   wear; the effect of read-out protection on a probe; write protection of the second bank, exchanged banks (BFB2), 1
//!   MiB in two banks (DB1M).
//! * The HSI oscillator's error (it runs at 16 MHz exactly), ageing of crystals.
//! * Stop and Standby: a WFI or WFE with SLEEPDEEP stops the board with an error. The window watchdog.
//! * A debugger that freezes timers with the core: [`board::EmulatedBoard::halt`] refuses. It freezes the independent watchdog and the
//!   CAN controllers.
//! * Inside a quantum a program does not see the edges of that quantum: captures, their interrupts and their DMA reach it
//!   at the end, with the counts they had. Without DMA, two edges in one quantum are an overcapture.
//! * The synchroniser of capture inputs (a delay that is equal for every edge), compare preload.
//!
//! Related crates: [`ecss-can-cli`](https://docs.rs/ecss-can-cli), [`ecss-can-worlds`](https://docs.rs/ecss-can-worlds),
//! [`ecss-can`](https://docs.rs/ecss-can).

#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(feature = "boards")]
mod accelerator;
#[cfg(feature = "boards")]
pub mod board;
#[cfg(feature = "boards")]
pub mod bxcan;
#[cfg(feature = "boards")]
mod chip;
#[cfg(feature = "boards")]
pub mod clock;
#[cfg(feature = "boards")]
pub mod cpu;
#[cfg(feature = "boards")]
pub mod crystal;
#[cfg(feature = "boards")]
pub mod description;
#[cfg(feature = "boards")]
pub mod devices;
#[cfg(feature = "boards")]
pub mod guest;
#[cfg(feature = "boards")]
pub mod image;
#[cfg(feature = "boards")]
mod memory;
#[cfg(feature = "boards")]
pub mod mmio;
#[cfg(feature = "boards")]
pub mod model;
#[cfg(feature = "boards")]
mod part;
#[cfg(feature = "boards")]
pub mod peripherals;
#[cfg(feature = "boards")]
pub mod pin;
#[cfg(feature = "boards")]
mod port;
#[cfg(feature = "boards")]
pub mod pulses;
#[cfg(feature = "boards")]
pub mod rtt;
#[cfg(feature = "boards")]
pub mod spacecraft;
#[cfg(feature = "boards")]
pub mod stamps;
#[cfg(feature = "boards")]
pub mod traffic;
pub mod wire;
#[cfg(feature = "boards")]
mod wiring;
