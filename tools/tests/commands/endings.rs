//! Early ends of the commands: a closed pipe, Ctrl-C, SIGTERM.

use std::fs::{self, File};
use std::io::{self, BufReader, Read};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus, Stdio};

use second::programs::{PIPE_CLOSED, closed_pipe};
use serde_json::Value;

use crate::{TOOLS, signal, wait_for};

/// Exit code of an interrupted command: 128 + SIGINT.
const INTERRUPTED: Option<i32> = Some(130);

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn summary(out: &Path) -> Value {
    let text = fs::read_to_string(out.join("summary.json")).expect("the summary is written");
    serde_json::from_str(&text).expect("JSON")
}

/// Starts a demo that is long enough to be interrupted.
fn demo_under_way(out: &Path) -> Child {
    let mut child = TOOLS
        .command(&["fly", "--slaves", "1", "--seconds", "3600", "--out", text(out)])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut stdout = BufReader::new(child.stdout.take().expect("piped"));
    wait_for(&mut stdout, "power on");
    // Continues to read, as a terminal does.
    std::thread::spawn(move || stdout.read_to_string(&mut String::new()));
    child
}

fn lock_file() -> PathBuf {
    let folder = ecss_can_cli::images::target().join("firmware");
    fs::create_dir_all(&folder).expect("a directory");
    folder.join("lock")
}

/// Starts a command while another build holds the lock, and waits until it reports that. Stop it with SIGTERM: if tests
/// run in the background of a script, SIGINT is ignored.
fn held_up(arguments: &[&str], act: impl FnOnce(&mut Child, File)) -> ExitStatus {
    let lock = File::create(lock_file()).expect("the lock file");
    lock.lock().expect("the lock");
    let mut child = TOOLS
        .command(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut stderr = BufReader::new(child.stderr.take().expect("piped"));
    wait_for(&mut stderr, "waiting for another build of the firmware");
    act(&mut child, lock);
    child.wait().expect("it ends")
}

#[test]
fn closed_stdout_ends_every_command_quietly() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let out = |name: &str| text(&here.path().join(name)).to_owned();
    for arguments in [
        &["fly", "--slaves", "1", "--seconds", "2", "--out", &out("fly")][..],
        &["eds", "--out", &out("eds")],
        &["build", "slave"],
    ] {
        let (code, stderr) = TOOLS.run_with_closed_stdout(arguments);
        assert_eq!(code, PIPE_CLOSED, "{arguments:?}: {stderr}");
        assert!(!stderr.contains("panicked") && !stderr.contains("error"), "{arguments:?}: {stderr}");
    }
    assert!(here.path().join("eds/slave.eds").exists(), "files are written before their names are printed");
    let summary = summary(&here.path().join("fly"));
    assert_eq!(summary["verdict"], "interrupted", "{summary}");
}

#[test]
fn closed_stderr_changes_no_exit_code() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let missing = here.path().join("missing");
    let ports = ["--slcan-nominal", "0", "--slcan-redundant", "0"];
    let twin = [&["twin", "--listen", "0.0.0.0", "--slaves", "1", "--seconds", "0.1"], &ports[..]].concat();
    for (arguments, code) in [(&twin[..], 0), (&["eds", "--check", "--out", text(&missing)], 1)] {
        let status = TOOLS.command(arguments).stdout(Stdio::null()).stderr(closed_pipe()).status();
        assert_eq!(status.expect("the program starts").code(), Some(code), "{arguments:?}");
    }
}

/// Given a folder with an earlier run's results and a file of the user's, When the flight is interrupted, Then the
/// results are those of the interrupted flight and state that.
#[test]
fn interrupted_demo_writes_what_was_flown() {
    for name in ["-INT", "-TERM"] {
        let here = tempfile::tempdir().expect("a temporary directory");
        for file in ["summary.json", "report.html", "mine.txt"] {
            fs::write(here.path().join(file), "of an earlier run").expect("a file");
        }
        let mut child = demo_under_way(here.path());
        signal(&child, name);
        assert_eq!(child.wait().expect("it ends").code(), INTERRUPTED, "{name}");

        let summary = summary(here.path());
        assert_eq!(summary["verdict"], "interrupted", "{summary}");
        assert_eq!(summary["planned_seconds"], 3600.0);
        let flown = summary["virtual_seconds"].as_f64().expect("a number");
        assert!((0.001..3600.0).contains(&flown), "{flown}");
        let reason = summary["reasons"][0].as_str().expect("a reason");
        assert!(reason.contains("Ctrl-C") && reason.contains("of 3600 s"), "{reason}");
        let report = fs::read_to_string(here.path().join("report.html")).expect("the report");
        assert!(report.contains("interrupted") && report.contains(reason), "the report must say it, too");
        assert_eq!(fs::read_to_string(here.path().join("mine.txt")).expect("kept"), "of an earlier run");
    }
}

#[test]
fn unfinished_demo_leaves_no_results_of_an_earlier_run() {
    let here = tempfile::tempdir().expect("a temporary directory");
    for file in ["summary.json", "report.html", "bus-nominal.log", "mine.txt"] {
        fs::write(here.path().join(file), "of an earlier run").expect("a file");
    }
    let status = held_up(&["fly", "--out", text(here.path())], |child, _lock| signal(child, "-TERM"));
    assert!(!status.success());
    let left = fs::read_dir(here.path()).expect("a directory").map(|entry| entry.expect("one").file_name());
    assert_eq!(left.collect::<Vec<_>>(), ["mine.txt"]);
}

/// Given another build that holds the lock, When the twin waits for it, Then it reports that, has no port open, and
/// ends by a signal.
#[test]
fn waiting_twin_can_be_stopped_and_has_no_open_port() {
    let port = || TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port").port();
    let (nominal, redundant) = (port(), port());
    let arguments =
        ["twin", "--slcan-nominal", &nominal.to_string(), "--slcan-redundant", &redundant.to_string()];
    held_up(&arguments, |child, _lock| {
        for port in [nominal, redundant] {
            let refused = TcpStream::connect(("127.0.0.1", port)).expect_err("no boards fly yet");
            assert_eq!(refused.kind(), io::ErrorKind::ConnectionRefused);
        }
        signal(child, "-TERM");
        // The lock is held until it has ended.
        assert!(!child.wait().expect("it ends").success());
    });
}
