//! What a program that ends leaves to the next one: cause, program counter, task, return addresses, the end of its log.
//!
//! ```text
//! check | cause | program counter | 8 return addresses | newest 128 bytes of the log
//! ```
//! The record lies in RAM that no start initialises. It is taken once, and only where power did not fail since. A program that
//! ends first puts both controllers into reset, so that it acknowledges no more frames. A controller enters Init mode only at
//! the end of a frame, and its clock may be wrong by then.

use core::cell::UnsafeCell;
use core::hint::black_box;
use core::mem::MaybeUninit;
use core::ptr::{addr_of, addr_of_mut};
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::{DCB, SCB};
use ecss_can::emcy::PostMortem;
use embassy_stm32::pac::{FLASH, RCC};

const ADDRESSES: usize = 8;
const LOG_WORDS: usize = 32;
const DUMP_WORDS: usize = ADDRESSES + LOG_WORDS;
/// Flags of RCC_CSR (RM0090 7.3.21).
const BORRSTF: u32 = 1 << 25;
const PORRSTF: u32 = 1 << 27;
const SFTRSTF: u32 = 1 << 28;
const IWDGRSTF: u32 = 1 << 29;
const WWDGRSTF: u32 = 1 << 30;
/// CFSR: the frame of an exception could not be stacked.
const STKERR: u32 = 1 << 12;
/// Upper byte of addresses in flash.
const FLASH_PAGE: u32 = 0x08;
/// `UDF #0`, by which `panic-probe` ends a panic. Traps of the compiler have another number.
const PANIC: u16 = 0xDE00;
/// More than can be in a row: what RAM holds after another program.
const MOST_IN_A_ROW: u32 = 20;

/// Checksum, cause, program counter, dump.
const WORDS: usize = 3 + DUMP_WORDS;
type Record = [u32; WORDS];

/// For the handler of faults alone, since the stack may be what is lost.
#[repr(C, align(8))]
struct FaultStack(UnsafeCell<MaybeUninit<[u32; 64]>>);

// SAFETY: only a handler that never returns works on it.
unsafe impl Sync for FaultStack {}

// SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM.
#[unsafe(link_section = ".uninit.FAULT_STACK")]
static FAULT_STACK: FaultStack = FaultStack(UnsafeCell::new(MaybeUninit::uninit()));
// SAFETY: as above.
#[unsafe(link_section = ".uninit.POST_MORTEM")]
static mut POST_MORTEM: MaybeUninit<Record> = MaybeUninit::uninit();
/// Resets in a row for a cause.
// SAFETY: as above. The bits of a u32 may be any.
#[unsafe(link_section = ".uninit.ROW")]
static ROW: AtomicU32 = AtomicU32::new(0);
/// The task that is being polled; zero for none.
// SAFETY: as above.
#[unsafe(link_section = ".uninit.RUNNING")]
static RUNNING: AtomicU32 = AtomicU32::new(0);
/// The task that the program before this one polled last.
static RAN: AtomicU32 = AtomicU32::new(0);
static mut DUMP: [u32; DUMP_WORDS] = [0; DUMP_WORDS];

unsafe extern "C" {
    static __etext: u8;
    static _stack_start: u8;
    static _stack_end: u8;
    /// Control block of the log. Words 7 to 9: buffer, its size, where the next byte goes.
    static _SEGGER_RTT: [AtomicU32; 10];
}

/// The first task is there, and has not been polled.
pub(crate) fn begin() {
    RAN.store(RUNNING.load(Ordering::Relaxed), Ordering::Relaxed);
}

/// A task is polled; zero for none.
#[inline(always)] // a store
pub(crate) fn runs(task: u32) {
    RUNNING.store(task, Ordering::Relaxed);
}

/// Resets from now on are not in a row with those before.
pub(crate) fn trust() {
    ROW.store(0, Ordering::Relaxed);
}

/// The record. The compiler does not see where it is, as it would take what the linker says of its content for true.
fn place() -> *mut Record {
    black_box(addr_of_mut!(POST_MORTEM).cast())
}

