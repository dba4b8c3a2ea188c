use std::fs;

use super::*;
use crate::fly::plan::Plan;

/// Reads a file with this text into options.
fn read_with(text: &str, options: &mut Options, given: &[&str]) -> Result<BTreeSet<String>, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.toml");
    fs::write(&path, text).unwrap();
    fs::write(folder.path().join("heater.elf"), "").unwrap();
    let given = given.iter().map(|field| (*field).to_owned()).collect();
    let outcome = apply(&path, options, &given);
    // Without the folder, which differs.
    outcome.map_err(|misuse| misuse.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

fn read(text: &str) -> Result<Options, String> {
    let mut options = Options::default();
    read_with(text, &mut options, &[]).map(|_| options)
}

const FILE: &str = r#"
profile = "standard"
seconds = 12
seed = 7
slaves = 1

[[node]]
id = 1
place = 2

[[node]]
id = 5
image = "heater.elf"
cable = 10.5
crystal = -20.0
drift = 0.01
power-on = 0.25

[[node]]
id = 2
cable = 3

[[fault]]
at = 4
command = "cut nominal 5"

[[fault]]
at = 5.5
command = "heal nominal"

[[criterion]]
operational-at = 3
fail-over-within = 0.5

[[criterion]]
nodes = [5]
operational-at-end = false
"#;

#[test]
fn every_key_is_transferred() {
    let options = read(FILE).unwrap();
    assert_eq!((options.fleet.target.profile, options.seconds, options.seed), (Profile::Standard, 12.0, 7));
    let plan = Plan::new(&options).unwrap();
    let places: Vec<(u8, f64)> = plan.boards.iter().map(|board| (board.node, board.position_m)).collect();
    assert_eq!(places, [(1, 2.0), (2, 15.5), (5, 12.5)]);
    let own = &plan.boards[2];
    assert_eq!((own.own_image.as_deref(), own.power_on), (Some("heater.elf"), Time::from_ms(250)));
    assert_eq!((own.crystal.ppm, own.crystal.drift_ppm_per_s), (-20.0, 0.01));
    let times: Vec<u64> = plan.faults.iter().map(|fault| fault.at.as_us() / 1000).collect();
    assert_eq!(times, [4_000, 5_500]);
    let musts: Vec<(u8, Must)> =
        plan.criteria.iter().map(|criterion| (criterion.node, criterion.must)).collect();
    let (at, within) = (Must::OperationalAt(Time::from_ms(3_000)), Must::FailOverWithin(Time::from_ms(500)));
    assert_eq!(musts, [(2, at), (5, at), (2, within), (5, within), (5, Must::MayBeLost)]);
    assert!(
        plan.criteria[0].origin.ends_with("m.toml:32: criterion[0].operational-at"),
        "{}",
        plan.criteria[0].origin
    );
}

#[test]
fn options_replace_entries_of_the_file() {
    let mut options =
        Options { seconds: 30.0, seed: 3, cut_at: Some(CutAt::Second(9.0)), ..Options::default() };
    options.places = vec!["5=20"].into_iter().map(|text| crate::fly::setup::place_m(text).unwrap()).collect();
    options
        .fleet
        .own_slaves
        .push(crate::images::support::fleet::NodeFile { node: 5, file: "other.elf".into() });
    let set = read_with(FILE, &mut options, &["seconds", "seed", "cut_at"]).unwrap();
    assert!(set.contains("profile") && !set.contains("seed"), "{set:?}");
    let plan = Plan::new(&options).unwrap();
    assert_eq!((options.seconds, options.seed), (30.0, 3));
    assert_eq!((plan.boards[2].own_image.as_deref(), plan.boards[2].position_m), (Some("other.elf"), 20.0));
    let cuts: Vec<u64> = plan.faults.iter().map(|fault| fault.at.as_us() / 1000).collect();
    assert_eq!(cuts, [9_000], "the cut of the option replaces the faults of the file");
}

/// Given a file with one mistake, then the error names its line and its key, and what is allowed.
#[test]
fn each_mistake_has_line_key_and_allowed_values() {
    for (text, said) in [
        ("seconds = ", "m.toml:1: "),
        ("slaves = 2\nlength = 3", "m.toml:2: length: unknown field `length`, expected one of `board`"),
        ("\nseconds = \"ten\"", "m.toml:2: seconds: invalid type: string \"ten\", expected f64"),
        ("seconds = 0.5", "m.toml:1: seconds: 0.5 is outside of the range; allowed are 1 to 3600 s"),
        ("slaves = 15", "m.toml:1: slaves: 15 is outside of the range; allowed are 0 to 14"),
        ("seed = -1", "m.toml:1: seed: -1 is outside"),
        (
            "profile = \"slow\"",
            "m.toml:1: profile: 'slow': no such profile; allowed are librecube, standard, standby",
        ),
        ("board = \"arduino\"", "m.toml:1: board: 'arduino': no such board; allowed are pyboard-v11"),
        ("chip = \"Z80\"", "m.toml:1: chip: 'Z80': "),
        ("oscillator = \"slow\"", "m.toml:1: oscillator: 'slow': "),
        ("cut-at = -3", "m.toml:1: cut-at: -3: allowed are seconds from 0"),
        ("[[node]]\nplace = 3", "m.toml:1: node[0]: missing field `id`"),
        ("[[node]]\nid = 16", "m.toml:2: node[0].id: 16 is outside of the range; allowed are 1 to 15"),
        ("[[node]]\nid = 9", "m.toml:2: node[0].id: node 9 has no image; give it `image` or `package`"),
        ("[[node]]\nid = 2\n[[node]]\nid = 2", "m.toml:4: node[1].id: node 2 is there twice"),
        (
            "[[node]]\nid = 2\nplace = 1001.0",
            "m.toml:3: node[0].place: 1001 is outside of the range; allowed are 0 to 1000 m",
        ),
        (
            "[[node]]\nid = 2\nplace = 1\ncable = 2",
            "m.toml:4: node[0].cable: a board has a `place` or a `cable`",
        ),
        (
            "[[node]]\nid = 2\nplace = 999\n[[node]]\nid = 3\ncable = 2",
            "m.toml:6: node[1].cable: the board would be at 1001 m",
        ),
        (
            "[[node]]\nid = 2\ncrystal = 300",
            "m.toml:3: node[0].crystal: 300 is outside of the range; allowed are -200 to 200 ppm",
        ),
        ("[[node]]\nid = 2\nimage = \"no.elf\"", "m.toml:3: node[0].image: there is no file no.elf"),
        ("[[node]]\nid = 2\neds = \"no.eds\"", "m.toml:3: node[0].eds: there is no file no.eds"),
        (
            "[[node]]\nid = 2\nimage = \"heater.elf\"\npackage = \"heater\"",
            "m.toml:4: node[0].package: a board has an `image` or",
        ),
        ("[[node]]\nid = 2\nprogram = \"heater\"", "m.toml:3: node[0].program: `program` is for a `package`"),
        ("[[fault]]\nat = 3", "m.toml:1: fault[0]: missing field `command`"),
        (
            "[[fault]]\nat = 3\ncommand = \"jump\"",
            "m.toml:3: fault[0].command: 'jump': unrecognized subcommand 'jump'",
        ),
        (
            "[[fault]]\nat = 3\ncommand = \"quit\"",
            "m.toml:3: fault[0].command: 'quit': 'quit' is no fault; allowed are cut, heal",
        ),
        (
            "[[criterion]]\nnodes = [0]\noperational-at = 1",
            "m.toml:2: criterion[0].nodes: 0 is no Node-ID; allowed are 1 to 15",
        ),
        ("[[criterion]]\nclock-within-us = 0", "m.toml:2: criterion[0].clock-within-us: 0 is outside"),
    ] {
        let error = read(text).expect_err(text);
        assert!(error.starts_with(said), "{text}\n  {error}\n  {said}");
    }
}

/// Given a fault or a criterion that does not fit the flight, then the error of the plan names line and key of the file.
#[test]
fn errors_of_the_plan_name_line_and_key() {
    for (text, said) in [
        (
            "[[fault]]\nat = 50\ncommand = \"reset 3\"",
            "m.toml:3: fault[0].command: 50 s is after the end of the run",
        ),
        ("[[fault]]\nat = 5\ncommand = \"reset 9\"", "m.toml:3: fault[0].command: there is no node 9"),
        (
            "[[criterion]]\nnodes = [9]\noperational-at = 1",
            "m.toml:3: criterion[0].operational-at: there is no node 9",
        ),
    ] {
        let options = read(text).unwrap();
        let error = Plan::new(&options).expect_err(text).to_string();
        assert!(error.ends_with("1, 2, 3, 4") || error.contains("allowed are"), "{error}");
        assert!(error.contains(said), "{text}\n  {error}");
    }
}
