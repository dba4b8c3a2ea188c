//! Nodes of the demonstration mission in a world of the host, and what their applications do.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use ecss_can::boot::{AssignedSlave, Expected, Setting};
use ecss_can::node::{Device, Master, MasterEvent, Slave, SlaveEvent};
use ecss_can::pdo::Sequence;
use ecss_can::profile::Profile;
use ecss_can::redundancy::{Broken, MasterBoards, Role, Strap};
use ecss_can::types::{Address, Bus, Instant, NodeId};
use host_worlds::{Events, Handle, NodeKey, Time, World};
use judge::Bounds;
use mission::{
    COMMAND_PERIOD, Command, CommanderObjects, Message, MissionObjects, SlaveRecord, TELECOMMAND_RPDO,
};

use crate::rule::Rule;
use crate::script::{SELECTIVE, Script};

/// A slave without data store.
pub type CampaignSlave = Slave<MissionObjects<Vec<u8>>>;
type CampaignMaster<B> = Master<CommanderObjects, B>;

/// Slaves that the master configures in a script with `assigned`.
const ASSIGNED: [NodeId; 3] = [NodeId::of::<2>(), NodeId::of::<3>(), NodeId::of::<4>()];
/// Error behaviour (1029h), and the value that the master writes there.
const SETTING: Address = Address::new(0x1029, 1);
const SET: u8 = 1;

/// All slaves have parallel access.
const PARALLEL: Profile = mission::STANDARD;
const MIXED: Profile = Profile { selective: &[SELECTIVE], ..PARALLEL };
/// As these, with slaves 2 to 4 assigned and configured by the master.
const PARALLEL_ASSIGNED: Profile = assigned(PARALLEL);
const MIXED_ASSIGNED: Profile = assigned(MIXED);
/// All of these, with two master boards.
static PAIRS: [Profile; 4] = [pair(PARALLEL), pair(MIXED), pair(PARALLEL_ASSIGNED), pair(MIXED_ASSIGNED)];

const _: () = assert!(pair(PARALLEL).is_standby_sound(), "{}", Profile::STANDBY_UNSOUND);

const fn pair(profile: Profile) -> Profile {
    Profile { standby: Some(Profile::PAIR), ..profile }
}

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

/// Commands of one life of a master: their values begin at a multiple of it.
const LIFE: u32 = 1 << 16;
/// From its making a command may wait for its bus as long as the profile allows, and for its bus task.
const SLACK: Time = Time::from_ms(5);

/// A command that a slave executed.
#[derive(Clone, Copy, Debug)]
pub struct Execution {
    /// When.
    pub at: Time,
    /// By whom.
    pub node: NodeId,
    /// Rises with every command to this slave, also over resets of a master. No two masters give the same one.
    pub value: u32,
}

/// What the applications know of each other.
#[derive(Default)]
pub struct Notes {
    /// In the order of time.
    pub executions: RefCell<Vec<Execution>>,
    /// Where one of two masters became active, the next one first.
    pub takeovers: RefCell<VecDeque<Bus>>,
    /// Power-ons of the masters.
    lives: RefCell<Vec<NodeKey>>,
}

impl Notes {
    /// Who made a command, and when by its clock; `None` in another life of it.
    pub fn made(&self, value: u32) -> Option<(NodeKey, Instant)> {
        let lives = self.lives.borrow();
        let index = life(value).checked_sub(1)? as usize;
        let key = *lives.get(index)?;
        let is_this_life = !lives[index + 1..].contains(&key);
        is_this_life.then(|| (key, Instant::ZERO + COMMAND_PERIOD.times(value % LIFE)))
    }

    /// A master begins another life. First value of its commands.
    fn begin(&self, key: NodeKey) -> u32 {
        let mut lives = self.lives.borrow_mut();
        lives.push(key);
        lives.len() as u32 * LIFE
    }
}

/// Number of the life of a master that made a command, from 1.
pub fn life(value: u32) -> u32 {
    value / LIFE
}

