//! The test applications: what firmware does above its node.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::rc::Rc;

use can_wire::time::Time;
use ecss_can::nmt::NodeId;
use ecss_can::node::{Master, MasterEvent, MasterRequest, Slave, SlaveEvent};
use ecss_can::pdo::Message;
use ecss_can::profile::Profile;
use ecss_can::profile::mission::{
    Command, MissionObjects, REQUEST_RPDO, Request, SlaveRecord, TELECOMMAND_RPDO, TELEMETRY_TPDO,
};
use ecss_can::runner::{AppLink, NodeCell};
use ecss_can::time::{Clock, Instant};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;

use crate::clock::MockClock;
use crate::log::{Entry, Happening};
use crate::timeline::Timeline;

pub(crate) type MasterApp = AppLink<NoopRawMutex, MasterEvent, MasterRequest>;
pub(crate) type SlaveApp = AppLink<NoopRawMutex, SlaveEvent, Infallible>;
/// The node of a master, as its task and its application share it.
pub type MasterCell = NodeCell<NoopRawMutex, Master>;
/// The node of a slave, as its task and its application share it.
pub type SlaveCell = NodeCell<NoopRawMutex, Slave<MissionObjects<Vec<u8>>>>;

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

/// Listens to the master.
pub(crate) async fn master(app: Rc<MasterApp>, diary: Diary) {
    loop {
        diary.note(Happening::Master(app.events.receive().await));
    }
}

/// A command and a telemetry request to each slave, every period of the mission.
pub(crate) async fn traffic(app: Rc<MasterApp>, clock: MockClock, slaves: Vec<NodeId>, profile: Profile) {
    let mut round = 0_u32;
    let mut due = Instant::ZERO;
    loop {
        due += profile.command;
        clock.at(due).await;
        round += 1;
        for &node in &slaves {
            let message = Command::SetValue(round).encode();
            app.requests.send(MasterRequest::Command { node, message }).await;
            let message = Request::Value.encode();
            app.requests.send(MasterRequest::RequestTelemetry { node, message }).await;
        }
    }
}

/// Executes commands and answers telemetry requests; sets `reset` when the chip is to be reset.
pub(crate) async fn slave(
    app: Rc<SlaveApp>,
    node: Rc<SlaveCell>,
    clock: MockClock,
    diary: Diary,
    reset: Rc<Cell<bool>>,
) {
    let mut record = SlaveRecord::default();
    loop {
        let event = app.events.receive().await;
        diary.note(Happening::Slave(event));
        match event {
            SlaveEvent::Pdo { number, data, .. } => {
                let message = Message::from_payload(&data).expect("eight bytes");
                match usize::from(number) {
                    TELECOMMAND_RPDO => execute(&node, &diary, &mut record, message),
                    REQUEST_RPDO => answer(&node, &clock, &diary, &record, message),
                    _ => {}
                }
            }
            SlaveEvent::Sync { stamp, .. } => record.stamp_source = Some(stamp.source),
            SlaveEvent::ResetNode => reset.set(true),
            _ => {}
        }
    }
}

fn execute(node: &SlaveCell, diary: &Diary, record: &mut SlaveRecord, message: Message) {
    let Some(command) = Command::decode(&message) else {
        return diary.note(Happening::Unknown(message.code()));
    };
    record.execute(command);
    diary.note(Happening::Executed(command));
    if command == Command::ResetCounters {
        node.with(Slave::reset_counters);
    }
}

fn answer(node: &SlaveCell, clock: &MockClock, diary: &Diary, record: &SlaveRecord, message: Message) {
    let Some(request) = Request::decode(&message) else {
        return diary.note(Happening::Unknown(message.code()));
    };
    let now = clock.now();
    node.with(|slave| {
        let telemetry = record.answer(request, &slave.status(now)).encode();
        slave.objects_mut().application.telemetry = telemetry.into();
        slave.send_pdo(TELEMETRY_TPDO, now);
    });
}
