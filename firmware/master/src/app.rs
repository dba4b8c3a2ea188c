//! Start of the master: board, node, tasks.

use board::Spec;
use boards_runtime::Irqs;
use boards_stm32f4::{DIAGNOSTICS, supervised};
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use master::{Application, Cables, pulses_per_second};
use mission::{Boards, PROFILE};

type Board = boards_stm32f4::Board<Spec>;
type Node = master::Node<Boards>;

static RESOURCES: Resources<Board, Node> = Resources::new();
static CABLES: Cables = Cables::new();

boards_runtime::node_tasks!(Board, Node);
boards_runtime::pulse_task!(Board, Node, pulses_per_second);

#[embassy_executor::task]
fn cables(master: Handle<Board, Node>) -> impl Future<Output = ()> {
    supervised("cables", CABLES.run(master))
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards_stm32f4::start::<Spec>();
    let timing = const { boards_stm32f4::bit_timing(&PROFILE.network) };
    let board = Board::new(board::take!(p), timing, Irqs);
    defmt::info!("master starts, profile {=str}", PROFILE.name);
    #[cfg(not(feature = "standby"))]
    let master = || mission::master(PROFILE, board.store);
    #[cfg(feature = "standby")]
    let Some(strap) = boards_stm32f4::straps::master_board(board.straps) else {
        return defmt::error!("straps of neither master board, staying silent");
    };
    #[cfg(feature = "standby")]
    let master = || mission::master_of_two(PROFILE, strap, board.store);
    let (master, events, runners) = RESOURCES.start(master, board.ports, board.clock, &DIAGNOSTICS);
    master.with(|master, _| master.set_post_mortem(board.post_mortem));
    spawn_node(spawner, runners);
    spawn_pulses(spawner, board.pulse, master);
    spawner.spawn(cables(master).unwrap());
    let application = Application::new(master, events, board.leds, &CABLES, PROFILE.minimal);
    supervised("application", application.run()).await
}
