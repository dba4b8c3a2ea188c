//! Parts that all boards and images share.
//!
//! The chips are of one family: CAN1 and CAN2 on APB1 at 42 MHz, and the same interrupts.

use core::sync::atomic::{AtomicU32, Ordering};

use ecss_can::emcy::PostMortem;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{AnyPin, Input, Level, Output, Pull, Speed};
use embassy_stm32::peripherals::{CAN1, CAN2};

use crate::bxcan::ControllerInterrupts;
use crate::{post_mortem, straps, supervisor};

/// Interrupts of both CAN controllers: `ecss_can_runtime::Irqs`, or a structure of `bind_interrupts!`.
pub trait CanInterrupts: Copy + ControllerInterrupts<CAN1> + ControllerInterrupts<CAN2> {}

impl<I: Copy + ControllerInterrupts<CAN1> + ControllerInterrupts<CAN2>> CanInterrupts for I {}

/// Straps as last read, encoded by [`straps::latch`].
// SAFETY: the section is `.uninit` of the linker script `link.x`, which is RAM. The bits of a u32 may be any.
#[unsafe(link_section = ".uninit.STRAPS")]
static STRAPS: AtomicU32 = AtomicU32::new(0);

/// Four LEDs, two of them outside of the board; a high level lights them.
pub struct Leds {
    /// On the board: toggles with each SYNC.
    pub sync: Output<'static>,
    /// On or off by command, or by the state of the node.
    pub state: Output<'static>,
    /// External: toggles with each heartbeat of the master.
    pub heartbeat: Output<'static>,
    /// External: toggles with each spacecraft time.
    pub time: Output<'static>,
}

impl Leds {
    pub(crate) fn new([sync, state, heartbeat, time]: [Peri<'static, AnyPin>; 4]) -> Leds {
        Leds { sync: dark(sync), state: dark(state), heartbeat: dark(heartbeat), time: dark(time) }
    }
}

/// Makes an output that is low.
pub(crate) fn dark(pin: Peri<'static, AnyPin>) -> Output<'static> {
    Output::new(pin, Level::Low, Speed::Low)
}

/// Takes the record of the last reset and, with a core clock of `hclk` Hz, starts the supervisor, which may wait for
/// minutes. Also returns whether the reset was external: see [`post_mortem::take`].
pub(crate) fn watch(hclk: u32) -> (PostMortem, bool) {
    let (last, is_from_outside) = post_mortem::take();
    supervisor::start(last.row, hclk);
    (last, is_from_outside)
}

/// Returns the straps; the first one is bit 0. They are read after a reset `from_outside`; after any other reset the
/// values read before are kept (ECSS 6.10g).
#[inline(always)] // called from one place of an image
pub(crate) fn strap_bits<const N: usize>(
    straps: [Peri<'static, AnyPin>; N],
    hclk: u32,
    from_outside: bool,
) -> u8 {
    let latched = straps::latched(STRAPS.load(Ordering::Relaxed)).filter(|_| !from_outside);
    let bits = latched.unwrap_or_else(|| {
        let straps = straps.map(|strap| Input::new(strap, Pull::Up));
        // Waits 50 µs for the pull-ups (40 kΩ) to charge wires of about 100 pF.
        cortex_m::asm::delay(50 * (hclk / 1_000_000));
        straps.iter().rev().fold(0, |bits, strap| bits << 1 | u8::from(strap.is_low()))
    });
    STRAPS.store(straps::latch(bits), Ordering::Relaxed);
    bits
}
