//! Converts the list of a board's pins to the peripherals that the board takes.

/// Makes `Resources` and the macro `take!` from the list of pins. `$` is passed in so that the inner macro can use it.
macro_rules! wiring {
    ($d:tt, $($role:ident: $pin:ident,)*) => {
        /// Peripherals that the board uses. The macro `take!` fills it.
        #[allow(missing_docs)] // the board's module documents the wiring of each pin
        pub struct Resources {
            pub can1: embassy_stm32::Peri<'static, embassy_stm32::peripherals::CAN1>,
            pub can2: embassy_stm32::Peri<'static, embassy_stm32::peripherals::CAN2>,
            pub tim3: embassy_stm32::Peri<'static, embassy_stm32::peripherals::TIM3>,
            pub tim5: embassy_stm32::Peri<'static, embassy_stm32::peripherals::TIM5>,
            pub dma1_ch2: embassy_stm32::Peri<'static, embassy_stm32::peripherals::DMA1_CH2>,
            pub dma1_ch4: embassy_stm32::Peri<'static, embassy_stm32::peripherals::DMA1_CH4>,
            pub flash: embassy_stm32::Peri<'static, embassy_stm32::peripherals::FLASH>,
            $(pub $role: embassy_stm32::Peri<'static, embassy_stm32::peripherals::$pin>,)*
        }

        /// Moves the peripherals that the board uses out of the HAL's `Peripherals` and leaves the rest to the
        /// application. Taking one twice does not compile.
        #[macro_export]
        macro_rules! take {
            ($d p:ident) => {
                $crate::Resources {
                    can1: $d p.CAN1,
                    can2: $d p.CAN2,
                    tim3: $d p.TIM3,
                    tim5: $d p.TIM5,
                    dma1_ch2: $d p.DMA1_CH2,
                    dma1_ch4: $d p.DMA1_CH4,
                    flash: $d p.FLASH,
                    $($role: $d p.$pin,)*
                }
            };
        }

        impl Resources {
            /// Selects the peripherals of the board from all of the chip.
            pub(crate) fn of(p: embassy_stm32::Peripherals) -> Resources {
                take!(p)
            }
        }
    };
}

pub(crate) use wiring;
