//! The tasks: one for each bus, one for what is due, one for the application.

use boards::{Port, TELLTALE, Uptime};
use ecss_can::runner::{bus_task, node_task};
use ecss_can::types::Bus;

use crate::app::{APPLICATION, Node};
use crate::application::Application;

#[embassy_executor::task(pool_size = 2)]
pub async fn bus(bus: Bus, port: Port, clock: Uptime, node: &'static Node) -> ! {
    match bus_task(bus, port, clock, node, &APPLICATION, &TELLTALE).await {}
}

#[embassy_executor::task]
pub async fn node(node: &'static Node, clock: Uptime) -> ! {
    match node_task(node, clock, &APPLICATION, &TELLTALE).await {}
}

#[embassy_executor::task]
pub async fn application(application: Application) -> ! {
    application.run().await
}
