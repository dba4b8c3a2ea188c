//! Hardware that differs between boards of one model, faults included.

use crate::accelerator::FlashTiming;
use crate::bxcan::Side;
use crate::peripherals::FlashSpeed;
use crate::pin::Pin;
use crate::wire::time::Time;
use crate::wire::transceiver::Transceiver;
use crate::wiring::{Bus, Wiring};

/// Fitted parts of a board and its environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fittings {
    /// Bus of each controller.
    pub wiring: Wiring,
    /// For a board with one controller and two transceivers: pin that connects CAN1 with the transceiver of CAN1's bus
    /// (low) or of CAN2's bus (high). CAN2 then has no transceiver.
    pub transceiver_switch: Option<Pin>,
    /// The two jumper wires from CAN_RX to the capture inputs, where the model of the board has them.
    pub capture_wires: bool,
    /// Delays of the transceivers of both buses; `None`: those of the wire's own configuration.
    pub transceiver: Option<Transceiver>,
    /// Frequency of the LSI oscillator, Hz: 32 000 typical, 17 000 to 47 000 by the data sheet (DS8626 table 41).
    pub lsi_hz: u32,
    /// An LM75 at 48h on I2C1. For other devices see [`attach_i2c`](super::EmulatedBoard::attach_i2c).
    pub thermometer: bool,
    /// Initial temperature of the devices, in °C.
    pub temperature_c: f64,
    /// Timing of flash reads.
    pub flash_timing: FlashTiming,
    /// Duration of programming and erasing flash.
    pub flash_speed: FlashSpeed,
    /// An F405 of revision A, which must not prefetch and has DEV_ID 411h in DBGMCU_IDCODE (ES0182).
    pub revision_a: bool,
    /// The oscillator on OSC_IN works. A broken one never becomes ready.
    pub hse_starts: bool,
    /// Delay after power-on until the oscillator or external clock on OSC_IN is available.
    pub hse_delay: Time,
}

impl Default for Fittings {
    fn default() -> Self {
        Fittings {
            wiring: Wiring::default(),
            transceiver_switch: None,
            capture_wires: true,
            transceiver: None,
            lsi_hz: 32_000,
            thermometer: true,
            temperature_c: 25.0,
            flash_timing: FlashTiming::AsSet,
            flash_speed: FlashSpeed::Typical,
            revision_a: false,
            hse_starts: true,
            hse_delay: Time::ZERO,
        }
    }
}

/// A transceiver that is connected to a bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plug {
    /// Controller to which the wiring assigns the bus.
    pub transceiver: Side,
    /// Controller connected to the transceiver.
    pub controller: Side,
    pub bus: Bus,
    /// Pin that selects the transceiver, and the level for it.
    pub selected_by: Option<(Pin, bool)>,
}

impl Fittings {
    /// Each transceiver that is on a bus, that of CAN1's bus first.
    pub(crate) fn plugs(self) -> impl Iterator<Item = Plug> {
        self.wiring.ports().map(move |(transceiver, bus)| Plug {
            transceiver,
            controller: if self.transceiver_switch.is_some() { Side::Can1 } else { transceiver },
            bus,
            selected_by: self.transceiver_switch.map(|pin| (pin, transceiver == Side::Can2)),
        })
    }
}
