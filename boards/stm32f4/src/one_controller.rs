//! A board of a minimal slave with one CAN controller and two transceivers (ECSS A.4.1, Figure A-6).

use core::marker::PhantomData;

use ecss_can::link::one_controller::{OneController, Side, TransceiverSwitch};
use ecss_can::runner::{Connection, Platform};
use ecss_can::types::{Bus, NodeId, PerBus};
use embassy_stm32::Peri;
use embassy_stm32::gpio::{AnyPin, Level, Output, Speed};
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;

use crate::Uptime;
use crate::alternate::AlternatePin;
use crate::bxcan::Port;
use crate::common::{CanInterrupts, Leds, strap_bits, watch};
use crate::spec::{BoardSpec, Wiring};
use crate::stamping::Interrupts;
use crate::straps::{self, StrapError};
use crate::timing::ControllerTiming;

/// As [`MinimalBoard`](crate::MinimalBoard), with CAN1 only. An output pin selects the transceiver of the nominal bus
/// (low) or of the redundant one (high). CAN2 stays in reset.
///
/// The node has selective access: [`on_one_bus`](ecss_can::node::minimal::MinimalSlaveBuilder::on_one_bus).
pub struct OneControllerBoard<B> {
    /// The CAN controller as the port of each bus, off both, and the time since power-on: for
    /// [`Resources::start`](ecss_can::runner::Resources::start).
    pub connection: Connection<PerBus<SharedPort>, Uptime>,
    /// The LEDs, dark.
    pub leds: Leds,
    /// Node-ID from the straps.
    pub node_id: Result<NodeId, StrapError>,
    board: PhantomData<B>,
}

impl<B: BoardSpec> OneControllerBoard<B> {
    /// Starts the watchdog, selects the nominal bus, puts CAN1 into Init mode (silent: not even an acknowledgement) and
    /// reads the straps. The pin that is CAN2_TX on other boards selects the transceiver.
    #[inline(never)] // a stack of its own is a small one, reached by short instructions
    pub fn new(
        resources: B::Resources,
        timing: ControllerTiming,
        irqs: impl CanInterrupts,
    ) -> OneControllerBoard<B> {
        let Wiring { nominal, redundant, straps, leds, .. } = B::wiring(resources);
        let AlternatePin(_, switch) = redundant.tx;
        let (_, from_outside) = watch(B::HCLK);
        let [bit_0, bit_1, bit_2, bit_3, parity, _] = straps;
        let node_id =
            straps::node_id(strap_bits([bit_0, bit_1, bit_2, bit_3, parity], B::HCLK, from_outside));
        let ports = share(Port::new(nominal, irqs, timing, Interrupts), switch);
        OneControllerBoard {
            connection: Connection { ports, clock: Uptime },
            leds: Leds::new(leds),
            node_id,
            board: PhantomData,
        }
    }
}

/// A bus of a board with one controller. For tasks in thread mode.
pub type SharedPort = Side<ThreadModeRawMutex, Port<Interrupts>, TransceiverPin>;

impl<B: 'static> Platform for OneControllerBoard<B> {
    type Port = SharedPort;
    type Clock = Uptime;
}

/// Pin that selects a transceiver: low for the nominal bus, high for the redundant one.
pub struct TransceiverPin(Output<'static>);

impl TransceiverSwitch for TransceiverPin {
    fn select(&mut self, bus: Bus) {
        self.0.set_level((bus == Bus::Redundant).into());
    }
}

/// Makes the ports of both buses from one controller.
fn share(controller: Port<Interrupts>, pin: Peri<'static, AnyPin>) -> PerBus<SharedPort> {
    let switch = TransceiverPin(Output::new(pin, Level::Low, Speed::Low));
    let shared = OneController::new(controller, switch);
    cortex_m::singleton!(: OneController<ThreadModeRawMutex, Port<Interrupts>, TransceiverPin> = shared)
        .unwrap()
        .ports()
}
