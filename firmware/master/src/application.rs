//! The master's application: commands every operational slave, asks it for telemetry, logs what happens.
//!
//! Blue toggles with every SYNC sent. Yellow is lit while the redundant bus is the active one.

mod cables;
mod log;
mod schedule;

use core::future::pending;

use board::Spec;
use boards_stm32f4::{Leds, Pulse, supervised};
use ecss_can::link::port::{ErrorState, Health};
use ecss_can::node::{Master, MasterEvent, SelfTest};
use ecss_can::pdo::Sequence;
use ecss_can::runner::{Events, Handle};
use ecss_can::types::{Address, Bus, Instant, NmtState, NodeId};
use embassy_futures::select::{Either, select};
use mission::counters::COUNTERS;
use mission::{
    COMMAND_PERIOD, CableMeasurement, Command, CommanderObjects, PROFILE, Received, Request, SLAVES,
    TELEMETRY_PERIOD, slot,
};

pub use cables::cables;
use schedule::{Schedule, Turn};

/// Written, it starts the measurement of a cable.
const CABLE_OF: Address = CommanderObjects::CABLE.field(CableMeasurement::NODE).address();

/// The board of this image.
pub type Board = boards_stm32f4::Board<Spec>;

/// The master of this image.
#[cfg(not(feature = "standby"))]
pub type Node = Master<CommanderObjects>;
/// The master of this image.
#[cfg(feature = "standby")]
pub type Node = Master<CommanderObjects, ecss_can::node::TwoBoards>;

/// Pulses at seconds of the spacecraft time, or parts of them.
#[embassy_executor::task]
pub fn pulses(pulse: Pulse, master: Handle<Board, Node>) -> impl Future<Output = ()> {
    let per_second = move || master.with(|master, _| master.objects().application.device.pulses);
    supervised("pulses", pulse.run(master.clock(), per_second))
}

pub struct Application {
    master: Handle<Board, Node>,
    events: Events<Board, Node>,
    leds: Leds,
    commands: Schedule,
    telemetry: Schedule,
    /// Numbers the commands to each slave.
    sequences: [Sequence; SLAVES],
}

impl Application {
    pub fn new(master: Handle<Board, Node>, events: Events<Board, Node>, leds: Leds) -> Self {
        let (commands, telemetry) = (Schedule::new(COMMAND_PERIOD), Schedule::new(TELEMETRY_PERIOD));
        let sequences = [Sequence::new(master.now(), COMMAND_PERIOD); SLAVES];
        Application { master, events, leds, commands, telemetry, sequences }
    }

    pub async fn run(mut self) -> ! {
        // Nothing is heard of a minimal slave without heartbeat.
        for minimal in PROFILE.minimal.iter().filter(|minimal| !minimal.has_heartbeat) {
            self.work(minimal.node);
        }
        loop {
            let next = wait(self.master, self.next_turn());
            match select(self.events.next(), next).await {
                Either::First(event) => self.on_event(&event),
                Either::Second(()) => self.take_turns(),
            }
        }
    }

    fn next_turn(&self) -> Option<Instant> {
        let turns = [self.commands.next(), self.telemetry.next()];
        turns.into_iter().flatten().map(|turn| turn.at).min()
    }

    fn take_turns(&mut self) {
        let now = self.master.now();
        if let Some(turn) = self.commands.next().filter(|turn| turn.at <= now) {
            self.command(turn);
        }
        if let Some(turn) = self.telemetry.next().filter(|turn| turn.at <= now) {
            self.request(turn);
        }
    }

    fn on_event(&mut self, event: &MasterEvent) {
        log::event(event);
        match event {
            MasterEvent::SlaveState { node, state: NmtState::Operational, .. } => self.work(*node),
            #[cfg(feature = "standby")]
            MasterEvent::Role(change) => self.on_role(*change),
            MasterEvent::SlaveState { node, .. } | MasterEvent::SlaveLost { node } => self.rest(*node),
            MasterEvent::Pdo { number, data, .. } => self.on_pdo(*number, *data),
            MasterEvent::ResetNode => boards_stm32f4::reset(),
            MasterEvent::SelfTest => self.test(),
            MasterEvent::Written(at) if *at == CABLE_OF => cables::start(self.master),
            MasterEvent::SyncSent { .. } => {
                self.leds.sync.toggle();
                COUNTERS.on_sync_sent();
            }
            MasterEvent::BusSwitched { to, .. } => self.show(*to),
            _ => {}
        }
    }

