//! What every board hands to an image.

use ecss_can::emcy::PostMortem;
use ecss_can::link::bit_timing::BitTiming;
use ecss_can::runner::Platform;
use ecss_can::store::identity::{self, NoNodeId};
use ecss_can::store::{ParameterStore, RetainedMemory};
use ecss_can::types::{NodeId, PerBus};
use embassy_stm32::Peri;
use embassy_stm32::gpio::AnyPin;
use embassy_stm32::peripherals::FLASH;

use crate::bxcan::Port;
use crate::capture::{self, Edges};
use crate::common::{CanInterrupts, Leds, strap_bits, watch};
use crate::pulse::Pulse;
use crate::store::{self, ChipFlash, Crc, ParameterLog};
use crate::straps::{self, StrapError};
use crate::{Resources, Uptime, retained, spare, supervisor};

/// Everything an image needs of the board.
pub struct Board {
    /// The CAN controllers, off their buses.
    pub ports: PerBus<Port<Edges>>,
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

impl Board {
    /// Starts the watchdog, puts both controllers into Init mode (silent: not even an acknowledgement), opens the parameter
    /// store and reads the straps.
    #[inline(never)] // a stack of its own is a small one, reached by short instructions
    pub fn new(p: Resources, timing: BitTiming, irqs: impl CanInterrupts) -> Board {
        let (post_mortem, from_outside) = watch();
        let mut store = store(p.flash);
        let straps = [
            p.strap_0.into(),
            p.strap_1.into(),
            p.strap_2.into(),
            p.strap_3.into(),
            p.strap_parity.into(),
            p.strap_maintenance.into(),
        ];
        let Identity { node_id, straps, is_maintenance } =
            identity(straps, from_outside, store.as_deref_mut());
        let edges = capture::start(p.tim5, p.nominal_edges, p.redundant_edges, p.dma1_ch2, p.dma1_ch4);
        // CAN1 first: it holds the filter banks and the clock of both.
        let nominal = Port::new(p.can1, p.nominal_rx, p.nominal_tx, irqs, timing, edges.nominal);
        let redundant = Port::new(p.can2, p.redundant_rx, p.redundant_tx, irqs, timing, edges.redundant);
        Board {
            ports: PerBus { nominal, redundant },
            clock: Uptime,
            pulse: Pulse::new(p.tim3, p.pulse),
            leds: Leds::new([
                p.led_sync.into(),
                p.led_state.into(),
                p.led_heartbeat.into(),
                p.led_time.into(),
            ]),
            node_id,
            straps,
            is_maintenance,
            store,
            retained: retained::take(),
            post_mortem,
            memory: spare::take(),
        }
    }

    /// Returns the pattern of late heartbeats of this chip, for
    /// [`Slave::with_late_heartbeats`](ecss_can::node::Slave::with_late_heartbeats).
    ///
    /// The pattern is the CRC-32C of the unique ID (96 bits). Two IDs that differ within 32 consecutive bits have different CRCs.
    /// Chips of one wafer differ in their coordinates, which are the first 32 bits (RM0090 39.1). The parameter store already
    /// contains this CRC.
    pub fn late_heartbeats() -> u32 {
        let mut crc = Crc::new();
        crc.update(&embassy_stm32::uid::uid());
        crc.value()
    }
}

impl Platform for Board {
    type Port = Port<Edges>;
    type Clock = Uptime;
}

/// Opens the parameter store, which may take seconds: see [`store::open`].
#[inline(never)] // a stack of its own is a small one, reached by short instructions
fn store(flash: Peri<'static, FLASH>) -> Option<&'static mut (dyn ParameterStore + Send)> {
    supervisor::feed();
    match store::open(flash) {
        Ok((log, opened)) => {
            // Reports what was lost and why, or how many bits were corrected.
            if opened.damaged > 0 || opened.is_interrupted || opened.corrected > 0 {
                defmt::warn!("parameter store: {}", opened);
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
struct Identity {
    node_id: Result<NodeId, NoNodeId>,
    straps: Result<NodeId, StrapError>,
    is_maintenance: bool,
}

/// The straps: bits 0 to 3, parity, maintenance mode. They are read after a reset `from_outside`, and are as they were else (ECSS
/// 6.10g).
#[inline(never)] // a stack of its own is a small one, reached by short instructions
fn identity(
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
