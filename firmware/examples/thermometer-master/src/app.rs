//! Start of the thermometer's master: board, node, tasks.

use board::Spec;
use boards_runtime::Irqs;
use boards_stm32f4::{DIAGNOSTICS, supervised};
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use thermometer::PROFILE;
use thermometer_master::{Ground, application};

type Node = Master<Ground>;

type Board = boards_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Node> = Resources::new();

boards_runtime::node_tasks!(Board, Node);

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards_stm32f4::start::<Spec>();
    let Board { ports, clock, store, post_mortem, .. } =
        Board::new(board::take!(p), const { boards_stm32f4::bit_timing(&PROFILE.network) }, Irqs);
    let master = || Master::new(&PROFILE, Ground::default(), store);
    let (master, events, runners) = RESOURCES.start(master, ports, clock, &DIAGNOSTICS);
    master.set_post_mortem(post_mortem);
    spawn_node(spawner, runners);
    supervised("application", application(master, events, |report| defmt::info!("{}", report))).await;
}
