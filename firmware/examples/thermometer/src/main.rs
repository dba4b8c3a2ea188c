//! Firmware of the thermometer. On the host it prints its data sheet.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(target_os = "none")]
mod app;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    let made = eds::Timestamp { year: 2026, month: 11, day: 22, hour: 12, minute: 0 };
    let device = eds::Device {
        vendor: "The ecss-can authors".into(),
        product: "Thermometer".into(),
        order_code: "thermometer".into(),
        nodes: 2..=15,
        bit_rates: vec![1000],
        boot_up_slave: true,
        ..eds::Device::new(made)
    };
    eds::program(&device, |id| thermometer::slave(id, Vec::new()).objects().clone())
}
