//! The slave's application: executes commands, answers telemetry requests, shows activity on the LEDs and its time at a
//! pin.
//!
//! One LED each toggles with heartbeats of the master, SYNC and spacecraft time; commands switch another one.

use ecss_can::link::port::{ErrorState, Health};
use ecss_can::node::{SelfTest, Slave, SlaveEvent};
use ecss_can::pdo::ReceivedPdo;
use ecss_can::runner::{EventSource, Handle, Platform, SlaveHandle};

use crate::counters::COUNTERS;
use crate::{
    Command, Declined, Indicators, Message, MissionObjects, REQUEST, Request, SlaveRecord, TELECOMMAND,
    error, info, warn,
};

/// The slave of the mission.
pub type Node = Slave<MissionObjects>;

/// Returns a function that reads the pulses per second of the spacecraft time from object 6310h of the slave.
pub fn pulses_per_second(slave: Handle<impl Platform, Node>) -> impl Fn() -> u16 {
    move || slave.read(|objects| objects.pulses)
}

/// The application of a slave on a platform `P`, with events `E` and indicators `I`.
pub struct Application<P: Platform, E, I> {
    slave: Handle<P, Node>,
    events: E,
    indicators: I,
    record: SlaveRecord,
}

impl<P: Platform, E: EventSource<Event = SlaveEvent>, I: Indicators> Application<P, E, I> {
    /// Makes the application at power-on.
    pub fn new(slave: Handle<P, Node>, events: E, indicators: I) -> Self {
        Application { slave, events, indicators, record: SlaveRecord::new() }
    }

    /// Runs for ever.
    pub async fn run(mut self) -> ! {
        loop {
            self.step().await;
        }
    }

    /// Waits for the next event and handles it.
    ///
    /// # Cancel safety
    /// A dropped future loses no event.
    pub async fn step(&mut self) {
        let event = self.events.next().await;
        self.on_event(&event);
    }

    /// Returns the state that commands changed.
    pub fn record(&self) -> &SlaveRecord {
        &self.record
    }

    #[inline(never)] // a small stack frame of its own, reached by short instructions
    fn on_event(&mut self, event: &SlaveEvent) {
        match *event {
            SlaveEvent::Pdo(ref pdo) => self.on_pdo(pdo),
            SlaveEvent::Heartbeat { .. } => {
                self.indicators.heartbeat();
                COUNTERS.on_heartbeat();
            }
            SlaveEvent::Time(_) => {
                self.indicators.time();
                COUNTERS.times.count();
            }
            SlaveEvent::Sync { stamp, .. } => {
                self.record.stamp_source = Some(stamp.source);
                self.indicators.sync();
                COUNTERS.syncs.count();
            }
            SlaveEvent::SelfTest => self.test(),
            SlaveEvent::ResetNode => {
                info!("reset by the master");
                self.indicators.reset();
            }
            _ => log(event),
        }
    }

    fn on_pdo(&mut self, pdo: &ReceivedPdo) {
        let Some(message) = Message::from_payload(&pdo.data) else { return };
        if pdo.is(TELECOMMAND) {
            self.execute(&message);
        } else if pdo.is(REQUEST) {
            self.answer(&message);
        }
    }

    fn execute(&mut self, message: &Message) {
        let command = match self.record.take(message, self.slave.now()) {
            Ok(command) => command,
            Err(Declined::Repeat) => return COUNTERS.repeats.count(),
            Err(Declined::Unknown) => {
                warn!("unknown command {=u16:04X}h", message.code());
                return;
            }
        };
        COUNTERS.commands.count();
        match command {
            Command::SetLed(on) => self.indicators.state(on),
            Command::SetValue(value) => {
                self.slave.update(|objects| objects.value = value);
            }
            Command::ResetCounters => self.slave.reset_counters(),
            Command::SelectBus(bus) => {
                if self.slave.select_bus(bus).is_err() {
                    warn!("declined: the master chooses the bus of a slave with parallel access");
                }
            }
        }
    }

    fn answer(&mut self, message: &Message) {
        let Some(request) = Request::decode(message) else {
            warn!("unknown telemetry request {=u16:04X}h", message.code());
            return;
        };
        let telemetry = self.record.answer(request, &self.slave.status()).encode();
        self.slave.send_with(MissionObjects::TELEMETRY_PDO, |objects| objects.telemetry = telemetry.into());
        COUNTERS.requests.count();
    }

    /// Runs the self-test: both controllers must be error active. Failures: bit 0 nominal, bit 1 redundant.
    fn test(&mut self) {
        let health = self.slave.status().health;
        let bad = |health: Health| u32::from(health.state != ErrorState::Active);
        let failures = bad(health.nominal) | bad(health.redundant) << 1;
        let progress = if failures == 0 { SelfTest::PASSED } else { SelfTest::FAILED };
        self.slave.report_self_test(SelfTest { progress, failures });
    }
}

fn log(event: &SlaveEvent) {
    match event {
        SlaveEvent::State(state) => info!("{}", state),
        SlaveEvent::ActiveBus { bus, cause } => info!("active bus: {} ({})", bus, cause),
        SlaveEvent::MasterMissed { bus } => warn!("master missed on {}", bus),
        SlaveEvent::GaveUp { bus } => warn!("search given up, listening on {}", bus),
        SlaveEvent::Health { bus, health: Health { state, tec, rec, last_error } } => match state {
            ErrorState::Active => {
                info!("{}: error {}, TEC {}, REC {}, last {}", bus, state, tec, rec, last_error);
            }
            _ => warn!("{}: error {}, TEC {}, REC {}, last {}", bus, state, tec, rec, last_error),
        },
        SlaveEvent::BusStalled { bus } => error!("{} neither joined nor left, trying on", bus),
        SlaveEvent::BusFailed { bus } => error!("{} failed: bus-off too often", bus),
        SlaveEvent::Clash { bus, yields } => {
            error!("another node with this Node-ID on {}, yields: {=bool}", bus, yields);
        }
        SlaveEvent::ClashOver => info!("the other node with this Node-ID is silent"),
        SlaveEvent::ResetIgnored { bus, command } => {
            warn!("{} on {} ignored: the master is not heard", command, bus);
        }
        SlaveEvent::BdefaultNoted { bus, is_kept: true } => info!("Bdefault {} kept", bus),
        SlaveEvent::BdefaultNoted { bus, is_kept: false } => warn!("Bdefault {} not kept", bus),
        SlaveEvent::Step(step) => {
            info!("clock set: {=u32} s, was {=u32} s", step.to.coarse(), step.from.coarse());
        }
        SlaveEvent::NotSent { bus, id, data } => {
            warn!("{=u16:03X}h not sent on {}: {=[u8; 8]:02X}", id.raw(), bus, *data);
        }
        SlaveEvent::Written(at) => info!("{=u16:04X}h:{=u8} written", at.index, at.sub),
        _ => {}
    }
}
