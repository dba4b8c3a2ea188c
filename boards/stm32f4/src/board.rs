//! Peripherals and data that a board provides to an image.

use core::marker::PhantomData;

use ecss_can::emcy::PostMortem;
use ecss_can::node::Hardware;
use ecss_can::runner::{Connection, Platform};
use ecss_can::store::ParameterStore;
use ecss_can::store::identity::{self, MAINTENANCE, NoNodeId};
use ecss_can::types::{NodeId, PerBus};
use embassy_stm32::Peri;
use embassy_stm32::gpio::AnyPin;
use embassy_stm32::peripherals::FLASH;

use crate::bxcan::Port;
use crate::capture::{self, Edges};
use crate::common::{CanInterrupts, Leds, strap_bits, watch};
use crate::crc::Crc;
use crate::pulse::Pulse;
use crate::spec::{BoardSpec, Wiring};
use crate::store::{self, ChipFlash, ParameterLog};
use crate::straps::{self, StrapError};
use crate::timing::ControllerTiming;
use crate::{Uptime, register_table, registers, retained, spare, supervisor};

/// Peripherals and data of the board `B` for an image.
pub struct Board<B> {
    /// The CAN controllers, off their buses, and the time since power-on: for
    /// [`Resources::start`](ecss_can::runner::Resources::start).
    pub connection: Connection<PerBus<Port<Edges>>, Uptime>,
    /// Parameter store (none if its flash fails), RAM that outlives a reset, record of the last reset, and a pattern of
    /// late heartbeats: for the builder of the node.
    pub hardware: Hardware,
    /// The pulse output, low.
    pub pulse: Pulse,
    /// The LEDs, dark.
    pub leds: Leds,
    /// Node-ID of a slave from straps and parameter store. If the strap of maintenance mode is closed, it is always
    /// [`MAINTENANCE`].
    pub node_id: Result<NodeId, NoNodeId>,
    /// Node-ID of the straps alone.
    pub straps: Result<NodeId, StrapError>,
    /// Unused RAM, at most 64 KiB, for blocks of data.
    pub memory: &'static mut [u8],
    board: PhantomData<B>,
}

impl<B: BoardSpec> Board<B> {
    /// Starts the watchdog, puts both controllers into Init mode (silent: not even an acknowledgement), opens the parameter
    /// store and reads the straps.
    #[inline(never)] // a stack of its own is a small one, reached by short instructions
    pub fn new(resources: B::Resources, timing: ControllerTiming, irqs: impl CanInterrupts) -> Board<B> {
        let Wiring { nominal, redundant, capture, edges, pulse, straps, leds, flash } = B::wiring(resources);
        let (post_mortem, from_outside) = watch(B::HCLK);
        let mut store = store(flash);
        let Identity { node_id, straps } = identity(straps, B::HCLK, from_outside, store.as_deref_mut());
        let captured = [edges.nominal.channel, edges.redundant.channel];
        // TIM5 has four channels; two capture.
        let free = (0..3).find(|channel| !captured.contains(channel)).unwrap_or(3);
        let edges = capture::start(capture, edges);
        // CAN1 first: it holds the filter banks and the clock of both.
        let nominal = Port::new(nominal, irqs, timing, edges.nominal);
        let redundant = Port::new(redundant, irqs, timing, edges.redundant);
        let pulse = Pulse::new(pulse, free);
        register_table::keep();
        Board {
            connection: Connection { ports: PerBus { nominal, redundant }, clock: Uptime },
            hardware: hardware(store, post_mortem),
            pulse,
            leds: Leds::new(leds),
            node_id,
            straps,
            memory: spare::take(),
            board: PhantomData,
        }
    }
}

impl<B: 'static> Platform for Board<B> {
    type Port = Port<Edges>;
    type Clock = Uptime;
}

/// Returns the hardware that the node uses besides ports and clock.
fn hardware(store: Option<&'static mut (dyn ParameterStore + Send)>, post_mortem: PostMortem) -> Hardware {
    let mut hardware = Hardware::default();
    hardware.store = store;
    hardware.retained = Some(retained::take());
    hardware.post_mortem = post_mortem;
    hardware.late_heartbeats = late_heartbeats();
    hardware.upsets = Some(&registers::UPSETS);
    hardware
}

/// Returns the pattern of late heartbeats of this chip: the CRC-32C of the unique ID (96 bits). Two IDs that differ within 32
/// consecutive bits have different CRCs. Chips of one wafer differ in their coordinates, which are the first 32 bits (RM0090 39.1).
/// The parameter store already contains this CRC.
fn late_heartbeats() -> u32 {
    let mut crc = Crc::new();
    crc.update(&embassy_stm32::uid::uid());
    crc.value()
}

/// Opens the parameter store, which may take seconds: see [`store::open`].
#[inline(never)] // a stack of its own is a small one, reached by short instructions
fn store(flash: Peri<'static, FLASH>) -> Option<&'static mut (dyn ParameterStore + Send)> {
    supervisor::feed();
    match store::open(flash) {
        Ok((log, opened)) => {
            // Logs lost sets with the cause, or the number of corrected bits.
            if opened.damaged > 0 || opened.is_interrupted || opened.corrected > 0 {
                warn!("parameter store: {}", opened);
            }
            let log = cortex_m::singleton!(: ParameterLog<ChipFlash> = log)?;
            Some(log)
        }
        Err(error) => {
            error!("no parameter store: {}", error);
            None
        }
    }
}

/// Identity of the board.
struct Identity {
    node_id: Result<NodeId, NoNodeId>,
    straps: Result<NodeId, StrapError>,
}

/// The straps: bits 0 to 3, parity, maintenance mode. They are read after a reset `from_outside`; after any other reset
/// the values read before are kept (ECSS 6.10g).
#[inline(never)] // a stack of its own is a small one, reached by short instructions
fn identity(
    straps: [Peri<'static, AnyPin>; 6],
    hclk: u32,
    from_outside: bool,
    store: Option<&mut (dyn ParameterStore + Send + 'static)>,
) -> Identity {
    let bits = strap_bits(straps, hclk, from_outside);
    let straps = straps::node_id(bits);
    let node_id = if bits >> 5 != 0 {
        Ok(MAINTENANCE)
    } else {
        identity::node_id(straps::of_slave(straps), store.and_then(|store| store.node_id()))
    };
    Identity { node_id, straps }
}
