//! Memory map of a board's chip, for the linker.
//!
//! A *memory map* is the file `memory.x`, which the linker script of cortex-m-rt includes. It says where the program, its data
//! and its stack lie, and where the parameter store lies in flash. A board needs a build script of one line:
//!
//! ```no_run
//! # #[allow(clippy::needless_doctest_main, reason = "a whole build.rs")]
//! fn main() {
//!     ecss_can_memory::place()
//! }
//! ```
//!
//! and its chip in the manifest, as a feature of embassy-stm32:
//!
//! ```
//! let manifest = r#"
//!     [target.'cfg(target_os = "none")'.dependencies]
//!     embassy-stm32 = { version = "=0.6.0", features = ["stm32f407vg"] }
//!
//!     [build-dependencies]
//!     ecss-can-memory = { path = "../memory" }
//! "#;
//! let chip = ecss_can_memory::chip_of_manifest(manifest).unwrap();
//! assert_eq!((chip.flash_kib(), chip.ram_kib(), chip.ccm_kib()), (1024, 128, 64));
//! ```
//!
//! Supported are the STM32F4 with two bxCAN controllers that reach 168 MHz, with 512 KiB of flash or more: STM32F405, 407,
//! 415, 417, 427, 429, 437, 439, 446, 469 and 479. Another chip stops the build with the reason.
//!
//! # Layout
//!
//! | memory | use |
//! | --- | --- |
//! | last two sectors of flash, 128 KiB each | parameter store, from `__store_start` on |
//! | flash below them | program |
//! | CCM | stack |
//! | SRAM | data |
//!
//! The STM32F446 has no CCM: its stack has the first 72 KiB of SRAM, and its data the other 56. In both cases a stack that grows
//! too far causes a fault, because there is no memory below it.
//!
//! Flash of 1 MiB is one bank (DB1M = 0, as delivered).
//!
//! # Symbols
//!
//! | symbol | value |
//! | --- | --- |
//! | `__store_start` | address of the first sector of the parameter store |
//! | `__device_id` | DEV_ID of DBGMCU_IDCODE of the chip that the image was linked for, as 0x413 |
//! | `_stack_start`, `_stack_end` | highest and lowest address of the stack |
//!
//! Related crates: [`ecss-can-stm32f4`](https://docs.rs/ecss-can-stm32f4),
//! [`ecss-can-runtime`](https://docs.rs/ecss-can-runtime),
//! [`ecss-can-pyboard-v11`](https://docs.rs/ecss-can-pyboard-v11).

#![forbid(unsafe_code)]

mod chip;
mod error;
mod map;
mod place;
mod sources;

pub use chip::Chip;
pub use error::Error;
pub use place::{place, place_for};
pub use sources::{chip_of_board, chip_of_manifest};

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
