//! The firmware: starts the board, the node with its tasks, and the application. A master reads no straps: it is node 1.

use board::Spec;
use ecss_can::prelude::*;
use ecss_can_runtime::Irqs;
use ecss_can_stm32f4::{DIAGNOSTICS, supervised};
use embassy_executor::Spawner;

use {{crate}}::{Ground, application};

use {{slave_crate}}::PROFILE;

type Board = ecss_can_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Master<Ground>> = Resources::new();

ecss_can_runtime::node_tasks!(fn spawn_node(Board, Master<Ground>));

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = ecss_can_stm32f4::start::<Spec>();
    let bit_timing = const { ecss_can_stm32f4::bit_timing(&PROFILE.network) };
    let board = Board::new(board::take!(p), bit_timing, Irqs);
    let master = Master::builder(&PROFILE, Ground::default()).hardware(board.hardware);
    let (master, events, runners) =
        RESOURCES.start(|| master.build(), board.connection, &DIAGNOSTICS);
    spawn_node(spawner, runners);
    supervised(
        "application",
        application(master, events, |report| defmt::info!("{}", report)),
    )
    .await;
}
