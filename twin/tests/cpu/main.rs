//! The emulated core against the architecture manual, Unicorn and QEMU.

mod board;
mod cycles;
mod debug;
mod events;
mod exceptions;
mod faults;
mod flash_patch;
mod fpu;
mod integer;
mod lock_up;
mod priorities;
mod qemu;
mod special;
mod system;
mod totality;
mod vectors;
