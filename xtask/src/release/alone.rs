//! Uses the published packages without this repository, as a new user does.
//!
//! The user has a home of his own, without a cache of cargo, and no network. His cargo knows one source: the `.crate` files, and the
//! packages of others that they need. He installs `ecss-can`, and follows the README of its package with each template, for each
//! shipped board.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, ensure};
use ecss_can_cli::images::support::board::Board;
use ecss_can_cli::images::support::output;

use super::archive::Archive;
use super::directory;

/// The package with the program.
const PROGRAM: &str = "ecss-can-cli";
/// Templates for a shipped board, and names of the projects made of them.
const FOR_BOARDS: [(&str, &str); 2] = [("slave", "heater"), ("master", "ground")];
/// The template of a board that is not shipped, and the name of its project.
const OWN_BOARD: (&str, &str) = ("board", "h405");
/// Commands in the folder of a project.
const TEST: [&str; 2] = ["cargo", "test"];
const FLY: [&str; 2] = ["ecss-can", "fly"];
/// Starts a command in a network of its own, which has no interface.
const WITHOUT_NETWORK: [&str; 3] = ["unshare", "--map-current-user", "--net"];
/// Variables that the user has from this process.
const KEPT: [&str; 3] = ["PATH", "TERM", "FIRMWARE_TOOLCHAIN"];

/// A user with his home.
struct User {
    home: PathBuf,
    /// Target directory of all projects, so that equal packages are compiled once.
    target: PathBuf,
    /// The beginning of each command: [`WITHOUT_NETWORK`] where this computer permits it.
    start: &'static [&'static str],
}

/// A project of a template.
struct Project {
    template: &'static str,
    name: &'static str,
    board: String,
}

/// Installs the program, and runs the commands of each template for each board. Prints the time of each.
///
/// # Errors
/// When a command fails.
pub fn check(archives: &[Archive]) -> anyhow::Result<()> {
    // Outside of the repository: cargo reads configurations in all folders above.
    let root = tempfile::tempdir().context("no temporary folder")?;
    let [home, target, source] = ["home", "target", "source"].map(|name| root.path().join(name));
    let user = User { home, target, start: start() };
    directory::fill(&source, archives)?;
    let folder = user.home.join(".cargo");
    fs::create_dir_all(&folder)?;
    fs::write(folder.join("config.toml"), directory::configuration(&source))?;

    let program =
        archives.iter().find(|archive| archive.name == PROGRAM).context("no package with the program")?;
    let package = source.join(&program.stem).display().to_string();
    user.run(&user.home, &["cargo", "install", "--quiet", "--locked", "--path", &package])?;
    let rows: Vec<String> =
        projects().iter().map(|project| user.follow(project)).collect::<anyhow::Result<_>>()?;
    output::line("template  board                   new  cargo test  ecss-can fly  (seconds)")?;
    rows.iter().try_for_each(output::line)
}

/// Returns all projects: each template for each shipped board, and a board.
fn projects() -> Vec<Project> {
    let boards = Board::built();
    let of_boards = boards.iter().flat_map(|board| {
        FOR_BOARDS.map(|(template, name)| Project { template, name, board: board.name().to_owned() })
    });
    let (template, name) = OWN_BOARD;
    of_boards.chain([Project { template, name, board: name.to_owned() }]).collect()
}

/// Returns the beginning of each command of the user.
fn start() -> &'static [&'static str] {
    let [program, arguments @ ..] = WITHOUT_NETWORK;
    let mut probe = Command::new(program);
    probe.args(arguments).arg("true").stdout(Stdio::null()).stderr(Stdio::null());
    if probe.status().is_ok_and(|status| status.success()) {
        return &WITHOUT_NETWORK;
    }
    output::note("this computer permits no network without interfaces: only cargo is offline");
    &[]
}

impl Project {
    /// Returns the command that makes it.
    fn command(&self) -> Vec<&str> {
        let command = ["ecss-can", "new", self.template, self.name];
        let is_usual = self.board == Board::DEFAULT || self.board == self.name;
        let board = ["--board", &self.board];
        command.into_iter().chain(board.into_iter().filter(|_| !is_usual)).collect()
    }
}

impl User {
    /// Runs the commands for a project, in a folder for its board. Returns their times as a row of the table.
    fn follow(&self, project: &Project) -> anyhow::Result<String> {
        let folder = self.home.join(&project.board);
        fs::create_dir_all(&folder)?;
        let made = self.run(&folder, &project.command())?;
        let inside = folder.join(project.name);
        let (tested, flown) = (self.run(&inside, &TEST)?, self.run(&inside, &FLY)?);
        let Project { template, board, .. } = project;
        Ok(format!("{template:<9} {board:<18} {made:>8.1} {tested:>11.1} {flown:>13.1}"))
    }

    /// Runs a command. Prints its time, and returns it in seconds.
    fn run(&self, folder: &Path, words: &[&str]) -> anyhow::Result<f64> {
        let begin = Instant::now();
        let line = words.join(" ");
        let words = [self.start, words].concat();
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).current_dir(folder).env_clear();
        command.envs(KEPT.iter().filter_map(|name| Some((name, std::env::var_os(name)?))));
        command.env("HOME", &self.home).env("CARGO_HOME", self.home.join(".cargo"));
        // The user shares the toolchains of this computer. Rustup must not change them.
        command.env("RUSTUP_HOME", rustup_home()?).env("RUSTUP_AUTO_INSTALL", "0");
        command.env("CARGO_TARGET_DIR", &self.target);
        command.env("PATH", self.path()?);
        let status = command.status().with_context(|| format!("cannot run {line}"))?;
        ensure!(status.success(), "`{line}` failed in {} ({status}), see above", folder.display());
        let seconds = begin.elapsed().as_secs_f64();
        output::line(format_args!("{seconds:>6.1} s  {line}"))?;
        Ok(seconds)
    }

    /// PATH with the installed program first.
    fn path(&self) -> anyhow::Result<std::ffi::OsString> {
        let all = std::env::var_os("PATH").unwrap_or_default();
        let own = self.home.join(".cargo/bin");
        Ok(std::env::join_paths([own].into_iter().chain(std::env::split_paths(&all)))?)
    }
}

/// Returns the folder of rustup's toolchains, which the user shares.
fn rustup_home() -> anyhow::Result<PathBuf> {
    let given = std::env::var_os("RUSTUP_HOME").map(PathBuf::from);
    given.or_else(|| Some(std::env::home_dir()?.join(".rustup"))).context("no home directory")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given three shipped boards and three templates, then slave and master are made for each board, and a board once.
    #[test]
    fn each_template_is_used_for_each_shipped_board() {
        let commands: Vec<String> = projects().iter().map(|project| project.command().join(" ")).collect();
        let expected = [
            "ecss-can new slave heater",
            "ecss-can new master ground",
            "ecss-can new slave heater --board nucleo-f446re",
            "ecss-can new master ground --board nucleo-f446re",
            "ecss-can new slave heater --board stm32f4discovery",
            "ecss-can new master ground --board stm32f4discovery",
            "ecss-can new board h405",
        ];
        assert_eq!(commands, expected);
    }
}
