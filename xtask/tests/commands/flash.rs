//! `cargo master` and `cargo slave` through their aliases, with a probe-rs that only writes down how it was called.
#![cfg(unix)]

use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// PATH without any probe-rs, `first` before all.
pub fn path(first: Option<&Path>) -> OsString {
    let all = std::env::var_os("PATH").expect("PATH");
    let others = std::env::split_paths(&all).filter(|folder| !folder.join("probe-rs").exists());
    std::env::join_paths(first.map(Path::to_owned).into_iter().chain(others)).expect("folders")
}

/// Runs `cargo NAME` as its alias does.
pub fn run(name: &str, arguments: &[&str], path: &OsString) -> Output {
    let (package, alias) = second::programs::alias(name);
    assert_eq!(package, "xtask", "cargo {name}");
    assert!(!alias.is_empty(), "cargo {name} names no command");
    Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(alias)
        .args(arguments)
        .env("PATH", path)
        .output()
        .expect("xtask starts")
}

/// A probe-rs that writes its arguments to a file beside it, one a line, and fails with code 7.
pub fn fake_probe_rs(folder: &Path) -> PathBuf {
    let (program, arguments) = (folder.join("probe-rs"), folder.join("arguments"));
    let script = format!(
        "#!/bin/sh\n[ \"$1\" = --version ] && exit 0\nprintf '%s\\n' \"$@\" > {}\nexit 7\n",
        arguments.display()
    );
    fs::write(&program, script).expect("a file");
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).expect("executable");
    arguments
}

#[test]
fn image_is_built_and_handed_to_probe_rs() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let written = fake_probe_rs(here.path());
    let path = path(Some(here.path()));
    for (name, arguments, chip, image) in [
        (
            "slave",
            &["--board", "pyboard-v11", "--profile", "librecube"][..],
            "STM32F405RG",
            "pyboard-v11-librecube",
        ),
        ("master", &[], "STM32F405RG", "pyboard-v11-librecube"),
        ("minimal", &["--one-controller"], "STM32F405RG", "pyboard-v11-librecube+one-controller"),
        ("master", &["--board", "nucleo-f446re"], "STM32F446RETx", "nucleo-f446re-librecube"),
    ] {
        let output = run(name, &[arguments, &["--", "--probe", "1234:5678"]].concat(), &path);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(7), "the exit code of probe-rs: {stderr}");
        let told = fs::read_to_string(&written).expect("probe-rs was called");
        let [run, option, target, elf, rest @ ..] = &told.lines().collect::<Vec<_>>()[..] else {
            panic!("{told}")
        };
        assert_eq!([*run, *option, *target], ["run", "--chip", chip]);
        assert_eq!(rest, ["--probe", "1234:5678"]);
        assert!(elf.ends_with(name) && elf.contains(image), "{elf}");
        assert_eq!(fs::read(elf).expect("the image is there")[..4], *b"\x7FELF");
    }
}

#[test]
fn missing_probe_rs_is_reported_with_how_to_install_it() {
    let output = run("slave", &[], &path(None));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("probe-rs is not installed"), "{stderr}");
    assert!(stderr.contains("cargo install probe-rs-tools"), "{stderr}");
    assert!(!stderr.contains("build firmware"), "it says so before the build: {stderr}");
}

#[test]
fn wrong_arguments_are_refused_with_the_allowed_ones() {
    for (name, arguments, expected) in [
        ("slave", &["--board", "nucleo"][..], &["nucleo", "pyboard-v11", "nucleo-f446re"][..]),
        ("master", &["--profile", "warp"], &["warp", "librecube", "standard", "standby"]),
        ("master", &["--one-controller"], &["--one-controller", "cargo minimal"]),
        ("master", &["slave"], &["slave", "Usage: cargo xtask flash"]),
    ] {
        let output = run(name, arguments, &path(None));
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        for part in expected {
            assert!(stderr.contains(part), "{arguments:?}: no {part:?} in\n{stderr}");
        }
    }
}
