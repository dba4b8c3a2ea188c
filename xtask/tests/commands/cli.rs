//! The command line: help, wrong values, exit codes.

use std::process::Command;

/// Runs xtask; gives exit code, stdout, stderr.
fn xtask(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_xtask")).args(arguments).output().expect("xtask starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("xtask prints UTF-8");
    (output.status.code().expect("xtask exits"), text(output.stdout), text(output.stderr))
}

/// A wrong command line must end with code 2, name the option and say what is allowed.
fn refuses(arguments: &[&str], expected: &[&str]) {
    let (code, stdout, stderr) = xtask(arguments);
    assert_eq!(code, 2, "{arguments:?}: {stderr}");
    assert_eq!(stdout, "", "{arguments:?}");
    for part in expected {
        assert!(stderr.contains(part), "{arguments:?}: no {part:?} in\n{stderr}");
    }
}

#[test]
fn help_explains_every_option_with_default_and_range() {
    let (code, help, _) = xtask(&["demo", "--help"]);
    assert_eq!(code, 0);
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "--slaves <N>",
        "[0..14]",
        "[default: 3]",
        "--minimal <N>",
        "[0..13]",
        "--one-controller <N>",
        "--master <FILE>",
        "--slave <N=FILE>",
        "--profile <PROFILE>",
        "--seconds <S>",
        "[1..3600]",
        "[default: 40]",
        "--cut-at <S>",
        "[0..SECONDS]",
        "[default: half of SECONDS]",
        "--seed <N>",
        "[default: 1]",
        "--board <BOARD>",
        "pyboard-v11",
        "nucleo-f446re",
        "--out <DIR>",
        "[default: target/demo]",
        "Exit code 0",
    ] {
        assert!(help.contains(part), "no {part:?} in\n{help}");
    }
}

#[test]
fn help_of_the_twin_tells_ports_and_what_to_do_with_them() {
    let (code, help, _) = xtask(&["twin", "--help"]);
    assert_eq!(code, 0);
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "--slcan-nominal <PORT>",
        "[default: 29501]",
        "--slcan-redundant <PORT>",
        "[default: 29502]",
        "--listen <IP>",
        "[default: 127.0.0.1]",
        "--slaves <N>",
        "[0..14]",
        "--no-master",
        "--master <FILE>",
        "--slave <N=FILE>",
        "--seconds <S>",
        "--board <BOARD>",
        "--profile <PROFILE>",
        "socket://127.0.0.1:29501",
        "Exit code 0",
    ] {
        assert!(help.contains(part), "no {part:?} in\n{help}");
    }
}

#[test]
fn wrong_values_of_the_twin_are_refused() {
    refuses(&["twin", "--slaves", "15"], &["--slaves", "0..=14"]);
    refuses(&["twin", "--slcan-nominal", "65536"], &["--slcan-nominal", "65535"]);
    refuses(&["twin", "--listen", "nowhere"], &["--listen", "nowhere"]);
    refuses(&["twin", "--control", "65536"], &["--control", "65535"]);
    refuses(&["twin", "--seconds", "0"], &["--seconds", "0.1 to 172800"]);
}

#[test]
fn images_of_the_user_are_checked_before_anything_is_built() {
    for command in ["twin", "demo"] {
        let usage = format!("Usage: cargo xtask {command}");
        refuses(&[command, "--slave", "3"], &["--slave", "a Node-ID and a file"]);
        refuses(&[command, "--slave", "16=x.elf"], &["--slave", "Node-IDs 2 to 15"]);
        refuses(&[command, "--slave", "3=nowhere.elf"], &["nowhere.elf", &usage]);
        refuses(&[command, "--master", "Cargo.toml"], &["Cargo.toml is no image", &usage]);
        refuses(&[command, "--slave", "3=a", "--slave", "3=b"], &["two images for node 3", &usage]);
    }
    refuses(&["twin", "--master", "a", "--no-master"], &["--master", "--no-master"]);
    refuses(&["twin", "--slaves", "0", "--no-master"], &["no board is left"]);
}

