//! A master: its redundancy, fed with what its program took from its controllers.
//!
//! The boot-up process, the watch for two slaves with one Node-ID and the watch for babbling slaves give the redundancy
//! inputs. They are the machines of flight, too, and run along.

mod actions;
mod boot;
mod health;
mod received;

use std::collections::BTreeSet;

use ecss_can::link::port::Health;
use ecss_can::nmt::StateClashes;
use ecss_can::profile::Profile;
use ecss_can::redundancy::{Babblers, MasterRedundancy, MasterSetup, Strap, TwoBoards};
use ecss_can::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, earliest};

use crate::machine::{Machine, Produced};
use boot::BootProcess;
use health::Controllers;

/// A master with parallel access.
pub struct Master {
    profile: &'static Profile,
    strap: Option<Strap>,
    /// Slaves that its 1016h names.
    monitored: Vec<NodeId>,
    redundancy: MasterRedundancy<TwoBoards>,
    boot: BootProcess,
    clashes: StateClashes,
    babblers: Babblers,
    controllers: Controllers,
    /// Those that are neither acknowledged nor given up, the oldest first.
    heartbeats: Vec<Heartbeat>,
    /// Errors that were reported and are not gone: error code, source.
    errors: BTreeSet<(u16, u8)>,
    produced: Vec<Produced>,
}

/// Heartbeat that waits for its acknowledgement.
#[derive(Clone, Copy, Debug)]
struct Heartbeat {
    bus: Bus,
    expires: Instant,
    /// It is in a mailbox.
    is_requested: bool,
}

impl Master {
    /// Makes a master before its first power-on. `monitored`: slaves that its 1016h names.
    pub fn new(strap: Option<Strap>, profile: &'static Profile, monitored: Vec<NodeId>) -> Master {
        let dwell = profile.redundancy().dwell(profile.dwell);
        Master {
            profile,
            strap,
            monitored,
            redundancy: redundancy(strap, profile),
            boot: BootProcess::new(profile),
            clashes: StateClashes::default(),
            babblers: Babblers::new(profile.budget.heard, dwell),
            controllers: Controllers::new(profile.bus_off),
            heartbeats: Vec::new(),
            errors: BTreeSet::new(),
            produced: Vec::new(),
        }
    }

    fn log(&mut self, now: Instant, line: String) {
        self.produced.push(Produced::line(now, line));
    }

    fn raise(&mut self, now: Instant, error: (u16, u8)) {
        if self.errors.insert(error) {
            self.produced.push(Produced::emergency(now, error));
        }
    }

    /// Returns the place of the oldest heartbeat of a bus that is requested, or not.
    fn heartbeat(&self, bus: Bus, is_requested: bool) -> Option<usize> {
        self.heartbeats.iter().position(|one| one.bus == bus && one.is_requested == is_requested)
    }

    /// Entries of 1016h, with the consumer time of the profile.
    fn consumers(&self) -> Vec<u32> {
        let time = self.profile.consumer.as_millis() as u32;
        self.monitored.iter().map(|node| u32::from(node.get()) << 16 | time).collect()
    }
}

fn redundancy(strap: Option<Strap>, profile: &Profile) -> MasterRedundancy<TwoBoards> {
    let setup = MasterSetup {
        parameters: profile.master_redundancy(),
        silent_share: profile.silent_share,
        dwell: profile.dwell,
        grace: profile.grace,
        access: profile.access(NodeId::MASTER),
        lifetime: profile.heartbeat,
    };
    let pair = profile.standby.filter(|_| strap.is_some());
    MasterRedundancy::new(TwoBoards::new(pair, strap.unwrap_or(Strap::Prime)), &setup)
}

impl Machine for Master {
    fn lose_power(&mut self) {}

    fn start_delay(&self) -> Duration {
        Duration::from_micros(985)
    }

