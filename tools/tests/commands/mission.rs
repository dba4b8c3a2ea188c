//! Mission files, and flights of a project of the user's.

use std::fs;
use std::path::Path;

use second::programs::root;
use serde_json::Value;
use toml::Table;

use crate::TOOLS;

/// The example of the documentation.
const EXAMPLE: &str = "docs/missions/thermometer.toml";

/// Reads `summary.json` of a flight.
fn summary(out: &Path) -> Value {
    serde_json::from_slice(&fs::read(out.join("summary.json")).expect("a summary")).expect("JSON")
}

/// Given the mission file of the documentation, when it is flown, then its package is built and has a data sheet, its faults are caused, its
/// criteria hold, and its page shows it as it is.
#[test]
fn example_of_the_documentation_flies() {
    let file = root().join(EXAMPLE);
    let page = fs::read_to_string(root().join("docs/mission-file.md")).expect("a page");
    assert!(page.contains(&fs::read_to_string(&file).expect("a file")), "the page shows another file");
    let out = tempfile::tempdir().expect("a temporary directory");
    let out = out.path();
    let (code, stdout, stderr) =
        TOOLS.run(&["fly", file.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    for part in [
        "===== node 5 loses its power =====",
        "===== the nominal bus is cut next to the master =====",
        "===== the nominal bus is mended =====",
    ] {
        assert!(stdout.contains(part), "no {part:?} in {stdout}");
    }
    let summary = summary(out);
    assert_eq!((&summary["own_images"]["5"], &summary["lost_frames"]), (&"thermometer".into(), &0.into()));
    let checks: Vec<&str> = summary["checks"]
        .as_array()
        .expect("checks")
        .iter()
        .filter_map(|check| check["name"].as_str())
        .collect();
    let of = |name: &str| checks.iter().filter(|check| **check == name).count();
    let counts = ["operational in time", "answers in time", "fail-over in time"].map(of);
    assert_eq!(counts, [4, 3, 3], "{checks:?}");
}

/// Given a criterion that does not hold, and a fault that cannot be caused, then the flight fails and names line and key of both.
#[test]
fn criterion_that_does_not_hold_fails_the_flight() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let file = here.path().join("m.toml");
    let text = "profile = \"standard\"\nslaves = 1\nseconds = 1\n[[fault]]\nat = 0\ncommand = \"reset 2\"\n\
                [[criterion]]\noperational-at = 0.01\n";
    fs::write(&file, text).expect("a file");
    let out = here.path().join("out");
    let arguments = ["fly", file.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")];
    let (code, stdout, stderr) = TOOLS.run(&arguments);
    assert_eq!(code, 1, "{stdout}{stderr}");
    for part in [
        "m.toml:6: fault[0].command: node 2 has no power: power 2 on",
        "m.toml:8: criterion[0].operational-at: node 2 operational at 0.01 s, found: starting",
    ] {
        assert!(stderr.contains(part), "no {part:?} in {stderr}");
    }
    fs::write(&file, "slaves = 1\nsecond = 1\n").expect("a file");
    TOOLS.refuses(&arguments, &["m.toml:2: second: unknown field `second`, expected one of `board`"]);
    TOOLS.refuses(&["fly", "nowhere.toml"], &["nowhere.toml", "give a mission file (TOML)"]);
    TOOLS.refuses(&["fly", "--place", "9=3"], &["'9=3' for '--place <N=METRES>'", "no board is node 9"]);
    TOOLS.refuses(&["fly", "--fault", "1 jump"], &["--fault <S COMMAND>", "allowed are cut, heal"]);
}

/// Given a package of a slave in a folder that is no part of this repository, when `fly` runs there without a path, then the package
/// is built with its data sheet and flown as node 5 beside a shipped slave. Options give its place and its faults.
#[test]
fn project_of_the_user_flies_without_paths() {
    let here = tempfile::tempdir().expect("a temporary directory");
    // Kept: what is built there is the same each time.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("greenhouse");
    write_project(here.path(), &target);
    let line = "fly --slaves 1 --seconds 3 --place 5=40 --crystal 5=-30";
    let faults = ["--fault", "1.5 cut nominal 35.5", "--fault", "2 heal nominal", "--fault", "2.2 reset 5"];
    let words: Vec<&str> = line.split(' ').chain(faults).collect();
    let mut command = TOOLS.command(&words);
    command.current_dir(here.path()).env_remove("CARGO_TARGET_DIR");
    let output = command.output().expect("it starts");
    let [stdout, stderr] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).expect("UTF-8"));
    assert_eq!(output.status.code(), Some(0), "{stdout}{stderr}");
    for part in ["the nominal bus is cut between the slaves", "the nominal bus is mended", "node 5 is reset"]
    {
        assert!(stdout.contains(part), "no {part:?} in {stdout}");
    }
    let summary = summary(&target.join("fly"));
    assert_eq!(
        (&summary["own_images"]["5"], &summary["profile"]),
        (&"greenhouse".into(), &"standard".into())
    );
    assert_eq!((&summary["board"], &summary["lost_frames"]), (&"pyboard-v11".into(), &0.into()));
    let report = fs::read_to_string(target.join("fly/report.html")).expect("a report");
    assert!(report.contains("40.0 m") && report.contains("-30.0 ppm"), "place and crystal of node 5");
    assert!(target.join("firmware/greenhouse").is_file(), "its image");
}

