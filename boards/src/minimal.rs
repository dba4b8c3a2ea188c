//! What a board hands to the image of a minimal slave (ECSS 9).

use ecss_can::link::bit_timing::BitTiming;
use ecss_can::runner::Platform;
use ecss_can::types::{NodeId, PerBus};

use crate::bxcan::Port;
use crate::common::{CanInterrupts, Leds, strap_bits, watch};
use crate::stamping::Interrupts;
use crate::straps::{self, StrapError};
use crate::{Resources, Uptime};

/// What a minimal slave needs of its board: no capture of edges, no parameter store, no post-mortem record.
///
/// A program that panics, faults or hangs is reset, and its controllers are silent from then on until it has started again.
pub struct MinimalBoard {
    /// The CAN controllers, off their buses.
    pub ports: PerBus<Port<Interrupts>>,
    /// Time since power-on.
    pub clock: Uptime,
    /// The LEDs, dark.
    pub leds: Leds,
    /// Node-ID from the straps.
    pub node_id: Result<NodeId, StrapError>,
}

impl MinimalBoard {
    /// Starts the watchdog, puts both controllers into Init mode (silent: not even an acknowledgement) and reads the straps.
    #[inline(never)] // a stack of its own is a small one, reached by short instructions
    pub fn new(p: Resources, timing: BitTiming, irqs: impl CanInterrupts) -> MinimalBoard {
        let (_, from_outside) = watch();
        let straps =
            [p.strap_0.into(), p.strap_1.into(), p.strap_2.into(), p.strap_3.into(), p.strap_parity.into()];
        let node_id = straps::node_id(strap_bits(straps, from_outside));
        // CAN1 first: it holds the filter banks and the clock of both.
        let nominal = Port::new(p.can1, p.nominal_rx, p.nominal_tx, irqs, timing, Interrupts);
        let redundant = Port::new(p.can2, p.redundant_rx, p.redundant_tx, irqs, timing, Interrupts);
        let leds =
            Leds::new([p.led_sync.into(), p.led_state.into(), p.led_heartbeat.into(), p.led_time.into()]);
        MinimalBoard { ports: PerBus { nominal, redundant }, clock: Uptime, leds, node_id }
    }
}

impl Platform for MinimalBoard {
    type Port = Port<Interrupts>;
    type Clock = Uptime;
}
