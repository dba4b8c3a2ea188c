//! A board of a minimal slave with one CAN controller and two transceivers (ECSS A.4.1, Figure A-6).

use ecss_can::link::one_controller::{OneController, Side, TransceiverSwitch};
use ecss_can::runner::Platform;
use ecss_can::types::{Bus, NodeId, PerBus};
use embassy_stm32::Peri;
use embassy_stm32::gpio::{AnyPin, Level, Output, Speed};
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;

use crate::Uptime;
use crate::bxcan::Port;
use crate::common::Leds;
use crate::straps::StrapError;

/// As [`MinimalBoard`](crate::MinimalBoard), with CAN1 alone: an output pin selects the transceiver of the nominal bus (low) or of
/// the redundant one (high). CAN2 stays in reset.
///
/// The node has selective access: [`Numbers::on_one_bus`](ecss_can::node::minimal::Numbers::on_one_bus).
pub struct OneControllerBoard {
    /// The CAN controller as the port of each bus, off both.
    pub ports: PerBus<SharedPort>,
    /// Time since power-on.
    pub clock: Uptime,
    /// The LEDs, dark.
    pub leds: Leds,
    /// Node-ID from the straps.
    pub node_id: Result<NodeId, StrapError>,
}

/// A bus of a board with one controller. For tasks in thread mode.
pub type SharedPort = Side<ThreadModeRawMutex, Port, TransceiverPin>;

impl Platform for OneControllerBoard {
    type Port = SharedPort;
    type Clock = Uptime;
}

/// The pin that selects a transceiver.
pub struct TransceiverPin(Output<'static>);

impl TransceiverSwitch for TransceiverPin {
    fn select(&mut self, bus: Bus) {
        self.0.set_level((bus == Bus::Redundant).into());
    }
}

/// The ports of both buses.
pub(crate) fn share(controller: Port, pin: Peri<'static, AnyPin>) -> PerBus<SharedPort> {
    let switch = TransceiverPin(Output::new(pin, Level::Low, Speed::Low));
    let shared = OneController::new(controller, switch);
    defmt::unwrap!(cortex_m::singleton!(: OneController<ThreadModeRawMutex, Port, TransceiverPin> = shared))
        .ports()
}
