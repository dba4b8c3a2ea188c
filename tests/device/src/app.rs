//! Start and tasks of the test device.

use board::Spec;
use boards_runtime::Irqs;
use boards_stm32f4::TELLTALE;
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use mission::PROFILE;
use test_device::TestObjects;

type Node = Slave<TestObjects>;

type Board = boards_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Node> = Resources::new();

boards_runtime::node_tasks!(Board, Node);

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards_stm32f4::start::<Spec>();
    let Board { ports, clock, node_id, store, retained, memory, .. } =
        Board::new(board::take!(p), const { boards_stm32f4::bit_timing(&PROFILE.network) }, Irqs);
    let Ok(id) = node_id else { return };
    let device = || test_device::device(id, PROFILE, memory).with_retained(retained).with_store(store);
    let (_, mut events, runners) = RESOURCES.start(device, ports, clock, &TELLTALE);
    spawn_node(spawner, runners);
    // Nothing follows an event but the reset that the master asks for.
    loop {
        if let SlaveEvent::ResetNode = events.next().await {
            boards_stm32f4::reset()
        }
    }
}
