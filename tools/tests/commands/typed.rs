//! `cargo twin` with commands typed at a terminal, and with a program at its control port.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;

use rexpect::session::{PtySession, spawn_command};

/// Time limit of each wait in milliseconds, including the build of the images.
const PATIENCE: u64 = 600_000;

/// `cargo twin` at a terminal, and its control port.
fn twin(record: &Path) -> (PtySession, u16) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ecss-can"));
    command.args(["twin", "--slcan-nominal", "0", "--slcan-redundant", "0", "--control", "0"]);
    command.args(["--profile", "standard", "--slaves", "3", "--seconds", "600", "--record"]).arg(record);
    command.env("TERM", "xterm");
    let mut session = spawn_command(command, Some(PATIENCE)).expect("it starts");
    session.exp_string("control: socket://127.0.0.1:").expect("a control port");
    let port = session.exp_regex("[0-9]+\\s").expect("its number").1;
    (session, port.trim().parse().expect("a port"))
}

/// Types a line and waits for these texts.
fn type_line(session: &mut PtySession, line: &str, expected: &[&str]) {
    // The Enter key sends a carriage return.
    session.send(&format!("{line}\r")).and_then(|_| session.flush()).expect("it reads");
    for words in expected {
        session.exp_string(words).unwrap_or_else(|error| panic!("{line}: {words}: {error}"));
    }
}

/// Sends a line as a program does. Returns the answer and its end.
fn ask(port: u16, line: &str) -> (String, String) {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).expect("it listens");
    writeln!(stream, "{line}").expect("it reads");
    let mut said = String::new();
    for line in BufReader::new(stream).lines() {
        match line.expect("it answers").as_str() {
            end @ ("ok" | "error") => return (said, end.to_owned()),
            line => said.extend([line, "\n"]),
        }
    }
    panic!("{line}: no end after {said:?}");
}

/// Given a cut and its repair, a slave without power, a reset and an inverted bit, then the logs of the boards show
/// each.
#[test]
fn faults_are_typed_while_it_flies() {
    let directory = tempfile::tempdir().expect("a directory");
    let record = directory.path().join("record");
    let (mut session, port) = twin(&record);
    session.exp_string("slave 2: Operational").expect("a slave starts");
    session.exp_string("slave 3: Operational").expect("the other one, too");
    type_line(
        &mut session,
        "status",
        &["0.0 m", "operational, nominal", "nominal bus: no fault", "redundant bus:"],
    );
    type_line(&mut session, "heal nominal", &["already whole"]);
    type_line(&mut session, "cut nominal 0.5", &["done", "active bus: Redundant"]);
    type_line(&mut session, "cut nominal 0.5", &["already cut at 0.5 m"]);
    type_line(&mut session, "short nominal 0", &["done"]);
    type_line(&mut session, "short nominal 0", &["already shorted at 0 m, dominant"]);
    type_line(&mut session, "status", &["nominal bus: cut at 0.5 m; short at 0 m, dominant; load "]);
    type_line(&mut session, "clear nominal", &["done"]);
    type_line(&mut session, "clear nominal", &["already without a short"]);
    type_line(&mut session, "heal nominal", &["done"]);
    type_line(&mut session, "power 3 off", &["done", "slave 3: lost"]);
    type_line(&mut session, "power 3 off", &["already off"]);
    type_line(&mut session, "status", &["without power: node 3"]);
    type_line(&mut session, "power 3 on", &["done", "slave 3: Operational"]);
    type_line(&mut session, "power 3 on", &["already on"]);
    type_line(&mut session, "reset 2", &["done", "slave 2: Operational"]);
    type_line(&mut session, "flip redundant 20", &["done"]);
    type_line(&mut session, "cut third 1", &["nominal, redundant"]);
    type_line(&mut session, "power 9 on", &["allowed are 1, 2, 3, 4"]);

    let (said, end) = ask(port, "status");
    let row = said.lines().find(|line| line.trim_start().starts_with("2 ")).expect("a row of node 2");
    assert!(row.contains("operational, redundant") && end == "ok", "{said}");
    let redundant = said.lines().find(|line| line.starts_with("redundant bus: ")).expect("a row of the bus");
    assert!(redundant.contains("no fault; load ") && redundant.contains(" % (failed"), "{said}");
    assert!(!redundant.contains(" 0 destroyed"), "a bit was inverted: {said}");
    assert_eq!(ask(port, "jump").1, "error");
    let (said, end) = ask(port, "help");
    assert!(said.contains("Break the cable of a bus") && end == "ok", "{said}{end}");

    type_line(&mut session, "exit", &["ended after", "redundant bus: ", "load of the busiest second"]);
    session.exp_eof().expect("it ends");
    let frames = |bus: &str| {
        let log = std::fs::read_to_string(record.join(format!("bus-{bus}.log"))).expect("a log");
        assert!(log.lines().all(|line| line.contains(&format!(" {bus} "))));
        log.lines().count()
    };
    assert!(frames("nominal") > 30 && frames("redundant") > 30);
    let said = std::fs::read_to_string(record.join("boards.log")).expect("a log");
    assert!(said.contains("slave 3: lost"));
    assert!(record.join("spacecraft.pcapng").metadata().expect("a capture").len() > 1_000);
}
