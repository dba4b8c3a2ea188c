//! The test device: its image, and its data sheets for scripts. Also data sheets of the slaves on one bus.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use async_canopen::node::{CanopenSlave, Settings};
use async_canopen::od::Objects;
use async_canopen::types::NodeId;
use ecss_can_eds::{Commissioning, Description, Device, Timestamp};
use embassy_slave::Heater;
use mission::LIBRECUBE;

use crate::tools::workspace;

/// Node of the DCF.
const NODE: NodeId = NodeId::of::<3>();
/// Any timestamp, because no test checks it.
const MADE: Timestamp = Timestamp { year: 2026, month: 11, day: 22, hour: 12, minute: 0 };

/// The image, profile `librecube`.
///
/// # Errors
/// When it cannot be built.
pub fn image() -> anyhow::Result<PathBuf> {
    Ok(ecss_can_cli::images::build_fixture("test-device", LIBRECUBE.name)?)
}

/// Writes EDS and DCF into `target/second/device`; returns the EDS. The DCF is beside it and has `-3` in its name.
///
/// # Errors
/// When a file cannot be written.
pub fn data_sheet() -> anyhow::Result<PathBuf> {
    let device = Device {
        product: "Test device".into(),
        order_code: "test-device".into(),
        nodes: 2..=127,
        bit_rates: vec![10, 20, 50, 125, 250, 500, 1000],
        boot_up_slave: true,
        ..Device::new(MADE)
    };
    written("test-device", &device, |node| {
        let mut objects = fixtures::device(node, &LIBRECUBE, Vec::new()).build().objects().clone();
        // Boards have a parameter store.
        (objects.extension.storage.store, objects.extension.storage.restore) = ([1; 4], [1; 4]);
        objects
    })
}

/// As [`data_sheet`], of the slaves on one bus: `firmware/examples/embassy-slave`.
///
/// # Errors
/// When a file cannot be written.
pub fn heater_data_sheet() -> anyhow::Result<PathBuf> {
    let device = Device {
        product: "Heater".into(),
        nodes: 2..=127,
        bit_rates: vec![1000],
        boot_up_slave: true,
        ..Device::new(MADE)
    };
    written("heater", &device, |node| {
        CanopenSlave::new(node, &Settings::DEFAULT, Heater::default()).into_objects()
    })
}

/// Writes EDS and DCF of a device whose nodes have these objects.
fn written<D: Objects>(
    name: &str,
    device: &Device,
    objects: impl Fn(NodeId) -> D,
) -> anyhow::Result<PathBuf> {
    let description = Description::new(device, &objects)?;
    let [eds, dcf] = [format!("{name}.eds"), format!("{name}-{}.dcf", NODE.get())];
    let directory = workspace().join("target/second/device");
    fs::create_dir_all(&directory).with_context(|| format!("cannot make {}", directory.display()))?;
    let text = description.dcf(&dcf, &eds, &Commissioning::new(NODE), &mut objects(NODE))?;
    for (name, text) in [(&eds, description.eds(&eds)), (&dcf, text)] {
        // It is renamed, not written in place, because scripts of other tests may read it.
        let part = directory.join(format!("{name}.{:?}", std::thread::current().id()));
        fs::write(&part, text).with_context(|| format!("cannot write {}", part.display()))?;
        fs::rename(&part, directory.join(name))
            .with_context(|| format!("cannot rename {}", part.display()))?;
    }
    Ok(directory.join(eds))
}