/// Given an image that runs but exports no counters, when the demo is to fly it, then it is refused before the flight.
#[test]
fn an_image_without_counters_is_refused_by_the_demo() {
    let shipped = firmware_images::build("pyboard-v11", "librecube").expect("images");
    let mut elf = std::fs::read(shipped.slave).expect("an image");
    // Names of symbols, mangled or not, and of debug information.
    let symbol = b"DIAGNOSTICS";
    while let Some(name) = elf.windows(symbol.len()).position(|bytes| bytes == symbol) {
        elf[name] = b'X';
    }
    let here = tempfile::tempdir().expect("a temporary directory");
    let image = here.path().join("own");
    std::fs::write(&image, elf).expect("a file");
    let own = format!("3={}", image.display());
    refuses(&["demo", "--slaves", "0", "--slave", &own], &["node 3", "DIAGNOSTICS", "cargo twin"]);
}

#[test]
fn the_subcommands_are_listed() {
    let (code, help, _) = xtask(&["--help"]);
    assert_eq!(code, 0);
    assert!(["demo", "twin", "firmware"].iter().all(|name| help.contains(name)), "{help}");
}

#[test]
fn the_number_of_slaves_is_checked() {
    refuses(&["demo", "--slaves", "0"], &["--slaves", "1 to 14, or 0 with --slave N=FILE"]);
    refuses(&["demo", "--slaves", "0", "--master", "a"], &["--slaves", "1 to 14, or 0 with --slave N=FILE"]);
    refuses(&["demo", "--slaves", "15"], &["--slaves", "0..=14"]);
    refuses(&["demo", "--slaves", "three"], &["--slaves", "three"]);
    refuses(&["demo", "--slaves", "-3"], &["--slaves", "0..=14"]);
    refuses(&["demo", "--minimal", "14"], &["--minimal", "0..=13"]);
    refuses(&["demo", "--minimal", "two"], &["--minimal", "two"]);
    refuses(&["demo", "--minimal", "12"], &["--minimal", "allowed are 0 to 11", "Usage: cargo xtask demo"]);
    refuses(&["demo", "--minimal", "1", "--slaves", "14"], &["--minimal", "allowed are 0 to 0"]);
    refuses(
        &["demo", "--minimal", "2", "--one-controller", "3"],
        &["--one-controller", "0 to 2", "--minimal"],
    );
    refuses(&["demo", "--one-controller", "14"], &["--one-controller", "0..=13"]);
    refuses(&["demo", "--minimal", "2", "--slaves", "0"], &["--slaves", "1 to 14, or 0 with --slave N=FILE"]);
}

#[test]
fn times_are_checked() {
    refuses(&["demo", "--seconds", "0"], &["--seconds", "1 to 3600"]);
    refuses(&["demo", "--seconds", "nan"], &["--seconds", "1 to 3600"]);
    refuses(&["demo", "--cut-at", "-1"], &["--cut-at", "from 0 to the value of --seconds", "never"]);
    refuses(&["demo", "--cut-at", "inf"], &["--cut-at", "from 0 to the value of --seconds"]);
}

#[test]
fn a_cut_after_the_end_is_refused() {
    refuses(
        &["demo", "--seconds", "10", "--cut-at", "10.5"],
        &["10.5", "--cut-at", "0 to 10", "ends at 10 s"],
    );
}

#[test]
fn an_unknown_board_is_refused_with_the_known_ones() {
    refuses(&["demo", "--board", "nucleo"], &["nucleo", "--board", "pyboard-v11", "nucleo-f446re"]);
    refuses(&["firmware", "--board", "nucleo"], &["nucleo", "--board", "pyboard-v11", "nucleo-f446re"]);
    refuses(&["firmware", "--profile", "apollo"], &["apollo", "--profile", "librecube", "standard"]);
    refuses(&["firmware", "--bit-rate", "800"], &["800", "--bit-rate", "1000", "500", "125", "10"]);
}

#[test]
fn an_out_directory_that_cannot_be_written_is_refused() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let file = here.path().join("file");
    std::fs::write(&file, "in the way").expect("a file");
    let below = file.join("out");
    refuses(&["demo", "--out", below.to_str().expect("UTF-8")], &["--out", "created and written to"]);
}

