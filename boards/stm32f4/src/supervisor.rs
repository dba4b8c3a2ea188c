//! Supervisor: feeds the watchdog as long as all supervised tasks answer and time passes.
//!
//! Ten times a second an interrupt of the highest priority feeds the watchdog and wakes one [`supervised`] task, in
//! turn. A task has answered when it was polled and returned, also if it waits for an event for hours. After a second
//! without an answer the interrupt records the running task with its program counter and resets the chip. So it does when
//! one of three counters differs from the others ([`counters`]). Without the interrupt, the watchdog resets the chip.
//! Only one task is woken at a time: a frame that arrives then waits for one poll more, not for one of each task.

mod counters;
mod duties;

use core::cell::RefCell;
use core::pin::Pin;
use core::sync::atomic::{AtomicI32, AtomicU32, Ordering};
use core::task::{Context, Poll, Waker};

use cortex_m::peripheral::{NVIC, SYST};
use cortex_m::register::basepri;
use ecss_can::emcy::PostMortem;
use embassy_stm32::pac::iwdg::regs::{Kr, Pr, Rlr};
use embassy_stm32::pac::{DBGMCU, IWDG};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use pin_project_lite::pin_project;

#[cfg(feature = "full")]
pub(crate) use counters::add_capture;
#[cfg(feature = "full")]
pub use duties::{Duty, supervise};

use crate::clocks::TIMERS;
use crate::post_mortem::{self, ReadLog};

/// Ticks within which a task has to answer. A task that hangs blocks all others of its executor, so the next task that
/// is asked does not answer.
const PATIENCE: u32 = 10;
/// Ticks of uptime after which the next reset counts as the first one in a row.
const TRUSTED: i32 = ticks(60);
/// Number of resets in a row from which on the board stays silent before it starts. The silence doubles with each
/// further reset.
const LOOP: u8 = 5;
const SILENCE: i32 = ticks(600);
const LONGEST_SILENCE: i32 = ticks(24 * 3600);
/// Number of tasks that can be supervised.
const TASKS: usize = if cfg!(feature = "full") { 16 } else { 4 };

/// The watchdog counts LSI divided by 64. LSI has 17 to 47 kHz (DS8626 table 41).
const PRESCALER: u32 = 4;
/// Counts until the first task is supervised: at least 2.6 s. The flash erases a sector in at most 2 s.
const COUNTS_AT_START: u32 = 1_900;
/// Counts from then on: 0.3 s at 47 kHz, which is three ticks; 0.44 s at 32 kHz, 0.84 s at 17 kHz. A tick may be late by
/// the time in which the flash programs a word, 100 µs.
const COUNTS: u32 = 222;
const KEY_START: Kr = Kr(0xCCCC);
const KEY_ACCESS: Kr = Kr(0x5555);
const KEY_FEED: Kr = Kr(0xAAAA);

/// A supervised task.
#[repr(C)]
struct Place {
    name: u32,
    /// `None`: the place is free.
    waker: Option<Waker>,
}

static TASK_LIST: Mutex<CriticalSectionRawMutex, RefCell<[Place; TASKS]>> =
    Mutex::new(RefCell::new([const { Place { name: 0, waker: None } }; TASKS]));
/// Task that was asked and has not answered: its index plus one; zero for none.
static ASKED: AtomicU32 = AtomicU32::new(0);
/// Index of the task that was asked last.
static TURN: AtomicU32 = AtomicU32::new(0);
/// Ticks since a task was asked.
static WAITED: AtomicU32 = AtomicU32::new(0);
/// Ticks since the start, or since the end of a silence, before which it is negative.
static UPTIME: AtomicI32 = AtomicI32::new(0);

/// Converts seconds to ticks.
const fn ticks(seconds: u64) -> i32 {
    ((seconds * TIMERS as u64) >> counters::TICK) as i32 + 1
}

/// Starts watchdog and supervisor; `hclk` is the clock of the core in Hz. After too many resets in a row the board is silent first, for 10 minutes and more.
#[inline(never)] // a small stack frame of its own, reached by short instructions
pub(crate) fn start(row: u8, hclk: u32) {
    DBGMCU.apb1fzr().modify(|w| w.set_iwdg(true));
    IWDG.kr().write_value(KEY_START);
    IWDG.kr().write_value(KEY_ACCESS);
    IWDG.pr().write_value(Pr(PRESCALER));
    IWDG.rlr().write_value(Rlr(COUNTS_AT_START - 1));
    feed();
    // SAFETY: no critical section relies on a priority, and no other part of the program uses SysTick.
    unsafe {
        let nvic = &*NVIC::PTR;
        for priority in &nvic.ipr[..96] {
            // SysTick has the highest priority, zero; all others are lower.
            priority.write(1 << 4);
        }
        let timer = &*SYST::PTR;
        timer.rvr.write(counters::reload(hclk));
        timer.cvr.write(0);
        timer.csr.write(0b111);
    }
    if let Some(more) = row.checked_sub(LOOP) {
        let silence = LONGEST_SILENCE.min(SILENCE << more.min(8));
        UPTIME.store(-silence, Ordering::Relaxed);
        // A flipped bit ends the silence, or makes it at most twice as long.
        while (-silence..0).contains(&UPTIME.load(Ordering::Relaxed)) {
            cortex_m::asm::wfi();
        }
    }
}

/// Feeds the watchdog.
pub(crate) fn feed() {
    IWDG.kr().write_value(KEY_FEED);
}

