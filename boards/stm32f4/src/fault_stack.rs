//! Stack of the fault handlers, because the stack of the program may be unusable.

#[cfg(feature = "full")]
mod own {
    use core::cell::UnsafeCell;
    use core::mem::MaybeUninit;

    /// Bytes of the stack.
    pub const FAULT_STACK_SIZE: usize = 256;

    /// A stack for a handler that never returns.
    #[repr(C, align(8))]
    pub struct FaultStack(UnsafeCell<MaybeUninit<[u8; FAULT_STACK_SIZE]>>);

    // SAFETY: only a handler that never returns works on it.
    unsafe impl Sync for FaultStack {}

    /// Stack on which a fault handler writes the record. It grows down from the end.
    // SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM.
    #[unsafe(link_section = ".uninit.FAULT_STACK")]
    pub static FAULT_STACK: FaultStack = FaultStack(UnsafeCell::new(MaybeUninit::uninit()));
}

/// Without a record nothing reads the stack of the program, so a handler reuses it from the top.
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
