//! What surrounds the slave: frames in, commands and events out, as the runner does it.

use std::hint::black_box;

use anyhow::ensure;
use ecss_can::heartbeat;
use ecss_can::link::Stamp;
use ecss_can::link::machine::Outgoing;
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::extend::{BusCommand, LinkEvent, Outbox, Turn};
use ecss_can::node::{DeviceNode, Node, Slave, SlaveEvent, Status};
use ecss_can::od::Domain;
use ecss_can::pdo::{Mapping, PdoMapping};
use ecss_can::profile::Profile;
use ecss_can::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId};

use crate::objects::{Application, BLOCK, NODE};

/// From frame to frame: a busy bus at 1 Mbit/s.
const PAUSE: Duration = Duration::from_micros(100);

/// The slave and the end of the bus that it sees.
pub struct Harness<M: Mapping = PdoMapping, const SCATTERED: bool = false> {
    pub slave: Slave<Application<M, SCATTERED>>,
    out: Outbox<SlaveEvent>,
    now: Instant,
    /// When the master's heartbeat is due.
    beat: Instant,
    /// COB-ID of what is waited for.
    awaited: CobId,
    /// How many of these came, and the last.
    pub answers: u32,
    pub answer: Frame,
}

impl<M: Mapping, const SCATTERED: bool> Harness<M, SCATTERED> {
    /// An operational slave. Frames with `awaited` are counted.
    pub fn new(awaited: CobId) -> anyhow::Result<Self> {
        let application = Application { block: Domain::new(vec![0; BLOCK]), ..Application::default() };
        let mut harness = Harness {
            slave: Slave::builder(NODE, &Profile::DEFAULT, application).build(),
            out: Outbox::new(),
            now: Instant::ZERO,
            beat: Instant::ZERO,
            awaited,
            answers: 0,
            answer: heartbeat::encode(NODE, NmtState::Stopped),
        };
        harness.slave.start(&mut Turn::new(harness.now, &mut harness.out));
        // A slave serves SDO when its boot-up message has left.
        while let Some((bus, command)) = harness.out.pop_command() {
            if let BusCommand::Send(Outgoing { frame, .. }) = command {
                let sent = LinkEvent::Transmitted { frame, stamp: Stamp::interrupt(harness.now) };
                harness.slave.on_link(bus, &sent, &mut Turn::new(harness.now, &mut harness.out));
            }
        }
        harness.receive(NmtMessage { command: Command::Start, target: Target::All }.encode());
        let state = harness.status().state;
        ensure!(state == NmtState::Operational, "the slave is {state:?}");
        Ok(harness)
    }

    /// The slave as it is now.
    pub fn status(&self) -> Status {
        self.slave.status(self.now)
    }

    /// The application changes its objects.
    pub fn change(&mut self, change: impl FnOnce(&mut Application<M, SCATTERED>)) {
        self.slave.change(self.now, change);
    }

    /// A frame comes in; with it, ten times a second, a heartbeat of the master.
    #[inline(always)]
    pub fn receive(&mut self, frame: Frame) {
        self.now += PAUSE;
        if self.now >= self.beat {
            self.beat();
        }
        self.handle(frame);
    }

    #[inline(never)]
    fn beat(&mut self) {
        self.beat = self.now + Profile::DEFAULT.heartbeat;
        self.handle(heartbeat::encode(NodeId::MASTER, NmtState::Operational));
    }

    #[inline(always)]
    fn handle(&mut self, frame: Frame) {
        let stamp = Stamp::interrupt(self.now);
        self.slave.on_received(
            Bus::Nominal,
            black_box(&frame),
            black_box(&stamp),
            &mut Turn::new(self.now, &mut self.out),
        );
        while let Some(event) = self.out.pop_event() {
            black_box(&event);
        }
        while let Some((_, command)) = self.out.pop_command() {
            if let BusCommand::Send(outgoing) = &command
                && outgoing.frame.id() == self.awaited
            {
                (self.answers, self.answer) = (self.answers + 1, outgoing.frame);
            }
        }
    }
}
