//! A whole slave between two buses.

use ecss_can::link::Stamp;
use ecss_can::node::extend::{BusCommand, LinkEvent, Outbox, Turn};
use ecss_can::node::{Node, Slave, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::types::{Bus, CobId, Duration, Frame, Instant, NodeId};

use super::device::{self, Instrument};

/// The node.
pub const ID: NodeId = NodeId::of::<5>();

pub type TestSlave = Slave<Instrument>;

/// Number of switches of a search, small so that searches end.
const NTOGGLE: u8 = 2;

/// Returns the profile for a byte: whether the slave starts by itself, and its access to the buses.
pub fn profile(options: u8) -> Profile {
    let selective: &[_] = if options & 2 != 0 { &[ID] } else { &[] };
    Profile { autostart: options & 1 != 0, selective, ntoggle: NTOGGLE, ..Profile::DEFAULT }
}

/// The slave, the time, and the slave's outputs of the last step.
pub struct Bench {
    pub slave: TestSlave,
    pub now: Instant,
    pub sent: Vec<(Bus, Frame)>,
    pub events: Vec<SlaveEvent>,
}

impl Bench {
    /// Makes a bench with a powered slave.
    pub fn new(profile: &Profile) -> Bench {
        let slave = device::slave(ID, profile);
        let mut bench = Bench { slave, now: Instant::from_micros(1_000), sent: vec![], events: vec![] };
        bench.step(|slave, turn| slave.start(turn));
        bench
    }

    /// Acknowledges the boot-up message. Before that a slave answers no request.
    pub fn acknowledge_boot_up(&mut self) {
        let event =
            LinkEvent::Transmitted { frame: frame(0x705, 1, [0; 8]), stamp: Stamp::interrupt(self.now) };
        let bus = self.slave.status(self.now).active;
        self.step(|slave, turn| slave.on_link(bus, &event, turn));
    }

    /// Runs one step. Its frames fit into an outbox.
    pub fn step(&mut self, step: impl FnOnce(&mut TestSlave, &mut Turn<'_, SlaveEvent>)) {
        let mut out = Outbox::new();
        self.sent.clear();
        self.events.clear();
        step(&mut self.slave, &mut Turn::new(self.now, &mut out));
        while let Some((bus, command)) = out.pop_command() {
            if let BusCommand::Send(outgoing) = command {
                if outgoing.is_expired(self.now) {
                    // A synchronous PDO after its window: its bus counts it as expired.
                    assert!(self.slave.objects().communication.sync.window > 0, "stale at once");
                } else {
                    self.sent.push((bus, outgoing.frame));
                }
            }
        }
        while let Some(event) = out.pop_event() {
            self.events.push(event);
        }
        assert_eq!(out.take_overflows(), 0, "more than an outbox holds: {:?} {:?}", self.sent, self.events);
    }

    /// Does the actions that are due now.
    pub fn poll(&mut self) {
        self.step(|slave, turn| slave.poll(turn));
        assert!(self.slave.deadline().is_none_or(|due| due > self.now), "a deadline of the past");
    }

    /// Receives a frame that ended now.
    pub fn receive(&mut self, bus: Bus, frame: Frame) {
        let stamp = Stamp::interrupt(self.now);
        self.step(|slave, turn| slave.on_link(bus, &LinkEvent::Received { frame, stamp }, turn));
    }

    /// Lets time pass, and calls `see` after each step.
    pub fn wait(&mut self, span: Duration, mut see: impl FnMut(&Bench)) {
        let until = self.now + span;
        while let Some(due) = self.slave.deadline().filter(|due| *due <= until) {
            self.now = due.max(self.now);
            self.poll();
            see(self);
        }
        self.now = until;
    }
}

/// Makes a frame of up to eight bytes.
pub fn frame(id: u16, dlc: u8, data: [u8; 8]) -> Frame {
    let id = CobId::new(id & 0x7FF).expect("11 bits");
    Frame::new(id, &data[..usize::from(dlc.min(8))]).expect("at most eight bytes")
}

/// Returns one of the buses.
pub const fn bus(byte: u8) -> Bus {
    if byte & 1 == 0 { Bus::Nominal } else { Bus::Redundant }
}
