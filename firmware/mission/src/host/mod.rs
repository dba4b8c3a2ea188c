//! Programs that run a shipped application on a computer, in a mock spacecraft (feature `host`).
//!
//! Such a program powers on a few nodes of a [`MockSpacecraft`] and gives one of them its application. [`run`] does the
//! rest: options, virtual time, the cut of the nominal bus, and a line for each event.
//!
//! ```no_run
//! use mission::{PROFILE, host};
//! use ecss_can::types::NodeId;
//!
//! fn main() -> std::process::ExitCode {
//!     host::run("A master and two slaves", |spacecraft, console| {
//!         host::slave(spacecraft, PROFILE, NodeId::of::<2>());
//!         host::slave(spacecraft, PROFILE, NodeId::of::<3>());
//!         host::master(spacecraft, PROFILE, NodeId::of::<2>(), console);
//!     })
//! }
//! ```

mod console;
mod frames;
mod indicators;
mod options;
mod partner;

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time;

pub use console::Console;
use ecss_can::mock::MockSpacecraft;
use ecss_can::types::{Bus, Instant};
use frames::Frames;
pub use indicators::PrintedIndicators;
use options::Options;
pub use partner::{master, memory, slave};

/// Ctrl-C: 128 + SIGINT.
const INTERRUPTED: u8 = 130;
/// Longest pause between two checks for Ctrl-C.
const PAUSE: time::Duration = time::Duration::from_millis(50);

/// Runs a spacecraft with the options of the command line. `about` is the first line of the help; `power_on` makes the
/// nodes and their applications.
///
/// Returns the exit code: 0 at the end of the run, 1 when something failed, 130 after Ctrl-C, 141 when the reader of
/// stdout has left. A wrong command line ends the program with 2.
pub fn run(about: &'static str, power_on: impl FnOnce(&mut MockSpacecraft, &Console)) -> ExitCode {
    let options = Options::parse(about);
    let is_stopped = Arc::new(AtomicBool::new(false));
    let stop = is_stopped.clone();
    if let Err(error) = ctrlc::set_handler(move || stop.store(true, Ordering::Relaxed)) {
        eprintln!("error: cannot handle Ctrl-C: {error}");
        return ExitCode::FAILURE;
    }
    let console = Console::start(options.seconds);
    let mut spacecraft = MockSpacecraft::new();
    power_on(&mut spacecraft, &console);
    let code = fly(&mut spacecraft, &options, &console, &is_stopped);
    console.finish();
    code
}

fn fly(
    spacecraft: &mut MockSpacecraft,
    options: &Options,
    console: &Console,
    is_stopped: &AtomicBool,
) -> ExitCode {
    let (started, mut frames) = (time::Instant::now(), Frames::new(options.frames));
    let mut cut = Some(options.cut());
    while spacecraft.now() < options.end() {
        if is_stopped.load(Ordering::Relaxed) {
            return ExitCode::from(INTERRUPTED);
        }
        for sent in spacecraft.step(cut.unwrap_or(Instant::NEVER).min(options.end())) {
            frames.show(console, &sent);
        }
        let now = spacecraft.now();
        console.set_time(now);
        if cut.take_if(|at| *at <= now).is_some() {
            spacecraft.cut(Bus::Nominal);
            console.line("spacecraft", "the nominal bus is cut");
        }
        if let Some(code) = console.failure() {
            return code;
        }
        if options.real_time {
            pace(started + time::Duration::from_micros(now.as_micros()), is_stopped);
        }
    }
    ExitCode::SUCCESS
}

/// Waits until `at`, or until Ctrl-C.
fn pace(at: time::Instant, is_stopped: &AtomicBool) {
    while !is_stopped.load(Ordering::Relaxed) {
        match at.saturating_duration_since(time::Instant::now()) {
            time::Duration::ZERO => return,
            ahead => thread::sleep(ahead.min(PAUSE)),
        }
    }
}
