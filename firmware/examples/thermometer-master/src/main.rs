//! Firmware of the thermometer's master. On the host it prints its data sheet.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(target_os = "none")]
mod app;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    let made = eds::Timestamp::noon(2026, 11, 22);
    let sheet = eds::Device { product: "Thermometer master".into(), ..eds::Device::new(made) };
    eds::master_program::<thermometer_master::Ground>(&thermometer::PROFILE, sheet)
}
