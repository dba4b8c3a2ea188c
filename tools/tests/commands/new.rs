//! `new`: files of the projects, and refused names; `completions` and `man`, which list its commands.

use std::fs;
use std::path::Path;

use crate::{TOOLS, assert_refused};

/// Runs `new` in a folder. Returns exit code and stderr.
fn new(here: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = TOOLS.command(&[&["new"], arguments].concat()).current_dir(here).output();
    let output = output.expect("the program starts");
    (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Files of a folder and its subfolders.
fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![read(&path)] }).collect()
}

#[test]
fn projects_have_no_open_places_and_name_crates_by_version() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let top = here.path();
    for (kind, name) in [("slave", "cooler-2"), ("master", "ground"), ("board", "h407")] {
        assert_eq!(new(top, &[kind, name]), (Some(0), String::new()));
        assert!(files(&top.join(name)).iter().all(|text| !text.contains("{{")), "{kind}");
    }
    let manifest = read(&top.join("cooler-2/Cargo.toml"));
    let version = env!("CARGO_PKG_VERSION").rsplit_once('.').expect("three numbers").0;
    assert!(manifest.contains("name = \"cooler-2\"\n"), "{manifest}");
    assert!(manifest.contains(&format!("\necss-can = \"{version}\"\n")), "{manifest}");
    assert!(!manifest.contains("path ="), "{manifest}");
    assert!(read(&top.join("cooler-2/tests/world.rs")).contains("use cooler_2::{"));
    assert!(read(&top.join("ground/heater/Cargo.toml")).contains("name = \"heater\"\n"));
    assert!(read(&top.join("h407/board.toml")).contains("name = \"h407\"\n"));
}

#[test]
fn board_node_and_slave_are_chosen_by_options() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let top = here.path();
    assert_eq!(new(top, &["board", "h407"]).0, Some(0));
    assert_eq!(new(top, &["slave", "cooler", "--board", "h407", "--node", "7"]).0, Some(0));
    assert_eq!(new(top, &["master", "ground", "--slave", "cooler", "--board", "nucleo-f446re"]).0, Some(0));
    let manifest = read(&top.join("cooler/Cargo.toml"));
    assert!(manifest.contains("\nboard = { package = \"h407\", path = \"../h407\" }\n"), "{manifest}");
    assert!(read(&top.join("cooler/mission.toml")).contains("id = 7\npackage = \"cooler\"\n"));
    let manifest = read(&top.join("ground/Cargo.toml"));
    assert!(manifest.contains("\ncooler = { path = \"../cooler\" }\n"), "{manifest}");
    assert!(manifest.contains("\nboard = { package = \"ecss-can-nucleo-f446re\", version ="), "{manifest}");
    assert!(read(&top.join("ground/src/lib.rs")).contains("use cooler::{"));
}

#[test]
fn names_and_folders_that_cannot_be_used_are_refused() {
    assert_refused(&[
        ("new slave 2heater", &["2heater", "<NAME>", "allowed are a small letter"]),
        ("new slave fn", &["keyword of Rust"]),
        ("new slave defmt", &["depends on one of this name"]),
        ("new master heater", &["depends on one of this name"]),
        ("new board test", &["cargo reserves it"]),
        ("new slave heater --board nowhere", &["--board", "pyboard-v11", "nucleo-f446re"]),
        ("new slave heater --node 16", &["--node", "2..=15"]),
        ("new master ground --slave nowhere", &["--slave", "nowhere", "folder of a package"]),
        ("new rover heater", &["rover"]),
    ]);
    let here = tempfile::tempdir().expect("a temporary directory");
    fs::create_dir(here.path().join("heater")).expect("a folder");
    let (code, stderr) = new(here.path(), &["slave", "heater"]);
    assert_eq!(code, Some(2));
    assert!(stderr.contains("the folder exists; allowed is the name of a new one"), "{stderr}");
    assert!(files(here.path()).is_empty());
}

#[test]
fn completions_and_man_pages_have_all_commands() {
    let names: Vec<String> = TOOLS.subcommands().into_iter().map(|(name, _)| name).collect();
    for shell in ["bash", "zsh", "fish"] {
        let (code, script, stderr) = TOOLS.run(&["completions", shell]);
        assert_eq!((code, &*stderr), (0, ""));
        assert!(names.iter().all(|name| script.contains(name.as_str())), "{shell}: {script}");
    }
    let here = tempfile::tempdir().expect("a temporary directory");
    let folder = here.path().join("man1");
    let (code, _, stderr) = TOOLS.run(&["man", folder.to_str().expect("UTF-8")]);
    assert_eq!(code, 0, "{stderr}");
    for name in names.iter().filter(|name| *name != "help") {
        assert!(folder.join(format!("ecss-can-{name}.1")).is_file(), "{name}");
    }
    assert!(read(&folder.join("ecss-can-new-slave.1")).contains("Examples"));
}

/// Given a machine that runs these tests, then it can build images.
#[test]
fn doctor_finds_what_this_computer_has() {
    let (code, stdout, stderr) = TOOLS.run(&["doctor"]);
    assert_eq!((code, &*stderr), (0, ""), "{stdout}");
    assert!(stdout.contains("toolchain for thumbv7em-none-eabihf:"), "{stdout}");
    assert!(stdout.ends_with("Images can be built.\n"), "{stdout}");
}
