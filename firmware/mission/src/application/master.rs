//! The master's application: commands every operational slave, requests its telemetry, and logs events.
//!
//! The blue LED toggles with every SYNC sent. The yellow LED is lit while the redundant bus is active.

mod cables;
mod log;
mod schedule;
#[cfg(test)]
mod tests;

pub use cables::Cables;
use ecss_can::link::port::{ErrorState, Health};
use ecss_can::node::{Master, MasterEvent, SelfTest};
use ecss_can::pdo::{ReceivedPdo, Sequence};
use ecss_can::profile::MinimalNode;
use ecss_can::redundancy::{MasterBoards, RoleChange};
use ecss_can::runner::{EventSource, Handle, MasterHandle, Platform};
use ecss_can::types::{Address, Bus, Instant, NmtState, NodeId};
use embassy_futures::select::{Either, select};
use schedule::{FIRST, Schedule, Turn};

use crate::counters::COUNTERS;
use crate::{
    COMMAND_PERIOD, CableMeasurement, Command, CommanderObjects, Indicators, REQUEST, Received, Request,
    SLAVES, TELECOMMAND, TELEMETRY_PERIOD, slot,
};

/// Object that starts the measurement of a cable when it is written.
const CABLE_OF: Address = CommanderObjects::CABLE.field(CableMeasurement::NODE).address();

/// Whether the role of this board may change. Only an image of profile `standby` contains the code for it; tests always
/// do.
const HAS_ROLES: bool = cfg!(any(feature = "standby", not(target_os = "none")));

/// The master of the mission: one board, or with [`TwoBoards`](ecss_can::redundancy::TwoBoards) one of two.
pub type Node<B> = Master<CommanderObjects, B>;

/// Returns a function that reads the pulses per second of the spacecraft time from object 6310h of the master.
pub fn pulses_per_second<B: MasterBoards>(master: Handle<impl Platform, Node<B>>) -> impl Fn() -> u16 {
    move || master.read(|objects| objects.pulses)
}

/// The application of a master on a platform `P`, with events `E` and indicators `I`.
pub struct Application<P: Platform, B: MasterBoards, E, I> {
    master: Handle<P, Node<B>>,
    events: E,
    indicators: I,
    cables: &'static Cables,
    commands: Schedule<{ COMMAND_PERIOD.as_micros() }>,
    telemetry: Schedule<{ TELEMETRY_PERIOD.as_micros() }>,
    /// Sequence of the commands to each slave.
    sequences: [Sequence; SLAVES],
    /// Slave whose turns were compared last with its state; the first is 0.
    compared: u8,
}

