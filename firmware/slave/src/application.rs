//! The slave's application: executes commands, answers telemetry requests, shows life on the LEDs and its time at a pin.
//!
//! An LED each toggles with heartbeats of the master, SYNC and spacecraft time; another one is switched by command.

use board::Spec;
use boards_stm32f4::{Leds, Pulse, supervised};
use ecss_can::link::port::{ErrorState, Health};
use ecss_can::node::{DeviceNode, SelfTest, Slave, SlaveEvent};
use ecss_can::runner::{Events, Handle};
use mission::counters::COUNTERS;
use mission::{
    Command, Declined, Message, MissionObjects, REQUEST_RPDO, Request, SlaveRecord, TELECOMMAND_RPDO,
    TELEMETRY_TPDO,
};

/// The board of this image.
pub type Board = boards_stm32f4::Board<Spec>;

/// The slave of this image.
pub type Node = Slave<MissionObjects>;

/// Pulses at seconds of the spacecraft time, or parts of them.
#[embassy_executor::task]
pub fn pulses(pulse: Pulse, slave: Handle<Board, Node>) -> impl Future<Output = ()> {
    let per_second = move || slave.with(|slave, _| slave.objects().application.pulses);
    supervised("pulses", pulse.run(slave.clock(), per_second))
}

pub struct Application {
    slave: Handle<Board, Node>,
    events: Events<Board, Node>,
    leds: Leds,
    record: SlaveRecord,
}

impl Application {
    pub fn new(slave: Handle<Board, Node>, events: Events<Board, Node>, leds: Leds) -> Self {
        Application { slave, events, leds, record: SlaveRecord::new() }
    }

    pub async fn run(mut self) -> ! {
        loop {
            let event = self.events.next().await;
            self.on_event(&event);
        }
    }

    #[inline(never)] // a small stack frame of its own, reached by short instructions
    fn on_event(&mut self, event: &SlaveEvent) {
        match *event {
            SlaveEvent::Pdo { number, data, .. } => self.on_pdo(usize::from(number), data),
            SlaveEvent::Heartbeat { .. } => {
                self.leds.heartbeat.toggle();
                COUNTERS.on_heartbeat();
            }
            SlaveEvent::Time(_) => {
                self.leds.time.toggle();
                COUNTERS.times.count();
            }
            SlaveEvent::Sync { stamp, .. } => {
                self.record.stamp_source = Some(stamp.source);
                self.leds.sync.toggle();
                COUNTERS.syncs.count();
            }
            SlaveEvent::SelfTest => self.test(),
            SlaveEvent::ResetNode => {
                defmt::info!("reset by the master");
                boards_stm32f4::reset()
            }
            _ => log(event),
        }
    }

    fn on_pdo(&mut self, number: usize, data: [u8; 8]) {
        let Some(message) = Message::from_payload(&data) else { return };
        match number {
            TELECOMMAND_RPDO => self.execute(&message),
            REQUEST_RPDO => self.answer(&message),
            _ => {}
        }
    }

    fn execute(&mut self, message: &Message) {
        let command = match self.record.take(message, self.slave.now()) {
            Ok(command) => command,
            Err(Declined::Repeat) => return COUNTERS.repeats.count(),
            Err(Declined::Unknown) => {
                defmt::warn!("unknown command {=u16:04X}h", message.code());
                return;
            }
        };
        COUNTERS.commands.count();
        match command {
            Command::SetLed(on) => self.leds.state.set_level(on.into()),
            Command::SetValue(value) => {
                self.slave.change(|objects| objects.value = value);
            }
            Command::ResetCounters => self.slave.with(|slave, _| slave.reset_counters()),
            Command::SelectBus(bus) => {
                if self.slave.with(|slave, _| slave.select_bus(bus)).is_err() {
                    defmt::warn!("declined: the master chooses the bus of a slave with parallel access");
                }
            }
        }
    }

    fn answer(&mut self, message: &Message) {
        let Some(request) = Request::decode(message) else {
            defmt::warn!("unknown telemetry request {=u16:04X}h", message.code());
            return;
        };
        self.slave.with(|slave, now| {
            let telemetry = self.record.answer(request, &slave.status(now)).encode();
            slave.change(now, |objects| objects.telemetry = telemetry.into());
            slave.send_pdo(TELEMETRY_TPDO, now);
        });
        COUNTERS.requests.count();
    }

    /// Both controllers must be error active: bit 0 nominal, bit 1 redundant.
    fn test(&mut self) {
        self.slave.with(|slave, now| {
            let health = slave.status(now).health;
            let bad = |health: Health| u32::from(health.state != ErrorState::Active);
            let failures = bad(health.nominal) | bad(health.redundant) << 1;
            let progress = if failures == 0 { SelfTest::PASSED } else { SelfTest::FAILED };
            slave.report_self_test(SelfTest { progress, failures }, now);
        });
    }
}

fn log(event: &SlaveEvent) {
    match event {
        SlaveEvent::State(state) => defmt::info!("{}", state),
        SlaveEvent::ActiveBus { bus, cause } => defmt::info!("active bus: {} ({})", bus, cause),
        SlaveEvent::MasterMissed { bus } => defmt::warn!("master missed on {}", bus),
        SlaveEvent::GaveUp { bus } => defmt::warn!("search given up, listening on {}", bus),
        SlaveEvent::Health { bus, health: Health { state, tec, rec, last_error } } => match state {
            ErrorState::Active => {
                defmt::info!("{}: error {}, TEC {}, REC {}, last {}", bus, state, tec, rec, last_error);
            }
            _ => defmt::warn!("{}: error {}, TEC {}, REC {}, last {}", bus, state, tec, rec, last_error),
        },
        SlaveEvent::BusStalled { bus } => defmt::error!("{} neither joined nor left, trying on", bus),
        SlaveEvent::BusFailed { bus } => defmt::error!("{} failed: bus-off too often", bus),
        SlaveEvent::Clash { bus, yields } => {
            defmt::error!("another node with this Node-ID on {}, yields: {=bool}", bus, yields);
        }
        SlaveEvent::ClashOver => defmt::info!("the other node with this Node-ID is silent"),
        SlaveEvent::ResetIgnored { bus, command } => {
            defmt::warn!("{} on {} ignored: the master is not heard", command, bus);
        }
        SlaveEvent::BdefaultNoted { bus, is_kept: true } => defmt::info!("Bdefault {} kept", bus),
        SlaveEvent::BdefaultNoted { bus, is_kept: false } => defmt::warn!("Bdefault {} not kept", bus),
        SlaveEvent::Step(step) => {
            defmt::info!("clock set: {=u32} s, was {=u32} s", step.to.coarse(), step.from.coarse());
        }
        SlaveEvent::Written(at) => defmt::info!("{=u16:04X}h:{=u8} written", at.index, at.sub),
        _ => {}
    }
}
