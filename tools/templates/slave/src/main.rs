//! The firmware of the board; on a computer, a program that prints the data sheet.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod app;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    use {{crate}}::{Heater, PROFILE};

    let made = ecss_can_eds::Timestamp::noon({{date}});
    let sheet = ecss_can_eds::Device {
        product: "Heater".into(),
        ..ecss_can_eds::Device::new(made)
    };
    ecss_can_eds::slave_program::<Heater>(&PROFILE, sheet)
}
