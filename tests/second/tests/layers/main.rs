//! Dependencies between packages and between modules have one direction.

mod circles;
mod features;
mod indices;
mod modules;
mod paths;
mod protocol;
mod rooms;
mod targets;
mod untested;
mod words;

use std::path::PathBuf;

/// Returns the root of the repository.
fn workspace() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}
