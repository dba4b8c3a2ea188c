//! Stack of the handlers of faults, as the stack of the program may be what is lost.

#[cfg(feature = "full")]
mod own {
    use core::cell::UnsafeCell;
    use core::mem::MaybeUninit;

    /// Bytes of the stack.
    pub const FAULT_STACK_SIZE: usize = 256;

    /// For a handler that never returns.
    #[repr(C, align(8))]
    pub struct FaultStack(UnsafeCell<MaybeUninit<[u8; FAULT_STACK_SIZE]>>);

    // SAFETY: only a handler that never returns works on it.
    unsafe impl Sync for FaultStack {}

    /// The stack of a handler of faults begins at the end of this: the record is written on it.
    // SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM.
    #[unsafe(link_section = ".uninit.FAULT_STACK")]
    pub static FAULT_STACK: FaultStack = FaultStack(UnsafeCell::new(MaybeUninit::uninit()));
}

/// Without a record nothing needs the stack of the program any more: a handler begins at its top.
#[cfg(not(feature = "full"))]
mod of_the_program {
    /// Bytes from the symbol to the top.
    pub const FAULT_STACK_SIZE: usize = 0;

    unsafe extern "C" {
        #[link_name = "_stack_start"]
        /// Top of the stack.
        pub static FAULT_STACK: u8;
    }
}

#[cfg(not(feature = "full"))]
pub use of_the_program::{FAULT_STACK, FAULT_STACK_SIZE};
#[cfg(feature = "full")]
pub use own::{FAULT_STACK, FAULT_STACK_SIZE};