    fn start(&mut self, now: Instant) {
        let produced = std::mem::take(&mut self.produced);
        *self = Master::new(self.strap, self.profile, std::mem::take(&mut self.monitored));
        self.produced = produced;
        let consumers = self.consumers();
        self.redundancy.peers_mut().set_times(&consumers);
        for slave in self.profile.slaves {
            self.redundancy.peers_mut().assign(slave.node, true);
        }
        if self.redundancy.start(now) {
            self.boot_up(now);
        }
        self.poll(now);
    }

    fn poll(&mut self, now: Instant) {
        let is_over = |one: &Heartbeat| !one.is_requested && one.expires <= now;
        while let Some(place) = self.heartbeats.iter().position(is_over) {
            self.on_heartbeat_failed(place);
        }
        if self.redundancy.is_active() {
            self.poll_recoveries(now);
            self.poll_babblers(now);
        }
        while let Some(action) = self.redundancy.poll(now, now) {
            self.act(action, now);
        }
        if self.redundancy.is_active() {
            self.poll_boot(now);
        }
    }

    fn deadline(&self) -> Option<Instant> {
        if !self.redundancy.is_active() {
            return self.redundancy.deadline();
        }
        let waiting = self.heartbeats.iter().find(|heartbeat| !heartbeat.is_requested);
        let expires = waiting.map(|heartbeat| heartbeat.expires);
        earliest(&[
            self.redundancy.deadline(),
            self.controllers.deadline(),
            self.babblers.deadline(),
            self.boot.deadline(),
            expires,
            self.asks_at(),
        ])
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.poll(now);
        if self.redundancy.is_active() {
            self.on_frame(bus, frame, now);
        } else {
            self.overhear(bus, frame, now);
        }
    }

    fn on_sent(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        if !self.redundancy.is_active() {
            return;
        }
        if self.redundancy.on_sent(bus, frame.id(), now) {
            if let Some(place) = self.heartbeat(bus, true) {
                self.heartbeats.remove(place);
            }
        } else if frame.id() == CobId::SYNC {
            self.boot.on_sync_sent();
        }
    }

    fn on_aborted(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        if frame.id() != CobId::heartbeat(NodeId::MASTER) {
            return;
        }
        let Some(place) = self.heartbeat(bus, true) else { return };
        // Before the end of its lifetime it was aborted for an urgent frame, and returned to the queue.
        self.heartbeats[place].is_requested = false;
        if self.redundancy.is_active() && self.heartbeats[place].expires <= now {
            self.on_heartbeat_failed(place);
        }
    }

    fn on_requested(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        if frame.id() == CobId::heartbeat(NodeId::MASTER) {
            if let Some(place) = self.heartbeat(bus, false) {
                self.heartbeats[place].is_requested = true;
            }
        } else if self.redundancy.is_active() {
            self.on_sdo_request(bus, frame, now);
        }
    }

    fn on_health(&mut self, bus: Bus, health: Health, now: Instant) {
        self.on_health(bus, health, now);
    }

    fn bus(&self) -> Option<Bus> {
        // The log of a standby does not show the bus that it follows.
        self.redundancy.is_active().then(|| self.redundancy.active())
    }

    fn state(&self) -> NmtState {
        self.redundancy.state()
    }

    fn is_of_machine(&self, line: &str) -> bool {
        let states = ["Initialising", "Stopped", "Operational", "PreOperational"];
        let beginnings =
            ["active bus: ", "this master board: ", "another master sends", "no more 701h", "no slave heard"];
        let of_slave = |rest: &str| {
            let is_state = |state: &&str| rest.starts_with(&format!("{state} on "));
            states.iter().any(is_state)
                || ["back on ", "lost", "never heard", "sends too much"]
                    .iter()
                    .any(|text| rest.starts_with(text))
        };
        let slave = line.strip_prefix("slave ").and_then(|rest| rest.split_once(": "));
        states.contains(&line)
            || beginnings.iter().any(|beginning| line.starts_with(beginning))
            || line.contains(" have Node-ID ")
            || line.contains(" has Node-ID ")
            || slave.is_some_and(|(_, rest)| of_slave(rest))
    }

    fn take_produced(&mut self) -> Vec<Produced> {
        std::mem::take(&mut self.produced)
    }
}
