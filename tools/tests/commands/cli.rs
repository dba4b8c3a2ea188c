//! The command line: help, wrong values, exit codes.

use second::programs::alias;

use crate::{TOOLS, assert_refused};

/// Given `--help` of demo and twin, then every option is explained with its default and range, and the use of the
/// ports.
#[test]
fn help_explains_every_option_with_default_and_range() {
    let of_demo = [
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
        "[default: target/fly]",
        "Exit code 0",
    ];
    let of_twin = [
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
    ];
    for (command, parts) in [("fly", &of_demo[..]), ("twin", &of_twin)] {
        let (code, help, _) = TOOLS.run(&[command, "--help"]);
        assert_eq!(code, 0, "{command}");
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        for part in parts {
            assert!(help.contains(part), "{command}: no {part:?} in\n{help}");
        }
    }
}

#[test]
fn wrong_values_are_refused_with_what_is_allowed() {
    let no_slave = &["--slaves", "1 to 14, or 0 with --slave N=FILE"][..];
    assert_refused(&[
        ("fly --slaves 0", no_slave),
        ("fly --slaves 0 --master a", no_slave),
        ("fly --minimal 2 --slaves 0", no_slave),
        ("fly --slaves 15", &["--slaves", "0..=14"]),
        ("fly --slaves three", &["--slaves", "three"]),
        ("fly --slaves -3", &["--slaves", "0..=14"]),
        ("fly --minimal 14", &["--minimal", "0..=13"]),
        ("fly --minimal two", &["--minimal", "two"]),
        ("fly --minimal 12", &["--minimal", "allowed are 0 to 11", "Usage: ecss-can fly"]),
        ("fly --minimal 1 --slaves 14", &["--minimal", "allowed are 0 to 0"]),
        ("fly --minimal 2 --one-controller 3", &["--one-controller", "0 to 2", "--minimal"]),
        ("fly --one-controller 14", &["--one-controller", "0..=13"]),
        ("fly --seconds 0", &["--seconds", "1 to 3600"]),
        ("fly --seconds nan", &["--seconds", "1 to 3600"]),
        ("fly --cut-at -1", &["--cut-at", "from 0 to the value of --seconds", "never"]),
        ("fly --cut-at inf", &["--cut-at", "from 0 to the value of --seconds"]),
        ("fly --seconds 10 --cut-at 10.5", &["10.5", "--cut-at", "0 to 10", "ends at 10 s"]),
        ("fly --seconds 10 --cut-at 11", &["Usage: ecss-can fly"]),
        ("fly --board nucleo", &["nucleo", "--board", "pyboard-v11", "nucleo-f446re"]),
        ("twin --slaves 15", &["--slaves", "0..=14"]),
        ("twin --slcan-nominal 65536", &["--slcan-nominal", "65535"]),
        ("twin --listen nowhere", &["--listen", "nowhere"]),
        ("twin --control 65536", &["--control", "65535"]),
        ("twin --seconds 0", &["--seconds", "0.1 to 172800"]),
        (
            "twin --slcan-nominal 29501 --slcan-redundant 29501",
            &["--slcan-nominal", "--slcan-redundant", "29501", "Usage: ecss-can twin"],
        ),
    ]);
}

#[test]
fn images_of_the_user_are_checked_before_anything_is_built() {
    for command in ["twin", "fly"] {
        let usage = format!("Usage: ecss-can {command}");
        TOOLS.refuses(&[command, "--slave", "3"], &["--slave", "a Node-ID and a file"]);
        TOOLS.refuses(&[command, "--slave", "16=x.elf"], &["--slave", "Node-IDs 2 to 15"]);
        TOOLS.refuses(&[command, "--slave", "3=nowhere.elf"], &["nowhere.elf", &usage]);
        TOOLS.refuses(&[command, "--master", "Cargo.toml"], &["Cargo.toml is no image", &usage]);
        TOOLS.refuses(&[command, "--slave", "3=a", "--slave", "3=b"], &["two images for node 3", &usage]);
    }
    assert_refused(&[
        ("twin --master a --no-master", &["--master", "--no-master"]),
        ("twin --slaves 0 --no-master", &["no board is left"]),
    ]);
}

#[test]
fn wrong_images_are_refused_with_the_known_ones() {
    assert_refused(&[
        ("build --board nucleo", &["nucleo", "--board", "pyboard-v11", "nucleo-f446re"]),
        ("build --profile apollo", &["apollo", "--profile", "librecube", "standard"]),
        ("build --bit-rate 800", &["800", "--bit-rate", "1000", "500", "125", "10"]),
        ("build rover", &["rover", "master, slave, minimal"]),
        ("build master --one-controller", &["--one-controller", "minimal slave", "Usage: ecss-can build"]),
    ]);
}

/// Given an image that runs but exports no counters, when the demo is to fly it, then it is refused before the flight.
#[test]
fn an_image_without_counters_is_refused_by_the_demo() {
    let shipped = ecss_can_cli::images::build("pyboard-v11", "librecube").expect("images");
    let mut elf = std::fs::read(shipped.slave).expect("an image");
    // Names of symbols, mangled or not, and of debug information.
    const NAME: &[u8] = b"DIAGNOSTICS";
    while let Some(name) = elf.windows(NAME.len()).position(|bytes| bytes == NAME) {
        elf[name] = b'X';
    }
    let here = tempfile::tempdir().expect("a temporary directory");
    let image = here.path().join("own");
    std::fs::write(&image, elf).expect("a file");
    let own = format!("3={}", image.display());
    TOOLS.refuses(&["fly", "--slaves", "0", "--slave", &own], &["node 3", "DIAGNOSTICS", "cargo twin"]);
}

#[test]
fn the_commands_for_users_are_listed_with_help() {
    let listed = TOOLS.subcommands();
    let names: Vec<&str> = listed.iter().map(|(name, _)| name.as_str()).collect();
    let expected = [
        "new",
        "build",
        "flash",
        "fly",
        "twin",
        "eds",
        "campaign",
        "schedule",
        "doctor",
        "completions",
        "man",
        "help",
    ];
    assert_eq!(names, expected);
    assert!(listed.iter().all(|(_, help)| !help.is_empty()), "{listed:?}");
}

/// Given the aliases of `.cargo/config.toml`, then `cargo NAME` is `ecss-can NAME`, and `cargo demo` is a flight.
#[test]
fn commands_have_aliases() {
    for (name, command) in [
        ("demo", "fly"),
        ("twin", "twin"),
        ("eds", "eds"),
        ("campaign", "campaign"),
        ("schedule", "schedule"),
    ] {
        assert_eq!(alias(name), ("ecss-can-cli".to_owned(), vec![command.to_owned()]));
    }
    assert_eq!(alias("ecss-can"), ("ecss-can-cli".to_owned(), Vec::new()));
}

#[test]
fn an_out_directory_that_cannot_be_written_is_refused() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let file = here.path().join("file");
    std::fs::write(&file, "in the way").expect("a file");
    let below = file.join("out");
    TOOLS.refuses(&["fly", "--out", below.to_str().expect("UTF-8")], &["--out", "created and written to"]);
}

#[test]
fn without_a_command_the_help_is_shown() {
    let (code, _, stderr) = TOOLS.run(&[]);
    assert_eq!(code, 2);
    assert!(stderr.contains("Usage: ecss-can <COMMAND>"), "{stderr}");
}

#[test]
fn folders_given_are_those_seen_from_the_current_one() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let status = TOOLS.command(&["eds", "--out", "here"]).current_dir(here.path()).status();
    assert!(status.expect("the program starts").success());
    assert!(here.path().join("here/slave.eds").is_file());
}
