//! Masters and slaves on two simulated buses: what the standard wants, seen from outside.

mod application_events;
mod babbling;
mod boot;
mod clock;
mod crowd;
mod determinism;
mod disturbed;
mod doubles;
mod failover;
mod filters;
mod indicators;
mod log_lines;
mod mappings;
mod master_application;
mod messages;
mod minimal;
mod minimal_application;
mod mission_world;
mod one_controller;
mod outages;
mod pair;
mod prototype;
#[path = "../random/mod.rs"]
mod random;
mod recovery;
mod scripts;
mod sdo_client;
mod separate_buses;
mod shipped_minimal;
mod slave_application;
mod start_up;
mod support;
mod thermometer;
mod time;
mod toggling;
mod yielding;
