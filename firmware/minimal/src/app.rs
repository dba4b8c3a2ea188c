//! Start of the minimal slave: board, node, tasks.

use boards::{MinimalBoard, TELLTALE};
use ecss_can::node::minimal::{MinimalSlave, Numbers};
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use mission::PROFILE;
use mission::minimal::Shipped;

use crate::application::{self, Node};

static RESOURCES: Resources<MinimalBoard, Node> = Resources::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards::start();
    let MinimalBoard { ports, clock, leds, node_id } =
        MinimalBoard::new(boards::take!(p), const { boards::bit_timing(&PROFILE.network) });
    // ECSS 6.10f: without a Node-ID the controllers stay in Init mode and do not even acknowledge.
    let Ok(id) = node_id.inspect_err(|error| defmt::error!("{}, staying silent", error)) else { return };
    defmt::info!("minimal slave {} starts, profile {=str}", id.get(), PROFILE.name);
    let slave = || MinimalSlave::new(id, Numbers::of(PROFILE, id), Shipped::new());
    let (slave, events, runners) = RESOURCES.start(slave, ports, clock, &TELLTALE);
    spawner.spawn(bus(runners.nominal).unwrap());
    spawner.spawn(bus(runners.redundant).unwrap());
    spawner.spawn(due(runners.due).unwrap());
    application::run(slave, events, leds).await
}

#[embassy_executor::task(pool_size = 2)]
async fn bus(runner: BusRunner<MinimalBoard, Node>) -> ! {
    runner.run().await
}

#[embassy_executor::task]
async fn due(runner: DueRunner<MinimalBoard, Node>) -> ! {
    runner.run().await
}
