//! The slave's application: executes commands, answers telemetry requests, shows life on the LEDs.
//!
//! Blue toggles with every heartbeat of the master, SYNC and spacecraft time. Yellow is switched by command.

use boards::Leds;
use ecss_can::link::Bus;
use ecss_can::link::port::{ErrorState, Health};
use ecss_can::node::{SlaveEvent, SlaveRequest};
use ecss_can::pdo::Message;
use ecss_can::profile::mission::{Command, Request, SlaveRecord};
use ecss_can::runner::{AppLink, Telltale};

use crate::app::Raw;

pub struct Application {
    leds: Leds,
    link: &'static AppLink<Raw, SlaveEvent, SlaveRequest>,
    telltale: &'static Telltale,
    record: SlaveRecord,
}

impl Application {
    pub fn new(
        leds: Leds,
        link: &'static AppLink<Raw, SlaveEvent, SlaveRequest>,
        telltale: &'static Telltale,
    ) -> Self {
        Application { leds, link, telltale, record: SlaveRecord::default() }
    }

    pub async fn run(mut self) -> ! {
        loop {
            match self.link.events.receive().await {
                SlaveEvent::Command { message, .. } => self.execute(&message).await,
                SlaveEvent::TelemetryRequested { bus, request } => self.answer(bus, &request).await,
                SlaveEvent::Heartbeat { .. } | SlaveEvent::Time(_) => self.leds.activity.toggle(),
                SlaveEvent::Sync { stamp, .. } => {
                    self.record.stamp_source = Some(stamp.source);
                    self.leds.activity.toggle();
                }
                SlaveEvent::ResetNode => {
                    defmt::info!("reset by the master");
                    boards::reset()
                }
                event => log(&event),
            }
        }
    }

    async fn execute(&mut self, message: &Message) {
        let Some(command) = Command::decode(message) else {
            defmt::warn!("unknown command {=u16:04X}h", message.code());
            return;
        };
        self.record.execute(command);
        self.telltale.commands.count();
        match command {
            Command::SetLed(on) => self.leds.state.set_level(on.into()),
            Command::SetValue(_) => {}
            Command::ResetCounters => self.link.requests.send(SlaveRequest::ResetCounters).await,
        }
    }

    async fn answer(&mut self, bus: Bus, request: &Message) {
        let Some(request) = Request::decode(request) else {
            defmt::warn!("unknown telemetry request {=u16:04X}h", request.code());
            return;
        };
        // A node that asks has shown its status.
        let Some(status) = self.link.status() else { return };
        let message = self.record.answer(request, &status).encode();
        self.link.requests.send(SlaveRequest::Telemetry { bus, message }).await;
        self.telltale.telemetry_requests.count();
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
        _ => {}
    }
}
