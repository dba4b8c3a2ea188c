//! A world of the demonstration mission: its nodes with the applications of the images.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::rc::Rc;

use can_twin::wire::time::Time;
use ecss_can::node::minimal::MinimalSlave;
use ecss_can::node::{Master, Refusal, SlaveEvent};
use ecss_can::pdo::Sequence;
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::redundancy::{MasterBoards, OneBoard, Strap};
use ecss_can::runner::extend::WholeNode;
use ecss_can::runner::{EventSource, MasterHandle};
use ecss_can::types::{Instant, NodeId};
use ecss_can_worlds::task::Task;
use ecss_can_worlds::{Builder, Events, Handle, MockBoard, NodeKey, World, idle};
use mission::application::master::Cables;
use mission::application::{master, minimal, slave};
use mission::minimal::{MinimalMission, MissionDevice};
use mission::{
    COMMAND_PERIOD, Command, CommanderObjects, Message, REQUEST, Request, SlaveRecord, TELECOMMAND,
};

use crate::indicators::IndicatorLog;

pub type MissionMaster<B = OneBoard> = Master<CommanderObjects, B>;
pub type MissionSlave = slave::Node;

/// Bytes of a slave's data store.
const STORE: usize = 24 * 1024;

/// Reaction of a slave's application to a telecommand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reaction {
    Executed(Command),
    /// Dropped a command with this code that repeats the last one.
    Repeated(u16),
    /// Refused a message that is no command of this mission.
    Unknown(u16),
}

/// Reactions of all slaves, in the order of time.
type Reactions = Rc<RefCell<Vec<(Time, NodeId, Reaction)>>>;

/// A world with the mission's nodes.
pub struct MissionWorld {
    world: World,
    reactions: Reactions,
    indicators: IndicatorLog,
    sequences: Rc<Sequences>,
}

impl Deref for MissionWorld {
    type Target = World;

    fn deref(&self) -> &World {
        &self.world
    }
}

impl DerefMut for MissionWorld {
    fn deref_mut(&mut self) -> &mut World {
        &mut self.world
    }
}

impl MissionWorld {
    /// Makes a world with the master and `slaves` slaves from Node-ID 2 on.
    pub fn new(profile: Profile, slaves: u8) -> MissionWorld {
        MissionWorld::of(profile, slaves, |world| world)
    }

    /// Makes this world with the clocks and power of `plan`.
    pub fn of(profile: Profile, slaves: u8, plan: impl FnOnce(Builder) -> Builder) -> MissionWorld {
        MissionWorld::with(profile, slaves, false, plan)
    }

    /// Makes this world with the application of the master, which sends each slave a command and a request once per
    /// period of the mission.
    pub fn busy(profile: Profile, slaves: u8, plan: impl FnOnce(Builder) -> Builder) -> MissionWorld {
        MissionWorld::with(profile, slaves, true, plan)
    }

    /// Makes this world with the minimal slaves of the profile after the full ones.
    pub fn mixed(profile: Profile, slaves: u8, plan: impl FnOnce(Builder) -> Builder) -> MissionWorld {
        MissionWorld::with_indicators(profile, slaves, true, |world, indicators| {
            plan(with_minimal(world, &profile, indicators))
        })
    }

    fn with(
        profile: Profile,
        slaves: u8,
        is_busy: bool,
        plan: impl FnOnce(Builder) -> Builder,
    ) -> MissionWorld {
        MissionWorld::with_indicators(profile, slaves, is_busy, |world, _| plan(world))
    }

    fn with_indicators(
        profile: Profile,
        slaves: u8,
        is_busy: bool,
        plan: impl FnOnce(Builder, &IndicatorLog) -> Builder,
    ) -> MissionWorld {
        let (reactions, indicators, sequences) =
            (Reactions::default(), IndicatorLog::default(), Rc::<Sequences>::default());
        let ids: Vec<NodeId> = (2..=slaves + 1).map(|raw| NodeId::new(raw).unwrap()).collect();
        let node = move |_: MockBoard| mission::master(&profile).build();
        let world = if is_busy {
            let shown = indicators.clone();
            World::builder().master(node, move |master, events| {
                master_application(master, events, shown.clone(), profile.minimal)
            })
        } else {
            let numbers = sequences.clone();
            World::builder().master(node, move |master, events| {
                numbers.restart();
                idle(master, events)
            })
        };
        let world = with_slaves(world, profile, ids, &reactions, &indicators);
        MissionWorld { world: plan(world, &indicators).build(), reactions, indicators, sequences }
    }

