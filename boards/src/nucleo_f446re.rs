//! NUCLEO-F446RE: STM32F446RE with 8 MHz from its ST-LINK.
//!
//! | what | pins | connector |
//! | --- | --- | --- |
//! | nominal bus, CAN1 RX and TX | PB8, PB9 | CN10 3, 5 |
//! | redundant bus, CAN2 RX and TX | PB12, PB13 | CN10 16, 30 |
//! | with one controller, CAN1: bus, redundant when high | PB13 | CN10 30 |
//! | capture of CAN_RX, nominal and redundant, by wires from CN10 3 and 16 | PA0, PA1 | CN7 28, 30 |
//! | pulse at an instant | PB1 | CN10 24 |
//! | straps: bits 0 to 3, odd parity | PC0, PC1, PC2, PC3, PB0 | CN7 38, 36, 35, 37, 34 |
//! | strap: maintenance mode | PA4 | CN7 32 |
//! | LEDs: SYNC (LD2, green), state (external) | PA5, PA6 | on board, CN10 13 |
//! | LEDs: heartbeat, spacecraft time (external) | PB14, PB15 | CN10 28, 26 |
//!
//! PA2 and PA3 are the serial port of the ST-LINK, PA13 and PA14 its debug port; they are never touched. Straps are closed to ground (CN7 22); inside they have pull-ups.

use ecss_can::link::bit_timing::BitTiming;
use ecss_can::types::PerBus;
use embassy_stm32::peripherals::{
    CAN1, CAN2, DMA1_CH2, DMA1_CH4, FLASH, PA0, PA1, PA4, PA5, PA6, PB0, PB1, PB8, PB9, PB12, PB13, PB14,
    PB15, PC0, PC1, PC2, PC3, TIM3, TIM5,
};
use embassy_stm32::rcc::{Hse, HseMode, PllPreDiv};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Peri, Peripherals};

use crate::bxcan::Port;
use crate::common::{Irqs, Leds, strap_bits, watch};
use crate::{MinimalBoard, OneControllerBoard, Uptime, capture, clock_tree, one_controller, straps};

#[cfg(feature = "full")]
use crate::{
    board::{Board, Identity, identity, store},
    pulse::Pulse,
    retained, spare,
};

/// MCO of the ST-LINK, a square wave.
const OSCILLATOR: Hse = Hse { freq: Hertz(8_000_000), mode: HseMode::Bypass };

/// What the board uses of the chip, by the names of the HAL. [`take!`](crate::take) fills it.
#[allow(missing_docs, non_snake_case)] // names of the chip
pub struct Resources {
    pub TIM3: Peri<'static, TIM3>,
    pub TIM5: Peri<'static, TIM5>,
    pub DMA1_CH2: Peri<'static, DMA1_CH2>,
    pub DMA1_CH4: Peri<'static, DMA1_CH4>,
    pub CAN1: Peri<'static, CAN1>,
    pub CAN2: Peri<'static, CAN2>,
    pub FLASH: Peri<'static, FLASH>,
    pub PB8: Peri<'static, PB8>,
    pub PB9: Peri<'static, PB9>,
    pub PB12: Peri<'static, PB12>,
    pub PB13: Peri<'static, PB13>,
    pub PB14: Peri<'static, PB14>,
    pub PB15: Peri<'static, PB15>,
    pub PA0: Peri<'static, PA0>,
    pub PA1: Peri<'static, PA1>,
    pub PC0: Peri<'static, PC0>,
    pub PC1: Peri<'static, PC1>,
    pub PC2: Peri<'static, PC2>,
    pub PC3: Peri<'static, PC3>,
    pub PB0: Peri<'static, PB0>,
    pub PB1: Peri<'static, PB1>,
    pub PA4: Peri<'static, PA4>,
    pub PA5: Peri<'static, PA5>,
    pub PA6: Peri<'static, PA6>,
}

/// Moves what the board uses out of the HAL's `Peripherals` and leaves the rest to the application. What is taken cannot be
/// taken again: that does not compile.
#[macro_export]
macro_rules! take {
    ($p:ident) => {
        $crate::Resources {
            TIM3: $p.TIM3,
            TIM5: $p.TIM5,
            DMA1_CH2: $p.DMA1_CH2,
            DMA1_CH4: $p.DMA1_CH4,
            CAN1: $p.CAN1,
            CAN2: $p.CAN2,
            FLASH: $p.FLASH,
            PB8: $p.PB8,
            PB9: $p.PB9,
            PB12: $p.PB12,
            PB13: $p.PB13,
            PB14: $p.PB14,
            PB15: $p.PB15,
            PA0: $p.PA0,
            PA1: $p.PA1,
            PC0: $p.PC0,
            PC1: $p.PC1,
            PC2: $p.PC2,
            PC3: $p.PC3,
            PB0: $p.PB0,
            PB1: $p.PB1,
            PA4: $p.PA4,
            PA5: $p.PA5,
            PA6: $p.PA6,
        }
    };
}

