//! What every board hands to an image.

use ecss_can::emcy::PostMortem;
use ecss_can::runner::Platform;
use ecss_can::store::identity::{self, NoNodeId};
use ecss_can::store::{ParameterStore, RetainedMemory};
use ecss_can::types::{NodeId, PerBus};
use embassy_stm32::Peri;
use embassy_stm32::gpio::AnyPin;
use embassy_stm32::peripherals::FLASH;

use crate::bxcan::Port;
use crate::common::{Leds, strap_bits};
use crate::pulse::Pulse;
use crate::store::{self, ChipFlash, ParameterLog};
use crate::straps::{self, StrapError};
use crate::{Uptime, supervisor};

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
    let bits = strap_bits(straps, from_outside);
    let straps = straps::node_id(bits);
    Identity {
        node_id: identity::node_id(straps::of_slave(straps), store.and_then(|store| store.node_id())),
        straps,
        is_maintenance: bits >> 5 != 0,
    }
}