#[test]
fn without_a_command_the_help_is_shown() {
    let (code, _, stderr) = xtask(&[]);
    assert_eq!(code, 2);
    assert!(stderr.contains("Usage"), "{stderr}");
}

#[test]
fn an_unknown_area_is_refused_with_the_known_ones() {
    refuses(
        &["bench", "--only", "weather"],
        &["weather", "--only", "size", "rx", "load", "failover", "demo"],
    );
    refuses(&["bench", "--only", "irq", "--shard", "0/4"], &["--shard", "I from 1 to N", "3/16"]);
    refuses(
        &["bench", "--only", "time", "--shard", "1/12"],
        &["--shard: 12 shards of ", "allowed are 1 to "],
    );
    refuses(&["bench", "--only", "irq", "--shard", "1/1", "--check"], &["--shard", "--check"]);
    refuses(&["bench", "merge"], &["<FILE>", "Usage: cargo xtask bench merge"]);
    refuses(&["sizes", "--symbols", "-1"], &["--symbols", "-1"]);
}

#[test]
fn misuse_found_after_parsing_shows_the_usage_of_its_command() {
    refuses(&["demo", "--seconds", "10", "--cut-at", "11"], &["Usage: cargo xtask demo"]);
}

#[test]
fn one_port_for_both_buses_is_refused() {
    refuses(
        &["twin", "--slcan-nominal", "29501", "--slcan-redundant", "29501"],
        &["--slcan-nominal", "--slcan-redundant", "29501", "Usage: cargo xtask twin"],
    );
}

#[test]
fn unwritable_rows_are_refused_before_anything_is_measured() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let file = here.path().join("file");
    std::fs::write(&file, "in the way").expect("a file");
    let below = file.join("rows.json");
    for command in ["bench", "sizes"] {
        let usage = format!("Usage: cargo xtask {command}");
        refuses(&[command, "--out", below.to_str().expect("UTF-8")], &["--out <FILE>", &usage]);
        refuses(&[command, "--out", here.path().to_str().expect("UTF-8")], &["is a directory", &usage]);
    }
}

#[test]
fn folders_given_are_those_seen_from_the_current_one() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let output = Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(["eds", "--out", "here"])
        .current_dir(here.path())
        .output()
        .expect("xtask starts");
    assert!(output.status.success());
    assert!(here.path().join("here/slave.eds").is_file());
}

#[test]
fn removed_spelling_of_two_masters_names_the_present_one() {
    refuses(&["demo", "--standby"], &["'--standby'", "--profile standby"]);
}

#[test]
fn wrong_values_of_the_schedule_are_refused() {
    refuses(&["schedule", "--nodes", "0"], &["--nodes", "1..=126"]);
    refuses(&["schedule", "--nodes", "127"], &["--nodes", "1..=126"]);
    refuses(&["schedule", "--bit-rate", "300"], &["--bit-rate", "250, 500, 800, 1000 kbit/s"]);
    refuses(&["schedule", "--errors", "2:0"], &["--errors", "0 to 100 errors", "1 to 60000 ms"]);
    refuses(&["schedule", "--profile", "none"], &["--profile", "librecube", "standard"]);
}

/// Both profiles meet every deadline at 1 Mbit/s with errors. At 125 kbit/s the bus is too slow for fourteen slaves.
#[test]
fn schedule_of_the_mission_is_judged() {
    for profile in ["standard", "librecube"] {
        let (code, table, _) = xtask(&["schedule", "--profile", profile, "--errors", "2:10"]);
        assert_eq!(code, 0, "{table}");
        assert!(table.contains("every deadline is met"), "{table}");
        for id in
            ["000h", "080h", "082h", "181h", "18Fh", "302h", "38Fh", "402h", "58Fh", "602h", "701h", "70Fh"]
        {
            assert!(table.lines().any(|line| line.starts_with(id)), "{id} of {table}");
        }
    }
    let (code, table, stderr) = xtask(&["schedule", "--bit-rate", "125"]);
    assert_eq!(code, 1, "{table}");
    assert!(table.contains("NO BOUND") && stderr.contains("deadlines cannot be met"), "{table}{stderr}");
}

