//! Start of the slave: board, node, tasks.

use core::convert::Infallible;

use boards::{Board, TELLTALE};
use ecss_can::link::bit_timing::BitTiming;
use ecss_can::link::port::CanPort;
use ecss_can::node::{Filters, Slave, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::runner::{AppLink, NodeCell};
use ecss_can::store::{ParameterStore, RetainedMemory};
use ecss_can::types::{Bus, NodeId};
use embassy_executor::Spawner;
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::once_lock::OnceLock;
use mission::MissionObjects;

use crate::application::Application;
use crate::tasks;

#[cfg(feature = "librecube")]
pub const PROFILE: &Profile = &mission::LIBRECUBE;
#[cfg(not(feature = "librecube"))]
pub const PROFILE: &Profile = &mission::STANDARD;

/// Selective slaves that would give up before the master has tried both buses fail the build here.
const _: () = assert!(PROFILE.is_search_long_enough(), "{}", Profile::SEARCH_TOO_SHORT);

/// A network for which this board has no bit timing fails the build here.
const BIT_TIMING: BitTiming = boards::bit_timing(&PROFILE.network);

/// Only tasks use node and channels, and all tasks run in thread mode.
pub type Raw = ThreadModeRawMutex;

/// The slave, for its task and its application.
pub type Node = NodeCell<Raw, Slave<MissionObjects>>;
/// What the slave tells the application, which asks it for nothing: it goes to [`Node`].
pub type Link = AppLink<Raw, SlaveEvent, Infallible>;

pub static LINK: Link = AppLink::new();
static NODE: OnceLock<Node> = OnceLock::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards::start();
    let Board { mut ports, clock, leds, node_id, store, retained, memory } =
        Board::new(boards::take!(p), BIT_TIMING);
    let id = match node_id {
        Ok(id) => id,
        Err(error) => {
            // ECSS 6.10f: the controllers stay in Init mode and do not even acknowledge.
            defmt::error!("no valid Node-ID on the straps, staying silent: {}", error);
            return;
        }
    };
    defmt::info!("slave {} starts, profile {=str}", id.get(), PROFILE.name);
    let (node, filters) = node(id, memory, store, retained);
    Bus::ALL.into_iter().for_each(|bus| ports[bus].set_filters(&filters));

    spawner.spawn(tasks::bus(Bus::Nominal, ports.nominal, clock, node).expect("spawned once"));
    spawner.spawn(tasks::bus(Bus::Redundant, ports.redundant, clock, node).expect("spawned once"));
    spawner.spawn(tasks::node(node, clock).expect("spawned once"));
    let application = Application::new(leds, clock, node, &LINK, &TELLTALE);
    spawner.spawn(tasks::application(application).expect("spawned once"));
}

/// The slave before power-on, and its filters. Apart from [`main`]: places on a small stack are reached by short instructions.
#[inline(never)]
fn node(
    id: NodeId,
    memory: &'static mut [u8],
    store: Option<&'static mut (dyn ParameterStore + Send)>,
    retained: &'static mut (dyn RetainedMemory + Send),
) -> (&'static Node, Filters) {
    let mut slave = mission::slave(id, PROFILE, memory).with_retained(retained);
    if let Some(store) = store {
        slave = slave.with_store(store);
    }
    let filters = slave.filters();
    (NODE.get_or_init(|| NodeCell::new(slave)), filters)
}
