//! Nodes of the demonstration mission in a world of the host, and what their applications do.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use ecss_can::boot::{AssignedSlave, Expected, Setting};
use ecss_can::node::{Master, Slave, SlaveEvent};
use ecss_can::pdo::Sequence;
use ecss_can::profile::Profile;
use ecss_can::types::{Address, Instant, NodeId};
use host_worlds::{Events, Handle, Time, World, idle};
use mission::{
    COMMAND_PERIOD, Command, CommanderObjects, Message, MissionObjects, SlaveRecord, TELECOMMAND_RPDO,
};

use crate::broken::Rule;
use crate::script::Script;

/// A slave without data store.
pub type CampaignSlave = Slave<MissionObjects<Vec<u8>>>;
type CampaignMaster = Master<CommanderObjects>;

const FOUR: NodeId = NodeId::of::<4>();
/// Slaves that the master configures in a script with `assigned`.
const ASSIGNED: [NodeId; 3] = [NodeId::of::<2>(), NodeId::of::<3>(), FOUR];
/// Error behaviour (1029h), and the value that the master writes there.
const SETTING: Address = Address::new(0x1029, 1);
const SET: u8 = 1;

/// All slaves have parallel access.
const PARALLEL: Profile = mission::STANDARD;
/// Slave 4 has selective access.
const MIXED: Profile = Profile { selective: &[FOUR], ..PARALLEL };
/// As these, with slaves 2 to 4 assigned and configured by the master.
const PARALLEL_ASSIGNED: Profile = assigned(PARALLEL);
const MIXED_ASSIGNED: Profile = assigned(MIXED);

const fn assigned(profile: Profile) -> Profile {
    const fn slave(node: NodeId) -> AssignedSlave {
        let expected = Expected { device_type: 0, identity: [0, 0x5015, 0, 0], stamp: [12_321, 43_200_000] };
        AssignedSlave { node, mandatory: false, expected }
    }
    const fn setting(node: NodeId) -> Setting {
        Setting { node, at: SETTING, value: &[SET] }
    }
    Profile {
        slaves: const { &[slave(ASSIGNED[0]), slave(ASSIGNED[1]), slave(ASSIGNED[2])] },
        settings: const { &[setting(ASSIGNED[0]), setting(ASSIGNED[1]), setting(ASSIGNED[2])] },
        ..profile
    }
}

/// Commands of one life of the master: their values begin here.
const LIFE: u32 = 1 << 16;
/// From its making a command may wait for its bus as long as the profile allows, and for its bus task.
const SLACK: Time = Time::from_ms(5);

/// A command that a slave executed.
#[derive(Clone, Copy, Debug)]
pub struct Deed {
    /// When.
    pub at: Time,
    /// By whom.
    pub node: NodeId,
    /// Rises with every command to this slave, also over resets of the master.
    pub value: u32,
}

/// What the applications know of each other.
#[derive(Default)]
pub struct Notes {
    /// In the order of time.
    pub deeds: RefCell<Vec<Deed>>,
    /// Power-ons of the master.
    lives: Cell<u32>,
}

impl Notes {
    /// When a command was made, by the clock of the master; `None` in another life of it.
    pub fn made(&self, value: u32) -> Option<Instant> {
        let is_this_life = value / LIFE == self.lives.get();
        is_this_life.then(|| Instant::ZERO + COMMAND_PERIOD.times(value % LIFE))
    }
}

/// The profile of a script.
pub fn profile(script: &Script) -> &'static Profile {
    match (script.selective, script.assigned) {
        (false, false) => &PARALLEL,
        (true, false) => &MIXED,
        (false, true) => &PARALLEL_ASSIGNED,
        (true, true) => &MIXED_ASSIGNED,
    }
}

/// How long after its making a command may be executed.
pub fn lifetime(script: &Script) -> Time {
    Time::from_us(profile(script).event.as_micros()) + SLACK
}

/// Whether the master of a script configures this slave.
pub fn is_assigned(script: &Script, node: NodeId) -> bool {
    script.assigned && ASSIGNED.contains(&node)
}

/// Whether a slave has the value that the master writes.
pub fn is_configured(slave: &CampaignSlave) -> bool {
    slave.objects().communication.nmt.error_behaviour == [SET]
}

/// A master that commands all slaves each period, and its slaves. `broken`: a rule that does not hold.
pub fn world(script: &Script, broken: Option<Rule>) -> (World, Rc<Notes>) {
    let of_core = broken.and_then(Rule::of_core);
    let (notes, profile) = (Rc::<Notes>::default(), profile(script));
    let ids: Vec<NodeId> = (2..=script.slaves + 1).filter_map(NodeId::new).collect();
    let (all, theirs) = (ids.clone(), notes.clone());
    let mut builder = World::builder().master(
        move |_| {
            let mut master = mission::master(profile, None);
            master.break_rule(of_core);
            master
        },
        move |master, events| command(master, events, all.clone(), theirs.clone()),
    );
    for id in ids {
        let theirs = notes.clone();
        builder = builder.slave(
            id,
            move |board| {
                let slave = mission::slave(board.node_id, profile, Vec::new());
                let mut slave = slave.with_retained(board.retained).with_store(board.store);
                slave.break_rule(of_core);
                slave
            },
            move |slave, events| obey(slave, events, id, theirs.clone(), broken == Some(Rule::Repeats)),
        );
    }
    (builder.seed(script.seed).build(), notes)
}

/// The application of the master.
async fn command(
    master: Handle<CampaignMaster>,
    events: Events<CampaignMaster>,
    slaves: Vec<NodeId>,
    notes: Rc<Notes>,
) {
    notes.lives.set(notes.lives.get() + 1);
    let first = notes.lives.get() * LIFE;
    let mut sequences: Vec<Sequence> =
        slaves.iter().map(|_| Sequence::new(Instant::ZERO, COMMAND_PERIOD)).collect();
    let traffic = async {
        let mut due = Instant::ZERO;
        for round in 1.. {
            due += COMMAND_PERIOD;
            master.wait_until(due).await;
            for (&node, sequence) in slaves.iter().zip(&mut sequences) {
                if let Some(sequence) = sequence.step(master.now()) {
                    let message = Command::SetValue(first + round).encode(sequence);
                    // One that is not Operational has to do without.
                    let _ = master.with(|master, now| mission::command(master, node, &message, now));
                }
            }
        }
    };
    futures_util::future::join(idle(master, events), traffic).await;
}

/// The application of a slave: executes commands; `repeats`: also those that CAN delivers twice.
async fn obey(
    slave: Handle<CampaignSlave>,
    mut events: Events<CampaignSlave>,
    node: NodeId,
    notes: Rc<Notes>,
    repeats: bool,
) {
    let mut record = SlaveRecord::new();
    loop {
        match events.next().await {
            SlaveEvent::Pdo { number, data, .. } if usize::from(number) == TELECOMMAND_RPDO => {
                let Some(message) = Message::from_payload(&data) else { continue };
                if repeats {
                    record = SlaveRecord::new();
                }
                if let Ok(Command::SetValue(value)) = record.take(&message, slave.now()) {
                    notes.deeds.borrow_mut().push(Deed { at: events.world_time(), node, value });
                }
            }
            SlaveEvent::ResetNode => events.reset(),
            _ => {}
        }
    }
}
