//! The programs of this workspace, run as users run them.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Sender};
use std::sync::{Arc, LazyLock, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::{Context, anyhow, ensure};
use serde_json::Value;

use crate::tools::{self, workspace};

/// Longest run of a spacecraft without a request to end, in seconds.
const SECONDS: &str = "600";

/// Longest time until the spacecraft listens. It may build the firmware first.
const UNTIL_IT_LISTENS: Duration = Duration::from_secs(900);

/// The program `ecss-can`, which `cargo demo`, `cargo twin` and the other commands for users run, built once in a test process.
///
/// # Errors
/// When it cannot be built.
pub fn executable() -> anyhow::Result<&'static Path> {
    static BUILT: LazyLock<Result<PathBuf, String>> =
        LazyLock::new(|| build().map_err(|error| format!("{error:#}")));
    BUILT.as_deref().map_err(|error| anyhow!("{error}"))
}

fn build() -> anyhow::Result<PathBuf> {
    tools::note("building the program ecss-can; the first time about a minute");
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let output = Command::new(cargo)
        .args([
            "build",
            "--quiet",
            "--package",
            "ecss-can-cli",
            "--message-format",
            "json-render-diagnostics",
        ])
        .args((!cfg!(debug_assertions)).then_some("--release"))
        .current_dir(workspace())
        .stderr(Stdio::inherit())
        .output()
        .context("cannot run cargo")?;
    ensure!(output.status.success(), "cargo build --package ecss-can-cli failed ({})", output.status);
    let messages = output.stdout.split(|byte| *byte == b'\n');
    let mut executables = messages.filter_map(|line| {
        let message: Value = serde_json::from_slice(line).ok()?;
        Some(PathBuf::from(message.get("executable")?.as_str()?))
    });
    executables.next_back().context("cargo built no program")
}

/// Runs that program to its end.
///
/// # Errors
/// When it cannot be built or fails. Its message is on stderr.
pub fn ends_well(arguments: &[&str]) -> anyhow::Result<()> {
    let mut command = Command::new(executable()?);
    let status = command.args(arguments).current_dir(workspace()).stdout(Stdio::null()).status();
    let status = status.context("cannot run the program ecss-can")?;
    ensure!(status.success(), "ecss-can {} failed ({status})", arguments.join(" "));
    Ok(())
}

/// A running spacecraft, which ends when it goes out of scope.
pub struct Twin {
    child: Child,
    said: Arc<Mutex<String>>,
    /// Thread that keeps its output.
    follower: Option<JoinHandle<()>>,
    /// Address of the nominal bus, for python-can.
    pub nominal: String,
    /// Address of the redundant bus.
    pub redundant: String,
}

impl Twin {
    /// Starts `cargo twin` on free ports, and waits until both buses are available.
    ///
    /// # Errors
    /// When it cannot be built or does not start to listen.
    pub fn start(arguments: &[&str]) -> anyhow::Result<Twin> {
        let mut command = Command::new(executable()?);
        command
            .args(["twin", "--slcan-nominal", "0", "--slcan-redundant", "0", "--seconds", SECONDS])
            .args(arguments)
            .current_dir(workspace())
            .stdin(Stdio::null())
            .stdout(Stdio::piped());
        Twin::of(command)
    }

    /// Runs the command `cargo twin` with piped standard output, and waits until both buses are available.
    ///
    /// # Errors
    /// When it does not begin to listen.
    pub fn of(mut command: Command) -> anyhow::Result<Twin> {
        let mut child = command.spawn().context("cannot run the twin")?;
        let said = Arc::new(Mutex::new(String::new()));
        let stdout = child.stdout.take();
        let (sender, addresses) = mpsc::channel();
        let follower = stdout.map(|stdout| follow(stdout, said.clone(), sender));
        let mut twin = Twin { child, said, follower, nominal: String::new(), redundant: String::new() };
        let next = || {
            let address = addresses.recv_timeout(UNTIL_IT_LISTENS);
            address.context("cargo twin does not listen; what it said stands above")
        };
        (twin.nominal, twin.redundant) = (next()?, next()?);
        Ok(twin)
    }

    /// Ends it regularly, and returns its output.
    ///
    /// # Errors
    /// When a board panicked, locked up or had to be stopped. The reason is on stderr.
    pub fn end(mut self) -> anyhow::Result<String> {
        let asked =
            Command::new("kill").arg(self.child.id().to_string()).status().context("cannot run kill")?;
        ensure!(asked.success(), "the spacecraft has ended by itself");
        let status = self.child.wait()?;
        if let Some(follower) = self.follower.take() {
            follower.join().map_err(|_| anyhow!("what the spacecraft said is lost"))?;
        }
        ensure!(status.success(), "the spacecraft was not well ({status})\n{}", self.said());
        Ok(self.said())
    }

    /// Returns its output so far.
    pub fn said(&self) -> String {
        self.said.lock().map(|said| said.clone()).unwrap_or_default()
    }
}

impl Drop for Twin {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Keeps the output of a spacecraft, and sends the addresses of its buses, nominal first, when they are printed.
fn follow(
    stdout: impl std::io::Read + Send + 'static,
    said: Arc<Mutex<String>>,
    addresses: Sender<String>,
) -> JoinHandle<()> {
    thread::spawn(move || {
        for line in BufReader::new(stdout).lines().map_while(Result::ok) {
            if let Some((_, words)) = line.split_once(" bus: slcan ") {
                let address = words.split(' ').next().unwrap_or_default();
                // There is no receiver when the start has failed.
                let _ = addresses.send(address.to_owned());
            }
            if let Ok(mut said) = said.lock() {
                *said += &line;
                said.push('\n');
            }
        }
    })
}