/// Takes the record of the program before this one. Once, before tasks run. Also returns whether power failed since, or the reset
/// pin was pulled: every reset pulls it, so that its flag alone says nothing (RM0090 7.1.1).
#[inline(never)] // a small stack frame of its own, reached by short instructions
pub(crate) fn take() -> (PostMortem, bool) {
    let flags = RCC.csr().read().0;
    RCC.csr().modify(|w| w.set_rmvf(true));
    let is_from_outside = flags & (PORRSTF | BORRSTF) != 0 || flags & (SFTRSTF | IWDGRSTF | WWDGRSTF) == 0;
    let mut found = PostMortem::default();
    let task = RAN.load(Ordering::Relaxed);
    // SAFETY: the record is RAM of its static, and any bits are words. Nobody else has it, or the copy of its dump, before tasks
    // and handlers run.
    let record = unsafe { &mut *place() };
    if flags & PORRSTF != 0 {
        ROW.store(0, Ordering::Relaxed);
    } else if flags & BORRSTF != 0 {
        ROW.store(0, Ordering::Relaxed);
        (found.cause, found.pc) = (PostMortem::BROWN_OUT, FLASH.optcr().read().bor_lev().into());
    } else if record[0] == check(record) {
        (found.cause, found.pc, found.task) = (record[1] as u8, record[2], task);
        // SAFETY: as above; the bytes of words are bytes.
        found.dump = unsafe {
            let dump = addr_of_mut!(DUMP);
            dump.copy_from_nonoverlapping(record.as_ptr().add(3).cast(), 1);
            core::slice::from_raw_parts(dump.cast::<u8>(), 4 * DUMP_WORDS)
        };
    } else if flags & IWDGRSTF != 0 {
        (found.cause, found.task) = (PostMortem::WATCHDOG, task);
    }
    record[0] = !record[0];
    let row = ROW.load(Ordering::Relaxed);
    if row < MOST_IN_A_ROW {
        found.row = row as u8;
    }
    if found.cause != PostMortem::NONE {
        found.row += 1;
        let PostMortem { cause, row, pc, task, .. } = found;
        defmt::error!(
            "last reset: cause {=u8}, {=u8} in a row, at {=u32:08X}h, task {=u32:08X}h",
            cause,
            row,
            pc,
            task
        );
    }
    ROW.store(found.row.into(), Ordering::Relaxed);
    (found, is_from_outside)
}

/// A checksum of the rest of the record.
#[inline(never)] // of several callers
fn check(record: &Record) -> u32 {
    record[1..].iter().fold(0x5EC5_0315, |sum, word| sum.rotate_left(5) ^ word)
}

/// Ends the program: silence, record, reset. With a debugger attached it stops there instead. `frame`: where the exception
/// stacked the registers of what it interrupted.
pub(crate) extern "C" fn end(frame: u32, cause: u32) -> ! {
    RCC.apb1rstr().modify(|w| {
        w.set_can1rst(true);
        w.set_can2rst(true);
    });
    let (top, bottom) = (addr_of!(_stack_start) as u32, addr_of!(_stack_end) as u32);
    // SAFETY: the record is RAM of its static, which only this function works on, once, as tasks run. Between both ends of the stack
    // there is RAM, and any bits are a u32. The program is flash, and a program counter is even. The log is a static of `defmt-rtt` that holds bytes; its control block says where.
    unsafe {
        let record = &mut *place();
        let is_lost = frame < bottom || (*SCB::PTR).cfsr.read() & STKERR != 0;
        let pc = if is_lost { 0 } else { word(frame + 4 * 6) };
        let is_panic = cause == PostMortem::FAULT.into() && is_program(pc) && *(pc as *const u16) == PANIC;
        record[1] = match (is_lost, is_panic) {
            (true, _) => PostMortem::STACK_OVERFLOW.into(),
            (_, true) => PostMortem::PANIC.into(),
            _ => cause,
        };
        record[2] = pc;
        let mut at = frame.max(bottom);
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
        let [.., buffer, size, next] = &_SEGGER_RTT;
        let [buffer, size, next] = [buffer, size, next].map(|word| word.load(Ordering::Relaxed));
        let log = place().cast::<u8>().add(4 * (WORDS - LOG_WORDS));
        let mut from = next;
        for place in (0..4 * LOG_WORDS).rev() {
            if from == 0 {
                from = size;
            }
            from -= 1;
            *log.add(place) = *((buffer + from) as *const u8);
        }
        record[0] = check(record);
    }
    if DCB::is_debugger_attached() {
        loop {
            cortex_m::asm::bkpt();
        }
    }
    SCB::sys_reset()
}

/// Whether an address is in the program.
fn is_program(address: u32) -> bool {
    address >> 24 == FLASH_PAGE && address < addr_of!(__etext) as u32
}

/// # Safety
/// There is RAM at this address.
unsafe fn word(at: u32) -> u32 {
    // SAFETY: as the caller says.
    unsafe { (at as *const u32).read_volatile() }
}

/// From the handler of faults, on its own stack.
extern "C" fn on_fault(frame: u32) -> ! {
    end(frame, PostMortem::FAULT.into())
}

/// From the NMI of the clock security system: the oscillator stopped.
extern "C" fn on_oscillator(frame: u32) -> ! {
    end(frame, PostMortem::OSCILLATOR.into())
}

/// Defines the handler of an exception after which nothing returns. The stack may be lost: it loads another one before it touches
/// memory.
macro_rules! on_its_own_stack {
    ($exception:ident, $handler:ident) => {
        // SAFETY: the vector table knows the handler by this name and no other symbol has it. It never returns.
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        unsafe extern "C" fn $exception() -> ! {
            core::arch::naked_asm!(
                "mov r0, sp",
                "ldr r1, ={stack} + 256",
                "mov sp, r1",
                "b {handler}",
                stack = sym FAULT_STACK,
                handler = sym $handler,
            )
        }
    };
}

on_its_own_stack!(HardFault, on_fault);
// The clock security system raises it alone (RM0090 7.2.7).
on_its_own_stack!(NonMaskableInt, on_oscillator);
