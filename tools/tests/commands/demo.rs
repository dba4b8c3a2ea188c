//! Short flights through the command line: their output, and reproducibility by the seed.

use std::path::PathBuf;

use ecss_can_cli::images::Package;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::TOOLS;

/// A flight that has ended.
struct Flown {
    out: TempDir,
    code: i32,
    stdout: String,
    stderr: String,
}

impl Flown {
    /// Runs `cargo demo` with these options, and with some that may contain blanks.
    fn of(options: &str, files: &[&str]) -> Flown {
        let out = tempfile::tempdir().expect("a temporary directory");
        let mut words = vec!["fly", "--out", out.path().to_str().expect("UTF-8")];
        words.extend(options.split_whitespace().chain(files.iter().copied()));
        let (code, stdout, stderr) = TOOLS.run(&words);
        Flown { out, code, stdout, stderr }
    }

    /// Runs a flight that passes. Returns it with its summary.
    fn passed(options: &str, files: &[&str]) -> (Flown, Value) {
        let flown = Flown::of(options, files);
        assert_eq!(flown.code, 0, "{options}: {}{}", flown.stdout, flown.stderr);
        let summary = flown.summary();
        (flown, summary)
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.out.path().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("UTF-8")
    }

    fn summary(&self) -> Value {
        serde_json::from_slice(&self.read("summary.json")).expect("JSON")
    }

    /// Checks that stdout and files have these texts.
    fn shows(&self, stdout: &[&str], files: &[(&str, &[&str])]) {
        let files = files.iter().map(|(name, expected)| (*name, self.text(name), *expected));
        for (what, text, expected) in files.chain([("stdout", self.stdout.clone(), stdout)]) {
            for part in expected {
                assert!(text.contains(part), "{what} without {part:?}: {text}");
            }
        }
    }
}

#[test]
fn a_seed_decides_every_byte_of_the_logs() {
    let flight = |seed: &str| {
        let (flown, summary) =
            Flown::passed(&format!("--slaves 1 --seconds 2 --cut-at 1 --seed {seed}"), &[]);
        assert_eq!(summary["slaves_operational_at_end"], 1);
        assert_eq!(summary["lost_frames"], 0);
        assert!(summary["tc_due"].as_u64() > Some(0));
        assert_eq!(summary["tc_executed"], summary["tc_due"]);
        assert!(summary["failover_ms"]["2"].as_f64() < Some(1000.0), "{summary}");
        ["bus-nominal.log", "bus-redundant.log", "spacecraft.pcapng"].map(|name| flown.read(name))
    };
    let first = flight("1");
    assert!(first.iter().all(|file| !file.is_empty()));
    assert!(first == flight("1"), "two flights with one seed differ");
    assert!(first != flight("2"), "another seed makes no difference");
}

#[test]
fn the_other_board_flies_as_well() {
    let (_, summary) = Flown::passed("--board nucleo-f446re --slaves 1 --seconds 2 --cut-at 1", &[]);
    assert_eq!(summary["board"], "nucleo-f446re");
    assert_eq!(summary["slaves_operational_at_end"], 1);
    assert_eq!(summary["lost_frames"], 0);
}

/// Given a slave with selective access that searches for 12.5 s, when the flight ends earlier after its cut, then it is refused
/// before it begins, with the lengths that are allowed. When the cut comes before the master has heard a slave, the master first
/// stays on its bus for a dwell: 25.5 s in profile librecube, 10 s in profile standard.
#[test]
fn flight_too_short_to_be_judged_is_refused() {
    let refused = |options: &str, parts: &[&str]| {
        let Flown { out, code, stderr, .. } = Flown::of(options, &[]);
        assert_eq!(code, 2, "{options}: {stderr}");
        parts.iter().for_each(|part| assert!(stderr.contains(part), "{options}: no {part:?} in {stderr}"));
        assert!(!out.path().join("report.html").exists(), "{options}");
    };
    for (options, found, allowed) in [
        ("--seconds 4 --cut-at 1", "'4'", "allowed are 14 to 3600"),
        ("--seconds 20", "'20'", "allowed are 26 to 3600"),
        ("--seconds 15 --cut-at 2.5", "'15'", "allowed are 15.5 to 3600"),
        ("--seconds 38 --cut-at 0.2", "'38'", "allowed are 39 to 3600"),
        ("--seconds 1", "'1'", "allowed are 26 to 3600"),
        ("--slaves 1 --seconds 1", "'1'", "allowed are 1.2 to 3600"),
        ("--profile standard --seconds 9 --cut-at 0.2", "'9'", "allowed are 11 to 3600"),
        (
            "--profile standard --minimal 1 --one-controller 1 --seconds 9 --cut-at 0",
            "'9'",
            "allowed are 11.3 to 3600",
        ),
        ("--profile standby --seconds 5.5 --cut-at 5", "'5.5'", "allowed are 6 to 3600"),
    ] {
        refused(options, &[found, "--seconds", allowed, "--cut-at never"]);
    }
    refused("--profile standby --seconds 8", &["'4' for '--cut-at <S>'", "allowed are 5 to 8"]);
}

