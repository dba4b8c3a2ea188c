//! A world of the demonstration mission: its nodes, and what its images do above them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::rc::Rc;

use can_wire::time::Time;
use ecss_can::node::minimal::{MinimalSlave, Numbers};
use ecss_can::node::{DeviceNode, Master, MasterBoards, Refusal, Slave, SlaveEvent};
use ecss_can::pdo::Sequence;
use ecss_can::profile::Profile;
use ecss_can::redundancy::Strap;
use ecss_can::types::{Instant, NodeId};
use host_worlds::task::Task;
use host_worlds::{Builder, Events, Handle, World, idle};
use mission::minimal::MinimalMission;
use mission::{
    COMMAND_PERIOD, Command, CommanderObjects, Declined, Message, MissionObjects, REQUEST_RPDO, Request,
    SlaveRecord, TELECOMMAND_RPDO, TELEMETRY_TPDO,
};

pub type MissionMaster = Master<CommanderObjects>;
pub type MissionSlave = Slave<MissionObjects<Vec<u8>>>;

/// Bytes of a slave's data store.
const STORE: usize = 24 * 1024;

/// What the application of a slave did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deed {
    Executed(Command),
    /// Dropped a command with this code that repeats the last one.
    Repeated(u16),
    /// Got a message that is none of this mission.
    Unknown(u16),
}

/// Deeds of all slaves, in the order of time.
type Deeds = Rc<RefCell<Vec<(Time, NodeId, Deed)>>>;

/// A world with the mission's nodes.
pub struct Craft {
    world: World,
    deeds: Deeds,
    sequences: Rc<Sequences>,
}

impl Deref for Craft {
    type Target = World;

    fn deref(&self) -> &World {
        &self.world
    }
}

impl DerefMut for Craft {
    fn deref_mut(&mut self) -> &mut World {
        &mut self.world
    }
}

impl Craft {
    /// The master and slaves 2, 3, .., `slaves` of them.
    pub fn new(profile: Profile, slaves: u8) -> Craft {
        Craft::of(profile, slaves, |world| world)
    }

    /// The same, with clocks and power as `plan` has them.
    pub fn of(profile: Profile, slaves: u8, plan: impl FnOnce(Builder) -> Builder) -> Craft {
        Craft::with(profile, slaves, false, plan)
    }

    /// The same, where the master commands and asks every slave once per period of the mission.
    pub fn busy(profile: Profile, slaves: u8, plan: impl FnOnce(Builder) -> Builder) -> Craft {
        Craft::with(profile, slaves, true, plan)
    }

    /// The same with minimal slaves behind the full ones: those that the profile names.
    pub fn mixed(profile: Profile, slaves: u8, plan: impl FnOnce(Builder) -> Builder) -> Craft {
        Craft::with(profile, slaves, true, |world| {
            let minimal = profile.minimal.iter().map(|minimal| minimal.node);
            plan(minimal.fold(world, |world, id| {
                let numbers = Numbers::of(&profile, id);
                world.minimal(
                    id,
                    move |board| MinimalSlave::new(board.node_id, numbers, MinimalMission::new()),
                    idle,
                )
            }))
        })
    }

    fn with(profile: Profile, slaves: u8, is_busy: bool, plan: impl FnOnce(Builder) -> Builder) -> Craft {
        let (deeds, sequences) = (Deeds::default(), Rc::<Sequences>::default());
        let ids: Vec<NodeId> = (2..=slaves + 1).map(|raw| NodeId::new(raw).unwrap()).collect();
        let minimal = profile.minimal.iter().map(|minimal| minimal.node);
        let busy: Vec<NodeId> = if is_busy { ids.iter().copied().chain(minimal).collect() } else { vec![] };
        let numbers = sequences.clone();
        let world = World::builder().master(
            move |_| mission::master(&profile, None),
            move |master, events| command(master, events, busy.clone(), numbers.clone()),
        );
        let world = with_slaves(world, profile, ids, &deeds);
        Craft { world: plan(world).build(), deeds, sequences }
    }

    /// Two master boards and slaves 2, 3, .., `slaves` of them. Each master commands every slave once per period of the
    /// mission, while it is active.
    pub fn pair(profile: Profile, slaves: u8, plan: impl FnOnce(Builder) -> Builder) -> Craft {
        let deeds = Deeds::default();
        let ids: Vec<NodeId> = (2..=slaves + 1).map(|raw| NodeId::new(raw).unwrap()).collect();
        let (first, second) = (ids.clone(), ids.clone());
        let world = World::builder()
            .master(
                move |_| mission::master_of_two(&profile, Strap::Prime, None),
                move |master, events| command(master, events, first.clone(), Rc::default()),
            )
            .second_master(
                move |_| mission::master_of_two(&profile, Strap::Second, None),
                move |master, events| command(master, events, second.clone(), Rc::default()),
            );
        let world = with_slaves(world, profile, ids, &deeds);
        Craft { world: plan(world).build(), deeds, sequences: Rc::default() }
    }

    /// What the application of a slave did so far.
    pub fn deeds(&self, node: NodeId) -> Vec<(Time, Deed)> {
        let deeds = self.deeds.borrow();
        deeds.iter().filter(|(_, id, _)| *id == node).map(|(at, _, deed)| (*at, *deed)).collect()
    }

    /// Sends a telecommand. The master is on for longer than a command's lifetime.
    pub fn command(&self, node: NodeId, command: Command) -> Result<(), Refusal> {
        let master = self.world.master();
        let message = self.sequences.encode(node, command, master.now()).unwrap();
        master.with(|master, now| mission::command(master, node, &message, now))
    }

