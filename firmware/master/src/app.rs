//! Start of the master: board, node, tasks.

use board::Spec;
use ecss_can::prelude::*;
use ecss_can_runtime::Irqs;
use ecss_can_stm32f4::{DIAGNOSTICS, Leds, supervise, supervised};
use embassy_executor::Spawner;
use mission::application::master::{Application, Cables, pulses_per_second};
use mission::{Boards, PROFILE};

type Board = ecss_can_stm32f4::Board<Spec>;
type Node = mission::application::master::Node<Boards>;

/// Time within which the application has to take a turn of its schedule: ten periods.
const SCHEDULE: Duration = Duration::from_millis(1_000);

static RESOURCES: Resources<Board, Node> = Resources::new();
static CABLES: Cables = Cables::new();

ecss_can_runtime::node_tasks!(fn spawn_node(Board, Node));
ecss_can_runtime::pulse_task!(fn spawn_pulses(Board, Node, pulses_per_second));

#[embassy_executor::task]
fn cables(master: Handle<Board, Node>) -> impl Future<Output = ()> {
    supervised("cables", CABLES.run(master))
}

// A separate task: `main` has its deepest stack while it makes the master (row `size.pyboard-v11.master.stack`).
#[embassy_executor::task]
fn application(
    master: Handle<Board, Node>,
    events: Events<Board, Node>,
    leds: Leds,
) -> impl Future<Output = ()> {
    supervised("application", async move {
        let schedule = supervise("schedule", SCHEDULE);
        let note = |is_expected| if is_expected { schedule.done() } else { schedule.rest() };
        Application::new(master, events, leds, &CABLES, PROFILE.minimal).run_supervised(note).await
    })
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = ecss_can_stm32f4::start::<Spec>();
    let timing = const { ecss_can_stm32f4::bit_timing(&PROFILE.network) };
    let board = Board::new(board::take!(p), timing, Irqs);
    defmt::info!("master starts, profile {=str}", PROFILE.name);
    #[cfg(feature = "standby")]
    let Some(strap) = ecss_can_stm32f4::straps::master_board(board.straps) else {
        return defmt::error!("straps of neither master board, staying silent");
    };
    let master = || {
        let master = mission::master(PROFILE).hardware(board.hardware);
        #[cfg(feature = "standby")]
        let master = master.one_of_two(strap);
        master.build()
    };
    let (master, events, runners) = RESOURCES.start(master, board.connection, &DIAGNOSTICS);
    spawn_node(spawner, runners);
    spawn_pulses(spawner, board.pulse, master);
    spawner.spawn(cables(master).unwrap());
    spawner.spawn(application(master, events, board.leds).unwrap());
}