/// Feeds the watchdog, or ends the program. Arguments: see [`on_tick`](crate::exceptions::on_tick).
#[inline(always)] // called from one place of an image
pub fn on_tick(frame: Option<u32>, log: ReadLog) {
    let uptime = UPTIME.load(Ordering::Relaxed).wrapping_add(1);
    UPTIME.store(uptime, Ordering::Relaxed);
    if uptime == TRUSTED {
        post_mortem::trust();
    }
    if ASKED.load(Ordering::Relaxed) != 0 {
        let waited = WAITED.load(Ordering::Relaxed).wrapping_add(1);
        WAITED.store(waited, Ordering::Relaxed);
        if waited > PATIENCE {
            post_mortem::end(frame, PostMortem::LATE_TASK, log);
        }
    } else if ask_next() {
        WAITED.store(0, Ordering::Relaxed);
    } else {
        // Before tasks run, the flash may be erased.
        return feed();
    }
    if let Some(duty) = duties::late() {
        post_mortem::runs(duty);
        post_mortem::end(frame, PostMortem::LATE_TASK, log);
    }
    // A mask that was set kept the interrupt of the uptime waiting: the next tick compares.
    if !unmask()
        && let Some(odd) = counters::odd_one(uptime as u32)
    {
        post_mortem::runs(u32::from_le_bytes(*odd));
        post_mortem::end(frame, PostMortem::TIME_BASE, log);
    }
    IWDG.kr().write_value(KEY_ACCESS);
    IWDG.rlr().write_value(Rlr(COUNTS - 1));
    feed();
}

/// Notes that the periodic work of the node is on schedule.
pub(crate) fn on_schedule() {
    duties::NODE.done();
}

/// Clears BASEPRI, which masks all interrupts except this one. Only an upset sets it. Returns whether it was set.
fn unmask() -> bool {
    let is_set = basepri::read() != 0;
    if is_set {
        // SAFETY: no critical section relies on a priority.
        unsafe { basepri::write(0) };
    }
    is_set
}

/// Wakes the next task. Returns whether there is one.
fn ask_next() -> bool {
    let turn = TURN.load(Ordering::Relaxed) as usize;
    TASK_LIST.lock(|list| {
        let list = list.borrow();
        let mut places = (turn + 1..turn + 1 + TASKS).map(|place| place % TASKS);
        let next = places.find_map(|place| Some((place, list.get(place)?.waker.as_ref()?)));
        let Some((place, waker)) = next else { return false };
        TURN.store(place as u32, Ordering::Relaxed);
        // No task runs before this handler has returned.
        ASKED.store(place as u32 + 1, Ordering::Relaxed);
        waker.wake_by_ref();
        true
    })
}

pin_project! {
    /// Future of [`supervised`].
    pub struct Supervised<F> {
        name: u32,
        // Index in the list plus one; zero before the first poll.
        place: u32,
        #[pin]
        future: F,
    }

    impl<F> PinnedDrop for Supervised<F> {
        fn drop(this: Pin<&mut Self>) {
            leave(this.place);
        }
    }
}

/// Supervises a task: `future` is the whole body of the task. If it does not return from a poll for a second, the chip
/// is reset, and the record of the reset has the first four characters of `name`, with spaces behind a shorter one.
///
/// At most 16 tasks are supervised, four without the feature `full`. Further tasks run without supervision.
///
/// ```ignore (a task of an image)
/// #[embassy_executor::task]
/// fn due(runner: DueRunner<Board, Node>) -> impl Future<Output = ()> {
///     supervised("due", runner.run())
/// }
/// ```
pub fn supervised<F: Future>(name: &'static str, future: F) -> Supervised<F> {
    Supervised { name: first_characters(name), place: 0, future }
}

/// Returns the first four characters of a name, with spaces behind a shorter one.
fn first_characters(name: &str) -> u32 {
    let mut first = [b' '; 4];
    for (place, byte) in first.iter_mut().zip(name.bytes()) {
        *place = byte;
    }
    u32::from_le_bytes(first)
}

impl<F: Future> Future for Supervised<F> {
    type Output = ();

    #[inline]
    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<()> {
        let this = self.project();
        if *this.place == 0 {
            *this.place = enter(*this.name, context.waker());
        }
        post_mortem::runs(*this.name);
        let result = this.future.poll(context).map(drop);
        answered(*this.place);
        result
    }
}

/// Adds a task to the list. Returns its index plus one, or a larger number than the capacity if the list is full.
#[inline(never)] // once for each task
fn enter(name: u32, waker: &Waker) -> u32 {
    TASK_LIST.lock(|list| {
        let mut list = list.borrow_mut();
        let place = list.iter().position(|place| place.waker.is_none()).unwrap_or(TASKS);
        if let Some(free) = list.get_mut(place) {
            *free = Place { name, waker: Some(waker.clone()) };
        }
        place as u32 + 1
    })
}

/// Removes a task from the list.
#[inline(never)] // once for each task
fn leave(place: u32) {
    answered(place);
    TASK_LIST.lock(|list| {
        if let Some(left) = list.borrow_mut().get_mut((place as usize).wrapping_sub(1)) {
            *left = Place { name: 0, waker: None };
        }
    });
}

#[inline]
fn answered(place: u32) {
    if ASKED.load(Ordering::Relaxed) == place {
        ASKED.store(0, Ordering::Relaxed);
    }
}
