//! Measures the cable to the slave in 6320h.

use boards_stm32f4::supervised;
use ecss_can::runner::Handle;
use ecss_can::types::NodeId;
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex as Raw;
use embassy_sync::signal::Signal;
use mission::{CableMeasurement, CommanderObjects};

use super::{Board, Node};

/// A slave whose cable is to be measured.
static WANTED: Signal<Raw, NodeId> = Signal::new();

/// 6320h was written.
pub fn start(master: Handle<Board, Node>) {
    let node = master.with(|master, _| master.objects().application.device.cable.node);
    if let Some(node) = NodeId::new(node).filter(|node| *node != NodeId::MASTER) {
        master.change(|objects| objects.cable.progress = CableMeasurement::RUNNING);
        WANTED.signal(node);
    }
}

/// Measures the slave that was named last.
#[embassy_executor::task]
pub fn cables(master: Handle<Board, Node>) -> impl Future<Output = ()> {
    supervised("cables", measure(master))
}

async fn measure(master: Handle<Board, Node>) -> ! {
    loop {
        let node = WANTED.wait().await;
        let measured = master.measure_cable(node).await;
        defmt::info!("cable to slave {}: {}", node.get(), measured);
        if WANTED.signaled() {
            // 6320h names another slave by now: what it shows is to be of that one.
            continue;
        }
        master.change(|CommanderObjects { cable, .. }| {
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
