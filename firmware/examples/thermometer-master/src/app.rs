//! Start of the thermometer's master: board, node, tasks.

use board::Spec;
use ecss_can::prelude::*;
use ecss_can_runtime::Irqs;
use ecss_can_stm32f4::{DIAGNOSTICS, supervised};
use embassy_executor::Spawner;
use thermometer::PROFILE;
use thermometer_master::{Ground, application};

type Node = Master<Ground>;

type Board = ecss_can_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Node> = Resources::new();

ecss_can_runtime::node_tasks!(fn spawn_node(Board, Node));

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = ecss_can_stm32f4::start::<Spec>();
    let bit_timing = const { ecss_can_stm32f4::bit_timing(&PROFILE.network) };
    let board = Board::new(board::take!(p), bit_timing, Irqs);
    let master = Master::builder(&PROFILE, Ground::default()).hardware(board.hardware);
    let (master, events, runners) = RESOURCES.start(|| master.build(), board.connection, &DIAGNOSTICS);
    spawn_node(spawner, runners);
    supervised("application", application(master, events, |report| defmt::info!("{}", report))).await;
}
