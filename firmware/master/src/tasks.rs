//! The tasks: one for each bus, one for the node, one for its application.

use boards::{Port, TELLTALE, Uptime};
use ecss_can::runner::{bus_task, node_task};
use ecss_can::types::Bus;

use crate::app::{APPLICATION, LINKS, Node, PROFILE};
use crate::application::Application;

#[embassy_executor::task(pool_size = 2)]
pub async fn bus(bus: Bus, port: Port, clock: Uptime) -> ! {
    bus_task(bus, port, clock, &LINKS, PROFILE.stamped).await
}

#[embassy_executor::task]
pub async fn node(node: &'static Node, clock: Uptime) -> ! {
    node_task(node, clock, &LINKS, &APPLICATION, &TELLTALE).await
}

#[embassy_executor::task]
pub async fn application(application: Application) -> ! {
    application.run().await
}
