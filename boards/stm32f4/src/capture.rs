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
use embassy_stm32::pac::TIM5;
use embassy_stm32::pac::dma::St;
use embassy_stm32::pac::dma::regs::Cr;
use embassy_stm32::pac::dma::vals::{Dir, Pl, Size};
use embassy_stm32::{Peri, pac, peripherals, rcc};

use crate::alternate::{AlternatePin, Direction};
use crate::clocks;
use crate::edges::EdgeInput;
use crate::registers::{self, Register};
use crate::stamping::FrameStamps;
use crate::{DIAGNOSTICS, Uptime, supervisor};

/// TIM5 is at this channel of each stream (RM0090 table 42).
const STREAM_CHANNEL: u8 = 6;

/// Flags of a stream, shifted to its place (RM0090 10.5.3).
const STREAM_FLAGS: u32 = 0x3D;
/// Reads of a stream that stops. A transfer of 4 bytes takes some ten cycles.
const STOP_POLLS: usize = 1_000;

/// Ticks of TIM5 in a microsecond.
pub(crate) const PER_MICRO: u32 = clocks::TIMERS / 1_000_000;

/// Registers of TIM5 that both lines share. Stamps that went wrong stay wrong, so all of them reset the board.
pub(crate) static REGISTERS: [Register; 4] = [
    // CR1: counts up.
    Register::of(TIM5_BASE, 0x3FF, 1).or_reset(),
    // SMCR: clocked from inside.
    Register::of(TIM5_BASE + 0x08, 0xFFFF, 0).or_reset(),
    // PSC, ARR: each clock, 32 bits.
    Register::of(TIM5_BASE + 0x28, 0xFFFF, 0).or_reset(),
    Register::of(TIM5_BASE + 0x2C, !0, !0).or_reset(),
];
const TIM5_BASE: u32 = 0x4000_0C00;

/// Bits of a channel in CCMR and CCER: its own input; falling edges, enabled.
const OWN_INPUT: u32 = 1;
const FALLING: u32 = 0b11;

static RINGS: PerBus<Ring> = PerBus { nominal: EdgeRing::new(), redundant: EdgeRing::new() };

type Ring = EdgeRing<PER_MICRO>;

/// Captured edges of one CAN_RX line.
pub struct Edges {
    ring: &'static Ring,
    /// Number of the stream in DMA1.
    stream: usize,
    /// Channel of TIM5, from 0.
    channel: usize,
    pin: AlternatePin,
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
    stream.cr().write_value(stream_settings());
}

/// Returns the settings of a stream that runs.
fn stream_settings() -> Cr {
    let mut settings = Cr(0);
    settings.set_chsel(STREAM_CHANNEL);
    settings.set_dir(Dir::PERIPHERAL_TO_MEMORY);
    settings.set_psize(Size::BITS32);
    settings.set_msize(Size::BITS32);
    settings.set_minc(true);
    settings.set_circ(true);
    settings.set_pl(Pl::VERY_HIGH);
    settings.set_en(true);
    settings
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
        let EdgeInput { mut pin, channel, stream } = input;
        pin.connect(Direction::Input);
        let edges = Edges { ring, stream, channel, pin };
        edges.run();
        edges
    }

    /// Stops the channel and its stream, and sets them up. After that earlier edges in the ring match no frame any more.
    fn run(&self) {
        let (channel, number, stream) = (self.channel, self.stream, self.stream());
        stream.cr().write_value(Cr(0));
        // The stream stops when its transfer has ended (RM0090 10.3.17).
        _ = (0..STOP_POLLS).find(|_| !stream.cr().read().en());
        pac::DMA1.ifcr(number / 4).write(|w| w.0 = STREAM_FLAGS << [0, 6, 16, 22][number % 4]);
        // The input of a channel can be selected while the channel is off (RM0090 18.4.7).
        let (input, edges) = (8 * (channel % 2), 4 * channel);
        TIM5.ccer().modify(|w| w.0 &= !(0xF << edges));
        TIM5.ccmr_input(channel / 2).modify(|w| w.0 = w.0 & !(0xFF << input) | OWN_INPUT << input);
        go_round(stream, self.capture(), self.ring);
        TIM5.dier().modify(|w| w.set_ccde(channel, true));
        TIM5.ccer().modify(|w| w.0 |= FALLING << edges);
    }

    fn stream(&self) -> St {
        pac::DMA1.st(self.stream)
    }

    /// Returns the capture register.
    fn capture(&self) -> *const u32 {
        TIM5.ccr(self.channel).as_ptr()
    }

    /// Returns whether the channel and its stream have the settings of [`Edges::run`]. A count beyond the ring would let DMA
    /// write behind it.
    fn runs(&self) -> bool {
        let (channel, stream) = (self.channel, self.stream());
        stream.cr().read() == stream_settings()
            && usize::from(stream.ndtr().read().ndt()) <= EDGES
            && stream.par().read() == self.capture() as u32
            && stream.m0ar().read() == self.ring.cells().as_ptr() as u32
            && TIM5.ccmr_input(channel / 2).read().0 >> (8 * (channel % 2)) & 0xFF == OWN_INPUT
            && TIM5.ccer().read().0 >> (4 * channel) & 0xF == FALLING
            && TIM5.dier().read().ccde(channel)
    }

    /// Returns the index of the ring's cell for the next edge.
    pub(crate) fn next(&self) -> usize {
        EDGES - usize::from(self.stream().ndtr().read().ndt())
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

    fn mend(&mut self) {
        self.pin.mend(Direction::Input);
        if !self.runs() {
            registers::count(self.stream().cr().as_ptr() as u32);
            self.run();
        }
    }
}
