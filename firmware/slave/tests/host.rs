//! The slave as a program on a computer.

use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStdout, Command, Output, Stdio};

fn slave(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_slave")).args(arguments).output().expect("the program starts")
}

fn lines(output: &Output) -> Vec<String> {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect()
}

/// Starts a run without end and waits for its first line.
fn endless(arguments: &[&str]) -> (Child, BufReader<ChildStdout>) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slave"));
    command.args(["--seconds", "0"]).args(arguments).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().expect("the program starts");
    let mut stdout = BufReader::new(child.stdout.take().expect("piped"));
    stdout.read_line(&mut String::new()).expect("a line");
    (child, stdout)
}

/// Given the program without options, then the slave is started and commanded. When the nominal bus is cut at 4 s, then the slave
/// follows the master, and commands and telemetry pass on the redundant bus.
///
/// Verifies: ECSS 6.5.1a.1, 8.3.3d, 8.3.3g
#[test]
fn slave_program_shows_the_fail_over() {
    let lines = lines(&slave(&[]));
    let cut = lines.iter().position(|line| line.contains("the nominal bus is cut")).expect("there is a cut");
    assert!(lines[cut].trim_start().starts_with("4.000000"), "{}", lines[cut]);
    let (before, after) = lines.split_at(cut);
    let has = |lines: &[String], words: &[&str]| {
        lines.iter().any(|line| words.iter().all(|word| line.contains(word)))
    };
    assert!(has(before, &["slave", "INFO", "Operational"]));
    assert!(has(before, &["nominal", "TC to node 2: SetLed(true)"]));
    assert!(has(before, &["indicators", "state LED on"]));
    let number = |words: &str| before.iter().filter(|line| line.contains(words)).count();
    assert_eq!(number("heartbeat of node 1: Operational"), 4, "one a second, of ten that are sent");
    assert_eq!(number("indicators  SYNC LED, toggles: 10"), 3, "after 1.1 s, 2.1 s and 3.1 s");
    assert!(has(before, &["nominal", "TM of node 2: Uptime(1000)"]));
    assert!(!has(before, &["  redundant "]));
    assert!(has(after, &["master", "active bus: Redundant"]));
    assert!(has(after, &["slave", "INFO", "active bus: Redundant"]));
    assert!(has(after, &["redundant", "heartbeat of node 2: Operational"]));
    assert!(has(after, &["redundant", "TC to node 2"]) && has(after, &["redundant", "TM of node 2"]));
    assert!(!has(after, &["  nominal  "]));
}

/// Given a run of 3 s with all frames, then each frame is a line of candump, and there is no cut. The boot-up message of the slave and
/// its first heartbeat in state Operational are those of CiA 301 7.2.8.3.
///
/// Verifies: ECSS 6.3b, 6.5.2a, 6.5.3a, 6.9c, 6.9d
/// Notices: ECSS 6.9d: SYNC comes with twice its period.
#[test]
fn slave_program_prints_frames_as_candump() {
    let lines = lines(&slave(&["--frames", "--seconds", "3"]));
    let frames: Vec<&String> = lines.iter().filter(|line| line.starts_with('(')).collect();
    assert!(frames.contains(&&"(0000000000.000000) nominal 702#00".to_owned()));
    assert!(frames.contains(&&"(0000000000.100000) nominal 702#05".to_owned()));
    assert!(frames.iter().all(|line| line.contains(" nominal ")));
    assert_eq!(frames.iter().filter(|line| line.ends_with(" 080#")).count(), 29, "from 0.1 s to 2.9 s");
}

/// Given invalid arguments, then the program ends with 2 and reports the value and the allowed range.
#[test]
fn slave_program_refuses_wrong_arguments() {
    for (arguments, reason) in [
        (
            &["--seconds", "ten"][..],
            "invalid value 'ten' for '--seconds <N>': allowed are whole seconds from 0 to 86400",
        ),
        (&["--seconds", "86401"], "allowed are whole seconds from 0 to 86400"),
        (
            &["--cut-at", "-1"],
            "invalid value '-1' for '--cut-at <N>': allowed are whole seconds from 0 to 86400",
        ),
        (&["--frame"], "unexpected argument '--frame' found"),
    ] {
        let output = slave(arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr.contains(reason), "{stderr}");
        assert!(output.stdout.is_empty());
    }
}

/// Given a run without end in real time, when Ctrl-C is pressed, then the program ends with 130.
#[test]
fn slave_program_ends_with_130_at_ctrl_c() {
    let (mut child, _stdout) = endless(&["--real-time"]);
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.expect("kill starts").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
}

/// Given a run without end, when its reader leaves, then the program ends with 141.
#[test]
fn slave_program_ends_when_its_reader_leaves() {
    let (mut child, stdout) = endless(&[]);
    drop(stdout);
    assert_eq!(child.wait().expect("it ends").code(), Some(141));
}
