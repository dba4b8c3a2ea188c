//! Arrows between packages and between modules run one way.

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

/// Root of the repository.
fn workspace() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}
