//! Any sequence of frames: never a panic, never a wrong write, never stuck.
//!
//! A [target](Target) makes of bytes a sequence of operations (frames, time, what becomes of sent frames) and compares what
//! happens with a model of its own. A [campaign](campaign::Campaign) runs it on inputs from a seed: the same seed and number
//! of executions give the same inputs, on every machine.

pub mod campaign;
pub mod corpus;
mod input;
mod mutation;
mod signature;
mod targets;

pub use input::Input;
pub use signature::Signature;

/// Something to be tried with any input.
#[derive(Clone, Copy)]
pub struct Target {
    /// What it is called on the command line; its corpus is in the folder of this name.
    pub name: &'static str,
    /// One execution. It panics when something is wrong.
    pub run: fn(Input, &mut Signature),
}

/// All of them.
pub const TARGETS: [Target; 5] = [
    Target { name: "sdo-server", run: targets::sdo_server::run },
    Target { name: "sdo-client", run: targets::sdo_client::run },
    Target { name: "pdo-mapping", run: targets::pdo_mapping::run },
    Target { name: "nmt", run: targets::nmt::run },
    Target { name: "slave", run: targets::slave::run },
];

/// The target of this name.
pub fn target(name: &str) -> Option<Target> {
    TARGETS.into_iter().find(|target| target.name == name)
}
