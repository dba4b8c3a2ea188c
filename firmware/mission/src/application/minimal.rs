//! The application of the minimal slave: shows activity on the LEDs and in the log. The device handles commands and
//! telemetry.
//!
//! One LED each toggles with heartbeats of the master, SYNC and spacecraft time; commands switch the state LED.

use ecss_can::node::minimal::{MinimalEvent, MinimalSlave};
use ecss_can::runner::{EventSource, Handle, MinimalHandle, Platform};

use crate::counters::COUNTERS;
use crate::minimal::MissionDevice;
use crate::{Indicators, error, info, warn};

/// The application of a minimal slave with device `D` on a platform `P`, with events `E` and indicators `I`.
pub struct Application<P: Platform, D: MissionDevice, E, I> {
    slave: Handle<P, MinimalSlave<D>>,
    events: E,
    indicators: I,
}

impl<P: Platform, D: MissionDevice, E: EventSource<Event = MinimalEvent>, I: Indicators>
    Application<P, D, E, I>
{
    /// Makes the application at power-on.
    pub fn new(slave: Handle<P, MinimalSlave<D>>, events: E, indicators: I) -> Self {
        Application { slave, events, indicators }
    }

    /// Runs for ever.
    pub async fn run(mut self) -> ! {
        loop {
            let event = self.events.next().await;
            self.on_event(&event);
        }
    }

    fn on_event(&mut self, event: &MinimalEvent) {
        match event {
            MinimalEvent::Heartbeat { .. } => {
                self.indicators.heartbeat();
                COUNTERS.on_heartbeat();
            }
            MinimalEvent::Sync { .. } => {
                self.indicators.sync();
                COUNTERS.syncs.count();
            }
            MinimalEvent::Pdo { number, .. } if Some(*number) == D::TIME_RPDO => {
                self.indicators.time();
                COUNTERS.times.count();
            }
            MinimalEvent::Pdo { .. } => {
                self.indicators.state(self.slave.read(D::led));
            }
            event => log(event),
        }
    }
}

fn log(event: &MinimalEvent) {
    match event {
        MinimalEvent::ActiveBus { bus, cause } => info!("active bus: {} ({})", bus, cause),
        MinimalEvent::MasterMissed { bus } => warn!("master missed on {}", bus),
        MinimalEvent::GaveUp { bus } => warn!("search given up, listening on {}", bus),
        MinimalEvent::Health { bus, health } => {
            info!("{}: error {}, TEC {}, REC {}", bus, health.state, health.tec, health.rec);
        }
        MinimalEvent::BusStalled { bus } => error!("{} neither joined nor left, trying on", bus),
        MinimalEvent::BusFailed { bus } => error!("{} failed: bus-off too often", bus),
        _ => {}
    }
}
