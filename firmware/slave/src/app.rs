//! Start of the slave: board, node, tasks.

use board::Spec;
use boards_runtime::Irqs;
use boards_stm32f4::{TELLTALE, supervised};
use ecss_can::prelude::*;
use ecss_can::store::identity::MAINTENANCE;
use embassy_executor::Spawner;
use mission::PROFILE;

use crate::application::{Application, Board, Node, pulses};

static RESOURCES: Resources<Board, Node> = Resources::new();

boards_runtime::node_tasks!(Board, Node);

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards_stm32f4::start::<Spec>();
    let Board {
        ports,
        clock,
        pulse,
        leds,
        node_id,
        store,
        retained,
        post_mortem,
        memory,
        is_maintenance,
        ..
    } = Board::new(board::take!(p), const { boards_stm32f4::bit_timing(&PROFILE.network) }, Irqs);
    let node_id = if is_maintenance { Ok(MAINTENANCE) } else { node_id };
    // ECSS 6.10f: without a Node-ID the controllers stay in Init mode and do not even acknowledge.
    let Ok(id) = node_id
        .inspect_err(|error| defmt::error!("no Node-ID by straps and store: {}, staying silent", error))
    else {
        return;
    };
    defmt::info!("slave {} starts, profile {=str}", id.get(), PROFILE.name);
    let slave = || {
        let slave = mission::slave(id, PROFILE, memory).with_late_heartbeats(Board::late_heartbeats());
        if is_maintenance {
            slave.in_maintenance(store)
        } else {
            let slave = slave.with_retained(retained);
            if let Some(store) = store { slave.with_store(store) } else { slave }
        }
    };
    let (slave, events, runners) = RESOURCES.start(slave, ports, clock, &TELLTALE);
    slave.with(|slave, _| slave.set_post_mortem(post_mortem));
    spawn_node(spawner, runners);
    spawner.spawn(pulses(pulse, slave).unwrap());
    supervised("application", Application::new(slave, events, leds).run()).await
}
