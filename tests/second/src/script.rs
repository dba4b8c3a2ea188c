//! Python scripts and how they are run.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::Duration;

use anyhow::{Context, bail, ensure};
use ecss_can_cli::images::Package;

use crate::device;
use crate::program::{Twin, ends_well};
use crate::tools;

/// Longest time to wait for a line of a script.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs a script of `python/` with a spacecraft of `cargo twin` and `arguments`, and returns the output of the
/// spacecraft.
///
/// The script finds the addresses of the buses in `SLCAN_NOMINAL` and `SLCAN_REDUNDANT`.
///
/// # Errors
/// When a tool is missing, the script fails, or a board fails. The error has the output of script and spacecraft.
pub fn run(name: &str, arguments: &[&str]) -> anyhow::Result<String> {
    run_with(name, arguments, &[])
}

/// Runs a script as [`run`] does, with these variables in its environment.
fn run_with(name: &str, arguments: &[&str], variables: &[(&str, &str)]) -> anyhow::Result<String> {
    let twin = Twin::start(arguments)?;
    let variables = [&buses(&twin)[..], variables].concat();
    judge(name, &variables).with_context(|| format!("the spacecraft said\n{}", twin.said()))?;
    twin.end()
}

/// Runs `thermometer.py` with the example thermometer as node 3, its master, and a shipped slave. The script finds its data sheet in
/// `SLAVE_EDS`.
///
/// # Errors
/// As [`run`], and when an image or the data sheet cannot be made.
pub fn run_with_thermometer() -> anyhow::Result<String> {
    let image = |name| -> anyhow::Result<String> {
        let built = Package::of_workspace(name).build(None)?;
        Ok(built.first().context("a package with a program")?.display().to_string())
    };
    let sheets = tools::workspace().join("target/second/thermometer");
    let sheets = sheets.to_str().context("a path in UTF-8")?;
    ends_well(&["eds", "--package", "thermometer", "--out", sheets])?;
    let (master, slave) = (image("thermometer-master")?, format!("--slave=3={}", image("thermometer")?));
    let variables = [("SLAVE_EDS", &*format!("{sheets}/thermometer.eds"))];
    run_with(
        "thermometer.py",
        &["--profile", "standard", "--slaves", "1", "--master", &master, &slave],
        &variables,
    )
}

/// As [`run`], with one of the example slaves on embassy's CAN driver as node 3 and no other board: `program`. The script finds the
/// data sheet of the slave in `SLAVE_EDS`, and its name among the conformance devices in `DEVICE`.
///
/// # Errors
/// As [`run`], and when image or data sheet cannot be made.
pub fn run_with_embassy(name: &str, program: &str) -> anyhow::Result<String> {
    let built = Package::of_workspace("embassy-slave").build("pyboard-v11")?;
    let image = built.iter().find(|image| image.ends_with(program));
    let slave = format!("--slave=3={}", image.context("the package has no such program")?.display());
    let sheet = device::heater_data_sheet()?;
    let sheet = sheet.to_str().context("a path in UTF-8")?;
    let variables = [("SLAVE_EDS", sheet), ("DEVICE", "heater")];
    run_with(name, &["--slaves", "0", "--no-master", &slave], &variables)
}

/// As [`run`], with the images of master and slaves 2 and 3 for 125 kbit/s, profile `standard`. The script finds the bit rate in
/// `BIT_RATE`.
///
/// # Errors
/// As [`run`], and when an image cannot be built.
pub fn run_at_125_kbit(name: &str) -> anyhow::Result<String> {
    let images = ecss_can_cli::images::build("pyboard-v11", "standard+kbit-125")?;
    let master = format!("--master={}", images.master.display());
    let [second, third] = [2, 3].map(|node| format!("--slave={node}={}", images.slave.display()));
    run_with(name, &["--slaves", "0", &master, &second, &third], &[("BIT_RATE", "125000")])
}

