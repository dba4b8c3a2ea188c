//! Start and tasks of the test device.

use core::convert::Infallible;

use boards::{Board, Port, TELLTALE, Uptime};
use ecss_can::link::bit_timing::BitTiming;
use ecss_can::link::port::CanPort;
use ecss_can::node::{Slave, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::runner::{AppLink, NodeCell, bus_task, node_task};
use ecss_can::types::Bus;
use embassy_executor::Spawner;
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::once_lock::OnceLock;
use test_device::TestObjects;

#[cfg(feature = "librecube")]
const PROFILE: &Profile = &mission::LIBRECUBE;
#[cfg(not(feature = "librecube"))]
const PROFILE: &Profile = &mission::STANDARD;

const BIT_TIMING: BitTiming = boards::bit_timing(&PROFILE.network);

type Node = NodeCell<ThreadModeRawMutex, Slave<TestObjects>>;
type Link = AppLink<ThreadModeRawMutex, SlaveEvent, Infallible>;

static LINK: Link = AppLink::new();
static NODE: OnceLock<Node> = OnceLock::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards::start();
    let Board { mut ports, clock, node_id, store, retained, memory, .. } =
        Board::new(boards::take!(p), BIT_TIMING);
    let Ok(id) = node_id else { return };
    let mut device = test_device::device(id, PROFILE, memory).with_retained(retained);
    if let Some(store) = store {
        device = device.with_store(store);
    }
    let filters = device.filters();
    let node = NODE.get_or_init(|| NodeCell::new(device));
    Bus::ALL.into_iter().for_each(|bus| ports[bus].set_filters(&filters));

    spawner.spawn(bus(Bus::Nominal, ports.nominal, clock, node).expect("spawned once"));
    spawner.spawn(bus(Bus::Redundant, ports.redundant, clock, node).expect("spawned once"));
    spawner.spawn(due(node, clock).expect("spawned once"));
    spawner.spawn(events().expect("spawned once"));
}

#[embassy_executor::task(pool_size = 2)]
async fn bus(bus: Bus, port: Port, clock: Uptime, node: &'static Node) -> ! {
    match bus_task(bus, port, clock, node, &LINK, &TELLTALE).await {}
}

#[embassy_executor::task]
async fn due(node: &'static Node, clock: Uptime) -> ! {
    match node_task(node, clock, &LINK, &TELLTALE).await {}
}

/// Nothing follows an event but the reset that the master asks for.
#[embassy_executor::task]
async fn events() -> ! {
    loop {
        if let SlaveEvent::ResetNode = LINK.events.receive().await {
            boards::reset()
        }
    }
}
