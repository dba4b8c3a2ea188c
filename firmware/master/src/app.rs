//! Start of the master: board, node, tasks.

use board::Spec;
use boards_runtime::Irqs;
use boards_stm32f4::{TELLTALE, supervised};
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use mission::PROFILE;

use crate::application::{Application, Board, Node, cables, pulses};

static RESOURCES: Resources<Board, Node> = Resources::new();

boards_runtime::node_tasks!(Board, Node);

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards_stm32f4::start::<Spec>();
    #[cfg_attr(
        not(feature = "standby"),
        expect(unused_variables, reason = "the straps of one of two boards")
    )]
    let Board { ports, clock, pulse, leds, straps, store, post_mortem, .. } =
        Board::new(board::take!(p), const { boards_stm32f4::bit_timing(&PROFILE.network) }, Irqs);
    defmt::info!("master starts, profile {=str}", PROFILE.name);
    #[cfg(not(feature = "standby"))]
    let master = || mission::master(PROFILE, store);
    #[cfg(feature = "standby")]
    let Some(strap) = boards_stm32f4::straps::master_board(straps) else {
        return defmt::error!("straps of neither master board, staying silent");
    };
    #[cfg(feature = "standby")]
    let master = || mission::master_of_two(PROFILE, strap, store);
    let (master, events, runners) = RESOURCES.start(master, ports, clock, &TELLTALE);
    master.with(|master, _| master.set_post_mortem(post_mortem));
    spawn_node(spawner, runners);
    spawner.spawn(pulses(pulse, master).unwrap());
    spawner.spawn(cables(master).unwrap());
    supervised("application", Application::new(master, events, leds).run()).await
}