/// Runs a script as [`run`] does, with the test device as these nodes. The script finds its data sheet in `SLAVE_EDS`.
///
/// # Errors
/// As [`run`], and when image or data sheet cannot be made.
pub fn run_with_device(name: &str, arguments: &[&str], nodes: &[u8]) -> anyhow::Result<String> {
    let image = device::image()?;
    let own: Vec<String> = nodes.iter().map(|node| format!("--slave={node}={}", image.display())).collect();
    let arguments: Vec<&str> = arguments.iter().copied().chain(own.iter().map(String::as_str)).collect();
    let sheet = device::data_sheet()?;
    let sheet = sheet.to_str().context("a path in UTF-8")?;
    run_with(name, &arguments, &[("SLAVE_EDS", sheet)])
}

/// Returns the addresses of the buses.
fn buses(twin: &Twin) -> [(&'static str, &str); 2] {
    [("SLCAN_NOMINAL", &twin.nominal), ("SLCAN_REDUNDANT", &twin.redundant)]
}

/// Returns the command of Python with a script of `python/` and these variables in its environment.
fn command(name: &str, variables: &[(&str, &str)]) -> anyhow::Result<Command> {
    let mut command = Command::new(tools::python()?);
    command
        .arg(tools::scripts().join(name))
        .envs(variables.iter().copied())
        .env("PYTHONDONTWRITEBYTECODE", "1");
    Ok(command)
}

/// Runs a script of `python/` with these variables in its environment.
///
/// # Errors
/// When Python is missing, or the script fails or tests nothing. The error has its output.
pub fn judge(name: &str, variables: &[(&str, &str)]) -> anyhow::Result<()> {
    let output = command(name, variables)?.output().with_context(|| format!("cannot run {name}"))?;
    let said =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    ensure!(output.status.success(), "{name} failed ({})\n{said}", output.status);
    let tested = said.lines().any(|line| line.starts_with("Ran ") && !line.starts_with("Ran 0 "));
    ensure!(tested, "{name} tested nothing\n{said}");
    Ok(())
}

/// A script that acts as a node until it goes out of scope.
pub struct Companion {
    name: String,
    child: Child,
    lines: Receiver<String>,
}

impl Companion {
    /// Starts a script of `python/` on the buses of a spacecraft.
    ///
    /// # Errors
    /// When Python is missing.
    pub fn start(name: &str, twin: &Twin) -> anyhow::Result<Companion> {
        let mut child = command(name, &buses(twin))?
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .with_context(|| format!("cannot run {name}"))?;
        let stdout = child.stdout.take().context("its output is piped")?;
        let (sender, lines) = mpsc::channel();
        thread::spawn(move || {
            // There is no receiver when the test has failed.
            BufReader::new(stdout).lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
        });
        Ok(Companion { name: name.to_owned(), child, lines })
    }

    /// Returns the next line that it prints.
    ///
    /// # Errors
    /// When it ends or prints nothing for a minute. The error has its stderr.
    pub fn next_line(&mut self) -> anyhow::Result<String> {
        self.lines.recv_timeout(PATIENCE).or_else(|_| {
            // It may have ended already.
            let _ = self.child.kill();
            let complaints = self.complaints()?;
            bail!("{} says nothing more\n{complaints}", self.name)
        })
    }

    /// Lets it end, and returns its unread output.
    ///
    /// # Errors
    /// When it has failed. The error has its output.
    pub fn end(mut self) -> anyhow::Result<Vec<String>> {
        drop(self.child.stdin.take());
        let complaints = self.complaints()?;
        let status = self.child.wait()?;
        ensure!(status.success(), "{} failed ({status})\n{complaints}", self.name);
        Ok(self.lines.iter().collect())
    }

    /// Returns its stderr until its end.
    fn complaints(&mut self) -> anyhow::Result<String> {
        let mut complaints = String::new();
        if let Some(mut stderr) = self.child.stderr.take() {
            stderr.read_to_string(&mut complaints)?;
        }
        Ok(complaints)
    }
}

impl Drop for Companion {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
