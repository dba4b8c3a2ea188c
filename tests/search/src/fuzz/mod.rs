//! Any sequence of frames: never a panic, never a wrong write, never stuck.
//!
//! A [target](Target) converts bytes to a sequence of operations (frames, time, results of sent frames) and compares
//! the behaviour with its own model. A [campaign](campaign::Campaign) runs it on inputs from a seed: the same seed and
//! number of executions give the same inputs, on every machine.

pub mod campaign;
pub mod corpus;
mod input;
mod mutation;
mod signature;
mod targets;

pub use input::Input;
pub use signature::Signature;

/// A component to be tested with any input.
#[derive(Clone, Copy)]
pub struct Target {
    /// Name on the command line and of the folder of its corpus.
    pub name: &'static str,
    /// Runs one execution. It panics at an error.
    pub run: fn(Input, &mut Signature),
}

/// All targets.
pub const TARGETS: [Target; 5] = [
    Target { name: "sdo-server", run: targets::sdo_server::run },
    Target { name: "sdo-client", run: targets::sdo_client::run },
    Target { name: "pdo-mapping", run: targets::pdo_mapping::run },
    Target { name: "nmt", run: targets::nmt::run },
    Target { name: "slave", run: targets::slave::run },
];

/// Returns the target with this name.
pub fn target(name: &str) -> Option<Target> {
    TARGETS.into_iter().find(|target| target.name == name)
}