    /// Makes a world with two master boards and their applications, `slaves` slaves from Node-ID 2 on, and the minimal
    /// slaves of the profile.
    pub fn pair(profile: Profile, slaves: u8, plan: impl FnOnce(Builder) -> Builder) -> MissionWorld {
        let (reactions, indicators) = (Reactions::default(), IndicatorLog::default());
        let ids: Vec<NodeId> = (2..=slaves + 1).map(|raw| NodeId::new(raw).unwrap()).collect();
        let of_two = |strap| move |_: MockBoard| mission::master(&profile).one_of_two(strap).build();
        let [first, second] = [indicators.clone(), IndicatorLog::default()].map(|indicators| {
            move |master, events| master_application(master, events, indicators.clone(), profile.minimal)
        });
        let world = World::builder().master(of_two(Strap::Prime), first);
        let world = world.board(NodeKey::SECOND_MASTER, of_two(Strap::Second), second);
        let world =
            with_minimal(with_slaves(world, profile, ids, &reactions, &indicators), &profile, &indicators);
        MissionWorld { world: plan(world).build(), reactions, indicators, sequences: Rc::default() }
    }

    /// Returns the indicators of a full slave or of the first master board.
    pub fn indicators(&self, node: NodeId) -> crate::indicators::Shown {
        self.indicators.shown(node)
    }

    /// Returns the reactions of a slave's application so far.
    pub fn reactions(&self, node: NodeId) -> Vec<(Time, Reaction)> {
        let reactions = self.reactions.borrow();
        reactions.iter().filter(|(_, id, _)| *id == node).map(|(at, _, reaction)| (*at, *reaction)).collect()
    }

    /// Sends a telecommand. The master must be on for longer than a command's lifetime.
    pub fn command(&self, node: NodeId, command: Command) -> Result<(), Refusal> {
        let master: Handle<MissionMaster> = self.world.master();
        let message = self.sequences.encode(node, command, master.now()).unwrap();
        master.send_to(node, TELECOMMAND, message.telecommand())
    }

    /// Requests telemetry.
    pub fn ask(&self, node: NodeId, request: Request) -> Result<(), Refusal> {
        let master: Handle<MissionMaster> = self.world.master();
        master.send_to(node, REQUEST, request.encode().values())
    }

    /// Starts an operation of the master's application on its node.
    pub fn on_master<T: 'static, F: Future<Output = T> + 'static>(
        &self,
        work: impl FnOnce(Handle<MissionMaster>) -> F,
    ) -> Task<T> {
        self.world.spawn(NodeId::MASTER, work(self.world.master()))
    }

    /// Starts an operation of a slave's application on its node.
    pub fn on_slave<T: 'static, F: Future<Output = T> + 'static>(
        &self,
        node: NodeId,
        work: impl FnOnce(Handle<MissionSlave>) -> F,
    ) -> Task<T> {
        self.world.spawn(node, work(self.world.slave(node)))
    }

    /// Calls `look` with the master.
    pub fn master<R>(&self, look: impl FnOnce(&mut MissionMaster) -> R) -> R {
        self.world.master().with(|master, _| look(master))
    }

    /// Calls `look` with a slave.
    pub fn slave<R>(&self, node: NodeId, look: impl FnOnce(&mut MissionSlave) -> R) -> R {
        self.world.slave(node).with(|slave, _| look(slave))
    }
}

fn with_slaves(
    world: Builder,
    profile: Profile,
    ids: Vec<NodeId>,
    reactions: &Reactions,
    indicators: &IndicatorLog,
) -> Builder {
    ids.into_iter().fold(world, |world, id| {
        let (reactions, indicators) = (reactions.clone(), indicators.clone());
        world.slave(
            id,
            move |board| {
                let slave = mission::slave(board.node_id, &profile, vec![0; STORE].leak());
                slave.retained(board.hardware.retained.expect("RAM that outlives a reset")).build()
            },
            move |slave, events| slave_application(slave, events, id, indicators.clone(), reactions.clone()),
        )
    })
}

