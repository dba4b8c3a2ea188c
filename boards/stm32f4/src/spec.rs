//! What a board is: an oscillator, and what each pin is wired to.

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

    /// What the board uses of the chip. The macro `take!` of the board's crate fills it.
    type Resources;

    /// What the board uses, out of all that the chip has.
    fn resources(p: Peripherals) -> Self::Resources;

    /// What is wired to what.
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

/// Peripherals and pins of a board, by what they are for.
pub struct Wiring {
    /// The controller of the nominal bus.
    pub nominal: CanLines<CAN1>,
    /// The controller of the redundant bus.
    pub redundant: CanLines<CAN2>,
    /// The timer that captures edges.
    pub capture: Peri<'static, TIM5>,
    /// The inputs where it captures CAN_RX of each bus.
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
    /// Takes a pin of that channel. Others do not compile.
    pub fn new(timer: Peri<'static, TIM3>, pin: Peri<'static, impl TimerPin<TIM3, Ch4>>) -> PulseOutput {
        PulseOutput { _timer: timer, pin: AlternatePin(pin.af_num(), pin.into()) }
    }
}

/// Declares the board of a crate: its oscillator and its pins.
///
/// It makes `Spec`, which implements [`BoardSpec`], the structure `Resources`, and the macro `take!`, which moves what the board
/// uses out of the HAL's `Peripherals`. `$crate` stands for the board's crate in that macro. The crate depends on `embassy-stm32`
/// with the feature of its chip.
///
/// A pin that cannot do what it is listed for does not compile, nor does a pin or a DMA stream that is listed twice. An oscillator
/// from which 168 MHz cannot be made fails the build with the reason.
///
/// | entry | what is allowed |
/// | --- | --- |
/// | `oscillator` | [`Oscillator::crystal`] of 4 to 26 MHz, or [`Oscillator::external`] of 1 to 50 MHz |
/// | `hclk` | may be left out: 168 MHz; or 84 MHz |
/// | `nominal_rx`, `nominal_tx` | pins of CAN1 |
/// | `redundant_rx`, `redundant_tx` | pins of CAN2 |
/// | `nominal_edges`, `redundant_edges` | pins of two different channels of TIM5: PA0 to PA3 |
/// | `nominal_stream`, `redundant_stream` | the stream of the channel: 1 `DMA1_CH2`, 2 `DMA1_CH4`, 3 `DMA1_CH0`, 4 `DMA1_CH1` |
/// | `pulse` | a pin of TIM3 channel 4: PB1, PC9 |
/// | `strap_0` to `strap_3`, `strap_parity`, `strap_maintenance` | any pin |
/// | `led_sync`, `led_state`, `led_heartbeat`, `led_time` | any pin |
#[macro_export]
macro_rules! board {
    (
        $d:tt $this:tt,
        oscillator: $oscillator:expr,
        $(hclk: $hclk:expr,)?
        nominal_rx: $nominal_rx:ident,
        nominal_tx: $nominal_tx:ident,
        redundant_rx: $redundant_rx:ident,
        redundant_tx: $redundant_tx:ident,
        nominal_edges: $nominal_edges:ident,
        nominal_stream: $nominal_stream:ident,
        redundant_edges: $redundant_edges:ident,
        redundant_stream: $redundant_stream:ident,
        pulse: $pulse:ident,
        strap_0: $strap_0:ident,
        strap_1: $strap_1:ident,
        strap_2: $strap_2:ident,
        strap_3: $strap_3:ident,
        strap_parity: $strap_parity:ident,
        strap_maintenance: $strap_maintenance:ident,
        led_sync: $led_sync:ident,
        led_state: $led_state:ident,
        led_heartbeat: $led_heartbeat:ident,
        led_time: $led_time:ident,
    ) => {
        $crate::__resources! {
            $d $this,
            CAN1, CAN2, TIM3, TIM5, FLASH,
            $nominal_rx, $nominal_tx, $redundant_rx, $redundant_tx,
            $nominal_edges, $nominal_stream, $redundant_edges, $redundant_stream, $pulse,
            $strap_0, $strap_1, $strap_2, $strap_3, $strap_parity, $strap_maintenance,
            $led_sync, $led_state, $led_heartbeat, $led_time,
        }

        /// This board.
        pub struct Spec;

        const _: $crate::Clocks = $crate::clocks_of::<Spec>();

        impl $crate::BoardSpec for Spec {
            const OSCILLATOR: $crate::Oscillator = $oscillator;
            $(const HCLK: u32 = $hclk;)?

            type Resources = Resources;

            fn resources(p: ::embassy_stm32::Peripherals) -> Resources {
                take!(p)
            }

            fn wiring(r: Resources) -> $crate::Wiring {
                $crate::Wiring {
                    nominal: $crate::CanLines::new(r.CAN1, r.$nominal_rx, r.$nominal_tx),
                    redundant: $crate::CanLines::new(r.CAN2, r.$redundant_rx, r.$redundant_tx),
                    capture: r.TIM5,
                    edges: $crate::PerBus {
                        nominal: $crate::EdgeInput::new(r.$nominal_edges, r.$nominal_stream),
                        redundant: $crate::EdgeInput::new(r.$redundant_edges, r.$redundant_stream),
                    },
                    pulse: $crate::PulseOutput::new(r.TIM3, r.$pulse),
                    straps: [
                        r.$strap_0.into(),
                        r.$strap_1.into(),
                        r.$strap_2.into(),
                        r.$strap_3.into(),
                        r.$strap_parity.into(),
                        r.$strap_maintenance.into(),
                    ],
                    leds: [
                        r.$led_sync.into(),
                        r.$led_state.into(),
                        r.$led_heartbeat.into(),
                        r.$led_time.into(),
                    ],
                    flash: r.FLASH,
                }
            }
        }
    };
}

/// `Resources` and `take!` of peripherals by name. A part of [`board!`](crate::board).
#[doc(hidden)]
#[macro_export]
macro_rules! __resources {
    ($d:tt $this:tt, $($name:ident,)*) => {
        /// What the board uses of the chip. The macro `take!` fills it.
        #[allow(non_snake_case, missing_docs)] // named as the HAL names them
        pub struct Resources {
            $(pub $name: ::embassy_stm32::Peri<'static, ::embassy_stm32::peripherals::$name>,)*
        }

        /// Moves what the board uses out of the HAL's `Peripherals` and leaves the rest to the application. What is taken
        /// cannot be taken again: that does not compile.
        #[macro_export]
        macro_rules! take {
            ($d p:ident) => {
                $d $this::Resources { $($name: $d p.$name,)* }
            };
        }
    };
}
