//! `cargo campaign`: wrong values, and parts that are merged.

use crate::{TOOLS, assert_refused};

#[test]
fn wrong_values_of_the_campaign_are_refused() {
    assert_refused(&[
        ("campaign --runs 0", &["--runs", "1..=10000000"]),
        ("campaign --shard 5/4", &["--shard", "I from 1 to N", "3/16"]),
        ("campaign --runs 2 --shard 1/3", &["--shard", "allowed are 1 to 2"]),
        ("campaign --world nowhere", &["--world", "host", "twin"]),
        ("campaign --masters 3", &["--masters", "1..=2"]),
        ("campaign --kinds rain", &["--kinds", "cut", "power-slave"]),
        ("campaign --kinds cut,cut,cut", &["--kinds: one or two kinds"]),
        ("campaign --kinds cut --world twin", &["--kinds", "world host"]),
        (
            "campaign --world upsets --draws moon=3",
            &["--draws", "ram, core, masks, peripherals, flash, store"],
        ),
        ("campaign --world upsets --replay nowhere.txt", &["--replay nowhere.txt"]),
        ("campaign --broken nothing", &["--broken", "dead-bus"]),
        ("campaign --replay nowhere.txt", &["--replay nowhere.txt", "Usage: ecss-can campaign"]),
        ("campaign merge", &["<FILE>"]),
    ]);
    let file = tempfile::NamedTempFile::new().expect("a file");
    let below = file.path().join("out");
    TOOLS.refuses(
        &["campaign", "--runs", "1", "--out", below.to_str().expect("UTF-8")],
        &["--out: cannot write ", "give a place that can be written"],
    );
}

/// Writes a part of a campaign with these properties.
fn part(folder: &std::path::Path, name: &str, commit: &str, seed: u64, shard: u64) -> String {
    let parameters = format!(r#"{{"seed":{seed},"runs":4,"world":"host","masters":1}}"#);
    let run = format!(r#"{{"command":"campaign","commit":"{commit}","shards":2,"parameters":{parameters}}}"#);
    let results = r#"{"flown":2,"double":1,"related":1,"idle":0,"virtual_us":120000000,"kinds":{"cut":[2,1]},"detections":[99],"violations":[]}"#;
    let path = folder.join(name);
    std::fs::write(&path, format!(r#"{{"run":{run},"shard":{shard},"results":{results}}}"#)).expect("a file");
    path.to_string_lossy().into_owned()
}

/// Given two parts of one campaign, when they are merged, then their numbers are added. Given parts that are not those
/// of one campaign, then the command ends with code 1, and names the wrong file or shard.
#[test]
fn only_all_parts_of_one_campaign_are_merged() {
    let folder = tempfile::tempdir().expect("a folder");
    let file =
        |name: &str, commit: &str, seed: u64, shard: u64| part(folder.path(), name, commit, seed, shard);
    let (one, two) = (file("1.json", "abc", 1, 1), file("2.json", "abc", 1, 2));
    let (code, table, stderr) = TOOLS.run(&["campaign", "merge", &two, &one]);
    assert_eq!(code, 0, "{stderr}");
    let runs =
        "4 runs in world host with one master, 2 of them with two faults, 2 with related ones, 0 without";
    assert!(table.contains(runs), "{table}");
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
        ([&two, "Cargo.toml"], ["Cargo.toml: no part of a run of `campaign`", "missing: 1"]),
        ([&two, "nowhere.json"], ["nowhere.json: No such file", "missing: 1"]),
    ] {
        let (code, stdout, stderr) = TOOLS.run(&["campaign", "merge", files[0], files[1]]);
        assert_eq!((code, &*stdout), (1, ""), "{stderr}");
        assert!(expected.iter().all(|part| stderr.contains(part)), "{expected:?}: {stderr}");
    }
}