/// Given the shortest flight that is allowed after a cut, then every slave is operational at its end.
#[test]
fn shortest_allowed_flight_passes() {
    for options in ["--seconds 14.5 --cut-at 1.5", "--seconds 38.8 --cut-at 0"] {
        Flown::passed(options, &[]);
    }
}

/// Given two masters, when the standby is reset and the nominal bus is cut between the slaves, then the active one
/// moves to the redundant bus, and the standby sends neither 701h nor a claim. When the active one then loses its
/// power, the other one takes over after its consumer time of 400 ms and at most 10 ms. Every slave is operational and
/// commanded again each time, and all output shows it.
///
/// Verifies: ECSS 8.1a
#[test]
fn a_standby_takes_over_and_everything_shows_it() {
    let (flown, summary) = Flown::passed("--profile standby --slaves 2 --seconds 8 --cut-at 6", &[]);
    assert_eq!((&summary["boards"], &summary["masters"]), (&4.into(), &2.into()));
    assert_eq!(summary["profile"], "standby");
    let faults = ["standby_reset_at_seconds", "cut_at_seconds", "master_lost_at_seconds"];
    assert_eq!(faults.map(|key| summary[key].as_f64()), [Some(1.5), Some(3.0), Some(6.0)]);
    let takeover = summary["takeover_ms"].as_f64().expect("a takeover");
    assert!((400.0..410.0).contains(&takeover), "{takeover} ms");
    assert_eq!((&summary["slaves_operational_at_end"], &summary["lost_frames"]), (&2.into(), &0.into()));
    assert_eq!(summary["tc_executed"], summary["tc_due"]);
    assert_eq!((&summary["bus_changes"], &summary["resets"]), (&1.into(), &0.into()));
    for slave in ["2", "3"] {
        // The master misses one of two slaves 250 ms after its last heartbeat, which was up to 100 ms before the cut.
        for (key, bounds) in [("failover_ms", 150.0..500.0), ("takeover_failover_ms", 300.0..1_500.0)] {
            assert!(
                summary[key][slave].as_f64().is_some_and(|took| bounds.contains(&took)),
                "{key}: {summary}"
            );
        }
    }
    one_master_is_active_at_a_time(&flown, 6.0);
    assert!(!flown.stdout.contains("frame without a known meaning"), "{}", flown.stdout);
    let took = format!("{takeover:.1} ms after the last heartbeat");
    let stdout = [
        "===== master 2, the standby, is reset =====",
        "===== the nominal bus is cut between the slaves =====",
        "===== master loses its power =====",
        "first claim on the redundant bus",
        " after the cut",
        " after the loss of the master",
        &took,
        "master 2              active, redundant bus",
    ];
    let report = [
        "Two masters and 2 slaves",
        "Around the cut",
        "Around the takeover",
        "master: active on the nominal bus",
        "master: active on the redundant bus",
        "master: off, 6.0000 s",
        "master 2: starting on the nominal bus, 1.5000 s",
        "master 2: standby on the nominal bus",
        "master 2: standby on the redundant bus",
        "master 2: active on the redundant bus",
    ];
    flown.shows(&stdout, &[("report.html", &report), ("timeline.svg", &[&took])]);
}

/// Checks both logs: before the loss only the first master sends a boot-up message and claims, after it only the second one. Claims are
/// on both buses all the time.
fn one_master_is_active_at_a_time(flown: &Flown, loss: f64) {
    let mut boot_ups = [0, 0];
    for log in ["bus-nominal.log", "bus-redundant.log"] {
        let mut claims = [0, 0];
        for line in flown.text(log).lines() {
            let at: f64 = line[1..].split(')').next().and_then(|at| at.parse().ok()).expect("a time stamp");
            let after = usize::from(at > loss);
            match line.split_whitespace().last().expect("a frame") {
                "701#00" => boot_ups[after] += 1,
                frame if frame.starts_with("680#") || frame.starts_with("681#") => {
                    assert_eq!(&frame[..4], ["680#", "681#"][after], "{log}: {line}");
                    claims[after] += 1;
                }
                _ => {}
            }
        }
        // A heartbeat every 100 ms: from about 1 s to the loss, and from 0.4 s after it for the rest of 8 s.
        assert!(claims[0] >= 45 && claims[1] >= 14, "{log}: {claims:?} claims");
    }
    assert_eq!(boot_ups, [1, 1], "each master becomes active once");
}

