//! A slave: its redundancy, fed with what its program took from its controllers.

mod surroundings;

use ecss_can::heartbeat::NodeControl;
use ecss_can::link::port::Health;
use ecss_can::profile::Profile;
use ecss_can::redundancy::{Parameters, Retained, SlaveRedundancy};
use ecss_can::types::{Bus, Duration, Frame, Instant, NmtState, NodeId, earliest};

use crate::machine::{Machine, Produced};
pub use surroundings::RESET;
use surroundings::{Memory, Surroundings};

/// A slave with parallel access.
pub struct Slave {
    profile: Profile,
    id: NodeId,
    pattern: u32,
    redundancy: SlaveRedundancy,
    memory: Memory,
    produced: Vec<Produced>,
}

impl Slave {
    /// Makes a slave before its first power-on. `pattern`: its late heartbeats.
    pub fn new(id: NodeId, profile: &Profile, pattern: u32) -> Slave {
        let parameters = profile.redundancy();
        let memory = Memory::new(control(id, profile, pattern), parameters);
        let redundancy =
            SlaveRedundancy::new(profile.access(id), parameters, Retained::default(), profile.grace);
        Slave { profile: *profile, id, pattern, redundancy, memory, produced: Vec::new() }
    }

    fn step(&mut self, now: Instant, step: impl FnOnce(&mut SlaveRedundancy, &mut Surroundings)) {
        let (memory, produced) = (&mut self.memory, &mut self.produced);
        step(&mut self.redundancy, &mut Surroundings { memory, produced, now });
    }
}

fn control(id: NodeId, profile: &Profile, pattern: u32) -> NodeControl {
    let mut control = NodeControl::new(id, profile.heartbeat, profile.late_heartbeat, profile.autostart);
    control.set_pattern(pattern);
    control
}

impl Machine for Slave {
    fn lose_power(&mut self) {
        self.memory.retained = Retained::default();
    }

    fn start_delay(&self) -> Duration {
        Duration::from_micros(335)
    }

    fn start(&mut self, now: Instant) {
        let stored = Parameters { bdefault: self.memory.stored, ..self.profile.redundancy() };
        let access = self.profile.access(self.id);
        self.redundancy = SlaveRedundancy::new(access, stored, self.memory.retained, self.profile.grace);
        self.memory.restart(control(self.id, &self.profile, self.pattern), self.redundancy.selected());
        let bus = self.redundancy.selected();
        self.step(now, |redundancy, node| {
            node.log(format!("active bus: {bus:?} (PowerOn)"));
            redundancy.boot(now, node);
        });
        self.poll(now);
    }

    fn poll(&mut self, now: Instant) {
        // A slave that waits for the reset of its chip does nothing.
        if self.state() == NmtState::Initialising {
            return;
        }
        self.step(now, |redundancy, node| redundancy.poll(now, now, node));
        if let Some(heartbeat) = self.memory.control.poll(now) {
            let bus = self.redundancy.selected();
            self.produced.push(Produced::frame(now, bus, heartbeat));
        }
    }

    fn deadline(&self) -> Option<Instant> {
        if self.state() == NmtState::Initialising {
            return None;
        }
        earliest(&[self.redundancy.deadline(), self.memory.control.deadline()])
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.memory.received[bus] = self.memory.received[bus].wrapping_add(1);
        self.poll(now);
        self.step(now, |redundancy, node| {
            redundancy.on_frame(bus, frame, now, now, node);
        });
    }

    fn on_sent(&mut self, _: Bus, frame: &Frame, now: Instant) {
        self.memory.control.on_sent(frame);
        self.redundancy.on_sent(frame, now, self.id);
    }

    fn on_aborted(&mut self, _: Bus, frame: &Frame, _: Instant) {
        self.redundancy.on_end(frame);
    }

    fn on_requested(&mut self, _: Bus, _: &Frame, _: Instant) {}

    fn on_health(&mut self, _: Bus, _: Health, _: Instant) {}

    fn bus(&self) -> Option<Bus> {
        Some(self.redundancy.selected())
    }

    fn state(&self) -> NmtState {
        self.memory.control.state()
    }

    fn is_of_machine(&self, line: &str) -> bool {
        let states = ["Stopped", "Operational", "PreOperational", RESET];
        let beginnings = ["active bus: ", "master missed on ", "search given up", "Bdefault "];
        states.contains(&line)
            || beginnings.iter().any(|beginning| line.starts_with(beginning))
            || line.contains("another node with this Node-ID")
            || line.contains("the other node with this Node-ID")
            || line.ends_with(" ignored: the master is not heard")
    }

    fn take_produced(&mut self) -> Vec<Produced> {
        std::mem::take(&mut self.produced)
    }
}
