//! Start of the minimal slave: board, node, tasks.

use boards::{TELLTALE, supervised};
use ecss_can::node::minimal::{MinimalSlave, Numbers};
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use mission::PROFILE;
use mission::minimal::Shipped;

use crate::application::{self, Board, Node};

static RESOURCES: Resources<Board, Node> = Resources::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards::start();
    let Board { ports, clock, leds, node_id } =
        Board::new(boards::take!(p), const { boards::bit_timing(&PROFILE.network) });
    // ECSS 6.10f: without a Node-ID the controllers stay in Init mode and do not even acknowledge.
    let Ok(id) = node_id.inspect_err(|error| defmt::error!("{}, staying silent", error)) else { return };
    defmt::info!("minimal slave {} starts, profile {=str}", id.get(), PROFILE.name);
    let slave = || MinimalSlave::new(id, numbers(id), Shipped::new());
    let (slave, events, runners) = RESOURCES.start(slave, ports, clock, &TELLTALE);
    spawner.spawn(bus(runners.nominal).unwrap());
    spawner.spawn(bus(runners.redundant).unwrap());
    spawner.spawn(due(runners.due).unwrap());
    supervised("application", application::run(slave, events, leds)).await
}

/// One controller is on one bus at a time, whatever the profile says of this node.
fn numbers(id: NodeId) -> Numbers {
    let numbers = Numbers::of(PROFILE, id);
    if cfg!(feature = "one-controller") { numbers.on_one_bus() } else { numbers }
}

#[embassy_executor::task(pool_size = 2)]
fn bus(runner: BusRunner<Board, Node>) -> impl Future<Output = ()> {
    supervised("bus", runner.run())
}

#[embassy_executor::task]
fn due(runner: DueRunner<Board, Node>) -> impl Future<Output = ()> {
    supervised("due", runner.run())
}
