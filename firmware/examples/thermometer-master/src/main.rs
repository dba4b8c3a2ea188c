//! Firmware of the thermometer's master. On the host it prints its data sheet.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(target_os = "none")]
mod app;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    let made = ecss_can_eds::Timestamp::noon(2026, 11, 22);
    let sheet =
        ecss_can_eds::Device { product: "Thermometer master".into(), ..ecss_can_eds::Device::new(made) };
    ecss_can_eds::master_program::<thermometer_master::Ground>(&thermometer::PROFILE, sheet)
}
