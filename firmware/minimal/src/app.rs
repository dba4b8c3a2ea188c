//! Start of the minimal slave: board, node, tasks.

use board::Spec;
use ecss_can::node::minimal::MinimalSlave;
use ecss_can::prelude::*;
use ecss_can_runtime::Irqs;
use ecss_can_stm32f4::{DIAGNOSTICS, supervised};
use embassy_executor::Spawner;
use mission::PROFILE;
use mission::application::minimal::Application;
use mission::minimal::Shipped;

#[cfg(not(feature = "one-controller"))]
type Board = ecss_can_stm32f4::MinimalBoard<Spec>;
#[cfg(feature = "one-controller")]
type Board = ecss_can_stm32f4::OneControllerBoard<Spec>;

type Node = MinimalSlave<Shipped>;

static RESOURCES: Resources<Board, Node> = Resources::new();

ecss_can_runtime::node_tasks!(fn spawn_node(Board, Node));

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = ecss_can_stm32f4::start::<Spec>();
    let Board { connection, leds, node_id, .. } =
        Board::new(board::take!(p), const { ecss_can_stm32f4::bit_timing(&PROFILE.network) }, Irqs);
    // ECSS 6.10f: without a Node-ID the controllers stay in Init mode and do not even acknowledge.
    let Ok(id) =
        node_id.inspect_err(|error| defmt::error!("no Node-ID by the straps: {}, staying silent", error))
    else {
        return;
    };
    defmt::info!("minimal slave {} starts, profile {=str}", id.get(), PROFILE.name);
    let slave = || {
        let slave = MinimalSlave::builder(id, PROFILE, Shipped::new());
        #[cfg(feature = "one-controller")] // on one bus at a time, whatever the profile says of this node
        let slave = slave.on_one_bus();
        slave.build()
    };
    let (slave, events, runners) = RESOURCES.start(slave, connection, &DIAGNOSTICS);
    spawn_node(spawner, runners);
    supervised("application", Application::new(slave, events, leds).run()).await
}