/// The profile of a script.
pub fn profile(script: &Script) -> &'static Profile {
    let one = match (script.selective, script.assigned) {
        (false, false) => &PARALLEL,
        (true, false) => &MIXED,
        (false, true) => &PARALLEL_ASSIGNED,
        (true, true) => &MIXED_ASSIGNED,
    };
    let nth = usize::from(script.selective) + 2 * usize::from(script.assigned);
    if script.masters == 1 { one } else { &PAIRS[nth] }
}

/// How long a rule may not hold after the last fault of a script.
pub fn bounds(script: &Script) -> Bounds {
    let profile = profile(script);
    Bounds::new(&profile.redundancy(), profile.dwell, &profile.standby.unwrap_or(Profile::PAIR))
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

/// One master or two, each commands all slaves each period while it is active, and the slaves. `broken`: a rule that does
/// not hold.
pub fn world(script: &Script, broken: Option<Rule>) -> (World, Rc<Notes>) {
    let of_core = broken.and_then(Rule::of_core);
    let (notes, profile) = (Rc::<Notes>::default(), profile(script));
    let ids: Vec<NodeId> = script.nodes().collect();
    let mut builder = if script.masters == 1 {
        let (all, theirs) = (ids.clone(), notes.clone());
        World::builder().master(
            move |_| unruly(mission::master(profile, None), of_core),
            move |master, events| command(master, events, NodeKey::MASTER, all.clone(), theirs.clone()),
        )
    } else {
        let [first, second] = [NodeKey::MASTER, NodeKey::SECOND_MASTER].map(|key| {
            let (all, theirs) = (ids.clone(), notes.clone());
            move |master, events| command(master, events, key, all.clone(), theirs.clone())
        });
        let of_two = move |strap| unruly(mission::master_of_two(profile, strap, None), of_core);
        let both = World::builder().master(move |_| of_two(Strap::Prime), first);
        both.second_master(move |_| of_two(Strap::Second), second)
    };
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

fn unruly<D: Device, B: MasterBoards>(mut master: Master<D, B>, broken: Option<Broken>) -> Master<D, B> {
    master.break_rule(broken);
    master
}

/// The application of a master.
async fn command<B: MasterBoards>(
    master: Handle<CampaignMaster<B>>,
    mut events: Events<CampaignMaster<B>>,
    key: NodeKey,
    slaves: Vec<NodeId>,
    notes: Rc<Notes>,
) {
    let first = notes.begin(key);
    let begin =
        |now| -> Vec<Sequence> { slaves.iter().map(|_| Sequence::new(now, COMMAND_PERIOD)).collect() };
    let sequences = RefCell::new(begin(Instant::ZERO));
    let watch = async {
        loop {
            let MasterEvent::Role(change) = events.next().await else { continue };
            if change.role == Role::Active {
                let active = master.with(|master, now| master.status(now).active);
                notes.takeovers.borrow_mut().push_back(active);
                *sequences.borrow_mut() = begin(master.now());
            }
        }
    };
    let traffic = async {
        let mut due = Instant::ZERO;
        for round in 1.. {
            due += COMMAND_PERIOD;
            master.wait_until(due).await;
            for (&node, sequence) in slaves.iter().zip(&mut *sequences.borrow_mut()) {
                if let Some(sequence) = sequence.step(master.now()) {
                    let message = Command::SetValue(first + round).encode(sequence);
                    // One that is not Operational has to do without.
                    let _ = master.with(|master, now| mission::command(master, node, &message, now));
                }
            }
        }
    };
    futures_util::future::join(watch, traffic).await;
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
                    notes.executions.borrow_mut().push(Execution { at: events.world_time(), node, value });
                }
            }
            SlaveEvent::ResetNode => events.reset(),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given a fault late in a run of any profile. Then the run goes on for as long as recovery may take.
    #[test]
    fn a_run_leaves_time_for_every_recovery() {
        for masters in [1, 2] {
            for options in ["", " selective=1", " assigned=1"] {
                let text = format!("run masters={masters} slaves=3{options}\ncut at=50000000 place=3\n");
                let script: Script = text.parse().unwrap();
                let left = script.shortest_length() - 50_000_000;
                assert!(left > bounds(&script).service.as_micros(), "{text}{left} us");
            }
        }
    }
}
