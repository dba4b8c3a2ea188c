//! Board, tasks, and the application: gives the thermometer its table and checks that it keeps it.

use boards::{Board, TELLTALE};
use ecss_can::nmt::Command;
use ecss_can::prelude::*;
use ecss_can::sdo::Error;
use embassy_executor::Spawner;
use embassy_futures::join::join;
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex as Raw;
use embassy_sync::signal::Signal;
use static_cell::StaticCell;
use thermometer::{PROFILE, Thermometer};

const NODE: NodeId = NodeId::of::<3>();
const TABLE: Address = Thermometer::<&mut [u8]>::TABLE.address();
const MODE: Address = Thermometer::<&mut [u8]>::MODE.address();
const SAVE_ALL: Address = Address::new(0x1010, 1);

/// It has no objects of its own.
#[derive(Objects)]
#[objects(device)]
struct Ground {}

impl Device for Ground {
    type Pdos = PdoObjects<0, 0>;
    type Consumers = HeartbeatConsumers<8>;

    const PDOS: PdoSet = PdoSet::NONE;
}

type Node = Master<Ground>;

static RESOURCES: StaticCell<Resources<Board, Node>> = StaticCell::new();
/// The thermometer is operational.
static READY: Signal<Raw, ()> = Signal::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards::start();
    let board = Board::new(boards::take!(p), const { boards::bit_timing(&PROFILE.network) });
    let node = || {
        Resources::new(
            Master::new(&PROFILE, Ground::default(), board.store),
            board.ports,
            board.clock,
            &TELLTALE,
        )
    };
    let (master, events, runners) = RESOURCES.init_with(node).start();
    spawner.spawn(bus(runners.nominal).expect("spawned once"));
    spawner.spawn(bus(runners.redundant).expect("spawned once"));
    spawner.spawn(due(runners.due).expect("spawned once"));
    join(listen(events), calibrate(master)).await;
}

async fn listen(mut events: Events<'_, Board, Node>) {
    loop {
        match events.next().await {
            MasterEvent::SlaveState { node, state, .. } => {
                defmt::info!("slave {}: {}", node.get(), state);
                if (node, state) == (NODE, NmtState::Operational) {
                    READY.signal(());
                }
            }
            MasterEvent::BusSwitched { to, .. } => defmt::warn!("active bus: {}", to),
            _ => {}
        }
    }
}

async fn calibrate(master: Handle<'_, Board, Node>) {
    READY.wait().await;
    let command = NmtMessage { command: Command::ResetNode, target: Target::Node(NODE) };
    if let Err(error) = write_table(master.sdo()).await {
        return defmt::error!("no table: {}", error);
    }
    defmt::info!("table saved, resetting the thermometer");
    READY.reset();
    master.request(MasterRequest::Nmt(command));
    READY.wait().await;
    match is_kept(master.sdo()).await {
        Ok(true) => defmt::info!("the table has survived the reset"),
        Ok(false) => defmt::error!("the table is not what was written"),
        Err(error) => defmt::error!("no answer: {}", error),
    }
}

/// By block transfer, then "save"; from now on the thermometer corrects by it.
async fn write_table(client: SdoClient<'_, Board, Ground>) -> Result<(), Error> {
    let mut bytes = table();
    client.download_from(NODE, TABLE, 2048, |part| part.fill_with(|| bytes.next().unwrap_or(0))).await?;
    client.write(NODE, MODE, &[1]).await?;
    client.write(NODE, SAVE_ALL, b"save").await
}

async fn is_kept(client: SdoClient<'_, Board, Ground>) -> Result<bool, Error> {
    let (mut bytes, mut same) = (table(), true);
    client
        .upload_to(NODE, TABLE, 2048, |part| same &= part.iter().all(|byte| bytes.next() == Some(*byte)))
        .await?;
    Ok(same && bytes.next().is_none())
}

/// 1024 corrections: a tenth of a degree more every 64 entries.
fn table() -> impl Iterator<Item = u8> {
    (0_i16..1024).flat_map(|entry| (entry / 64).to_le_bytes())
}

#[embassy_executor::task(pool_size = 2)]
async fn bus(runner: BusRunner<'static, Board, Node>) -> ! {
    runner.run().await
}

#[embassy_executor::task]
async fn due(runner: DueRunner<'static, Board, Node>) -> ! {
    runner.run().await
}
