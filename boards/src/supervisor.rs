//! The watchdog, and who feeds it.
//!
//! Ten times a second an interrupt above all others feeds the watchdog and wakes one task of all executors, in turn. A task has
//! answered when it was polled and returned, so one that waits for an event for hours answers as any other. While an answer is
//! missing the watchdog is not fed. After a second without it the interrupt records what runs, with its program counter, and
//! resets the chip. Where interrupts are off the watchdog does. Only one task is woken at a time: a frame that arrives then
//! waits for one poll more, not for one of each task.

use core::mem;
use core::ptr::{self, NonNull};
use core::sync::atomic::{AtomicI32, AtomicU32, Ordering};

use cortex_m::peripheral::{NVIC, SYST};
use ecss_can::emcy::PostMortem;
use embassy_executor::raw::{TaskRef, wake_task};
use embassy_stm32::pac::iwdg::regs::{Kr, Pr, Rlr};
use embassy_stm32::pac::{DBGMCU, IWDG};

use crate::post_mortem;

/// SysTick counts 24 bits of 168 MHz: 99.9 ms.
const TICK: u32 = (1 << 24) - 1;
/// Ticks in which a task answers. One that hangs stops all others of its executor: the next one asked does not answer.
const PATIENCE: u32 = 10;
/// Ticks of uptime after which the next reset counts as the first one of a row.
const TRUSTED: i32 = ticks(60);
/// From the fifth reset in a row on, the board is silent before it tries again: so long at first.
const LOOP: u8 = 5;
const SILENCE: i32 = ticks(600);
const LONGEST_SILENCE: i32 = ticks(24 * 3600);
/// Tasks that are asked; others are not.
const TASKS: usize = 16;

/// LSI divided by 64. It runs at 17 to 47 kHz (DS8626 table 41): 1,900 counts are 2.6 s at least, and the flash erases a sector in
/// 2 s at most. At 32 kHz they are 3.8 s, at 17 kHz 7.2 s.
const PRESCALER: u32 = 4;
const COUNTS: u32 = 1_900;
const KEY_START: Kr = Kr(0xCCCC);
const KEY_ACCESS: Kr = Kr(0x5555);
const KEY_FEED: Kr = Kr(0xAAAA);

/// The storage of each task; zero is a free place.
static ASKABLE: [AtomicU32; TASKS] = [const { AtomicU32::new(0) }; TASKS];
/// The task that was asked and has not answered; zero for none.
static ASKED: AtomicU32 = AtomicU32::new(0);
/// Place of the task that was asked last.
static TURN: AtomicU32 = AtomicU32::new(0);
/// Ticks since one was asked.
static WAITED: AtomicU32 = AtomicU32::new(0);
/// Ticks; negative while the board is silent.
static UPTIME: AtomicI32 = AtomicI32::new(0);

const fn ticks(seconds: u64) -> i32 {
    (seconds * 168_000_000 / (TICK as u64 + 1)) as i32 + 1
}

/// Starts watchdog and supervisor. After too many resets in a row the board is silent first, for 10 minutes and more.
#[inline(never)] // a small stack frame of its own, reached by short instructions
pub(crate) fn start(row: u8) {
    DBGMCU.apb1fzr().modify(|w| w.set_iwdg(true));
    IWDG.kr().write_value(KEY_START);
    IWDG.kr().write_value(KEY_ACCESS);
    IWDG.pr().write_value(Pr(PRESCALER));
    IWDG.rlr().write_value(Rlr(COUNTS - 1));
    feed();
    // SAFETY: no critical section relies on a priority. SysTick is that of no other part of the program.
    unsafe {
        let nvic = &*NVIC::PTR;
        for priority in &nvic.ipr[..96] {
            // SysTick has the highest one, zero.
            priority.write(1 << 4);
        }
        let timer = &*SYST::PTR;
        timer.rvr.write(TICK);
        timer.cvr.write(0);
        timer.csr.write(0b111);
    }
    if let Some(more) = row.checked_sub(LOOP) {
        let silence = LONGEST_SILENCE.min(SILENCE << more.min(8));
        UPTIME.store(-silence, Ordering::Relaxed);
        while UPTIME.load(Ordering::Relaxed) < 0 {
            cortex_m::asm::wfi();
        }
    }
}

