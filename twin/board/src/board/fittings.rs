//! What differs from board to board of one model, faults of its hardware included.

use can_wire::time::Time;
use can_wire::transceiver::Transceiver;

use crate::accelerator::FlashTiming;
use crate::bxcan::Side;
use crate::peripherals::FlashSpeed;
use crate::pin::Pin;
use crate::wiring::{Bus, Wiring};

/// What a board carries and what it feels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fittings {
    /// Which bus is behind which controller.
    pub wiring: Wiring,
    /// One controller and two transceivers: this pin connects CAN1 with the transceiver of CAN1's bus while it is
    /// low, and with that of CAN2's bus while it is high. CAN2 has none.
    pub transceiver_switch: Option<Pin>,
    /// The two jumper wires from CAN_RX to the capture inputs, where the model of the board has them.
    pub capture_wires: bool,
    /// Delays of the transceivers of both buses; `None`: those of the wire's own configuration.
    pub transceiver: Option<Transceiver>,
    /// Frequency of the LSI oscillator, Hz: 32 000 typical, 17 000 to 47 000 by the data sheet (DS8626 table 41).
    pub lsi_hz: u32,
    /// An LM75 at 48h on I2C1. Any other device: [`attach_i2c`](super::EmulatedBoard::attach_i2c).
    pub thermometer: bool,
    /// Its temperature at first, °C.
    pub temperature_c: f64,
    /// How much time reads of flash take.
    pub flash_timing: FlashTiming,
    /// How long flash takes to program and erase.
    pub flash_speed: FlashSpeed,
    /// An F405 of revision A, which must not prefetch and names itself 411h in DBGMCU_IDCODE (ES0182).
    pub revision_a: bool,
    /// The oscillator on OSC_IN works. A broken one never gets ready.
    pub hse_starts: bool,
    /// How long after power-on the oscillator on OSC_IN, or the clock there, is late.
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

/// A transceiver on its bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plug {
    /// Whose bus it is by the wiring.
    pub transceiver: Side,
    /// The controller behind it.
    pub controller: Side,
    pub bus: Bus,
    /// The pin that selects it, and the level that does.
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