#[test]
fn wrong_values_of_the_campaign_are_refused() {
    refuses(&["campaign", "--runs", "0"], &["--runs", "1..=10000000"]);
    refuses(&["campaign", "--shard", "5/4"], &["--shard", "I from 1 to N", "3/16"]);
    refuses(&["campaign", "--runs", "2", "--shard", "1/3"], &["--shard", "allowed are 1 to 2"]);
    refuses(&["campaign", "--world", "nowhere"], &["--world", "host", "twin"]);
    refuses(&["campaign", "--masters", "3"], &["--masters", "1..=2"]);
    refuses(&["campaign", "--broken", "nothing"], &["--broken", "dead-bus"]);
    refuses(
        &["campaign", "--replay", "nowhere.txt"],
        &["--replay nowhere.txt", "Usage: cargo xtask campaign"],
    );
    refuses(&["campaign", "merge"], &["<FILE>"]);
    let file = tempfile::NamedTempFile::new().expect("a file");
    let below = file.path().join("out");
    refuses(
        &["campaign", "--runs", "1", "--out", below.to_str().expect("UTF-8")],
        &["--out: cannot write ", "give a place that can be written"],
    );
}

/// A part of a campaign with these properties, as a file.
fn part(folder: &std::path::Path, name: &str, commit: &str, seed: u64, shard: u64) -> String {
    let parameters = format!(r#"{{"seed":{seed},"runs":4,"world":"host","masters":1}}"#);
    let run = format!(r#"{{"command":"campaign","commit":"{commit}","shards":2,"parameters":{parameters}}}"#);
    let results = r#"{"flown":2,"double":1,"idle":0,"virtual_us":120000000,"kinds":{"cut":[2,1]},"detections":[99],"violations":[]}"#;
    let path = folder.join(name);
    std::fs::write(&path, format!(r#"{{"run":{run},"shard":{shard},"results":{results}}}"#)).expect("a file");
    path.to_string_lossy().into_owned()
}

/// Given two parts of one campaign, when they are merged, then their numbers are added. Given parts that are not those of one
/// campaign, then the command ends with code 1, and says which file or shard is wrong.
#[test]
fn only_all_parts_of_one_campaign_are_merged() {
    let folder = tempfile::tempdir().expect("a folder");
    let file =
        |name: &str, commit: &str, seed: u64, shard: u64| part(folder.path(), name, commit, seed, shard);
    let (one, two) = (file("1.json", "abc", 1, 1), file("2.json", "abc", 1, 2));
    let (code, table, stderr) = xtask(&["campaign", "merge", &two, &one]);
    assert_eq!(code, 0, "{stderr}");
    assert!(table.contains("4 runs in world host with one master, 2 of them with two faults"), "{table}");
    assert!(table.contains("cut                      4            2\n"), "{table}");

    let masters = std::fs::read_to_string(&two).expect("a file").replace(r#""masters":1"#, r#""masters":2"#);
    let pair = folder.path().join("p.json");
    std::fs::write(&pair, masters).expect("a file");
    let pair = pair.to_string_lossy();
    for (files, expected) in [
        (
            [&*one, &file("c.json", "def", 1, 2)],
            ["c.json: of another run than", "commit abc there, def here"],
        ),
        ([&one, &file("s.json", "abc", 2, 2)], ["s.json: of another run than", "seed 1 there, 2 here"]),
        ([&one, &pair], ["p.json: of another run than", "masters 1 there, 2 here"]),
        ([&one, &file("t.json", "abc", 1, 1)], ["t.json: shard 1 is already in", "missing: 2"]),
        ([&two, "Cargo.toml"], ["Cargo.toml: no part of `cargo xtask campaign`", "missing: 1"]),
        ([&two, "nowhere.json"], ["nowhere.json: No such file", "missing: 1"]),
    ] {
        let (code, stdout, stderr) = xtask(&["campaign", "merge", files[0], files[1]]);
        assert_eq!((code, &*stdout), (1, ""), "{stderr}");
        assert!(expected.iter().all(|part| stderr.contains(part)), "{expected:?}: {stderr}");
    }
}
