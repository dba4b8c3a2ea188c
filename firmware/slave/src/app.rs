//! Start of the slave: board, node, tasks.

use board::Spec;
use ecss_can::prelude::*;
use ecss_can_runtime::Irqs;
use ecss_can_stm32f4::{DIAGNOSTICS, supervised};
use embassy_executor::Spawner;
use mission::PROFILE;
use mission::application::slave::{Application, Node, pulses_per_second};

type Board = ecss_can_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Node> = Resources::new();

ecss_can_runtime::node_tasks!(fn spawn_node(Board, Node));
ecss_can_runtime::pulse_task!(fn spawn_pulses(Board, Node, pulses_per_second));

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = ecss_can_stm32f4::start::<Spec>();
    let timing = const { ecss_can_stm32f4::bit_timing(&PROFILE.network) };
    let board = Board::new(board::take!(p), timing, Irqs);
    // ECSS 6.10f: without a Node-ID the controllers stay in Init mode and do not even acknowledge.
    let id = match board.node_id {
        Ok(id) => id,
        Err(error) => return defmt::error!("no Node-ID by straps and store: {}, staying silent", error),
    };
    defmt::info!("slave {} starts, profile {=str}", id.get(), PROFILE.name);
    let slave = || mission::slave(id, PROFILE, board.memory).hardware(board.hardware).build();
    let (slave, events, runners) = RESOURCES.start(slave, board.connection, &DIAGNOSTICS);
    spawn_node(spawner, runners);
    spawn_pulses(spawner, board.pulse, slave);
    supervised("application", Application::new(slave, events, board.leds).run()).await
}
