//! The thermometer of `firmware/examples` without its sensor. After 3 s its buses are served no more: it sends nothing and is not
//! reset. It goes on acknowledging frames, which are lost when its queues are full.

use core::future::pending;

use board::Spec;
use boards_runtime::Irqs;
use boards_stm32f4::{TELLTALE, supervised};
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use embassy_futures::select::select;
use embassy_time::{Duration, Timer};
use thermometer::{PROFILE, Thermometer, slave};

/// From the start of the program.
const SPEAKS: Duration = Duration::from_secs(3);
/// Bytes of the table.
const TABLE: usize = 2048;

type Node = Slave<Thermometer>;

type Board = boards_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Node> = Resources::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards_stm32f4::start::<Spec>();
    let board = Board::new(board::take!(p), const { boards_stm32f4::bit_timing(&PROFILE.network) }, Irqs);
    let Ok(id) = board.node_id else { return defmt::error!("no valid Node-ID on the straps") };
    let (table, _) = board.memory.split_at_mut(TABLE);
    let (_, mut events, runners) = RESOURCES.start(|| slave(id, table), board.ports, board.clock, &TELLTALE);
    spawner.spawn(bus(runners.nominal).unwrap());
    spawner.spawn(bus(runners.redundant).unwrap());
    spawner.spawn(due(runners.due).unwrap());
    loop {
        events.next().await;
    }
}

#[embassy_executor::task(pool_size = 2)]
async fn bus(runner: BusRunner<Board, Node>) -> ! {
    supervised("bus", select(runner.run(), Timer::after(SPEAKS))).await;
    pending().await
}

#[embassy_executor::task]
fn due(runner: DueRunner<Board, Node>) -> impl Future<Output = ()> {
    supervised("due", runner.run())
}
