//! Words of RAM that no start initialises: they keep their values over a reset and are undefined after power-on.

use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;

use ecss_can::store::RetainedMemory;

/// The words, in a section that `cortex-m-rt` neither loads nor zeroes.
// SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM.
#[unsafe(link_section = ".uninit.RETAINED")]
static mut RETAINED: UninitRam = UninitRam(MaybeUninit::uninit());

struct UninitRam(MaybeUninit<[u32; 2]>);

impl RetainedMemory for UninitRam {
    fn read(&self) -> [u32; 2] {
        // SAFETY: the words are RAM of this static, and any bits are a u32. The access is volatile: the compiler
        // assumes nothing about the content.
        unsafe { self.0.as_ptr().read_volatile() }
    }

    fn write(&mut self, words: [u32; 2]) {
        // SAFETY: the words are RAM of this static. The access is volatile: it is not optimised away although this
        // program may never read it.
        unsafe { self.0.as_mut_ptr().write_volatile(words) }
    }
}

/// Returns the words. Call it once, from `Board::new`.
pub(crate) fn take() -> &'static mut (dyn RetainedMemory + Send) {
    // SAFETY: this is the only reference, because `Board::new` takes peripherals that exist once.
    unsafe { &mut *addr_of_mut!(RETAINED) }
}