/// Given a master, two slaves of the whole protocol and two minimal ones, when the nominal bus is cut, then all follow
/// the master; each due command is executed, and all output shows the minimal ones.
#[test]
fn minimal_slaves_fly_beside_the_others() {
    let options = "--profile standard --slaves 2 --minimal 2 --seconds 3 --cut-at 1.5";
    let (flown, summary) = Flown::passed(options, &[]);
    assert_eq!((&summary["boards"], &summary["minimal"]), (&5.into(), &2.into()));
    assert_eq!((&summary["slaves_operational_at_end"], &summary["lost_frames"]), (&4.into(), &0.into()));
    assert!(summary["tc_due"].as_u64() > Some(80), "{summary}");
    assert_eq!(summary["tc_executed"], summary["tc_due"]);
    for slave in ["2", "3", "4", "5"] {
        assert!(summary["failover_ms"][slave].as_f64() < Some(500.0), "{summary}");
    }
    let nominal = flown.text("bus-nominal.log");
    for id in ["085#", "585#", "705#00"] {
        assert!(!nominal.contains(id), "{id} of a minimal slave");
    }
    flown.shows(
        &["node 5   parallel, minimal", "node 5    operational on the nominal bus"],
        &[
            ("bus-nominal.log", &["285#", "385#", "705#05"]),
            ("report.html", &["parallel, minimal", "a slave of the minimal set"]),
        ],
    );
}

/// Given a minimal slave with one controller and two transceivers, when the nominal bus is cut, then it searches and finds the master
/// after Ttoggle consumer times, 0.5 s, and executes every command due.
///
/// Verifies: ECSS 8.2.3a
#[test]
fn a_slave_with_one_controller_flies_beside_the_others() {
    let options = "--profile standard --slaves 1 --minimal 2 --one-controller 1 --seconds 4 --cut-at 1.5";
    let (flown, summary) = Flown::passed(options, &[]);
    let fleet = ["boards", "minimal", "one_controller", "slaves_operational_at_end", "lost_frames"];
    assert_eq!(fleet.map(|field| summary[field].as_u64().unwrap()), [4, 2, 1, 3, 0]);
    assert_eq!(summary["tc_executed"], summary["tc_due"]);
    assert!(summary["failover_ms"]["3"].as_f64() < Some(400.0), "{summary}");
    assert!((400.0..620.0).contains(&summary["failover_ms"]["4"].as_f64().unwrap()), "{summary}");
    let report = [
        "0.25 s), becomes pre-operational",
        "0.5 s after the last heartbeat",
        "a switch between its CAN controller and two transceivers",
    ];
    flown.shows(&["node 4   1 controller, minimal"], &[("report.html", &report)]);
}

/// Given shipped slaves as images of the user's, when the nominal bus is cut, then their access is found: node 3 follows the master at
/// once, and node 4 stays on the nominal bus.
#[test]
fn access_of_own_images_is_found_by_a_cut() {
    let images = ecss_can_cli::images::build("pyboard-v11", "librecube").expect("images");
    let slaves = [3, 4].map(|node| format!("{node}={}", images.slave.display()));
    let master = images.master.to_str().expect("UTF-8");
    let files = ["--master", master, "--slave", &slaves[0], "--slave", &slaves[1]];
    let (flown, summary) = Flown::passed("--slaves 0 --seconds 5 --cut-at 3", &files);
    assert_eq!(summary["access"], json!({ "3": "parallel", "4": "selective" }), "{summary}");
    flown.shows(&[], &[("report.html", &["<td>node 4</td><td>selective</td>"])]);
}

fn example(package: &str) -> PathBuf {
    let built = Package::of_workspace(package).build(None).unwrap_or_else(|error| panic!("{error}"));
    built[0].clone()
}

/// Given a slave with an image of its own, when its program serves no bus from 3 s on, without a reset, then the flight of 6 s
/// fails, and the summary names the node and its state.
#[test]
fn own_image_that_falls_silent_fails_the_flight() {
    let fixture = ecss_can_cli::images::build_fixture("test-silent", "standard").unwrap();
    let slave = format!("3={}", fixture.display());
    let flown = Flown::of("--profile standard --slaves 1 --seconds 6 --cut-at never", &["--slave", &slave]);
    let Flown { code, stderr, .. } = &flown;
    assert_eq!(*code, 1, "{stderr}");
    assert!(stderr.contains("node 3 is silent on the nominal bus at the end"), "{stderr}");
    assert!(!stderr.contains("node 3 reset itself") && !stderr.contains("node 2 is"), "{stderr}");
    let summary = flown.summary();
    assert_eq!((&summary["verdict"], &summary["resets"]), (&"failed".into(), &0.into()), "{summary}");
    assert_eq!(summary["slaves_operational_at_end"], 1);
    // Heartbeats every 100 ms until about 3 s, none until 6 s.
    let count = summary["heartbeats"]["3"].as_u64().expect("a number");
    assert!((20..=32).contains(&count), "{count} heartbeats");
}

