//! The test applications: what firmware does above its node.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use can_wire::time::Time;
use ecss_can::node::{DeviceNode, Master, Slave, SlaveEvent};
use ecss_can::pdo::Sequence;
use ecss_can::runner::{Events, Handle};
use ecss_can::time::Clock;
use ecss_can::types::{Duration, Instant, NodeId};
use mission::{
    COMMAND_PERIOD, Command, CommanderObjects, Declined, Message, MissionObjects, REQUEST_RPDO, Request,
    SlaveRecord, TELECOMMAND_RPDO, TELEMETRY_TPDO,
};

use crate::board::Mock;
use crate::clock::MockClock;
use crate::log::{Entry, Happening};
use crate::timeline::Timeline;

/// The master of the mission.
pub type MissionMaster = Master<CommanderObjects>;
/// The slave of the mission, its data in memory of its own.
pub type MissionSlave = Slave<MissionObjects<Vec<u8>>>;
/// The master, for its application.
pub type MasterHandle = Handle<Mock, MissionMaster>;
/// A slave, for its application.
pub type SlaveHandle = Handle<Mock, MissionSlave>;

/// Where a node writes what happens to it.
#[derive(Clone)]
pub(crate) struct Diary {
    pub node: NodeId,
    pub timeline: Rc<Timeline>,
    pub entries: Rc<RefCell<Vec<Entry>>>,
}

impl Diary {
    pub fn note(&self, what: Happening) {
        self.entries.borrow_mut().push(Entry { at: self.now(), node: self.node, what });
    }

    fn now(&self) -> Time {
        self.timeline.now()
    }
}

/// Numbers the commands of a master since its power-on, for its application and for the hands of the test.
pub(crate) struct Sequences {
    clock: MockClock,
    start: Instant,
    lifetime: Duration,
    slaves: RefCell<BTreeMap<NodeId, Sequence>>,
}

impl Sequences {
    pub fn new(clock: MockClock, lifetime: Duration) -> Self {
        let start = clock.now();
        Sequences { clock, start, lifetime, slaves: RefCell::default() }
    }

    /// A command as it goes out now; `None` so soon after power-on that a slave might take it for a repeat.
    pub fn encode(&self, node: NodeId, command: Command) -> Option<Message> {
        let mut slaves = self.slaves.borrow_mut();
        let sequence = slaves.entry(node).or_insert_with(|| Sequence::new(self.start, self.lifetime));
        sequence.step(self.clock.now()).map(|sequence| command.encode(sequence))
    }
}

/// Listens to the master.
pub(crate) async fn master(mut events: Events<Mock, MissionMaster>, diary: Diary) {
    loop {
        diary.note(Happening::Master(events.next().await));
    }
}

/// A command and a telemetry request to each slave, every period of the mission.
pub(crate) async fn traffic(master: MasterHandle, slaves: Vec<NodeId>, sequences: Rc<Sequences>) {
    let mut round = 0_u32;
    let mut due = Instant::ZERO;
    loop {
        due += COMMAND_PERIOD;
        master.wait_until(due).await;
        round += 1;
        for &node in &slaves {
            if let Some(message) = sequences.encode(node, Command::SetValue(round)) {
                // One that is not Operational has to do without.
                let _ = master.with(|master, now| mission::command(master, node, &message, now));
            }
            let message = Request::Value.encode();
            let _ = master.with(|master, now| mission::request(master, node, &message, now));
        }
    }
}

/// Executes commands and answers telemetry requests; sets `reset` when the chip is to be reset.
pub(crate) async fn slave(
    slave: SlaveHandle,
    mut events: Events<Mock, MissionSlave>,
    diary: Diary,
    reset: Rc<Cell<bool>>,
) {
    let mut record = SlaveRecord::new();
    loop {
        let event = events.next().await;
        diary.note(Happening::Slave(event));
        match event {
            SlaveEvent::Pdo { number, data, .. } => {
                let message = Message::from_payload(&data).expect("eight bytes");
                match usize::from(number) {
                    TELECOMMAND_RPDO => execute(slave, &diary, &mut record, message),
                    REQUEST_RPDO => answer(slave, &diary, &record, message),
                    _ => {}
                }
            }
            SlaveEvent::Sync { stamp, .. } => record.stamp_source = Some(stamp.source),
            SlaveEvent::ResetNode => reset.set(true),
            _ => {}
        }
    }
}

fn execute(slave: SlaveHandle, diary: &Diary, record: &mut SlaveRecord, message: Message) {
    let command = match record.take(&message, slave.now()) {
        Ok(command) => command,
        Err(Declined::Repeat) => return diary.note(Happening::Repeated(message.code())),
        Err(Declined::Unknown) => return diary.note(Happening::Unknown(message.code())),
    };
    diary.note(Happening::Executed(command));
    match command {
        Command::ResetCounters => slave.with(|slave, _| slave.reset_counters()),
        // One with parallel access stays where it is.
        Command::SelectBus(bus) => _ = slave.with(|slave, _| slave.select_bus(bus)),
        _ => {}
    }
}

fn answer(slave: SlaveHandle, diary: &Diary, record: &SlaveRecord, message: Message) {
    let Some(request) = Request::decode(&message) else {
        return diary.note(Happening::Unknown(message.code()));
    };
    slave.with(|slave, now| {
        let telemetry = record.answer(request, &slave.status(now)).encode();
        slave.change(now, |objects| objects.telemetry = telemetry.into());
        slave.send_pdo(TELEMETRY_TPDO, now);
    });
}
