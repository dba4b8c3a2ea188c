//! Runs the programs `ecss-can` and `xtask` as a user does. The tests of both share this module.

pub mod boards;
pub mod fake;

use std::fs;
use std::io::{self, PipeWriter};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Exit code of a command whose reader has left: 128 + SIGPIPE.
pub const PIPE_CLOSED: Option<i32> = Some(141);

/// A program of this workspace, by the path of its executable: `env!("CARGO_BIN_EXE_tools")`.
#[derive(Clone, Copy, Debug)]
pub struct Program(pub &'static str);

impl Program {
    /// Prepares a run with these arguments.
    pub fn command(self, arguments: &[&str]) -> Command {
        let mut command = Command::new(self.0);
        command.args(arguments);
        command
    }

    /// Runs to the end. Returns exit code, stdout and stderr.
    ///
    /// # Panics
    /// When the program does not start, is killed, or prints no UTF-8.
    pub fn run(self, arguments: &[&str]) -> (i32, String, String) {
        let output = self.command(arguments).output().expect("the program starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("it prints UTF-8");
        (output.status.code().expect("it exits"), text(output.stdout), text(output.stderr))
    }

    /// Checks that the program refuses a wrong command line: it exits with code 2, prints nothing on stdout, and its message has
    /// these parts.
    ///
    /// # Panics
    /// When it does not.
    pub fn refuses(self, arguments: &[&str], parts: &[&str]) {
        let (code, stdout, stderr) = self.run(arguments);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert_eq!(stdout, "", "{arguments:?}");
        for part in parts {
            assert!(stderr.contains(part), "{arguments:?}: no {part:?} in\n{stderr}");
        }
    }

    /// Runs to the end with a stdout whose reader has left. Returns exit code and stderr.
    ///
    /// # Panics
    /// When the program does not start, or prints no UTF-8.
    pub fn run_with_closed_stdout(self, arguments: &[&str]) -> (Option<i32>, String) {
        let output = self.command(arguments).stdout(closed_pipe()).output().expect("the program starts");
        (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
    }

    /// Returns the subcommands that `--help` lists, each with its line of help.
    ///
    /// # Panics
    /// When the help has no such list.
    pub fn subcommands(self) -> Vec<(String, String)> {
        let (_, help, _) = self.run(&["--help"]);
        let (_, list) = help.split_once("Commands:\n").expect("a list of commands");
        let lines = list.lines().take_while(|line| !line.is_empty());
        let entries = lines.map(|line| line.trim().split_once("  ").unwrap_or((line.trim(), "")));
        entries.map(|(name, help)| (name.to_owned(), help.trim().to_owned())).collect()
    }
}

/// Returns the writing end of a pipe whose reader has left.
///
/// # Panics
/// When the system has no pipe left.
pub fn closed_pipe() -> PipeWriter {
    let (reader, writer) = io::pipe().expect("a pipe");
    drop(reader);
    writer
}

/// Returns the package that `cargo NAME` runs by its alias in `.cargo/config.toml`, and the arguments that the alias gives to it.
///
/// # Panics
/// When there is no such alias, or it runs no package.
pub fn alias(name: &str) -> (String, Vec<String>) {
    let file = root().join(".cargo/config.toml");
    let table: toml::Table = fs::read_to_string(file).expect("there").parse().expect("TOML");
    let words: Vec<&str> = table["alias"][name].as_str().expect("a text").split_whitespace().collect();
    let ["run", "--package", package, "--", arguments @ ..] = &words[..] else {
        panic!("cargo {name} runs no package: {words:?}")
    };
    (package.to_string(), arguments.iter().map(|&word| word.to_owned()).collect())
}

/// Root of this workspace.
///
/// # Panics
/// When the folder of this package is not below it.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("a workspace").to_owned()
}
