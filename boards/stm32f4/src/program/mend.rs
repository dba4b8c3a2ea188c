//! The word with the flipped bit, and the right one in its place.
//!
//! Flash is not written: that erases a whole sector, of which a board has no copy. The *flash patch unit* of the core (FPB)
//! compares the address of each read from flash with two registers, one for instructions and one for data, and replaces the
//! word by one in RAM. It keeps this over resets, until the power fails, and the program is mended again at the next start. The
//! unit is not touched as long as the program is whole: a debugger uses it for breakpoints.

use core::cell::UnsafeCell;
use core::ptr::addr_of;

use cortex_m::asm;
use cortex_m::peripheral::FPB;
use cortex_m::peripheral::fpb::RegisterBlock;
use ecss_can::node::ProgramState;
use embassy_stm32::pac::crc::regs::Cr;
use embassy_stm32::pac::{CRC, RCC};

use super::remainder::flipped;

/// Four words of the program. Read one after the other in one step of a loop, they take half the time.
pub(super) type Line = [u32; 4];

/// A word of erased flash.
const ERASED: u32 = u32::MAX;
/// Comparators for instructions and for data.
const INSTRUCTIONS: usize = 0;
const DATA: usize = 6;
/// FP_CTRL: with the first bit a write counts, the second one enables the unit.
const ENABLED: u32 = 1 << 1 | 1 << 0;

/// Seal of the program.
#[repr(C)]
struct Seal {
    /// Length of the program in bytes, whole lines.
    bytes: u32,
    /// The remainder of the program is zero with this word.
    balance: u32,
}

/// `ecss-can` finds it by this name and writes it.
// SAFETY: no other symbol has this name.
#[unsafe(export_name = "__program_seal")]
static SEAL: Seal = Seal { bytes: ERASED, balance: ERASED };

/// Words that the unit puts in place of others, by comparator.
#[repr(C, align(32))]
struct Replacements(UnsafeCell<[u32; 8]>);

// SAFETY: only `replace` writes the words, and only the unit reads them.
unsafe impl Sync for Replacements {}

// SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM. The bits of a u32 may be any.
#[unsafe(link_section = ".uninit.REPLACEMENTS")]
static REPLACEMENTS: Replacements = Replacements(UnsafeCell::new([0; 8]));

unsafe extern "C" {
    static __vector_table: Line;
    static __store_start: u8;
}

/// Returns the lines of the program, none if it has no seal.
pub(super) fn sealed() -> &'static [Line] {
    let start = addr_of!(__vector_table);
    let room = addr_of!(__store_start) as usize - start as usize;
    // SAFETY: the seal is a static. The read is volatile: the compiler knows the initial value only.
    let bytes = unsafe { addr_of!(SEAL.bytes).read_volatile() } as usize;
    let lines = if bytes > room { 0 } else { bytes / size_of::<Line>() };
    // SAFETY: flash from the vector table to the parameter store is readable, and no code of a node writes it.
    unsafe { core::slice::from_raw_parts(start, lines) }
}

/// Starts a remainder.
pub(super) fn begin() {
    CRC.cr().write_value(Cr(1));
}

/// Adds lines to the remainder, and returns it.
pub(super) fn add(lines: &[Line]) -> u32 {
    for [a, b, c, d] in lines {
        CRC.dr().write_value(read(a));
        CRC.dr().write_value(read(b));
        CRC.dr().write_value(read(c));
        CRC.dr().write_value(read(d));
    }
    CRC.dr().read()
}

/// Returns the state of a program whose remainder is zero.
pub(super) fn whole() -> ProgramState {
    // A debugger uses no comparator for data.
    if fpb().comp[DATA].read() & 1 != 0 { ProgramState::Mended } else { ProgramState::Whole }
}

/// Compares the program with its seal, and mends a flipped bit. It takes 10 to 20 ms with a whole
/// program, and up to 0.7 s otherwise.
///
/// The function for the start of a program, before RAM has its initial values: it uses no variable.
pub fn mend_program() -> ProgramState {
    let program = sealed();
    if program.is_empty() {
        return ProgramState::Unchecked;
    }
    RCC.ahb1enr().modify(|w| w.set_crcen(true));
    if remainder(program) == 0 {
        return whole();
    }
    // If a word is replaced already, either bit may be wrong, that in flash or that in RAM.
    set_comparators(0);
    let words = program.as_flattened();
    let Some((at, bit)) = flipped(remainder(program), words.len()) else { return ProgramState::Damaged };
    if let Some(word) = words.get(at) {
        replace(word, read(word) ^ bit);
    }
    ProgramState::Mended
}

fn remainder(program: &[Line]) -> u32 {
    begin();
    add(program)
}

fn read(word: &u32) -> u32 {
    // SAFETY: the reference is valid. The read is volatile: a bit may flip, and the flash patch unit may replace the word.
    unsafe { addr_of!(*word).read_volatile() }
}

/// Replaces a word of flash.
fn replace(word: &u32, right: u32) {
    let words = REPLACEMENTS.0.get();
    // SAFETY: the words are RAM of this static, and the registers those of the unit. With them the core reads what the linker
    // wrote.
    unsafe {
        (*words)[INSTRUCTIONS] = right;
        (*words)[DATA] = right;
        fpb().remap.write(words as u32);
        fpb().ctrl.write(ENABLED);
    }
    set_comparators(addr_of!(*word) as u32 | 1);
    asm::dsb();
    asm::isb();
}

/// Sets address and enable bit of both comparators.
fn set_comparators(value: u32) {
    // SAFETY: the word at the address has a replacement, or the comparators are off.
    unsafe {
        fpb().comp[INSTRUCTIONS].write(value);
        fpb().comp[DATA].write(value);
    }
}

fn fpb() -> &'static RegisterBlock {
    // SAFETY: the registers exist as long as the chip does. No other part of the program uses them.
    unsafe { &*FPB::PTR }
}