/// Starts the clocks and the HAL.
///
/// Without its oscillator the board never returns from here: it logs the failure, its LEDs take turns, and both
/// controllers stay in reset.
///
/// # Panics
/// When called twice.
pub fn start() -> Peripherals {
    if !clock_tree::oscillates(OSCILLATOR) {
        // SAFETY: `Peripherals` were not handed out, and never are from here on.
        let leds = unsafe { [PA5::steal().into(), PA6::steal().into()] };
        clock_tree::without_oscillator(leds)
    }
    clock_tree::start(OSCILLATOR, PllPreDiv::DIV4)
}

#[cfg(feature = "full")]
impl Board {
    /// Starts the watchdog, puts both controllers into Init mode (silent: not even an acknowledgement), opens the parameter
    /// store and reads the straps.
    #[inline(never)] // a stack of its own is a small one, reached by short instructions
    pub fn new(p: Resources, timing: BitTiming) -> Board {
        let (post_mortem, from_outside) = watch();
        let mut store = store(p.FLASH);
        let straps = [p.PC0.into(), p.PC1.into(), p.PC2.into(), p.PC3.into(), p.PB0.into(), p.PA4.into()];
        let Identity { node_id, straps, is_maintenance } =
            identity(straps, from_outside, store.as_deref_mut());
        let edges = capture::start(p.TIM5, p.PA0, p.PA1, p.DMA1_CH2, p.DMA1_CH4);
        // CAN1 first: it holds the filter banks and the clock of both.
        let nominal = Port::new(p.CAN1, p.PB8, p.PB9, Irqs, timing, edges.nominal);
        let redundant = Port::new(p.CAN2, p.PB12, p.PB13, Irqs, timing, edges.redundant);
        Board {
            ports: PerBus { nominal, redundant },
            clock: Uptime,
            pulse: Pulse::new(p.TIM3, p.PB1),
            leds: Leds::new([p.PA5.into(), p.PA6.into(), p.PB14.into(), p.PB15.into()]),
            node_id,
            straps,
            is_maintenance,
            store,
            retained: retained::take(),
            post_mortem,
            memory: spare::take(),
        }
    }
}

impl MinimalBoard {
    /// Starts the watchdog, puts both controllers into Init mode (silent: not even an acknowledgement) and reads the straps.
    #[inline(never)] // a stack of its own is a small one, reached by short instructions
    pub fn new(p: Resources, timing: BitTiming) -> MinimalBoard {
        let (_, from_outside) = watch();
        let straps = [p.PC0.into(), p.PC1.into(), p.PC2.into(), p.PC3.into(), p.PB0.into()];
        let node_id = straps::node_id(strap_bits(straps, from_outside));
        let edges = capture::start(p.TIM5, p.PA0, p.PA1, p.DMA1_CH2, p.DMA1_CH4);
        // CAN1 first: it holds the filter banks and the clock of both.
        let nominal = Port::new(p.CAN1, p.PB8, p.PB9, Irqs, timing, edges.nominal);
        let redundant = Port::new(p.CAN2, p.PB12, p.PB13, Irqs, timing, edges.redundant);
        let ports = PerBus { nominal, redundant };
        MinimalBoard {
            ports,
            clock: Uptime,
            leds: Leds::new([p.PA5.into(), p.PA6.into(), p.PB14.into(), p.PB15.into()]),
            node_id,
        }
    }
}

impl OneControllerBoard {
    /// Starts the watchdog, selects the nominal bus, puts CAN1 into Init mode (silent: not even an acknowledgement) and reads the
    /// straps.
    #[inline(never)] // a stack of its own is a small one, reached by short instructions
    pub fn new(p: Resources, timing: BitTiming) -> OneControllerBoard {
        let (_, from_outside) = watch();
        let straps = [p.PC0.into(), p.PC1.into(), p.PC2.into(), p.PC3.into(), p.PB0.into()];
        let node_id = straps::node_id(strap_bits(straps, from_outside));
        let edges = capture::start(p.TIM5, p.PA0, p.PA1, p.DMA1_CH2, p.DMA1_CH4);
        let controller = Port::new(p.CAN1, p.PB8, p.PB9, Irqs, timing, edges.nominal);
        let ports = one_controller::share(controller, p.PB13.into());
        OneControllerBoard {
            ports,
            clock: Uptime,
            leds: Leds::new([p.PA5.into(), p.PA6.into(), p.PB14.into(), p.PB15.into()]),
            node_id,
        }
    }
}
