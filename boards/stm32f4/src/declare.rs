//! The declaration of a board. It is documented on each target and used only on a chip.

/// Declares the board of a crate: its oscillator and its pins.
///
/// It makes `Spec`, which implements `BoardSpec`, the structure `Resources`, and the macro `take!`, which moves what the board
/// uses out of the HAL's `Peripherals`. `$crate` stands for the board's crate in that macro. The crate depends on `embassy-stm32`
/// with the feature of its chip.
///
/// A pin without the function that it is listed for does not compile, nor does a pin or a DMA stream that is listed
/// twice. An oscillator from which 168 MHz cannot be derived fails the build with the reason.
///
/// | entry | what is allowed |
/// | --- | --- |
/// | `oscillator` | [`Oscillator::crystal`](crate::Oscillator::crystal) of 4 to 26 MHz, or [`Oscillator::external`](crate::Oscillator::external) of 1 to 50 MHz |
/// | `hclk` | may be left out: 168 MHz; or 84 MHz |
/// | `nominal_rx`, `nominal_tx` | pins of CAN1 |
/// | `redundant_rx`, `redundant_tx` | pins of CAN2 |
/// | `nominal_edges`, `redundant_edges` | pins of two different channels of TIM5: PA0 to PA3 |
/// | `nominal_stream`, `redundant_stream` | the stream of the channel: 1 `DMA1_CH2`, 2 `DMA1_CH4`, 3 `DMA1_CH0`, 4 `DMA1_CH1` |
/// | `pulse` | a pin of TIM3 channel 4: PB1, PC9 |
/// | `strap_0` to `strap_3`, `strap_parity`, `strap_maintenance` | any pin |
/// | `led_sync`, `led_state`, `led_heartbeat`, `led_time` | any pin |
///
/// ```
/// use ecss_can_stm32f4::{Oscillator, board};
///
/// # #[cfg(target_os = "none")] // on a chip alone there are pins
/// board! {
///     $crate,
///     oscillator: Oscillator::crystal(12_000_000),
///     nominal_rx: PB8,
///     nominal_tx: PB9,
///     redundant_rx: PB12,
///     redundant_tx: PB13,
///     nominal_edges: PA0,
///     nominal_stream: DMA1_CH2,
///     redundant_edges: PA1,
///     redundant_stream: DMA1_CH4,
///     pulse: PB1,
///     strap_0: PA2,
///     strap_1: PA3,
///     strap_2: PA4,
///     strap_3: PA5,
///     strap_parity: PA6,
///     strap_maintenance: PA7,
///     led_sync: PB4,
///     led_state: PA15,
///     led_heartbeat: PB14,
///     led_time: PB15,
/// }
/// ```
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
        /// Peripherals that the board uses. The macro `take!` fills it.
        #[allow(non_snake_case, missing_docs)] // named as the HAL names them
        pub struct Resources {
            $(pub $name: ::embassy_stm32::Peri<'static, ::embassy_stm32::peripherals::$name>,)*
        }

        /// Moves the peripherals that the board uses out of the HAL's `Peripherals` and leaves the rest to the
        /// application. Taking one twice does not compile.
        #[macro_export]
        macro_rules! take {
            ($d p:ident) => {
                $d $this::Resources { $($name: $d p.$name,)* }
            };
        }
    };
}
