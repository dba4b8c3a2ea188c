//! Start of the master: board, node, tasks.

use boards::{Board, TELLTALE};
use ecss_can::link::bit_timing::BitTiming;
use ecss_can::link::port::CanPort;
use ecss_can::node::{Master, MasterEvent, MasterRequest};
use ecss_can::profile::Profile;
use ecss_can::runner::{AppLink, NodeCell};
use ecss_can::types::Bus;
use embassy_executor::Spawner;
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::once_lock::OnceLock;
use mission::CommanderObjects;

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

/// The master, for its task and its application.
pub type Node = NodeCell<Raw, Master<CommanderObjects>>;

pub static APPLICATION: AppLink<Raw, MasterEvent, MasterRequest> = AppLink::new();
static NODE: OnceLock<Node> = OnceLock::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards::start();
    let Board { mut ports, clock, leds, .. } = Board::new(boards::take!(p), BIT_TIMING);
    defmt::info!("master starts, profile {=str}", PROFILE.name);
    // Made where it stays: each copy of it is 15 kB of this stack.
    let node = NODE.get_or_init(|| NodeCell::new(mission::master(PROFILE)));
    let filters = node.with(|master| master.filters());
    Bus::ALL.into_iter().for_each(|bus| ports[bus].set_filters(&filters));

    spawner.spawn(tasks::bus(Bus::Nominal, ports.nominal, clock, node).expect("spawned once"));
    spawner.spawn(tasks::bus(Bus::Redundant, ports.redundant, clock, node).expect("spawned once"));
    spawner.spawn(tasks::node(node, clock).expect("spawned once"));
    let application = Application::new(PROFILE, node, clock, leds, &APPLICATION, &TELLTALE);
    spawner.spawn(tasks::application(application).expect("spawned once"));
}
