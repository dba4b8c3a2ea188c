//! `cargo master` and `cargo slave` through their aliases, with a probe-rs that only records its arguments.
#![cfg(unix)]

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use second::programs::boards::elsewhere;
use second::programs::fake::{fake, path_without};

use crate::TOOLS;

/// PATH without any probe-rs, `first` before all.
fn path(first: Option<&Path>) -> OsString {
    path_without("probe-rs", first)
}

/// Runs `cargo NAME` as its alias does.
fn run(name: &str, arguments: &[&str], path: &OsString) -> Output {
    let (package, alias) = second::programs::alias(name);
    assert_eq!(package, "ecss-can-cli", "cargo {name}");
    assert!(!alias.is_empty(), "cargo {name} names no command");
    TOOLS.command(&[]).args(alias).args(arguments).env("PATH", path).output().expect("the program starts")
}

/// A probe-rs that writes its arguments to a file, which is returned, and fails with code 7.
fn fake_probe_rs(folder: &Path) -> PathBuf {
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
        ("master", &["--one-controller"], &["--one-controller", "flash minimal"]),
        ("master", &["slave"], &["slave", "Usage: ecss-can flash"]),
    ] {
        let output = run(name, arguments, &path(None));
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        for part in expected {
            assert!(stderr.contains(part), "{arguments:?}: no {part:?} in\n{stderr}");
        }
    }
}

#[test]
fn image_for_a_board_elsewhere_is_handed_to_probe_rs() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let written = fake_probe_rs(here.path());
    let arguments = ["--profile", "standard", "--board", &elsewhere(env!("CARGO_TARGET_TMPDIR"))];
    let output = run("slave", &arguments, &path(Some(here.path())));
    assert_eq!(output.status.code(), Some(7), "the exit code of probe-rs: {output:?}");
    let said = fs::read_to_string(&written).expect("probe-rs was called");
    assert!(said.starts_with("run\n--chip\nSTM32F405RG\n") && said.contains("/moved-"), "{said}");
}

/// Given ELF files of the user, then the chip is that of `--board`, or the one that the image was linked for.
#[test]
fn own_image_is_flashed_to_the_chip_that_it_names() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let written = fake_probe_rs(here.path());
    let path = path(Some(here.path()));
    let image = |board| ecss_can_cli::images::build(board, "librecube").expect("images").slave;
    let flash = |image: &Path, rest: &[&str]| {
        let image = image.to_str().expect("UTF-8");
        let output =
            TOOLS.command(&["flash", image]).args(rest).env("PATH", &path).output().expect("it starts");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    for (board, chip) in [("pyboard-v11", "STM32F405RG"), ("nucleo-f446re", "STM32F446RE")] {
        let (code, stderr) = flash(&image(board), &["--", "--speed", "4000"]);
        assert_eq!(code, Some(7), "{stderr}");
        let said = fs::read_to_string(&written).expect("probe-rs was called");
        assert!(said.starts_with(&format!("run\n--chip\n{chip}\n")), "{said}");
        assert!(said.ends_with("/slave\n--speed\n4000\n"), "{said}");
    }
    let (code, _) = flash(&image("pyboard-v11"), &["--board", "stm32f4discovery"]);
    assert_eq!(code, Some(7));
    let said = fs::read_to_string(&written).expect("probe-rs was called");
    assert!(said.contains("STM32F407VG"), "{said}");
    let (code, stderr) = flash(&image("pyboard-v11"), &["--board", "nucleo-f446re"]);
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("413h") && stderr.contains("Usage: ecss-can flash"), "{stderr}");
    let without = here.path().join("without");
    let mut elf = fs::read(image("pyboard-v11")).expect("an image");
    let place = elf.windows(11).position(|bytes| bytes == b"__device_id").expect("the symbol");
    elf[place] = b'X';
    fs::write(&without, elf).expect("a file");
    let (code, stderr) = flash(&without, &[]);
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("no symbol `__device_id`") && stderr.contains("--board"), "{stderr}");
}

#[test]
fn image_that_does_not_exist_is_refused_with_the_known_ones() {
    TOOLS.refuses(&["flash", "rover"], &["rover", "master, slave, minimal, or the path of an ELF file"]);
    TOOLS.refuses(&["flash"], &["give master, slave, minimal", "Usage: ecss-can flash"]);
    TOOLS.refuses(&["flash", "slave", "--package", "heater"], &["--package", "cannot be used with"]);
}
