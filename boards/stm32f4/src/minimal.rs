//! Peripherals and data that a board provides to the image of a minimal slave (ECSS 9).

use core::marker::PhantomData;

use ecss_can::runner::{Connection, Platform};
use ecss_can::types::{NodeId, PerBus};

use crate::Uptime;
use crate::bxcan::Port;
use crate::common::{CanInterrupts, Leds, strap_bits, watch};
use crate::spec::{BoardSpec, Wiring};
use crate::stamping::Interrupts;
use crate::straps::{self, StrapError};
use crate::timing::ControllerTiming;

/// Board of a minimal slave: without capture of edges, parameter store and post-mortem record.
///
/// A program that panics, faults or hangs is reset. Its controllers are silent until it has started again.
pub struct MinimalBoard<B> {
    /// The CAN controllers, off their buses, and the time since power-on: for
    /// [`Resources::start`](ecss_can::runner::Resources::start).
    pub connection: Connection<PerBus<Port<Interrupts>>, Uptime>,
    /// The LEDs, dark.
    pub leds: Leds,
    /// Node-ID from the straps.
    pub node_id: Result<NodeId, StrapError>,
    board: PhantomData<B>,
}

impl<B: BoardSpec> MinimalBoard<B> {
    /// Starts the watchdog, puts both controllers into Init mode (silent: not even an acknowledgement) and reads the straps.
    #[inline(never)] // a stack of its own is a small one, reached by short instructions
    pub fn new(
        resources: B::Resources,
        timing: ControllerTiming,
        irqs: impl CanInterrupts,
    ) -> MinimalBoard<B> {
        let Wiring { nominal, redundant, straps, leds, .. } = B::wiring(resources);
        let (_, from_outside) = watch(B::HCLK);
        let [bit_0, bit_1, bit_2, bit_3, parity, _] = straps;
        let node_id =
            straps::node_id(strap_bits([bit_0, bit_1, bit_2, bit_3, parity], B::HCLK, from_outside));
        // CAN1 first: it holds the filter banks and the clock of both.
        let nominal = Port::new(nominal, irqs, timing, Interrupts);
        let redundant = Port::new(redundant, irqs, timing, Interrupts);
        let ports = PerBus { nominal, redundant };
        MinimalBoard {
            connection: Connection { ports, clock: Uptime },
            leds: Leds::new(leds),
            node_id,
            board: PhantomData,
        }
    }
}

impl<B: 'static> Platform for MinimalBoard<B> {
    type Port = Port<Interrupts>;
    type Clock = Uptime;
}
