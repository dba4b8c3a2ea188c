//! The master of these tests: for each of slaves 2 to 9 a command, a request, telemetry and its local time.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Communication, Device, DeviceNode as _, Identity, Master, Refusal};
use ecss_can::od::{Objects, U56};
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, Rpdo, Tpdo};
use ecss_can::profile::Profile;
use ecss_can::redundancy::MasterBoards;
use ecss_can::store::ParameterStore;
use ecss_can::time::{LocalScet, ScetGet};
use ecss_can::types::{Instant, NodeId};

pub const SLAVES: usize = 8;
const FIRST: u8 = 2;

/// Slots of the first transmit PDOs of commands and requests. Slot 0 is the spacecraft time.
pub const COMMANDS: usize = 1;
const REQUESTS: usize = COMMANDS + SLAVES;
/// Slot of the first receive PDO of telemetry. Before it are local times.
pub const TELEMETRY: usize = SLAVES;

const TPDOS: [Tpdo; REQUESTS + SLAVES] = {
    let time = Pdo::<()>::new(CobIdOf::fixed(0x181))
        .map(LocalScet::SCET_GET.field(ScetGet::FINE))
        .map(LocalScet::SCET_GET.field(ScetGet::COARSE))
        .transmit(1);
    let mut all = [time; REQUESTS + SLAVES];
    let mut nth = 0;
    while nth < SLAVES {
        let (node, sub) = (FIRST as u16 + nth as u16, nth as u8 + 1);
        all[COMMANDS + nth] = Pdo::<()>::new(CobIdOf::fixed(0x300 + node))
            .map(Console::COMMANDS.sub(sub))
            .transmit((COMMANDS + nth) as u16 + 1);
        all[REQUESTS + nth] = Pdo::<()>::new(CobIdOf::fixed(0x400 + node))
            .map(Console::REQUESTS.sub(sub))
            .transmit((REQUESTS + nth) as u16 + 1);
        nth += 1;
    }
    all
};

const RPDOS: [Rpdo; TELEMETRY + SLAVES] = {
    let mut all = [Pdo::<()>::new(CobIdOf::fixed(0x182)).map(Console::LOCAL_TIMES.sub(1)).receive(1);
        TELEMETRY + SLAVES];
    let mut nth = 0;
    while nth < SLAVES {
        let (node, sub) = (FIRST as u16 + nth as u16, nth as u8 + 1);
        all[nth] = Pdo::<()>::new(CobIdOf::fixed(0x180 + node))
            .map(Console::LOCAL_TIMES.sub(sub))
            .receive(nth as u16 + 1);
        all[TELEMETRY + nth] = Pdo::<()>::new(CobIdOf::fixed(0x380 + node))
            .map(Console::TELEMETRY.sub(sub))
            .receive((TELEMETRY + nth) as u16 + 1);
        nth += 1;
    }
    all
};

#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
pub struct Console {
    /// Commands
    #[object(0x6200, array, ro, pdo)]
    pub commands: [u64; SLAVES],
    /// Requests
    #[object(0x6240, array, ro, pdo)]
    pub requests: [u64; SLAVES],
    /// Telemetry
    #[object(0x6280, array, rww, pdo)]
    pub telemetry: [u64; SLAVES],
    /// Local times
    #[object(0x62C0, array, rww, pdo)]
    pub local_times: [U56; SLAVES],
}

impl Device for Console {
    type Pdos = PdoObjects<{ RPDOS.len() }, { TPDOS.len() }>;
    type Consumers = HeartbeatConsumers<SLAVES>;

    const PDOS: PdoSet = PdoSet::new(&RPDOS, &TPDOS);

    fn communication(id: NodeId) -> Communication {
        Communication {
            device_name: "Console",
            identity: Identity { vendor: 0, product: 0x5015, revision: 1 << 16, serial: 1 },
            ..Communication::new(id)
        }
    }

    fn consumers(_: NodeId) -> Self::Consumers {
        let nodes = core::array::from_fn(|nth| (u32::from(FIRST) + nth as u32) << 16);
        HeartbeatConsumers { consumer_heartbeat: nodes }
    }
}

pub fn master(profile: &Profile) -> Master<Console> {
    Master::builder(profile, Console::default()).build()
}

/// The same with a parameter store.
pub fn master_with(profile: &Profile, store: &'static mut (dyn ParameterStore + Send)) -> Master<Console> {
    Master::builder(profile, Console::default()).store(store).build()
}

/// Sends a command of these bytes to one of slaves 2 to 9.
pub fn command<B: MasterBoards>(
    master: &mut Master<Console, B>,
    node: NodeId,
    message: [u8; 8],
    now: Instant,
) -> Result<(), Refusal> {
    let nth = usize::from(node.get() - FIRST);
    let set = |console: &mut Console| console.commands[nth] = u64::from_le_bytes(message);
    send(master, node, COMMANDS + nth, now, set)
}

/// Sends a request of these bytes to one of slaves 2 to 9.
pub fn request(
    master: &mut Master<Console>,
    node: NodeId,
    message: [u8; 8],
    now: Instant,
) -> Result<(), Refusal> {
    let nth = usize::from(node.get() - FIRST);
    let set = |console: &mut Console| console.requests[nth] = u64::from_le_bytes(message);
    send(master, node, REQUESTS + nth, now, set)
}

/// Sends a transmit PDO that is for one slave.
fn send<B: MasterBoards>(
    master: &mut Master<Console, B>,
    node: NodeId,
    number: usize,
    now: Instant,
    set: impl FnOnce(&mut Console),
) -> Result<(), Refusal> {
    if !master.may_command(node) {
        return Err(Refusal::NotOperational);
    }
    master.send_pdo(number, now)?;
    master.change(now, set);
    Ok(())
}