/// The thermometer's TPDO of each SYNC: two numbers of 16 bits with a sign.
const SHEET: &str = "[1803sub1]\nDefaultValue=$NODEID+0x480\n[1A03sub0]\nDefaultValue=2\n\
    [1A03sub1]\nDefaultValue=0x60000010\n[1A03sub2]\nDefaultValue=0x60010010\n\
    [6000]\nParameterName=Temperature\nDataType=0x0003\n[6001]\nParameterName=Highest\nDataType=0x0003\n";

/// Given the thermometer and its master, when the nominal bus is cut, then the flight is judged by heartbeats and
/// states. The master commanded the one reset. Commands and telemetry are left out, and all output states that. Of the
/// node with a data sheet the values of its PDO have names.
#[test]
fn own_images_are_judged_by_the_protocol_alone() {
    let master = example("thermometer-master");
    let slave = format!("3={}", example("thermometer").display());
    let sheets = tempfile::tempdir().expect("a temporary directory");
    let sheet = sheets.path().join("thermometer.eds");
    std::fs::write(&sheet, SHEET).expect("a data sheet");
    let (master, other) = (master.to_str().expect("UTF-8"), slave.replacen('3', "4", 1));
    let sheet = format!("3={}", sheet.display());
    let files = ["--master", master, "--slave", &slave, "--slave", &other, "--eds", &sheet];
    let (flown, summary) = Flown::passed("--slaves 0 --seconds 4 --cut-at 3", &files);
    let stdout = &flown.stdout;
    assert!(stdout.starts_with("images of your own"), "{stdout}");
    assert!(stdout.contains("node 3: reset") || stdout.contains("NMT reset node: node 3"), "{stdout}");
    assert_eq!(summary["verdict"], "passed", "{summary}");
    assert_eq!(summary["own_images"]["1"], "thermometer-master");
    for slave in ["3", "4"] {
        assert_eq!(summary["own_images"][slave], "thermometer");
    }
    assert_eq!(summary["slaves_operational_at_end"], 2);
    assert_eq!(summary["bus_changes"], 1);
    // Heartbeats every 100 ms; the master leaves its bus after one that no node acknowledged.
    for slave in ["3", "4"] {
        assert!(summary["failover_ms"][slave].as_f64().is_some_and(|took| took < 500.0), "{summary}");
    }
    assert!(summary["heartbeats"]["1"].as_u64() >= Some(30), "{summary}");
    assert!(summary["bus_load_percent"]["nominal"].as_f64() > Some(0.0), "{summary}");
    assert_eq!(summary.get("tc_due"), None);
    assert!(!flown.text("report.html").contains("TM reply"));
    let pdos = summary["pdo_values"].as_array().expect("an array");
    let cycle: Vec<&Value> = pdos.iter().filter(|pdo| pdo["cob_id"] == "483h").collect();
    assert_eq!((pdos.len(), cycle.len()), (1, 1), "{summary}");
    assert_eq!(cycle[0]["values"][0][0], "Temperature");
    // The master sends no spacecraft time.
    assert!(
        stdout.contains("clock of node 4 is not judged: no master sent the spacecraft time (181h)\n"),
        "{stdout}"
    );
    assert_eq!(summary["access"], json!({ "3": "parallel", "4": "parallel" }), "{summary}");
    assert_eq!(
        summary["data_sheets"],
        json!({ "3": { "file": "thermometer.eds", "device": null } }),
        "{summary}"
    );
    let aborted = summary["aborted"].as_array().expect("an array");
    let count: u64 = aborted.iter().filter_map(|frames| frames["frames"].as_u64()).sum();
    assert_eq!(summary["aborted_frames"], count, "{summary}");
    let of_master = aborted.iter().filter(|frames| frames["node"] == 1 && frames["bus"] == "nominal");
    assert!(of_master.count() > 0, "the master leaves the cut bus: {summary}");
    let unread = "neither read nor judged (master: thermometer-master, node 3: thermometer";
    // The master and the temperature with every SYNC.
    let log = [" redundant 701#05", " redundant 483#"];
    flown
        .shows(&[], &[("report.html", &[unread, "Temperature ", "; Highest "]), ("bus-redundant.log", &log)]);
}
