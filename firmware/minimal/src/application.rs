//! The application of the minimal slave: shows life on the LEDs and in the log. Commands and telemetry are its device's part.
//!
//! An LED each toggles with heartbeats of the master, SYNC and spacecraft time; the state LED is switched by command.

use board::Spec;
use boards_stm32f4::Leds;
use ecss_can::node::minimal::{MinimalEvent, MinimalSlave};
use ecss_can::runner::{Events, Handle};
use mission::counters::COUNTERS;
use mission::minimal::Shipped;

/// The board of this image.
#[cfg(not(feature = "one-controller"))]
pub type Board = boards_stm32f4::MinimalBoard<Spec>;
/// The board of this image.
#[cfg(feature = "one-controller")]
pub type Board = boards_stm32f4::OneControllerBoard<Spec>;

/// The slave of this image.
pub type Node = MinimalSlave<Shipped>;

/// Runs for ever.
pub async fn run(slave: Handle<Board, Node>, mut events: Events<Board, Node>, mut leds: Leds) -> ! {
    loop {
        match events.next().await {
            MinimalEvent::Heartbeat { .. } => {
                leds.heartbeat.toggle();
                COUNTERS.on_heartbeat();
            }
            MinimalEvent::Sync { .. } => {
                leds.sync.toggle();
                COUNTERS.syncs.count();
            }
            MinimalEvent::Pdo { number, .. } if Some(number) == Shipped::TIME_RPDO => {
                leds.time.toggle();
                COUNTERS.times.count();
            }
            MinimalEvent::Pdo { .. } => {
                let led = slave.with(|slave, _| slave.device().led());
                leds.state.set_level(led.into());
            }
            event => log(&event),
        }
    }
}

fn log(event: &MinimalEvent) {
    match event {
        MinimalEvent::ActiveBus { bus, cause } => defmt::info!("active bus: {} ({})", bus, cause),
        MinimalEvent::MasterMissed { bus } => defmt::warn!("master missed on {}", bus),
        MinimalEvent::GaveUp { bus } => defmt::warn!("search given up, listening on {}", bus),
        MinimalEvent::Health { bus, health } => {
            defmt::info!("{}: error {}, TEC {}, REC {}", bus, health.state, health.tec, health.rec);
        }
        MinimalEvent::BusStalled { bus } => defmt::error!("{} neither joined nor left, trying on", bus),
        MinimalEvent::BusFailed { bus } => defmt::error!("{} failed: bus-off too often", bus),
        MinimalEvent::Heartbeat { .. } | MinimalEvent::Sync { .. } | MinimalEvent::Pdo { .. } => {}
    }
}
