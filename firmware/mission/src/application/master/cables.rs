//! Measures the cable to the slave in 6320h.

use ecss_can::redundancy::MasterBoards;
use ecss_can::runner::{Handle, MasterHandle, Platform};
use ecss_can::types::NodeId;
#[cfg(not(target_os = "none"))]
use embassy_sync::blocking_mutex::raw::NoopRawMutex as Raw;
#[cfg(target_os = "none")]
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex as Raw;
use embassy_sync::signal::Signal;

use super::Node;
use crate::{CableMeasurement, CommanderObjects, info};

/// Measurements of cables. [`Application`](super::Application) starts them, a separate task runs them. An image holds
/// this in a static.
pub struct Cables {
    /// Slave whose cable is to be measured next.
    wanted: Signal<Raw, NodeId>,
}

impl Default for Cables {
    fn default() -> Self {
        Self::new()
    }
}

impl Cables {
    /// Makes an instance without a requested measurement.
    pub const fn new() -> Cables {
        Cables { wanted: Signal::new() }
    }

    /// Starts the measurement that a client wrote to 6320h.
    pub(super) fn start<B: MasterBoards>(&self, master: Handle<impl Platform, Node<B>>) {
        let node = master.read(|objects| objects.cable.node);
        if let Some(node) = NodeId::new(node).filter(|node| *node != NodeId::MASTER) {
            master.update(|objects| objects.cable.progress = CableMeasurement::RUNNING);
            self.wanted.signal(node);
        }
    }

    /// Runs for ever: measures the cable to the slave that was requested last.
    pub async fn run<B: MasterBoards>(&self, master: Handle<impl Platform, Node<B>>) -> ! {
        loop {
            let node = self.wanted.wait().await;
            let measured = master.measure_cable(node).await;
            info!("cable to slave {}: {}", node.get(), measured);
            if self.wanted.signaled() {
                // 6320h has been set to another slave: this result must not be shown.
                continue;
            }
            master.update(|CommanderObjects { cable, .. }| {
                (cable.progress, cable.abort) = match measured {
                    Ok(_) => (CableMeasurement::MEASURED, 0),
                    Err(error) => (CableMeasurement::FAILED, error.code()),
                };
                if let Ok(measured) = measured {
                    (cable.bus, cable.delay) = (measured.bus.bdefault(), measured.delay_ns);
                }
            });
        }
    }
}