/// Feeds the watchdog.
pub(crate) fn feed() {
    IWDG.kr().write_value(KEY_FEED);
}

extern "C" fn on_tick(frame: u32) {
    let uptime = UPTIME.load(Ordering::Relaxed).wrapping_add(1);
    UPTIME.store(uptime, Ordering::Relaxed);
    if uptime == TRUSTED {
        post_mortem::trust();
    }
    let waited = WAITED.load(Ordering::Relaxed) + 1;
    WAITED.store(waited, Ordering::Relaxed);
    if ASKED.load(Ordering::Relaxed) != 0 {
        if waited > PATIENCE {
            post_mortem::end(frame, PostMortem::LATE_TASK.into());
        }
        return;
    }
    feed();
    WAITED.store(0, Ordering::Relaxed);
    let turn = TURN.load(Ordering::Relaxed) as usize;
    let mut places = (turn + 1..turn + 1 + TASKS).map(|place| place % TASKS);
    let Some(place) = places.find(|place| ASKABLE[*place].load(Ordering::Relaxed) != 0) else { return };
    TURN.store(place as u32, Ordering::Relaxed);
    let task = ASKABLE[place].load(Ordering::Relaxed);
    if let Some(header) = NonNull::new(ptr::with_exposed_provenance_mut::<()>(task as usize))
        && uptime > 0
    {
        // No task runs before this handler has returned.
        ASKED.store(task, Ordering::Relaxed);
        // SAFETY: a `TaskRef` is this pointer, which the executor gave as an integer; a task that has ended is not here.
        wake_task(unsafe { mem::transmute::<NonNull<()>, TaskRef>(header) });
    }
}

/// Above all other handlers.
// SAFETY: the vector table knows the handler by this name and no other symbol has it. `on_tick` returns from the exception.
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn SysTick() {
    core::arch::naked_asm!("mov r0, sp", "b {handler}", handler = sym on_tick)
}

fn answered(task: u32) {
    if ASKED.load(Ordering::Relaxed) == task {
        ASKED.store(0, Ordering::Relaxed);
    }
}

#[inline(never)] // from two places
fn replace(old: u32, new: u32) {
    if let Some(place) = ASKABLE.iter().find(|task| task.load(Ordering::Relaxed) == old) {
        place.store(new, Ordering::Relaxed);
    }
}

/// What the executor calls (`embassy_executor::raw::trace`).
mod trace {
    use super::*;

    // SAFETY, for all: the executor declares them by these names, and no other symbol has one of them.
    #[unsafe(no_mangle)]
    fn _embassy_trace_poll_start(_executor: u32) {}

    // SAFETY: see above.
    #[unsafe(no_mangle)]
    fn _embassy_trace_executor_idle(_executor: u32) {}

    // SAFETY: see above.
    #[unsafe(no_mangle)]
    fn _embassy_trace_task_ready_begin(_executor: u32, _task: u32) {}

    // SAFETY: see above.
    #[unsafe(no_mangle)]
    fn _embassy_trace_task_new(_executor: u32, task: u32) {
        if ASKABLE[0].load(Ordering::Relaxed) == 0 {
            post_mortem::begin();
        }
        replace(0, task);
    }

    // SAFETY: see above.
    #[unsafe(no_mangle)]
    fn _embassy_trace_task_end(_executor: u32, task: u32) {
        answered(task);
        replace(task, 0);
    }

    // SAFETY: see above.
    #[unsafe(no_mangle)]
    fn _embassy_trace_task_exec_begin(_executor: u32, task: u32) {
        post_mortem::runs(task);
    }

    // SAFETY: see above.
    #[unsafe(no_mangle)]
    fn _embassy_trace_task_exec_end(_executor: u32, task: u32) {
        post_mortem::runs(0);
        answered(task);
    }
}