    /// Asks for telemetry.
    pub fn ask(&self, node: NodeId, request: Request) -> Result<(), Refusal> {
        self.world.master().with(|master, now| mission::request(master, node, &request.encode(), now))
    }

    /// The application of the master begins to do something with its node.
    pub fn on_master<T: 'static, F: Future<Output = T> + 'static>(
        &self,
        work: impl FnOnce(Handle<MissionMaster>) -> F,
    ) -> Task<T> {
        self.world.spawn(NodeId::MASTER, work(self.world.master()))
    }

    /// The application of a slave begins to do something with its node.
    pub fn on_slave<T: 'static, F: Future<Output = T> + 'static>(
        &self,
        node: NodeId,
        work: impl FnOnce(Handle<MissionSlave>) -> F,
    ) -> Task<T> {
        self.world.spawn(node, work(self.world.slave(node)))
    }

    /// Looks at the master.
    pub fn master<R>(&self, look: impl FnOnce(&mut MissionMaster) -> R) -> R {
        self.world.master().with(|master, _| look(master))
    }

    /// Looks at a slave.
    pub fn slave<R>(&self, node: NodeId, look: impl FnOnce(&mut MissionSlave) -> R) -> R {
        self.world.slave(node).with(|slave, _| look(slave))
    }
}

fn with_slaves(world: Builder, profile: Profile, ids: Vec<NodeId>, deeds: &Deeds) -> Builder {
    ids.into_iter().fold(world, |world, id| {
        let deeds = deeds.clone();
        world.slave(
            id,
            move |board| {
                mission::slave(board.node_id, &profile, vec![0; STORE]).with_retained(board.retained)
            },
            move |slave, events| obey(slave, events, id, deeds.clone()),
        )
    })
}

/// Numbers the commands of a master since its power-on.
#[derive(Default)]
struct Sequences(RefCell<BTreeMap<NodeId, Sequence>>);

impl Sequences {
    /// After a power-on, which is the zero of the master's clock.
    fn restart(&self) {
        self.0.borrow_mut().clear();
    }

    /// A command as it goes out now; `None` so soon after power-on that a slave might take it for a repeat.
    fn encode(&self, node: NodeId, command: Command, now: Instant) -> Option<Message> {
        let mut slaves = self.0.borrow_mut();
        let sequence = slaves.entry(node).or_insert_with(|| Sequence::new(Instant::ZERO, COMMAND_PERIOD));
        sequence.step(now).map(|sequence| command.encode(sequence))
    }
}

/// The application of the master: commands and asks all of `slaves`.
async fn command<B: MasterBoards>(
    master: Handle<Master<CommanderObjects, B>>,
    events: Events<Master<CommanderObjects, B>>,
    slaves: Vec<NodeId>,
    sequences: Rc<Sequences>,
) {
    sequences.restart();
    let traffic = async {
        let mut due = Instant::ZERO;
        for round in 1.. {
            due += COMMAND_PERIOD;
            master.wait_until(due).await;
            for &node in &slaves {
                turn(master, node, round, &sequences);
            }
        }
    };
    futures_util::future::join(idle(master, events), traffic).await;
}

/// One that is not Operational has to do without.
fn turn<B: MasterBoards>(
    master: Handle<Master<CommanderObjects, B>>,
    node: NodeId,
    round: u32,
    sequences: &Sequences,
) {
    if let Some(message) = sequences.encode(node, Command::SetValue(round), master.now()) {
        let _ = master.with(|master, now| mission::command(master, node, &message, now));
    }
    let message = Request::Value.encode();
    let _ = master.with(|master, now| mission::request(master, node, &message, now));
}

/// The application of a slave: executes commands, answers telemetry requests.
async fn obey(slave: Handle<MissionSlave>, mut events: Events<MissionSlave>, id: NodeId, deeds: Deeds) {
    let mut record = SlaveRecord::new();
    loop {
        match events.next().await {
            SlaveEvent::Pdo { number, data, .. } => {
                let message = Message::from_payload(&data).unwrap();
                let deed = match usize::from(number) {
                    TELECOMMAND_RPDO => Some(execute(slave, &mut record, message)),
                    REQUEST_RPDO => answer(slave, &record, message),
                    _ => None,
                };
                deeds.borrow_mut().extend(deed.map(|deed| (events.world_time(), id, deed)));
            }
            SlaveEvent::Sync { stamp, .. } => record.stamp_source = Some(stamp.source),
            SlaveEvent::ResetNode => events.reset(),
            _ => {}
        }
    }
}

fn execute(slave: Handle<MissionSlave>, record: &mut SlaveRecord, message: Message) -> Deed {
    match record.take(&message, slave.now()) {
        Ok(command) => {
            match command {
                Command::ResetCounters => slave.with(|slave, _| slave.reset_counters()),
                // One with parallel access stays where it is.
                Command::SelectBus(bus) => _ = slave.with(|slave, _| slave.select_bus(bus)),
                _ => {}
            }
            Deed::Executed(command)
        }
        Err(Declined::Repeat) => Deed::Repeated(message.code()),
        Err(Declined::Unknown) => Deed::Unknown(message.code()),
    }
}

fn answer(slave: Handle<MissionSlave>, record: &SlaveRecord, message: Message) -> Option<Deed> {
    let Some(request) = Request::decode(&message) else { return Some(Deed::Unknown(message.code())) };
    slave.with(|slave, now| {
        let telemetry = record.answer(request, &slave.status(now)).encode();
        slave.change(now, |objects| objects.telemetry = telemetry.into());
        slave.send_pdo(TELEMETRY_TPDO, now);
    });
    None
}
