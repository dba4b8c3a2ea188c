//! pyboard v1.1: STM32F405RG with a 12 MHz crystal.
//!
//! | what | pins | header |
//! | --- | --- | --- |
//! | nominal bus, CAN1 RX and TX | PB8, PB9 | Y3, Y4 |
//! | redundant bus, CAN2 RX and TX | PB12, PB13 | Y5, Y6 |
//! | straps: bits 0 to 3, odd parity | PA2, PA3, PA4, PA5, PA6 | X3, X4, X5, X6, X7 |
//! | LEDs: blue, yellow | PB4, PA15 | on board |
//!
//! The red and green LEDs hang on the debug pins PA13 and PA14 and are never touched. X1 and X2 (PA0, PA1) stay free for
//! capturing CAN_RX. Straps are closed to ground (X14, Y14); inside they have pull-ups.

use ecss_can::link::PerBus;
use ecss_can::nmt::NodeId;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, bind_interrupts, peripherals};

use crate::Uptime;
use crate::bxcan::{BitTiming, Port, ReceiveHandler, StatusHandler, TransmitHandler};
use crate::straps::{self, StrapError};

bind_interrupts!(struct Irqs {
    CAN1_TX => TransmitHandler<peripherals::CAN1>;
    CAN1_RX0 => ReceiveHandler<peripherals::CAN1>;
    CAN1_SCE => StatusHandler<peripherals::CAN1>;
    CAN2_TX => TransmitHandler<peripherals::CAN2>;
    CAN2_RX0 => ReceiveHandler<peripherals::CAN2>;
    CAN2_SCE => StatusHandler<peripherals::CAN2>;
});

/// Bit/s of both ports.
pub const BIT_RATE: u32 = 1_000_000;

/// 42 MHz / 2 / (1 + 16 + 4) = 1 Mbit/s, sample point 81.0 %.
const BIT_TIMING: BitTiming = BitTiming { prescaler: 2, segment1: 16, segment2: 4, jump_width: 4 };

/// Everything an image needs of the board.
pub struct Board {
    /// The CAN controllers, off their buses.
    pub ports: PerBus<Port>,
    /// Time since power-on.
    pub clock: Uptime,
    /// The LEDs, dark.
    pub leds: Leds,
    /// Node-ID of a slave from the straps.
    pub node_id: Result<NodeId, StrapError>,
}

/// The LEDs that are not on debug pins; a high level lights them.
pub struct Leds {
    /// Blue.
    pub blue: Output<'static>,
    /// Yellow.
    pub yellow: Output<'static>,
}

impl Board {
    /// Starts clocks, puts both controllers into Init mode (silent: not even an acknowledgement) and reads the straps.
    ///
    /// # Panics
    /// When called twice.
    pub fn init() -> Board {
        let p = embassy_stm32::init(clocks());
        let closed = [
            Input::new(p.PA2, Pull::Up),
            Input::new(p.PA3, Pull::Up),
            Input::new(p.PA4, Pull::Up),
            Input::new(p.PA5, Pull::Up),
            Input::new(p.PA6, Pull::Up),
        ];
        // Time for the pull-ups (40 kΩ) to charge a wire of some 100 pF.
        embassy_time::block_for(embassy_time::Duration::from_micros(50));
        let node_id = straps::node_id(closed.map(|strap| strap.is_low()));

        // CAN1 first: it holds the filter banks and the clock of both.
        let nominal = Port::new(p.CAN1, p.PB8, p.PB9, Irqs, BIT_TIMING);
        let redundant = Port::new(p.CAN2, p.PB12, p.PB13, Irqs, BIT_TIMING);
        Board {
            ports: PerBus { nominal, redundant },
            clock: Uptime,
            leds: Leds {
                blue: Output::new(p.PB4, Level::Low, Speed::Low),
                yellow: Output::new(p.PA15, Level::Low, Speed::Low),
            },
            node_id,
        }
    }
}

/// 12 MHz crystal, SYSCLK 168 MHz, APB1 (the CAN controllers) 42 MHz, its timers 84 MHz.
fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: Hertz(12_000_000), mode: HseMode::Oscillator });
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll = Some(Pll {
        prediv: PllPreDiv::DIV6,
        mul: PllMul::MUL168,
        divp: Some(PllPDiv::DIV2),
        divq: None,
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV4;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    config
}
