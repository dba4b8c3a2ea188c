//! The test applications: what firmware does above its node.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use can_wire::time::Time;
use ecss_can::link::Bus;
use ecss_can::nmt::NodeId;
use ecss_can::node::{MasterEvent, MasterRequest, SlaveEvent, SlaveRequest};
use ecss_can::pdo::Message;
use ecss_can::profile::Profile;
use ecss_can::profile::mission::{Command, Request, SlaveRecord};
use ecss_can::runner::AppLink;
use ecss_can::time::{Clock, Instant};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;

use crate::clock::MockClock;
use crate::log::{Entry, Happening};
use crate::timeline::Timeline;

pub(crate) type MasterApp = AppLink<NoopRawMutex, MasterEvent, MasterRequest>;
pub(crate) type SlaveApp = AppLink<NoopRawMutex, SlaveEvent, SlaveRequest>;

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
pub(crate) async fn slave(app: Rc<SlaveApp>, diary: Diary, reset: Rc<Cell<bool>>) {
    let mut record = SlaveRecord::default();
    loop {
        let event = app.events.receive().await;
        diary.note(Happening::Slave(event));
        match event {
            SlaveEvent::Command { message, .. } => match Command::decode(&message) {
                Some(command) => {
                    record.execute(command);
                    diary.note(Happening::Executed(command));
                    if command == Command::ResetCounters {
                        app.requests.send(SlaveRequest::ResetCounters).await;
                    }
                }
                None => diary.note(Happening::Unknown(message.code())),
            },
            SlaveEvent::TelemetryRequested { bus, request } => {
                answer(&app, &diary, &record, bus, request).await;
            }
            SlaveEvent::Sync { stamp, .. } => record.stamp_source = Some(stamp.source),
            SlaveEvent::ResetNode => reset.set(true),
            _ => {}
        }
    }
}

async fn answer(app: &SlaveApp, diary: &Diary, record: &SlaveRecord, bus: Bus, message: Message) {
    match Request::decode(&message) {
        Some(request) => {
            let status = app.status().expect("a node that asks has shown its status");
            let message = record.answer(request, &status).encode();
            app.requests.send(SlaveRequest::Telemetry { bus, message }).await;
        }
        None => diary.note(Happening::Unknown(message.code())),
    }
}
