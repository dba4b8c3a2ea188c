//! A clean environment for a cargo that is started by cargo.
//!
//! `cargo test` and `cargo run` set variables that would bind the inner cargo to the outer toolchain and its flags.
//! Users set others for their own firmware. [`clean`] removes both. A configuration file of cargo stays in effect: a
//! build sets the variables that take precedence over it.

use std::process::Command;

use crate::images::TARGET;

/// Beginnings of variables of an outer cargo or rustup, and of settings for what is built.
const PREFIXES: [&str; 6] =
    ["RUSTC", "RUSTUP_TOOLCHAIN", "CARGO_PKG_", "CARGO_MANIFEST", "CARGO_PROFILE_", "CARGO_UNSTABLE_"];
const NAMES: [&str; 6] = [
    "CARGO",
    "CARGO_ENCODED_RUSTFLAGS",
    "CARGO_INCREMENTAL",
    "CARGO_TARGET_DIR",
    "LD_LIBRARY_PATH",
    "RUSTFLAGS",
];
/// The one setting of `build` that changes no image.
const JOBS: &str = "CARGO_BUILD_JOBS";

/// Removes variables set by an outer cargo or rustup, and by users for their own firmware.
pub fn clean(command: &mut Command) -> &mut Command {
    for (name, _) in std::env::vars_os() {
        if is_foreign(&name.to_string_lossy()) {
            command.env_remove(&name);
        }
    }
    command
}

/// Returns the host's cargo in a clean environment, independent of the toolchain that runs this program.
pub fn host_cargo() -> Command {
    let mut cargo = Command::new("cargo");
    clean(&mut cargo);
    cargo
}

/// Prefix of the variables with cargo's settings for [`TARGET`].
pub fn of_target() -> String {
    format!("CARGO_TARGET_{}_", TARGET.to_uppercase().replace('-', "_"))
}

/// Returns whether a variable would change the result or the place of a build.
fn is_foreign(name: &str) -> bool {
    let is_of_build = name.starts_with("CARGO_BUILD_") && name != JOBS;
    NAMES.contains(&name)
        || PREFIXES.iter().any(|prefix| name.starts_with(prefix))
        || is_of_build
        || name.starts_with(&of_target())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names by the chapter "Environment Variables" of the Cargo Book.
    #[test]
    fn variables_that_change_images_are_removed_and_no_others() {
        for name in [
            "CARGO_BUILD_TARGET",
            "CARGO_BUILD_RUSTFLAGS",
            "CARGO_BUILD_TARGET_DIR",
            "CARGO_ENCODED_RUSTFLAGS",
            "CARGO_INCREMENTAL",
            "CARGO_PROFILE_RELEASE_STRIP",
            "CARGO_TARGET_DIR",
            "CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER",
            "CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS",
            "RUSTC_WRAPPER",
            "RUSTFLAGS",
        ] {
            assert!(is_foreign(name), "{name}");
        }
        // The linker of build scripts and the source of crates are settings of the user.
        for name in [
            "CARGO_BUILD_JOBS",
            "CARGO_HOME",
            "CARGO_HTTP_PROXY",
            "CARGO_NET_OFFLINE",
            "CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_LINKER",
            "PATH",
            "RUSTUP_HOME",
        ] {
            assert!(!is_foreign(name), "{name}");
        }
    }
}