/// Adds the minimal slaves of a profile.
fn with_minimal(world: Builder, profile: &Profile, indicators: &IndicatorLog) -> Builder {
    profile.minimal.iter().fold(world, |world, minimal| {
        let (id, profile, indicators) = (minimal.node, *profile, indicators.clone());
        let node = move |board: MockBoard| {
            MinimalSlave::builder(board.node_id, &profile, MinimalMission::new()).build()
        };
        world.board(id, node, move |slave, events| minimal_application(slave, events, id, indicators.clone()))
    })
}

/// Numbers the commands of a master since its power-on.
#[derive(Default)]
struct Sequences(RefCell<BTreeMap<NodeId, Sequence>>);

impl Sequences {
    /// Restarts the numbers at a power-on, which is zero on the master's clock.
    fn restart(&self) {
        self.0.borrow_mut().clear();
    }

    /// Encodes a command that is sent now. `None`: a slave might take it for a repeat, because the power-on was too
    /// recent.
    fn encode(&self, node: NodeId, command: Command, now: Instant) -> Option<Message> {
        let mut slaves = self.0.borrow_mut();
        let sequence = slaves.entry(node).or_insert_with(|| Sequence::new(Instant::ZERO, COMMAND_PERIOD));
        sequence.step(now).map(|sequence| command.encode(sequence))
    }
}

/// The application of the image of the master, with its task for cables.
pub async fn master_application<B: MasterBoards>(
    master: Handle<MissionMaster<B>>,
    events: Events<MissionMaster<B>>,
    indicators: IndicatorLog,
    minimal: &'static [MinimalNode],
) {
    let cables: &Cables = Box::leak(Box::default());
    let indicators = indicators.of(NodeId::MASTER, events.reset_line());
    let application = master::Application::new(master, events, indicators, cables, minimal);
    futures_util::future::join(application.run(), cables.run(master)).await;
}

/// The application of the image of a minimal slave.
pub async fn minimal_application<D: MissionDevice>(
    slave: Handle<MinimalSlave<D>>,
    events: Events<MinimalSlave<D>>,
    id: NodeId,
    indicators: IndicatorLog,
) {
    let indicators = indicators.of(id, events.reset_line());
    minimal::Application::new(slave, events, indicators).run().await;
}

/// The application of the image of a slave. Records its reaction to each telecommand.
async fn slave_application(
    slave: Handle<MissionSlave>,
    events: Events<MissionSlave>,
    id: NodeId,
    indicators: IndicatorLog,
    reactions: Reactions,
) {
    let last = Rc::new(Cell::new(None));
    let indicators = indicators.of(id, events.reset_line());
    let events = Watched { events, last: last.clone() };
    let mut application = slave::Application::new(slave, events, indicators);
    loop {
        let before = *application.record();
        application.step().await;
        let Some((at, SlaveEvent::Pdo(pdo))) = last.take() else { continue };
        if pdo.is(TELECOMMAND) {
            let message = Message::from_payload(&pdo.data).expect("the node takes no shorter one");
            reactions.borrow_mut().push((at, id, reaction(&before, application.record(), &message)));
        }
    }
}

/// Derives the reaction to a telecommand from the record of an application.
fn reaction(before: &SlaveRecord, after: &SlaveRecord, message: &Message) -> Reaction {
    if after.commands.repeats() > before.commands.repeats() {
        return Reaction::Repeated(message.code());
    }
    match Command::decode(message) {
        Some(Command::ResetCounters) if after.executed == 0 => Reaction::Executed(Command::ResetCounters),
        Some(command) if after.executed == before.executed + 1 => Reaction::Executed(command),
        _ => Reaction::Unknown(message.code()),
    }
}

/// Events of a slave, and the last one that its application handled.
struct Watched {
    events: Events<MissionSlave>,
    last: Rc<Cell<Option<(Time, SlaveEvent)>>>,
}

impl EventSource for Watched {
    type Event = SlaveEvent;

    async fn next(&mut self) -> SlaveEvent {
        let event = self.events.next().await;
        self.last.set(Some((self.events.world_time(), event)));
        event
    }
}
