//! Programs that replace third-party ones: they run nothing, and only record their arguments.
#![cfg(unix)]

use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// Writes a program that is this script of the shell.
///
/// # Panics
/// When it cannot be written.
pub fn script(program: &Path, script: &str) {
    fs::create_dir_all(program.parent().expect("a folder")).expect("a folder");
    fs::write(program, format!("#!/bin/sh\n{script}")).expect("a file");
    fs::set_permissions(program, fs::Permissions::from_mode(0o755)).expect("executable");
}

/// Writes a program that writes its arguments to the returned file beside it, one a line, and ends with this code; a
/// request for its version succeeds.
///
/// # Panics
/// When it cannot be written.
pub fn fake(folder: &Path, name: &str, code: i32) -> PathBuf {
    let arguments = folder.join("arguments");
    let shown = arguments.display();
    let text = format!("[ \"$1\" = --version ] && exit 0\nprintf '%s\\n' \"$@\" > {shown}\nexit {code}\n");
    script(&folder.join(name), &text);
    arguments
}

/// Returns PATH without folders that have this program, `first` before all.
///
/// # Panics
/// When there is no PATH.
pub fn path_without(program: &str, first: Option<&Path>) -> OsString {
    let all = std::env::var_os("PATH").expect("PATH");
    let others = std::env::split_paths(&all).filter(|folder| !folder.join(program).exists());
    std::env::join_paths(first.map(Path::to_owned).into_iter().chain(others)).expect("folders")
}
