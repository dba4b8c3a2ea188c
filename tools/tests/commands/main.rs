//! The commands, run as by a user.

mod boards;
mod campaign;
mod cli;
mod demo;
mod eds;
mod elsewhere;
mod endings;
mod environments;
mod flash;
mod mission;
mod new;
mod own_package;
mod permissions;
mod schedule;
mod twin;
mod typed;

use std::io::BufRead;
use std::process::{Child, Command};

/// The program under test.
const TOOLS: second::programs::Program = second::programs::Program(env!("CARGO_BIN_EXE_ecss-can"));

/// Reads lines until one contains `wanted`.
fn wait_for(lines: &mut impl BufRead, wanted: &str) {
    let mut line = String::new();
    while !line.contains(wanted) {
        line.clear();
        assert_ne!(lines.read_line(&mut line).expect("UTF-8"), 0, "it never said {wanted:?}");
    }
}

/// Sends a signal, such as `-INT`.
fn signal(child: &Child, name: &str) {
    let kill = Command::new("kill").args([name, &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
}

/// Checks that each of these command lines is refused, with a message that has these parts.
fn assert_refused(lines: &[(&str, &[&str])]) {
    for (line, parts) in lines {
        TOOLS.refuses(&line.split_whitespace().collect::<Vec<_>>(), parts);
    }
}
