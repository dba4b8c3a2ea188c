//! An emulated Cortex-M4F: ARMv7E-M with FPv4-SP as DDI 0403E and the Cortex-M4 technical reference manual (ARM 100166) describe it.
//!
//! A *core* executes the instructions of a program and takes its exceptions. It contains what the architecture puts inside: NVIC with 97
//! lines and 4 bits of priority, SysTick, system control block, MPU with 8 regions, FPU, cycle counter, flash patch and breakpoint unit
//! (FPB). Memories and peripherals belong to a *bus*, which the owner of the core implements and lends to each step:
//!
//! ```
//! use can_twin::cpu::{Bus, BusError, Config, Core, Width};
//!
//! /// 1 KiB of memory at 0800_0000h.
//! struct Memory(Vec<u8>);
//!
//! impl Memory {
//!     fn at(&mut self, address: u32, width: Width) -> Result<&mut [u8], BusError> {
//!         let start = address.wrapping_sub(0x0800_0000) as usize;
//!         self.0.get_mut(start..start + width.bytes() as usize).ok_or(BusError)
//!     }
//! }
//!
//! impl Bus for Memory {
//!     fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
//!         Ok(self.load(address, Width::Half)? as u16)
//!     }
//!     fn load(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
//!         Ok(self.at(address, width)?.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte)))
//!     }
//!     fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
//!         let bytes = value.to_le_bytes();
//!         self.at(address, width)?.copy_from_slice(&bytes[..width.bytes() as usize]);
//!         Ok(())
//!     }
//! }
//!
//! let mut memory = Memory(vec![0; 1024]);
//! memory.store(0x0800_0000, Width::Word, 0x0800_0400)?; // initial stack pointer
//! memory.store(0x0800_0004, Width::Word, 0x0800_0101)?; // first instruction, Thumb
//! memory.store(0x0800_0100, Width::Half, 0x202A)?; // MOVS r0, #42
//!
//! let mut core = Core::new(Config::stm32f4(1024));
//! core.step(&mut memory).unwrap(); // the reset sequence
//! core.step(&mut memory).unwrap();
//! assert_eq!(core.registers().r[0], 42);
//! # Ok::<(), BusError>(())
//! ```
//!
//! # Time
//!
//! Time is counted in core cycles, by the table in `cycles.rs` and the waits of the bus. [`Bus::begin`] announces the cycle at which an
//! instruction begins. All accesses of one instruction have that cycle; their order is kept, their distance is not.
//!
//! # Limits
//!
//! - Interrupts are taken between instructions. A load or store multiple is never left in the middle.
//! - Exception entry is one step. An exception of higher priority that arrives during it preempts before the first instruction of
//!   the handler; the real core would fetch its vector instead (late arrival).
//! - Bus faults are precise; there is no write buffer.
//! - Memory attributes (TEX, S, C, B of the MPU) have no effect.
//! - The FPB replaces neither vectors nor the words of a stack frame at the return from an exception. A replaced word costs one access to
//!   RAM; the real core also reads the word that it replaces, and ignores it.
//! - Not there: ITM, TPIU, comparators and profiling counters of the DWT, DCRSR and DCRDR, vector catch and stepping in DEMCR,
//!   DISFPCA and DISOOFP in ACTLR, CCR.BFHFNMIGN. A program that accesses them stops with [`Stop::Unmodelled`].
//! - UNPREDICTABLE encodings stop the core with [`Stop::Unpredictable`], or raise a UsageFault where [`Config::unpredictable`] says so.
//!
//! # Inlining
//!
//! The inlining attributes of this crate serve the row `twin.host_instructions` of `cargo xtask bench`.
//! Those of small functions that other crates reach were measured together, the others one by one.

mod bus;
mod cache;
mod core;
mod cycles;
mod decode;
mod exception;
mod execute;
mod float;
mod fpu;
mod instruction;
mod memory;
mod ppb;
mod registers;
mod system;
mod trap;
mod upset;

pub use core::{Config, Core, Run, Step, Stop, Unpredictable};

pub use bus::{Bus, BusError, Width};
pub use cache::Code;
pub use registers::Registers;
pub use upset::{CoreRegister, StateRegister, system_registers};
