//! `cargo master` and `cargo slave` through their aliases, with a probe-rs that only records its arguments.
#![cfg(unix)]

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::XTASK;
use crate::fake::{fake, path_without};

/// PATH without any probe-rs, `first` before all.
pub fn path(first: Option<&Path>) -> OsString {
    path_without("probe-rs", first)
}

/// Runs `cargo NAME` as its alias does.
pub fn run(name: &str, arguments: &[&str], path: &OsString) -> Output {
    let (package, alias) = second::programs::alias(name);
    assert_eq!(package, "xtask", "cargo {name}");
    assert!(!alias.is_empty(), "cargo {name} names no command");
    XTASK.command(&[]).args(alias).args(arguments).env("PATH", path).output().expect("xtask starts")
}

/// A probe-rs that writes its arguments to a file, which is returned, and fails with code 7.
pub fn fake_probe_rs(folder: &Path) -> PathBuf {
    fake(folder, "probe-rs", 7)
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
