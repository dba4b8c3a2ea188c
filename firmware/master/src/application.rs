//! The master's application: commands every operational slave, asks it for telemetry, logs what happens.
//!
//! Blue toggles with every SYNC sent. Yellow is lit while the redundant bus is the active one.

mod log;
mod round;

use boards::{Leds, Uptime};
use ecss_can::link::Bus;
use ecss_can::nmt::{NmtState, NodeId};
use ecss_can::node::{MasterEvent, MasterRequest};
use ecss_can::profile::Profile;
use ecss_can::profile::mission::{Command, Request};
use ecss_can::runner::{AppLink, Telltale};
use ecss_can::time::Clock;
use embassy_futures::select::{Either3, select3};

use crate::app::Raw;
use round::{Round, SLAVES, Turn};

pub struct Application {
    clock: Uptime,
    leds: Leds,
    link: &'static AppLink<Raw, MasterEvent, MasterRequest>,
    telltale: &'static Telltale,
    commands: Round,
    telemetry: Round,
    operational: [bool; SLAVES],
}

impl Application {
    pub fn new(
        profile: &Profile,
        clock: Uptime,
        leds: Leds,
        link: &'static AppLink<Raw, MasterEvent, MasterRequest>,
        telltale: &'static Telltale,
    ) -> Self {
        Application {
            clock,
            leds,
            link,
            telltale,
            commands: Round::new(profile.command, clock.now()),
            telemetry: Round::new(profile.telemetry, clock.now()),
            operational: [false; SLAVES],
        }
    }

    pub async fn run(mut self) -> ! {
        loop {
            let due = select3(
                self.link.events.receive(),
                self.clock.at(self.commands.next()),
                self.clock.at(self.telemetry.next()),
            );
            match due.await {
                Either3::First(event) => self.on_event(&event),
                Either3::Second(()) => {
                    let turn = self.commands.take();
                    self.command(turn).await;
                }
                Either3::Third(()) => {
                    let turn = self.telemetry.take();
                    self.request(turn).await;
                }
            }
        }
    }

    fn on_event(&mut self, event: &MasterEvent) {
        log::event(event);
        match event {
            MasterEvent::SlaveState { node, state, .. } => {
                self.set_operational(*node, *state == NmtState::Operational);
            }
            MasterEvent::SlaveLost { node } => self.set_operational(*node, false),
            MasterEvent::Telemetry { .. } => self.telltale.telemetry_replies.count(),
            MasterEvent::SyncSent { .. } => self.leds.blue.toggle(),
            MasterEvent::BusSwitched { to, .. } => {
                self.leds.yellow.set_level((*to == Bus::Redundant).into());
            }
            _ => {}
        }
    }

    fn set_operational(&mut self, node: NodeId, operational: bool) {
        if let Some(slave) = round::slot(node).and_then(|slot| self.operational.get_mut(slot)) {
            *slave = operational;
        }
    }

    fn is_operational(&self, node: NodeId) -> bool {
        round::slot(node).and_then(|slot| self.operational.get(slot)).is_some_and(|slave| *slave)
    }

    /// The LED in every other round, a value that telemetry reads back in the rounds between.
    async fn command(&mut self, Turn { node, round }: Turn) {
        if self.is_operational(node) {
            let command =
                if round % 2 == 0 { Command::SetLed(round % 4 == 0) } else { Command::SetValue(round) };
            self.link.requests.send(MasterRequest::Command { node, message: command.encode() }).await;
            self.telltale.commands.count();
        }
    }

    /// Every request in turn.
    async fn request(&mut self, Turn { node, round }: Turn) {
        let which = Request::ALL.get(round as usize % Request::ALL.len());
        if let Some(request) = which.filter(|_| self.is_operational(node)) {
            let message = request.encode();
            self.link.requests.send(MasterRequest::RequestTelemetry { node, message }).await;
            self.telltale.telemetry_requests.count();
        }
    }
}
