//! What every board hands to an image, and what all boards have in common.
//!
//! The parts are of one family: CAN1 and CAN2 on APB1 at 42 MHz, and the same interrupts.

use core::sync::atomic::Ordering;

use ecss_can::emcy::PostMortem;
use ecss_can::runner::Platform;
use ecss_can::store::identity::{self, NoNodeId};
use ecss_can::store::{ParameterStore, RetainedMemory};
use ecss_can::types::{NodeId, PerBus};
use embassy_stm32::gpio::{AnyPin, Input, Level, Output, Pin, Pull, Speed};
use embassy_stm32::peripherals::FLASH;
use embassy_stm32::{Peri, bind_interrupts, peripherals};

use crate::Uptime;
use crate::bxcan::{Port, ReceiveHandler, StatusHandler, TransmitHandler};
use crate::pulse::Pulse;
use crate::retained::STRAPS;
use crate::store::{self, ChipFlash, ParameterLog};
use crate::straps::{self, StrapError};
use crate::{post_mortem, supervisor};

bind_interrupts!(pub(crate) struct Irqs {
    CAN1_TX => TransmitHandler<peripherals::CAN1>;
    CAN1_RX0 => ReceiveHandler<peripherals::CAN1>;
    CAN1_SCE => StatusHandler<peripherals::CAN1>;
    CAN2_TX => TransmitHandler<peripherals::CAN2>;
    CAN2_RX0 => ReceiveHandler<peripherals::CAN2>;
    CAN2_SCE => StatusHandler<peripherals::CAN2>;
});

/// Everything an image needs of the board.
pub struct Board {
    /// The CAN controllers, off their buses.
    pub ports: PerBus<Port>,
    /// Time since power-on.
    pub clock: Uptime,
    /// The pulse output, low.
    pub pulse: Pulse,
    /// The LEDs, dark.
    pub leds: Leds,
    /// Node-ID of a slave from straps and parameter store.
    pub node_id: Result<NodeId, NoNodeId>,
    /// What the straps alone say.
    pub straps: Result<NodeId, StrapError>,
    /// Whether the strap of maintenance mode is closed; for
    /// [`Slave::in_maintenance`](ecss_can::node::Slave::in_maintenance).
    pub is_maintenance: bool,
    /// The parameter store; `None` when its flash fails.
    pub store: Option<&'static mut (dyn ParameterStore + Send)>,
    /// RAM that outlives a reset.
    pub retained: &'static mut (dyn RetainedMemory + Send),
    /// How the program before this one ended; for [`Slave::set_post_mortem`](ecss_can::node::Slave::set_post_mortem).
    pub post_mortem: PostMortem,
    /// RAM that is left, 64 KiB at most: for blocks of data.
    pub memory: &'static mut [u8],
}

impl Platform for Board {
    type Port = Port;
    type Clock = Uptime;
}

/// Two LEDs; a high level lights them.
pub struct Leds {
    /// Toggles with what the node hears or sends.
    pub activity: Output<'static>,
    /// On or off by command, or by the state of the node.
    pub state: Output<'static>,
}

impl Leds {
    pub(crate) fn new(activity: Peri<'static, impl Pin>, state: Peri<'static, impl Pin>) -> Leds {
        let dark = |pin| Output::new(pin, Level::Low, Speed::Low);
        Leds { activity: dark(activity.into()), state: dark(state.into()) }
    }
}

/// Opens the parameter store, which may take seconds: see [`store::open`].
#[inline(never)] // a stack of its own is a small one, reached by short instructions
pub(crate) fn store(flash: Peri<'static, FLASH>) -> Option<&'static mut (dyn ParameterStore + Send)> {
    supervisor::feed();
    match store::open(flash) {
        Ok((log, opened)) => {
            if opened.damaged > 0 {
                defmt::warn!("parameter store: power failed while it was written, {}", opened);
            }
            let log = cortex_m::singleton!(: ParameterLog<ChipFlash> = log)?;
            Some(log)
        }
        Err(error) => {
            defmt::error!("no parameter store: {}", error);
            None
        }
    }
}

/// Takes the record of the last reset and starts the supervisor, which may wait for minutes. Also returns whether the reset came
/// from outside: see [`post_mortem::take`].
pub(crate) fn watch() -> (PostMortem, bool) {
    let (last, is_from_outside) = post_mortem::take();
    supervisor::start(last.row);
    (last, is_from_outside)
}

/// Who this board is.
pub(crate) struct Identity {
    pub node_id: Result<NodeId, NoNodeId>,
    pub straps: Result<NodeId, StrapError>,
    pub is_maintenance: bool,
}

/// The straps: bits 0 to 3, parity, maintenance mode. They are read after a reset `from_outside`, and are as they were else (ECSS
/// 6.10g).
#[inline(never)] // a stack of its own is a small one, reached by short instructions
pub(crate) fn identity(
    straps: [Peri<'static, AnyPin>; 6],
    from_outside: bool,
    store: Option<&mut (dyn ParameterStore + Send + 'static)>,
) -> Identity {
    let latched = straps::latched(STRAPS.load(Ordering::Relaxed)).filter(|_| !from_outside);
    let bits = latched.unwrap_or_else(|| {
        let straps = straps.map(|strap| Input::new(strap, Pull::Up));
        // Time for the pull-ups (40 kΩ) to charge wires of some 100 pF: 50 µs.
        cortex_m::asm::delay(50 * 168);
        straps.iter().rev().fold(0, |bits, strap| bits << 1 | u8::from(strap.is_low()))
    });
    STRAPS.store(straps::latch(bits), Ordering::Relaxed);
    let straps = straps::node_id(bits);
    Identity {
        node_id: identity::node_id(straps::of_slave(straps), store.and_then(|store| store.node_id())),
        straps,
        is_maintenance: bits >> 5 != 0,
    }
}
