//! The master's application: commands every operational slave, asks it for telemetry, logs what happens.
//!
//! Blue toggles with every SYNC sent. Yellow is lit while the redundant bus is the active one.

mod log;
mod schedule;

use core::future::pending;

use boards::{Leds, Uptime};
use ecss_can::link::port::{ErrorState, Health};
use ecss_can::node::{MasterEvent, MasterRequest, SelfTest};
use ecss_can::pdo::Sequence;
use ecss_can::profile::Profile;
use ecss_can::runner::{AppLink, Telltale};
use ecss_can::time::Clock;
use ecss_can::types::{Bus, Instant, NmtState, NodeId};
use embassy_futures::select::{Either, select};
use mission::{Command, Request};

use crate::app::{Node, Raw};
use schedule::{SLAVES, Schedule, Turn, slot};

pub struct Application {
    node: &'static Node,
    clock: Uptime,
    leds: Leds,
    link: &'static AppLink<Raw, MasterEvent, MasterRequest>,
    telltale: &'static Telltale,
    commands: Schedule,
    telemetry: Schedule,
    /// Numbers the commands to each slave.
    sequences: [Sequence; SLAVES],
}

impl Application {
    pub fn new(
        profile: &Profile,
        node: &'static Node,
        clock: Uptime,
        leds: Leds,
        link: &'static AppLink<Raw, MasterEvent, MasterRequest>,
        telltale: &'static Telltale,
    ) -> Self {
        let (commands, telemetry) = (Schedule::new(profile.command), Schedule::new(profile.telemetry));
        let sequences = [Sequence::new(clock.now(), profile.command); SLAVES];
        Application { node, clock, leds, link, telltale, commands, telemetry, sequences }
    }

    pub async fn run(mut self) -> ! {
        loop {
            match select(self.link.events.receive(), wait(self.clock, self.next_turn())).await {
                Either::First(event) => self.on_event(&event),
                Either::Second(()) => self.take_turns().await,
            }
        }
    }

    fn next_turn(&self) -> Option<Instant> {
        let turns = [self.commands.next(), self.telemetry.next()];
        turns.into_iter().flatten().map(|turn| turn.at).min()
    }

    async fn take_turns(&mut self) {
        let now = self.clock.now();
        if let Some(turn) = self.commands.next().filter(|turn| turn.at <= now) {
            self.command(turn).await;
        }
        if let Some(turn) = self.telemetry.next().filter(|turn| turn.at <= now) {
            self.request(turn).await;
        }
    }

    fn on_event(&mut self, event: &MasterEvent) {
        log::event(event);
        match event {
            MasterEvent::SlaveState { node, state: NmtState::Operational, .. } => {
                // Telemetry goes with commands, and these wait until none is taken for one before a reset.
                if let Some(sequence) = slot(*node).and_then(|slot| self.sequences.get(slot)) {
                    let from = self.clock.now().max(sequence.ready_at());
                    self.commands.start(*node, from);
                    self.telemetry.start(*node, from);
                }
            }
            MasterEvent::SlaveState { node, .. } | MasterEvent::SlaveLost { node } => self.rest(*node),
            MasterEvent::Telemetry { .. } => self.telltale.telemetry_replies.count(),
            MasterEvent::SelfTest => self.test(),
            MasterEvent::SyncSent { .. } => self.leds.activity.toggle(),
            MasterEvent::BusSwitched { to, .. } => {
                self.leds.state.set_level((*to == Bus::Redundant).into());
            }
            _ => {}
        }
    }

    /// Both controllers must be error active: bit 0 nominal, bit 1 redundant.
    fn test(&mut self) {
        let now = self.clock.now();
        self.node.with(|master| {
            let health = master.status(now).health;
            let bad = |health: Health| u32::from(health.state != ErrorState::Active);
            let failures = bad(health.nominal) | bad(health.redundant) << 1;
            let progress = if failures == 0 { SelfTest::PASSED } else { SelfTest::FAILED };
            master.objects_mut().spacecraft.self_test = SelfTest { progress, failures };
        });
    }

    fn rest(&mut self, node: NodeId) {
        self.commands.stop(node);
        self.telemetry.stop(node);
    }

    /// The LED in every other turn, a value that telemetry reads back in those between.
    async fn command(&mut self, turn: Turn) {
        let now = self.clock.now();
        let missed = self.commands.taken(turn, now);
        self.telltale.skipped_turns.add(missed as u32);
        let Turn { node, count, .. } = turn;
        let sequence = slot(node).and_then(|slot| self.sequences.get_mut(slot)?.step(now));
        let Some(sequence) = sequence else { return self.telltale.skipped_turns.count() };
        let command = if count % 2 == 0 { Command::SetLed(count % 4 == 0) } else { Command::SetValue(count) };
        self.link.requests.send(MasterRequest::Command { node, message: command.encode(sequence) }).await;
        self.telltale.commands.count();
    }

    /// Every request in turn.
    async fn request(&mut self, turn: Turn) {
        let missed = self.telemetry.taken(turn, self.clock.now());
        self.telltale.skipped_turns.add(missed as u32);
        let Turn { node, count, .. } = turn;
        if let Some(request) = Request::ALL.get(count as usize % Request::ALL.len()) {
            let message = request.encode();
            self.link.requests.send(MasterRequest::RequestTelemetry { node, message }).await;
            self.telltale.telemetry_requests.count();
        }
    }
}

/// Waits until then, for ever without.
async fn wait(clock: Uptime, until: Option<Instant>) {
    match until {
        Some(at) => clock.at(at).await,
        None => pending().await,
    }
}
