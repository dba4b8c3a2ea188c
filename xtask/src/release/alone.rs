//! Uses the published packages without this repository, as a new user does.
//!
//! The user has a home of his own, without a cache of cargo, and no network. His cargo knows one source: the `.crate` files, and the
//! packages of others that they need. He installs `ecss-can`, and follows the README of its package with each template.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, ensure};
use ecss_can_cli::images::support::output;

use super::archive::Archive;
use super::directory;

/// The package with the program.
const PROGRAM: &str = "ecss-can-cli";
/// Templates, and names of the projects made of them.
const PROJECTS: [(&str, &str); 3] = [("slave", "heater"), ("master", "ground"), ("board", "h405")];
/// Commands in the folder of a project.
const COMMANDS: [&[&str]; 2] = [&["cargo", "test"], &["ecss-can", "fly"]];
/// Variables that the user has from this process.
const KEPT: [&str; 3] = ["PATH", "TERM", "FIRMWARE_TOOLCHAIN"];

/// A user with his home.
struct User {
    home: PathBuf,
    /// Target directory of all projects, so that equal packages are compiled once.
    target: PathBuf,
}

/// Installs the program, and runs the commands of each template. Prints the time of each.
///
/// # Errors
/// When a command fails.
pub fn check(archives: &[Archive]) -> anyhow::Result<()> {
    // Outside of the repository: cargo reads configurations in all folders above.
    let root = tempfile::tempdir().context("no temporary folder")?;
    let [home, target, source] = ["home", "target", "source"].map(|name| root.path().join(name));
    let user = User { home, target };
    directory::fill(&source, archives)?;
    let folder = user.home.join(".cargo");
    fs::create_dir_all(&folder)?;
    fs::write(folder.join("config.toml"), directory::configuration(&source))?;

    let program =
        archives.iter().find(|archive| archive.name == PROGRAM).context("no package with the program")?;
    let package = source.join(&program.stem).display().to_string();
    user.run(&user.home, &["cargo", "install", "--quiet", "--locked", "--path", &package])?;
    for (template, name) in PROJECTS {
        user.run(&user.home, &["ecss-can", "new", template, name])?;
        for command in COMMANDS {
            user.run(&user.home.join(name), command)?;
        }
    }
    Ok(())
}

impl User {
    /// Runs a command, and prints its time.
    fn run(&self, folder: &Path, words: &[&str]) -> anyhow::Result<()> {
        let begin = Instant::now();
        let line = words.join(" ");
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
        output::line(format_args!("{:>6.1} s  {line}", begin.elapsed().as_secs_f64()))
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