    fn show(&mut self, active: Bus) {
        self.leds.state.set_level((active == Bus::Redundant).into());
    }

    fn on_pdo(&self, number: u16, data: [u8; 8]) {
        match mission::received(number, data) {
            Some((node, Received::Telemetry(message))) => {
                COUNTERS.replies.count();
                log::telemetry(node, &message);
            }
            Some((node, Received::LocalTime(scet))) => {
                let reference = self.master.with(|master, _| master.scet_at_sync());
                log::local_time(node, scet, reference);
            }
            None => {}
        }
    }

    /// Both controllers must be error active: bit 0 nominal, bit 1 redundant.
    fn test(&mut self) {
        self.master.with(|master, now| {
            let health = master.status(now).health;
            let bad = |health: Health| u32::from(health.state != ErrorState::Active);
            let failures = bad(health.nominal) | bad(health.redundant) << 1;
            let progress = if failures == 0 { SelfTest::PASSED } else { SelfTest::FAILED };
            master.report_self_test(SelfTest { progress, failures }, now);
        });
    }

    /// Commands to a slave begin, unless this master is the standby of another one.
    fn work(&mut self, node: NodeId) {
        if !self.master.with(|master, _| master.is_active()) {
            return;
        }
        // Telemetry goes with commands, and these wait until none is taken for one before a reset.
        if let Some(sequence) = slot(node).and_then(|slot| self.sequences.get(slot)) {
            let from = self.master.now().max(sequence.ready_at());
            self.commands.start(node, from);
            self.telemetry.start(node, from);
        }
    }

    /// Commands begin anew to the slaves that run, or end.
    #[cfg(feature = "standby")]
    fn on_role(&mut self, change: ecss_can::redundancy::RoleChange) {
        let (is_active, bus) =
            self.master.with(|master, now| (master.is_active(), master.status(now).active));
        log::role(change, is_active.then_some(bus));
        self.show(bus);
        if is_active {
            self.sequences = [Sequence::new(self.master.now(), COMMAND_PERIOD); SLAVES];
        }
        for node in (2..).filter_map(NodeId::new).take(SLAVES) {
            let takes_commands = self.master.with(|master, _| master.may_command(node));
            if is_active && takes_commands { self.work(node) } else { self.rest(node) }
        }
    }

    fn rest(&mut self, node: NodeId) {
        self.commands.stop(node);
        self.telemetry.stop(node);
    }

    /// The LED in every other turn, a value that telemetry reads back in those between.
    fn command(&mut self, turn: Turn) {
        let now = self.master.now();
        let missed = self.commands.taken(turn, now);
        COUNTERS.skipped_turns.add(missed as u32);
        let Turn { node, count, .. } = turn;
        let sequence = slot(node).and_then(|slot| self.sequences.get_mut(slot)?.step(now));
        let Some(sequence) = sequence else { return COUNTERS.skipped_turns.count() };
        let command = if count % 2 == 0 { Command::SetLed(count % 4 == 0) } else { Command::SetValue(count) };
        let message = command.encode(sequence);
        let sent = self.master.with(|master, now| mission::command(master, node, &message, now));
        log::refused(node, sent);
        COUNTERS.commands.count();
    }

    /// Every request in turn.
    fn request(&mut self, turn: Turn) {
        let missed = self.telemetry.taken(turn, self.master.now());
        COUNTERS.skipped_turns.add(missed as u32);
        let Turn { node, count, .. } = turn;
        if let Some(request) = Request::ALL.get(count as usize % Request::ALL.len()) {
            let message = request.encode();
            let sent = self.master.with(|master, now| mission::request(master, node, &message, now));
            log::refused(node, sent);
            COUNTERS.requests.count();
        }
    }
}

/// Waits until then, for ever without.
async fn wait(master: Handle<Board, Node>, until: Option<Instant>) {
    match until {
        Some(at) => master.wait_until(at).await,
        None => pending().await,
    }
}
