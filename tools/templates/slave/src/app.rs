//! The firmware: starts the board, the node with its tasks, and the application.

use board::Spec;
use ecss_can::prelude::*;
use ecss_can_runtime::Irqs;
use ecss_can_stm32f4::{DIAGNOSTICS, supervised};
use embassy_executor::Spawner;

use {{crate}}::{Heater, PROFILE, application};

type Board = ecss_can_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Slave<Heater>> = Resources::new();

ecss_can_runtime::node_tasks!(fn spawn_node(Board, Slave<Heater>));

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    // `p` keeps the peripherals that the board does not use.
    let p = ecss_can_stm32f4::start::<Spec>();
    let bit_timing = const { ecss_can_stm32f4::bit_timing(&PROFILE.network) };
    let board = Board::new(board::take!(p), bit_timing, Irqs);
    let Ok(id) = board.node_id else {
        return defmt::error!("no Node-ID on the straps");
    };
    let slave = Slave::builder(id, &PROFILE, Heater::default()).hardware(board.hardware);
    let (slave, events, runners) =
        RESOURCES.start(|| slave.build(), board.connection, &DIAGNOSTICS);
    spawn_node(spawner, runners);
    supervised(
        "application",
        application(slave, events, || ecss_can_stm32f4::reset()),
    )
    .await
}
