//! The report of `cargo demo` in a browser: its layout fits the page, and its numbers are those of `summary.json`.

use std::fs;
use std::path::Path;
use std::process::Command;

use ecss_can_cli::images::support::needs::CHROMIUM;
use ecss_can_cli::images::support::project;
use second::{program, tools};
use serde_json::Value;

/// A page with the report in frames of two widths. It writes its measurements to the element `result`.
const FRAMES: &str = include_str!("report/frame.html");

/// Runs the demo into a folder, and returns its summary.
fn fly(out: &Path, arguments: &[&str]) -> Value {
    let output = Command::new(program::executable().unwrap_or_else(|failure| panic!("{failure:#}")))
        .args(["fly", "--out"])
        .arg(out)
        .args(arguments)
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&fs::read(out.join("summary.json")).expect("a summary")).expect("JSON")
}

/// Opens the report of a folder in chromium, and returns the measurements of the page and chromium's messages about
/// scripts.
fn open(out: &Path) -> (Value, String) {
    let report = fs::read_to_string(out.join("report.html")).expect("a report");
    // As a string of JavaScript inside of HTML.
    let report =
        serde_json::to_string(&report).expect("a string").replace("</", "<\\/").replace("<!--", "<\\!--");
    let page = out.join("frames.html");
    fs::write(&page, FRAMES.replace("REPORT", &report)).expect("a page");
    let output = Command::new("chromium")
        // The tests may run as root, where its sandbox does not start.
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--window-size=1400,1000",
            "--enable-logging=stderr",
        ])
        .arg(format!("--user-data-dir={}", out.join("browser").display()))
        .arg("--dump-dom")
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("chromium starts");
    let (dom, log) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{log}");
    let result = dom.split("<pre id=\"result\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let result = result.unwrap_or_default().replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let measured = serde_json::from_str(&result).unwrap_or_else(|error| panic!("{error}: {result}\n{log}"));
    (measured, log.lines().filter(|line| line.contains("CONSOLE")).collect())
}

/// Returns a number of the page in the unit of `summary.json`, and half of its last digit. `None`: a dash.
fn number(key: &str, text: &str) -> Option<(f64, f64)> {
    let (digits, unit) = text.split_once(' ').unwrap_or((text, ""));
    if digits == "\u{2013}" {
        return None;
    }
    let scale = match unit {
        "" | "%" | "ms" | "ns" => 1.0,
        "s" if key.contains("_ms") => 1000.0,
        _ => panic!("{key}: a number in {unit:?}"),
    };
    let value: f64 = digits.parse().unwrap_or_else(|_| panic!("{key}: {text:?} is no number"));
    let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    Some((value * scale, 0.5 * scale / 10_f64.powi(decimals as i32)))
}

/// Returns the value of a summary at a path such as `failover_ms.2`.
fn at<'a>(summary: &'a Value, key: &str) -> &'a Value {
    key.split('.')
        .fold(summary, |value, name| value.get(name).unwrap_or_else(|| panic!("no {key} in {summary}")))
}

/// Checks a report at both widths, and returns the keys of its numbers.
fn check(out: &Path, summary: &Value) -> Vec<String> {
    let (measured, console) = open(out);
    assert_eq!(console, "", "chromium reports an error of a script");
    let pages = measured.as_array().expect("pages");
    assert_eq!(pages.iter().map(|page| page["width"].as_u64()).collect::<Vec<_>>(), [Some(1240), Some(400)]);
    let mut keys = Vec::new();
    for page in pages {
        let width = &page["width"];
        assert!(page["scrollWidth"].as_u64() <= width.as_u64(), "{width} px: {}", page["scrollWidth"]);
        assert_eq!(page["wide"], Value::Array(vec![]), "{width} px: wider than the page");
        assert_eq!(page["cut"], Value::Array(vec![]), "{width} px: words outside of their picture");
        keys.clear();
        for entry in page["numbers"].as_array().expect("numbers") {
            let [key, text] = [0, 1].map(|part| entry[part].as_str().expect("text"));
            let expected = at(summary, key).as_f64();
            match (number(key, text), expected) {
                (None, None) => {}
                (Some((shown, half)), Some(exact)) => {
                    assert!((shown - exact).abs() <= half * 1.001, "{key}: {text:?} for {exact}");
                }
                (shown, exact) => panic!("{key}: {shown:?} for {exact:?}"),
            }
            keys.push(key.to_owned());
        }
    }
    keys
}

fn has(keys: &[String], expected: &[&str]) {
    for key in expected {
        assert!(keys.iter().any(|own| own == key), "no {key} on the page: {keys:?}");
    }
}

/// Given the flight of `cargo demo` with its cut, when its report is opened in frames of 1240 and 400 px, then no script fails,
/// nothing is wider than the page, and every number is that of `summary.json`, rounded.
#[test]
fn report_fits_the_page_and_has_the_numbers_of_the_summary() {
    tools::require(&[CHROMIUM]).unwrap_or_else(|failure| panic!("{failure:#}"));
    let here = tempfile::tempdir().expect("a temporary directory");
    let summary = fly(here.path(), &[]);
    let keys = check(here.path(), &summary);
    has(&keys, &["slaves_operational_at_end", "tc_executed", "tc_due", "tm_received", "emergencies"]);
    has(&keys, &["failover_ms.4", "frames.nominal", "bus_load_percent.redundant", "clock_rms_error_ns.2"]);
    has(&keys, &["lost_frames", "aborted_frames", "resets", "lockups", "panics"]);
}

/// Given a flight with a user's image and its data sheet, whose PDOs have rows with other names and charts, then the report fits too.
#[test]
fn report_of_unknown_images_fits_the_page() {
    tools::require(&[CHROMIUM]).unwrap_or_else(|failure| panic!("{failure:#}"));
    let here = tempfile::tempdir().expect("a temporary directory");
    let images =
        ecss_can_cli::images::build("pyboard-v11", "librecube").unwrap_or_else(|error| panic!("{error}"));
    let slave = format!("2={}", images.slave.display());
    let sheet = format!("2={}", project::path("docs/eds/slave.eds").display());
    let options = ["--slaves", "1", "--slave", &slave, "--eds", &sheet, "--seconds", "4", "--cut-at", "2"];
    let summary = fly(here.path(), &options);
    has(&check(here.path(), &summary), &["bus_changes", "failover_ms.2", "aborted_frames"]);
    let report = fs::read_to_string(here.path().join("report.html")).expect("a report");
    assert!(report.contains("<b>node 2: Telemetry, Data</b>"), "no chart of a value");
}

/// Given two masters and fourteen slaves, then the longest tables fit as well.
#[test]
fn report_of_two_masters_and_many_slaves_fits_the_page() {
    tools::require(&[CHROMIUM]).unwrap_or_else(|failure| panic!("{failure:#}"));
    let here = tempfile::tempdir().expect("a temporary directory");
    let summary =
        fly(here.path(), &["--profile", "standby", "--slaves", "14", "--seconds", "8", "--cut-at", "6"]);
    let keys = check(here.path(), &summary);
    has(&keys, &["takeover_ms", "takeover_failover_ms.15", "failover_ms.15"]);
}