impl<P: Platform, B: MasterBoards, E: EventSource<Event = MasterEvent>, I: Indicators>
    Application<P, B, E, I>
{
    /// Makes the application at power-on. `cables` runs in a separate task; `minimal` are the minimal slaves of the
    /// profile.
    pub fn new(
        master: Handle<P, Node<B>>,
        events: E,
        indicators: I,
        cables: &'static Cables,
        minimal: &[MinimalNode],
    ) -> Self {
        let mut application = Application {
            master,
            events,
            indicators,
            cables,
            commands: Schedule::new(),
            telemetry: Schedule::new(),
            sequences: [Sequence::new(master.now(), COMMAND_PERIOD); SLAVES],
            compared: 0,
        };
        // A minimal slave without heartbeat reports no state, so commands start at once.
        for minimal in minimal.iter().filter(|minimal| !minimal.has_heartbeat) {
            application.work(minimal.node);
        }
        application
    }

    /// Runs for ever.
    pub async fn run(self) -> ! {
        self.run_supervised(|_| ()).await
    }

    /// Runs for ever and reports whether turns are taken: `note` is called with `true` again and again as long as the next turn
    /// is due within a period, and with `false` while there is no slave to command.
    pub async fn run_supervised(mut self, note: impl Fn(bool)) -> ! {
        loop {
            let (next, latest) = (self.next_turn(), self.master.now() + COMMAND_PERIOD);
            if next.is_none_or(|at| at <= latest) {
                note(next.is_some());
            }
            let wait = self.master.wait_until(next.map_or(latest, |at| at.min(latest)));
            match select(self.events.next(), wait).await {
                Either::First(event) => self.on_event(&event),
                Either::Second(()) => {
                    self.take_turns();
                    self.compare_next();
                }
            }
        }
    }

    fn next_turn(&mut self) -> Option<Instant> {
        let now = self.master.now();
        let turns = [self.commands.next(now), self.telemetry.next(now)];
        turns.into_iter().flatten().map(|turn| turn.at).min()
    }

    fn take_turns(&mut self) {
        let now = self.master.now();
        if let Some(turn) = self.commands.next(now).filter(|turn| turn.at <= now) {
            self.command(turn);
        }
        if let Some(turn) = self.telemetry.next(now).filter(|turn| turn.at <= now) {
            self.request(turn);
        }
    }

    /// Compares the turns of the next slave with its state. They differ if a bit flipped, or if an event was lost.
    fn compare_next(&mut self) {
        self.compared = (self.compared + 1) % SLAVES as u8;
        if let Some(node) = NodeId::new(FIRST + self.compared) {
            self.adjust(node);
        }
    }

    /// Lets a slave have turns if it takes commands from this master, and none otherwise.
    fn adjust(&mut self, node: NodeId) {
        if self.master.is_active() && self.master.may_command(node) {
            self.work(node)
        } else {
            self.rest(node)
        }
    }

    fn on_event(&mut self, event: &MasterEvent) {
        log::event(event);
        match event {
            MasterEvent::SlaveState { node, state: NmtState::Operational, .. } => self.work(*node),
            MasterEvent::Role(change) if HAS_ROLES => self.on_role(*change),
            MasterEvent::SlaveState { node, .. } | MasterEvent::SlaveLost { node } => self.rest(*node),
            MasterEvent::Pdo(pdo) => self.on_pdo(pdo),
            MasterEvent::ResetNode => self.indicators.reset(),
            MasterEvent::SelfTest => self.test(),
            MasterEvent::Written(at) if *at == CABLE_OF => self.cables.start(self.master),
            MasterEvent::SyncSent { .. } => {
                self.indicators.sync();
                COUNTERS.on_sync_sent();
            }
            MasterEvent::BusSwitched { to, .. } => self.show(*to),
            _ => {}
        }
    }

    fn show(&mut self, active: Bus) {
        self.indicators.state(active == Bus::Redundant);
    }

    fn on_pdo(&self, pdo: &ReceivedPdo) {
        match crate::received(pdo) {
            Some((node, Received::Telemetry(message))) => {
                COUNTERS.replies.count();
                log::telemetry(node, &message);
            }
            Some((node, Received::LocalTime(scet))) => {
                log::local_time(node, scet, self.master.scet_at_sync());
            }
            None => {}
        }
    }

    /// Runs the self-test: both controllers must be error active. Failures: bit 0 nominal, bit 1 redundant.
    fn test(&mut self) {
        let health = self.master.status().health;
        let bad = |health: Health| u32::from(health.state != ErrorState::Active);
        let failures = bad(health.nominal) | bad(health.redundant) << 1;
        let progress = if failures == 0 { SelfTest::PASSED } else { SelfTest::FAILED };
        self.master.report_self_test(SelfTest { progress, failures });
    }

    /// Starts commands to a slave, unless this master is the standby of another one.
    fn work(&mut self, node: NodeId) {
        if !self.master.is_active() {
            return;
        }
        // Telemetry requests start with the commands. Commands wait until the slave cannot mistake one for a repeat of
        // a command before a reset.
        if let Some(sequence) = slot(node).and_then(|slot| self.sequences.get_mut(slot)) {
            let now = self.master.now();
            sequence.confine(now, COMMAND_PERIOD);
            let from = now.max(sequence.ready_at());
            self.commands.start(node, from);
            self.telemetry.start(node, from);
        }
    }

    /// Restarts the commands to the operational slaves, or ends them.
    fn on_role(&mut self, change: RoleChange) {
        let (is_active, bus) = (self.master.is_active(), self.master.status().active);
        log::role(change, is_active.then_some(bus));
        self.show(bus);
        if is_active {
            self.sequences = [Sequence::new(self.master.now(), COMMAND_PERIOD); SLAVES];
        }
        (FIRST..).filter_map(NodeId::new).take(SLAVES).for_each(|node| self.adjust(node));
    }

    fn rest(&mut self, node: NodeId) {
        let now = self.master.now();
        self.commands.stop(node, now);
        self.telemetry.stop(node, now);
    }

    /// Sends the command of a turn: alternately the LED, and a value that telemetry reads back.
    fn command(&mut self, turn: Turn) {
        let now = self.master.now();
        let missed = self.commands.taken(turn, now);
        COUNTERS.skipped_turns.add(missed as u32);
        let Turn { node, count, .. } = turn;
        let sequence = slot(node).and_then(|slot| self.sequences.get_mut(slot)?.step(now));
        let Some(sequence) = sequence else { return COUNTERS.skipped_turns.count() };
        let command = if count % 2 == 0 { Command::SetLed(count % 4 == 0) } else { Command::SetValue(count) };
        let message = command.encode(sequence);
        log::refused(node, self.master.send_to(node, TELECOMMAND, message.telecommand()));
        COUNTERS.commands.count();
    }

    /// Sends the telemetry request of a turn; the requests follow each other cyclically.
    fn request(&mut self, turn: Turn) {
        let missed = self.telemetry.taken(turn, self.master.now());
        COUNTERS.skipped_turns.add(missed as u32);
        let Turn { node, count, .. } = turn;
        if let Some(request) = Request::ALL.get(count as usize % Request::ALL.len()) {
            log::refused(node, self.master.send_to(node, REQUEST, request.encode().values()));
            COUNTERS.requests.count();
        }
    }
}
