//! Firmware of the thermometer. On the host it prints its data sheet.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(target_os = "none")]
mod app;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    let sheet = ecss_can_eds::Device {
        vendor: "The ecss-can authors".into(),
        product: "Thermometer".into(),
        nodes: 2..=15,
        ..ecss_can_eds::Device::new(ecss_can_eds::Timestamp::noon(2026, 11, 22))
    };
    ecss_can_eds::slave_program::<thermometer::Thermometer>(&thermometer::PROFILE, sheet)
}
