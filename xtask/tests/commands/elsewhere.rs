//! A board whose crate is in another folder: the shipped images are built for it and flashed to it.

use std::fs;

use second::programs::boards::elsewhere;

use crate::XTASK;
use crate::docs::root;
#[cfg(unix)]
use crate::flash::{fake_probe_rs, path, run};

fn board() -> String {
    elsewhere(env!("CARGO_TARGET_TMPDIR"))
}

/// Given the crate of a board elsewhere, then `firmware` prints where its images are: in a folder that no board of this project has.
#[test]
fn firmware_is_built_for_a_board_elsewhere() {
    let (code, lines, stderr) = XTASK.run(&["firmware", "--profile", "standard", "--board", &board()]);
    assert_eq!(code, 0, "{stderr}");
    for (line, image) in lines.lines().zip(["master", "slave", "minimal"]) {
        assert!(line.starts_with(image) && line.ends_with(&format!("/{image}")), "{lines}");
        assert!(line.contains("/firmware/moved-") && line.contains("-standard/"), "{lines}");
    }
    assert_eq!(lines.lines().count(), 3);
}

#[test]
fn self_test_flies_on_a_board_elsewhere() {
    let (code, stdout, stderr) = XTASK.run(&["selftest", "--twin", "--board", &board()]);
    assert_eq!(code, 0, "{stdout}{stderr}");
}

#[cfg(unix)]
#[test]
fn image_for_a_board_elsewhere_is_handed_to_probe_rs() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let written = fake_probe_rs(here.path());
    let arguments = ["--profile", "standard", "--board", &board()];
    let output = run("slave", &arguments, &path(Some(here.path())));
    assert_eq!(output.status.code(), Some(7), "the exit code of probe-rs: {output:?}");
    let said = fs::read_to_string(&written).expect("probe-rs was called");
    assert!(said.starts_with("run\n--chip\nSTM32F405RG\n") && said.contains("/moved-"), "{said}");
}

/// Given a package of the user's that names its board in its manifest, then it is built for that board alone.
#[test]
fn package_with_a_board_in_its_manifest_takes_no_other() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    fs::create_dir(folder.path().join("src")).expect("a folder");
    let manifest = folder.path().join("Cargo.toml");
    let dependency = format!(
        "[package]\nname = \"heater\"\nedition = \"2024\"\n[dependencies]\n\
         board = {{ package = \"pyboard-v11\", path = \"{}/boards/pyboard-v11\" }}\n",
        root().display()
    );
    fs::write(&manifest, dependency).expect("a file");
    fs::write(folder.path().join("src/lib.rs"), "").expect("a file");
    let manifest = manifest.to_str().expect("UTF-8");
    for (arguments, said) in [
        (
            ["--package", "heater", "--board", "nucleo-f446re"],
            &["the package heater has no dependency nucleo-f446re", "it chooses its board in Cargo.toml"][..],
        ),
        (["--package", "cooler", "--board", "nucleo-f446re"], &["'cooler'", "allowed are heater"]),
    ] {
        XTASK.refuses(&[&["firmware", "--manifest-path", manifest], &arguments[..]].concat(), said);
    }
}
