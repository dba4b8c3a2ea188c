//! Description of a board: its oscillator and the wiring of its pins.

use ecss_can::types::PerBus;
use embassy_stm32::gpio::AnyPin;
use embassy_stm32::peripherals::{CAN1, CAN2, FLASH, TIM3, TIM5};
use embassy_stm32::timer::{Ch4, TimerPin};
use embassy_stm32::{Peri, Peripherals};

use crate::alternate::AlternatePin;
use crate::bxcan::CanLines;
use crate::clocks::{Clocks, Oscillator};
use crate::edges::EdgeInput;

/// A board. The macro [`board!`](crate::board) implements it.
pub trait BoardSpec: 'static {
    /// The oscillator at HSE.
    const OSCILLATOR: Oscillator;
    /// Clock of the core in Hz: 168 MHz, or 84 MHz to save power.
    const HCLK: u32 = 168_000_000;

    /// Peripherals that the board uses. The macro `take!` of the board's crate fills it.
    type Resources;

    /// Selects the peripherals of the board from all of the chip.
    fn resources(p: Peripherals) -> Self::Resources;

    /// Assigns peripherals and pins to their purpose.
    fn wiring(resources: Self::Resources) -> Wiring;
}

/// The settings of the clock tree of a board.
///
/// # Panics
/// When there are none. Evaluated as a constant, that fails the build with the reason; [`board!`](crate::board) does it.
pub const fn clocks_of<B: BoardSpec>() -> Clocks {
    match Clocks::new(B::OSCILLATOR, B::HCLK) {
        Ok(clocks) => clocks,
        Err(error) => panic!("{}", error.message().as_str()),
    }
}

/// Peripherals and pins of a board, by purpose.
pub struct Wiring {
    /// The controller of the nominal bus.
    pub nominal: CanLines<CAN1>,
    /// The controller of the redundant bus.
    pub redundant: CanLines<CAN2>,
    /// The timer that captures edges.
    pub capture: Peri<'static, TIM5>,
    /// Inputs of the timer that capture CAN_RX of each bus.
    pub edges: PerBus<EdgeInput>,
    /// The pulse output.
    pub pulse: PulseOutput,
    /// Straps to ground: bits 0 to 3, odd parity, maintenance mode.
    pub straps: [Peri<'static, AnyPin>; 6],
    /// LEDs to ground, lit by a high level: SYNC, state, heartbeat, spacecraft time.
    pub leds: [Peri<'static, AnyPin>; 4],
    /// The flash, which holds the parameter store.
    pub flash: Peri<'static, FLASH>,
}

/// The output of pulses: channel 4 of TIM3.
#[cfg_attr(not(feature = "full"), allow(dead_code, reason = "a minimal board has it, but makes no pulses"))]
pub struct PulseOutput {
    _timer: Peri<'static, TIM3>,
    pub(crate) pin: AlternatePin,
}

impl PulseOutput {
    /// Takes a pin of TIM3 channel 4. Other pins do not compile.
    pub fn new(timer: Peri<'static, TIM3>, pin: Peri<'static, impl TimerPin<TIM3, Ch4>>) -> PulseOutput {
        PulseOutput { _timer: timer, pin: AlternatePin(pin.af_num(), pin.into()) }
    }
}
