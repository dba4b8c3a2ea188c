//! Record of a program that ended: cause, program counter, task, return addresses, the end of its log.
//!
//! ```text
//! check | cause | program counter | 8 return addresses | newest 128 bytes of the log
//! ```
//! The record is in RAM that no start initialises. It is taken once, and only if power did not fail since.

use core::hint::black_box;
use core::mem::MaybeUninit;
use core::ptr::{addr_of, addr_of_mut};
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::SCB;
use ecss_can::emcy::PostMortem;

use super::ReadLog;

const ADDRESSES: usize = 8;
const LOG_WORDS: usize = 32;
const DUMP_WORDS: usize = ADDRESSES + LOG_WORDS;
/// CFSR: the frame of an exception could not be stacked, because the MPU or the bus refused it (MSTKERR, STKERR).
const STACKING: u32 = 1 << 4 | 1 << 12;
/// Upper byte of addresses in flash.
const FLASH_PAGE: u32 = 0x08;
/// `UDF #0`, by which `panic-probe` ends a panic. Traps of the compiler have another number.
const PANIC: u16 = 0xDE00;

/// Checksum, cause, program counter, dump.
const WORDS: usize = 3 + DUMP_WORDS;
type Record = [u32; WORDS];

// SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM.
#[unsafe(link_section = ".uninit.POST_MORTEM")]
static mut POST_MORTEM: MaybeUninit<Record> = MaybeUninit::uninit();
/// First characters of the name of the task that was polled last; zero before the first one.
// SAFETY: as above. The bits of a u32 may be any.
#[unsafe(link_section = ".uninit.RUNNING")]
static RUNNING: AtomicU32 = AtomicU32::new(0);
static mut DUMP: [u32; DUMP_WORDS] = [0; DUMP_WORDS];

unsafe extern "C" {
    static __etext: u8;
    static _stack_start: u8;
    static _stack_end: u8;
}

/// Notes the task that is polled now.
#[inline(always)] // a store
pub fn runs(task: u32) {
    RUNNING.store(task, Ordering::Relaxed);
}

/// Takes the task that the program before this one polled last; zero if there was none. Call it once, before tasks run.
pub fn take_running() -> u32 {
    RUNNING.swap(0, Ordering::Relaxed)
}

/// Returns the address of the record. It is hidden from the compiler, which would otherwise assume the initial content.
fn place() -> *mut Record {
    black_box(addr_of_mut!(POST_MORTEM).cast())
}

/// Takes the record of the program before this one, if its checksum is right and `is_valid`. Call it once, before tasks
/// run.
pub fn take(is_valid: bool) -> Option<PostMortem> {
    // SAFETY: the record is RAM of its static, and any bits are words. No task and no handler runs yet, so this is the only
    // reference to it and to the copy of its dump.
    let record = unsafe { &mut *place() };
    let found = (is_valid && record[0] == check(record)).then(|| {
        // SAFETY: as above; the words may be read as bytes.
        let dump = unsafe {
            let dump = addr_of_mut!(DUMP);
            dump.copy_from_nonoverlapping(record.as_ptr().add(3).cast(), 1);
            core::slice::from_raw_parts(dump.cast::<u8>(), 4 * DUMP_WORDS)
        };
        PostMortem { cause: record[1] as u8, pc: record[2], dump, ..PostMortem::default() }
    });
    record[0] = !record[0];
    found
}

/// Returns a checksum of the rest of the record.
#[inline(never)] // of several callers
fn check(record: &Record) -> u32 {
    record[1..].iter().fold(0x5EC5_0315, |sum, word| sum.rotate_left(5) ^ word)
}

/// Writes the record. `frame`: address at which the exception stacked the registers of the interrupted code, if known.
/// `log` reads the log.
pub fn write(frame: Option<u32>, cause: u8, log: ReadLog) {
    let (top, bottom) = (addr_of!(_stack_start) as u32, addr_of!(_stack_end) as u32);
    // SAFETY: the record is RAM of its static, which only this function accesses once tasks run, and it runs once. All
    // addresses between both ends of the stack are RAM, and any bits are a u32. The program is flash, and a program
    // counter is even. The log is a static of `defmt-rtt` that holds bytes; its control block says where.
    unsafe {
        let record = &mut *place();
        let is_lost = frame.is_some_and(|frame| frame < bottom) || (*SCB::PTR).cfsr.read() & STACKING != 0;
        let pc = frame.filter(|_| !is_lost).map_or(0, |frame| word(frame + 4 * 6));
        let is_panic = cause == PostMortem::FAULT && is_program(pc) && *(pc as *const u16) == PANIC;
        record[1] = match (is_lost, is_panic) {
            (true, _) => PostMortem::STACK_OVERFLOW.into(),
            (_, true) => PostMortem::PANIC.into(),
            _ => cause.into(),
        };
        record[2] = pc;
        // Without a frame the search begins at the top and finds nothing.
        let mut at = frame.unwrap_or(top).max(bottom);
        for address in &mut record[3..3 + ADDRESSES] {
            *address = 0;
            while at < top && *address == 0 {
                let value = word(at);
                if value & 1 == 1 && is_program(value) {
                    *address = value;
                }
                at += 4;
            }
        }
        let newest = &mut record[WORDS - LOG_WORDS..];
        newest.fill(0);
        log(core::slice::from_raw_parts_mut(newest.as_mut_ptr().cast(), 4 * LOG_WORDS));
        record[0] = check(record);
    }
}

/// Returns whether an address is in the program.
fn is_program(address: u32) -> bool {
    address >> 24 == FLASH_PAGE && address < addr_of!(__etext) as u32
}

/// # Safety
/// There is RAM at this address.
unsafe fn word(at: u32) -> u32 {
    // SAFETY: as the caller says.
    unsafe { (at as *const u32).read_volatile() }
}
