//! Uses the published packages without this repository, as a new user does.
//!
//! The user has a home of his own, without a cache of cargo, and no network. His cargo knows one source: the `.crate` files, and the
//! packages of others that they need. He installs `ecss-can`, and follows the README of its package with each template.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, ensure};
use ecss_can_cli::images::support::{output, project};

use super::archive::Archive;
use super::{BUILT, directory};

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
    let root = project::target(BUILT).join("alone");
    let user = User { home: root.join("home"), target: root.join("target") };
    let source = root.join("source");
    clear(&user.home)?;
    let hashes = directory::fill(&source, archives)?.concat();
    user.forget_other_packages(&root.join("hashes"), &hashes)?;
    let folder = user.home.join(".cargo");
    fs::create_dir_all(&folder)?;
    fs::write(folder.join("config.toml"), directory::configuration(&source))?;

    let program =
        archives.iter().find(|archive| archive.name == PROGRAM).context("no package with the program")?;
    let installed = source.join(&program.stem).display().to_string();
    user.run(&user.home, &["cargo", "install", "--quiet", "--locked", "--path", &installed])?;
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
        command.env("RUSTUP_HOME", rustup_home()?).env("CARGO_TARGET_DIR", &self.target);
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

    /// Removes what was built of other archives: cargo compiles a package of a directory source once for each version.
    fn forget_other_packages(&self, note: &Path, hashes: &str) -> anyhow::Result<()> {
        if fs::read_to_string(note).is_ok_and(|before| before == hashes) {
            return Ok(());
        }
        clear(&self.target)?;
        fs::write(note, hashes).with_context(|| format!("cannot write {}", note.display()))
    }
}

/// Removes a folder with its contents, and makes it again.
fn clear(folder: &Path) -> anyhow::Result<()> {
    let removed = if folder.exists() { fs::remove_dir_all(folder) } else { Ok(()) };
    removed
        .and_then(|()| fs::create_dir_all(folder))
        .with_context(|| format!("cannot use {}", folder.display()))
}

/// Returns the folder of rustup's toolchains, which the user shares.
fn rustup_home() -> anyhow::Result<PathBuf> {
    let given = std::env::var_os("RUSTUP_HOME").map(PathBuf::from);
    given.or_else(|| Some(std::env::home_dir()?.join(".rustup"))).context("no home directory")
}
