//! A board whose crate is in another folder: the shipped images are built for it, fly on it and are flashed to it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::LazyLock;

use serde_json::Value;

use crate::docs::root;
#[cfg(unix)]
use crate::flash::{fake_probe_rs, path, run};

const MANIFEST: &str = r#"
[package]
name = "moved"
version = "1.0.0"
edition = "2024"

[target.'cfg(target_os = "none")'.dependencies]
boards-stm32f4 = { path = "ROOT/boards/stm32f4", default-features = false }
embassy-stm32 = { version = "=0.6.0", default-features = false, features = ["stm32f405rg"] }

[build-dependencies]
boards-memory = { path = "ROOT/boards/memory" }

[workspace]
"#;

/// Folder of the crate of a board: the pyboard with its straps moved, so that no image of the pyboard flies on it. It is the same folder
/// each time: what is built for it is kept.
static BOARD: LazyLock<String> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("moved");
    fs::create_dir_all(folder.join("src")).expect("a folder");
    let write = |path: &str, text: String| {
        let path = folder.join(path);
        if fs::read_to_string(&path).is_ok_and(|there| there == text) {
            return;
        }
        fs::write(path, text).expect("a file");
    };
    write("Cargo.toml", MANIFEST.replace("ROOT", &root().display().to_string()));
    for path in ["build.rs", "board.toml", "src/lib.rs"] {
        let text = fs::read_to_string(root().join("boards/pyboard-v11").join(path)).expect("the pyboard");
        let moved = text.replace("pyboard-v11", "moved").replace("PA2", "PC2").replace("PA3", "PC3");
        write(path, moved);
    }
    folder.to_str().expect("UTF-8").to_owned()
});

fn xtask(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask")).args(arguments).output().expect("xtask starts")
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned()
}

/// Given the crate of a board elsewhere, when the shipped images fly on it and the nominal bus is cut, then all of them follow the
/// master. They are found again without a build, and the images of this project's boards stay as they were.
#[test]
fn shipped_images_fly_on_a_board_elsewhere() {
    let usual = firmware_images::build("pyboard-v11", "standard").expect("images");
    let before = fs::read(&usual.slave).expect("an image");
    let here = tempfile::tempdir().expect("a temporary directory");
    let out = here.path().to_str().expect("UTF-8");
    let flight =
        ["demo", "--board", &BOARD, "--profile", "standard", "--slaves", "1", "--minimal", "1", "--out", out];
    for more in [&["--seconds", "3", "--cut-at", "1.5"][..], &["--seconds", "2", "--no-build"]] {
        let output = xtask(&[&flight[..], more].concat());
        assert!(output.status.success(), "{}", text(&output));
        let summary = fs::read(here.path().join("summary.json")).expect("a summary");
        let summary: Value = serde_json::from_slice(&summary).expect("JSON");
        assert_eq!((&summary["board"], &summary["lost_frames"]), (&"moved".into(), &0.into()), "{summary}");
        assert_eq!(summary["slaves_operational_at_end"], 2);
    }
    assert_eq!(fs::read(&usual.slave).expect("an image"), before);
}

/// Given the same, then `firmware` prints where its images are: in a folder that no board of this project has.
#[test]
fn firmware_is_built_for_a_board_elsewhere() {
    let output = xtask(&["firmware", "--profile", "standard", "--board", &BOARD]);
    assert!(output.status.success(), "{}", text(&output));
    let lines = String::from_utf8(output.stdout).expect("UTF-8");
    for (line, image) in lines.lines().zip(["master", "slave", "minimal"]) {
        assert!(line.starts_with(image) && line.ends_with(&format!("/{image}")), "{lines}");
        assert!(line.contains("target/firmware/moved-") && line.contains("-standard/"), "{lines}");
    }
    assert_eq!(lines.lines().count(), 3);
}

#[test]
fn self_test_flies_on_a_board_elsewhere() {
    let output = xtask(&["selftest", "--twin", "--board", &BOARD]);
    assert!(output.status.success(), "{}", text(&output));
}

#[cfg(unix)]
#[test]
fn image_for_a_board_elsewhere_is_handed_to_probe_rs() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let written = fake_probe_rs(here.path());
    let arguments = ["--profile", "standard", "--board", &BOARD];
    let output = run("slave", &arguments, &path(Some(here.path())));
    assert_eq!(output.status.code(), Some(7), "the exit code of probe-rs: {}", text(&output));
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
        let output = xtask(&[&["firmware", "--manifest-path", manifest], &arguments[..]].concat());
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(said.iter().all(|part| text(&output).contains(part)), "{}", text(&output));
    }
}
