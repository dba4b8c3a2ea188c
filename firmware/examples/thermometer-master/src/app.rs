//! Board, tasks, and the application: gives the thermometer its table, checks that it keeps it, shows what it measures.

use board::Spec;
use boards_runtime::Irqs;
use boards_stm32f4::{DIAGNOSTICS, supervised};
use ecss_can::nmt::Command;
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use embassy_futures::join::join;
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex as Raw;
use embassy_sync::signal::Signal;
use thermometer::PROFILE;
use thermometer_master::{CHANGE, COMMAND, Ground, THERMOMETER, is_kept, write_table};

type Node = Master<Ground>;

type Board = boards_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Node> = Resources::new();

boards_runtime::node_tasks!(Board, Node);
/// The thermometer is operational.
static READY: Signal<Raw, ()> = Signal::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards_stm32f4::start::<Spec>();
    let Board { ports, clock, store, post_mortem, .. } =
        Board::new(board::take!(p), const { boards_stm32f4::bit_timing(&PROFILE.network) }, Irqs);
    let master = || Master::new(&PROFILE, Ground::default(), store);
    let (master, events, runners) = RESOURCES.start(master, ports, clock, &DIAGNOSTICS);
    master.with(|master, _| master.set_post_mortem(post_mortem));
    spawn_node(spawner, runners);
    supervised("application", join(listen(master, events), calibrate(master))).await;
}

async fn listen(master: Handle<Board, Node>, mut events: Events<Board, Node>) {
    loop {
        match events.next().await {
            MasterEvent::SlaveState { node: THERMOMETER, state: NmtState::Operational, .. } => {
                READY.signal(());
            }
            MasterEvent::Pdo { number, .. } if usize::from(number) == CHANGE.slot() => {
                master.with(|master, _| {
                    let Ground { temperature, alarm, .. } = &master.objects().application.device;
                    defmt::info!("{=i16} tenths of a degree, alarm {=u8}", *temperature, *alarm);
                });
            }
            MasterEvent::BusSwitched { to, .. } => defmt::warn!("active bus: {}", to),
            _ => {}
        }
    }
}

async fn calibrate(master: Handle<Board, Node>) {
    READY.wait().await;
    if let Err(error) = write_table(master.sdo()).await {
        return defmt::error!("no table: {}", error);
    }
    defmt::info!("table saved, resetting the thermometer");
    READY.reset();
    let reset = NmtMessage { command: Command::ResetNode, target: Target::Node(THERMOMETER) };
    master.request(MasterRequest::Nmt(reset));
    READY.wait().await;
    match is_kept(master.sdo()).await {
        Ok(true) => defmt::info!("the table has survived the reset"),
        Ok(false) => defmt::error!("the table is not what was written"),
        Err(error) => defmt::error!("no answer: {}", error),
    }
    let sent = master.with(|master, now| {
        master.send_pdo_to(THERMOMETER, COMMAND.slot(), now, |ground| ground.command = 1)
    });
    sent.unwrap_or_else(|refusal| defmt::warn!("no command: {}", refusal));
}
