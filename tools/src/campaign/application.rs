//! Applications of the nodes of a world.
//!
//! A slave runs the application of its image. The master runs one that numbers its commands over all power-ons of all
//! masters. The number shows which master made a command and when, and whether a slave has executed it before. Commands
//! of the shipped master have no such number.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use can_twin::wire::time::Time;
use ecss_can::emcy::{DeviceError, ErrorCode};
use ecss_can::node::{Master, MasterEvent, SlaveEvent};
use ecss_can::pdo::Sequence;
use ecss_can::redundancy::{MasterBoards, Role};
use ecss_can::runner::{EventSource, MasterHandle};
use ecss_can::types::{Duration, Instant, NodeId};
use ecss_can_worlds::{Events, Handle, NodeKey, ResetLine};
use fastrand::Rng;
use mission::application::slave;
use mission::{COMMAND_PERIOD, Command, CommanderObjects, Indicators, TELECOMMAND};

use crate::campaign::notes::{Execution, Notes};

/// Index of the sequence in the bytes of a command.
const SEQUENCE: usize = 7;

/// Sends commands to all slaves in each period while its master is active.
pub async fn master<B: MasterBoards>(
    master: Handle<Master<CommanderObjects, B>>,
    mut events: Events<Master<CommanderObjects, B>>,
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
            notes.set_active(key, change.role == Role::Active);
            if change.role == Role::Active {
                notes.takeovers.borrow_mut().push_back(master.status().active);
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
                    // Refused for a slave that is not Operational.
                    let _ = master.send_to(node, TELECOMMAND, message.telecommand());
                }
            }
        }
    };
    futures_util::future::join(watch, traffic).await;
}

/// Runs the application of a slave's image and records the commands that it executes. Also raises the errors of `plan`.
/// `repeats`: a command that CAN delivers twice gets another sequence the second time.
pub async fn slave(
    node: Handle<slave::Node>,
    events: Events<slave::Node>,
    id: NodeId,
    notes: Rc<Notes>,
    repeats: bool,
    plan: Errors,
) {
    let begin = events.world_time();
    let work = serve(node, events, id, notes.clone(), repeats);
    futures_util::future::join(work, plan.raise(node, id, notes, begin)).await;
}

/// Raises and clears an error of a slave, each time after 20 to 600 ms.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Seed of the times.
    pub seed: u64,
    /// End of the changes.
    pub until: Time,
}

impl Errors {
    /// Error that is raised and cleared.
    pub const ERROR: DeviceError = DeviceError::new(ErrorCode::TEMPERATURE_DEVICE, 1);

    async fn raise(self, node: Handle<slave::Node>, id: NodeId, notes: Rc<Notes>, begin: Time) {
        let mut rng = Rng::with_seed(self.seed ^ u64::from(id.get()) ^ begin.0);
        let left = Duration::from_micros(self.until.since(begin).as_us());
        let (mut due, mut is_there) = (Instant::ZERO, false);
        loop {
            notes.errors.borrow_mut().insert(id, is_there);
            due += Duration::from_millis(rng.u64(20..600));
            if begin >= self.until || due.since(Instant::ZERO) >= left {
                return;
            }
            node.wait_until(due).await;
            is_there = !is_there;
            if is_there {
                node.raise(Self::ERROR, [0; 4]);
            } else {
                node.clear(Self::ERROR);
            }
        }
    }
}

async fn serve(
    node: Handle<slave::Node>,
    events: Events<slave::Node>,
    id: NodeId,
    notes: Rc<Notes>,
    repeats: bool,
) {
    let (reset, at) = (Reset(events.reset_line()), Rc::<Cell<Time>>::default());
    let events = Observed { events, at: at.clone(), sequence: repeats.then_some(0) };
    let mut application = slave::Application::new(node, events, reset);
    loop {
        let before = application.record().executed;
        application.step().await;
        let after = application.record();
        if after.executed != before {
            notes.executions.borrow_mut().push(Execution { at: at.get(), node: id, value: after.value });
        }
    }
}

/// Events of a slave, and the instant at which its application took the last one.
struct Observed {
    events: Events<slave::Node>,
    at: Rc<Cell<Time>>,
    /// Sequence of the last command, if every command has to seem new.
    sequence: Option<u8>,
}

impl EventSource for Observed {
    type Event = SlaveEvent;

    async fn next(&mut self) -> SlaveEvent {
        let mut event = self.events.next().await;
        self.at.set(self.events.world_time());
        if let SlaveEvent::Pdo(pdo) = &mut event
            && pdo.is(TELECOMMAND)
            && let Some(last) = &mut self.sequence
        {
            *last = last.wrapping_add(1);
            pdo.data[SEQUENCE] = *last;
        }
        event
    }
}

/// Indicators of which only the reset has an effect.
struct Reset(ResetLine);

impl Indicators for Reset {
    fn sync(&mut self) {}

    fn heartbeat(&mut self) {}

    fn time(&mut self) {}

    fn state(&mut self, _on: bool) {}

    fn reset(&mut self) {
        self.0.reset();
    }
}
