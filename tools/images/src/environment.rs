//! A clean environment for a cargo that is started by cargo.
//!
//! `cargo test` and `cargo run` set variables that would bind the inner cargo to the outer toolchain and its flags.

use std::process::Command;

/// Removes what an outer cargo or rustup has set.
pub fn clean(command: &mut Command) -> &mut Command {
    for (name, _) in std::env::vars_os() {
        let text = name.to_string_lossy();
        let of_toolchain =
            text.starts_with("RUSTC") || text.starts_with("RUSTUP_TOOLCHAIN") || text == "CARGO";
        let of_package = text.starts_with("CARGO_PKG_")
            || text.starts_with("CARGO_MANIFEST")
            || text == "CARGO_TARGET_DIR";
        let of_flags = text == "RUSTFLAGS" || text == "CARGO_ENCODED_RUSTFLAGS" || text == "LD_LIBRARY_PATH";
        if of_toolchain || of_package || of_flags {
            command.env_remove(&name);
        }
    }
    command
}
