//! Falling edges of both CAN_RX lines, captured by TIM5 and moved by DMA1, and stamps of frames from them.
//!
//! ```text
//! CAN1_RX ── wire ── PA0 ── TIM5 channel 1 ── DMA1 stream 2 ── ring of the nominal bus
//! CAN2_RX ── wire ── PA1 ── TIM5 channel 2 ── DMA1 stream 4 ── ring of the redundant bus
//! ```
//!
//! A board may use any two of the four channels: [`EdgeInput`].
//!
//! A pin has one alternate function, so CAN_RX goes to a second pin by wire; without it frames keep the stamps of their
//! interrupts. There are no interrupts: the DMA writes the ring continuously, and its position is read when a frame is
//! to be stamped. The streams are programmed here because the ring buffer of embassy-stm32 counts laps in interrupts
//! and returns each edge once, in order. The search for a frame reads backwards and needs no count: edges that were
//! overwritten no longer match the pattern of a frame.
//!
//! TIM5 runs since power-on, as the uptime does. The upper bits beyond its 32 come from the time of the interrupt.

use core::sync::atomic::{Ordering, fence};

use ecss_can::link::{Captured, EDGES, EdgeRing, Miss, Stamp};
use ecss_can::runner::Clock;
use ecss_can::types::{Frame, PerBus};
use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::pac::TIM5;
use embassy_stm32::pac::dma::St;
use embassy_stm32::pac::dma::vals::{Dir, Pl, Size};
use embassy_stm32::pac::timer::vals::CcmrInputCcs;
use embassy_stm32::{Peri, pac, peripherals, rcc};

use crate::alternate::AlternatePin;
use crate::clocks;
use crate::edges::EdgeInput;
use crate::stamping::FrameStamps;
use crate::{DIAGNOSTICS, Uptime, supervisor};

/// TIM5 is at this channel of each stream (RM0090 table 42).
const STREAM_CHANNEL: u8 = 6;

/// Ticks of TIM5 in a microsecond.
pub(crate) const PER_MICRO: u32 = clocks::TIMERS / 1_000_000;

static RINGS: PerBus<Ring> = PerBus { nominal: EdgeRing::new(), redundant: EdgeRing::new() };

type Ring = EdgeRing<PER_MICRO>;

/// Captured edges of one CAN_RX line.
pub struct Edges {
    ring: &'static Ring,
    stream: St,
}

/// Starts the capture of both lines.
pub fn start(_timer: Peri<'static, peripherals::TIM5>, inputs: PerBus<EdgeInput>) -> PerBus<Edges> {
    rcc::enable_and_reset::<peripherals::TIM5>();
    let nominal = Edges::new(inputs.nominal, &RINGS.nominal);
    let redundant = Edges::new(inputs.redundant, &RINGS.redundant);
    TIM5.arr().write_value(u32::MAX);
    // An interrupt in between would offset the stamps from the uptime permanently.
    cortex_m::interrupt::free(|_| {
        TIM5.cnt().write_value(next_microsecond().low::<PER_MICRO>());
        TIM5.cr1().modify(|w| w.set_cen(true));
    });
    supervisor::add_capture();
    PerBus { nominal, redundant }
}

/// Starts a circular transfer without interrupts: each request moves the capture register into the next cell of the
/// ring. The cells are atomics of a static: they may change at any time, and their memory is always valid.
fn go_round(stream: St, capture: *const u32, ring: &'static Ring) {
    stream.par().write_value(capture as u32);
    stream.m0ar().write_value(ring.cells().as_ptr() as u32);
    stream.ndtr().write(|w| w.set_ndt(EDGES as u16));
    // Completes all earlier writes to the ring before DMA may write.
    fence(Ordering::Release);
    stream.cr().write(|w| {
        w.set_chsel(STREAM_CHANNEL);
        w.set_dir(Dir::PERIPHERAL_TO_MEMORY);
        w.set_psize(Size::BITS32);
        w.set_msize(Size::BITS32);
        w.set_minc(true);
        w.set_circ(true);
        w.set_pl(Pl::VERY_HIGH);
        w.set_en(true);
    });
}

/// Waits for the beginning of the next microsecond of the uptime and returns it. If the uptime stands still, returns it
/// after [`POLLS`] reads.
fn next_microsecond() -> Stamp {
    /// Limit of reads: ten times the cycles of a microsecond.
    const POLLS: usize = 1_680;
    let now = Uptime.now();
    let next = (0..POLLS).map(|_| Uptime.now()).find(|next| *next > now);
    Stamp::interrupt(next.unwrap_or(now))
}

impl Edges {
    /// Captures the edges at an input. TIM5 must have its clock and not count yet.
    #[inline(never)] // once for both buses
    fn new(input: EdgeInput, ring: &'static Ring) -> Edges {
        let EdgeInput { pin: AlternatePin(function, pin), channel, stream } = input;
        let stream = pac::DMA1.st(stream);
        let mut pin = Flex::new(pin);
        // The pull-up keeps an input without wire free of edges.
        pin.set_as_af_unchecked(function, AfType::input(Pull::Up));
        // Dropping the pin would disconnect the timer.
        core::mem::forget(pin);
        go_round(stream, TIM5.ccr(channel).as_ptr(), ring);
        TIM5.ccmr_input(channel / 2).modify(|w| w.set_ccs(channel % 2, CcmrInputCcs::TI4));
        TIM5.dier().modify(|w| w.set_ccde(channel, true));
        TIM5.ccer().modify(|w| {
            w.set_ccp(channel, true);
            w.set_cce(channel, true);
        });
        Edges { ring, stream }
    }

    /// Returns the index of the ring's cell for the next edge.
    pub(crate) fn next(&self) -> usize {
        EDGES - usize::from(self.stream.ndtr().read().ndt())
    }

    /// Returns the number of edges since `next` was read, modulo the size of the ring.
    pub(crate) fn since(&self, next: usize) -> usize {
        (self.next() + EDGES - next) % EDGES
    }
}

impl FrameStamps for Edges {
    /// Returns the stamp measured from the edges if possible, otherwise that of the interrupt. Counts both cases.
    fn stamp(&self, frame: &Frame, reported: Stamp, bit: u32, alone: impl FnOnce() -> bool) -> Stamp {
        // A receiver has a frame one bit before its end, and at low bit rates its task may run before the end. The time
        // of the interrupt is rounded down to a microsecond.
        let end = reported.low::<PER_MICRO>().wrapping_add(bit + PER_MICRO);
        let longest = 2 * (bit + PER_MICRO);
        // Bounded by the number of reads: the loop ends even if the timer stands still.
        for _ in 0..longest {
            if !(1..=longest).contains(&end.wrapping_sub(TIM5.cnt().read())) {
                break;
            }
        }
        let alone_until = TIM5.cnt().read();
        let next = self.next();
        // Cells are read after the count of DMA, which stores a cell before it counts down.
        fence(Ordering::Acquire);
        let result = if alone() {
            self.ring.stamp(Captured { next, alone_until }, frame, reported, bit)
        } else {
            Err(Miss::Ambiguous)
        };
        DIAGNOSTICS.stamps.note(result.map(|stamp| stamp.low::<PER_MICRO>()));
        result.unwrap_or(reported)
    }
}
