//! Board, tasks, and the application: gives the thermometer its table and checks that it keeps it.

use boards::{Board, Port, TELLTALE, Uptime};
use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::link::bit_timing::BitTiming;
use ecss_can::link::port::CanPort;
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::{Device, Master, MasterEvent, MasterRequest};
use ecss_can::od::Objects;
use ecss_can::pdo::{PdoObjects, PdoSet};
use ecss_can::runner::{AppLink, NodeCell, SdoClient, bus_task, node_task};
use ecss_can::sdo::Error;
use ecss_can::types::{Address, Bus, NmtState, NodeId};
use embassy_executor::Spawner;
use embassy_futures::join::join;
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex as Raw;
use embassy_sync::once_lock::OnceLock;
use embassy_sync::signal::Signal;
use thermometer::{PROFILE, Thermometer};

const BIT_TIMING: BitTiming = boards::bit_timing(&PROFILE.network);
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

type Node = NodeCell<Raw, Master<Ground>>;

static NODE: OnceLock<Node> = OnceLock::new();
static LINK: AppLink<Raw, MasterEvent, MasterRequest> = AppLink::new();
/// A thermometer is operational.
static READY: Signal<Raw, NodeId> = Signal::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards::start();
    let Board { mut ports, .. } = Board::new(boards::take!(p), BIT_TIMING);
    let node = NODE.get_or_init(|| NodeCell::new(Master::new(&PROFILE, Ground::default())));
    let filters = node.with(|master| master.filters());
    Bus::ALL.into_iter().for_each(|bus| ports[bus].set_filters(&filters));
    spawner.spawn(bus(Bus::Nominal, ports.nominal, node).expect("spawned once"));
    spawner.spawn(bus(Bus::Redundant, ports.redundant, node).expect("spawned once"));
    spawner.spawn(due(node).expect("spawned once"));
    join(listen(), calibrate(SdoClient::new(node))).await;
}

async fn listen() {
    loop {
        match LINK.events.receive().await {
            MasterEvent::SlaveState { node, state, .. } => {
                defmt::info!("slave {}: {}", node.get(), state);
                if state == NmtState::Operational {
                    READY.signal(node);
                }
            }
            MasterEvent::BusSwitched { to, .. } => defmt::warn!("active bus: {}", to),
            _ => {}
        }
    }
}

async fn calibrate(client: SdoClient<'_, Raw, Ground>) {
    let node = READY.wait().await;
    let command = NmtMessage { command: Command::ResetNode, target: Target::Node(node) };
    if let Err(error) = write_table(&client, node).await {
        return defmt::error!("no table: {}", error);
    }
    defmt::info!("table saved, resetting the thermometer");
    READY.reset();
    LINK.requests.send(MasterRequest::Nmt(command)).await;
    let node = READY.wait().await;
    match is_kept(&client, node).await {
        Ok(true) => defmt::info!("the table has survived the reset"),
        Ok(false) => defmt::error!("the table is not what was written"),
        Err(error) => defmt::error!("no answer: {}", error),
    }
}

/// By block transfer, then "save"; from now on the thermometer corrects by it.
async fn write_table(client: &SdoClient<'_, Raw, Ground>, node: NodeId) -> Result<(), Error> {
    let mut bytes = table();
    client.download_from(node, TABLE, 2048, |part| part.fill_with(|| bytes.next().unwrap_or(0))).await?;
    client.write(node, MODE, &[1]).await?;
    client.write(node, SAVE_ALL, b"save").await
}

async fn is_kept(client: &SdoClient<'_, Raw, Ground>, node: NodeId) -> Result<bool, Error> {
    let (mut bytes, mut same) = (table(), true);
    client
        .upload_to(node, TABLE, 2048, |part| same &= part.iter().all(|byte| bytes.next() == Some(*byte)))
        .await?;
    Ok(same && bytes.next().is_none())
}

/// 1024 corrections: a tenth of a degree more every 64 entries.
fn table() -> impl Iterator<Item = u8> {
    (0_i16..1024).flat_map(|entry| (entry / 64).to_le_bytes())
}

#[embassy_executor::task(pool_size = 2)]
async fn bus(bus: Bus, port: Port, node: &'static Node) -> ! {
    match bus_task(bus, port, Uptime, node, &LINK, &TELLTALE).await {}
}

#[embassy_executor::task]
async fn due(node: &'static Node) -> ! {
    match node_task(node, Uptime, &LINK, &TELLTALE).await {}
}