/// Writes a package with the sources of an example, and with this target directory.
fn write_project(folder: &Path, target: &Path) {
    let example = root().join("firmware/examples/thermometer");
    let parse = |path: &Path| fs::read_to_string(path).expect("a manifest").parse::<Table>().expect("TOML");
    let workspace = parse(&root().join("Cargo.toml"));
    let known = workspace["workspace"]["dependencies"].as_table().expect("dependencies");
    let mut manifest = parse(&example.join("Cargo.toml"));
    manifest.remove("lints");
    let package = [("name", "greenhouse"), ("version", "0.1.0"), ("edition", "2024")];
    let package = Table::from_iter(package.map(|(key, value)| (key.to_owned(), value.into())));
    manifest.insert("package".into(), package.into());
    manifest.insert("lib".into(), Table::from_iter([("name".to_owned(), "thermometer".into())]).into());
    manifest.insert("workspace".into(), Table::new().into());
    let complete = |of: &mut Table| {
        for (name, dependency) in of["dependencies"].as_table_mut().expect("dependencies") {
            *dependency = completed(dependency, known.get(name), &example).into();
        }
    };
    complete(&mut manifest);
    for (_, target) in manifest["target"].as_table_mut().expect("targets") {
        complete(target.as_table_mut().expect("a target"));
    }
    ["src", ".cargo"].iter().for_each(|name| fs::create_dir(folder.join(name)).expect("a folder"));
    let configuration = format!("[build]\ntarget-dir = {:?}\n", target.display().to_string());
    fs::write(folder.join(".cargo/config.toml"), configuration).expect("a file");
    fs::write(folder.join("Cargo.toml"), manifest.to_string()).expect("a file");
    fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock")).expect("a copy");
    fs::copy(example.join("build.rs"), folder.join("build.rs")).expect("a copy");
    for source in fs::read_dir(example.join("src")).expect("a folder") {
        let source = source.expect("an entry");
        fs::copy(source.path(), folder.join("src").join(source.file_name())).expect("a copy");
    }
}

/// Returns a dependency with what the workspace says of it, and with an absolute path.
fn completed(dependency: &toml::Value, known: Option<&toml::Value>, example: &Path) -> Table {
    let mut own = dependency.as_table().expect("a table").clone();
    let (mut whole, folder) = match (own.remove("workspace"), known) {
        (Some(_), Some(toml::Value::Table(known))) => (known.clone(), root()),
        (Some(_), Some(version)) => (Table::from_iter([("version".to_owned(), version.clone())]), root()),
        _ => (Table::new(), example.to_owned()),
    };
    let features =
        |table: &Table| table.get("features").and_then(|all| all.as_array()).cloned().unwrap_or_default();
    let features = [features(&whole), features(&own)].concat();
    whole.extend(own);
    whole.insert("features".into(), features.into());
    if let Some(path) = whole.get_mut("path") {
        *path = folder.join(path.as_str().expect("a path")).display().to_string().into();
    }
    whole
}
