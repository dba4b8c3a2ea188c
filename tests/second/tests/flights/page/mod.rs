//! `docs/your-own.md`, followed in a fresh folder outside the repository up to the client in Python, and `docs/your-own-master.md` in the
//! same folder.

mod flights;
mod lines;

use std::fs;
use std::path::Path;

use second::page::{self, Folder, Step};

/// Given the page of the slave, when its steps are followed, then the device passes its tests, its image flies on the
/// board of the page, and its data sheet exists. The image survives a cut, a hang and a reset on that board. When the
/// page of the master is followed afterwards, the master passes its tests, commands the slave on emulated boards, and
/// has its data sheet.
#[test]
fn steps_up_to_the_client_work() {
    let top = page::fresh_folder("ecss-can-page").unwrap_or_else(|failure| panic!("{failure:#}"));
    let shown = follow(&top, page::your_own());
    assert_eq!(shown, 2, "the page shows what a flight on each board prints");
    assert_contains(&top.join("heater/heater.eds"), &["ParameterName=Setpoint", "HighLimit=850"]);
    lines::report(&top);
    flights::fly(&top);

    let shown = follow(&top, page::your_own_master());
    assert_eq!(shown, 1, "the page shows what the master reports");
    assert_contains(&top.join("ground/ground.eds"), &["ProductName=Ground", "[1A00]"]);
    fs::remove_dir_all(&*top).expect("the folder goes");
}

/// Executes the steps of a page before the first one that keeps running. Returns the number of outputs on that part of
/// the page.
fn follow(top: &Path, steps: anyhow::Result<Vec<Step>>) -> usize {
    let mut folder = Folder::new(top).unwrap_or_else(|failure| panic!("{failure:#}"));
    let steps = steps.unwrap_or_else(|failure| panic!("{failure:#}"));
    let steps: Vec<&Step> = steps.iter().take_while(|step| !matches!(step, Step::Background(_))).collect();
    for step in &steps {
        folder.follow(step).unwrap_or_else(|failure| panic!("{failure:#}"));
    }
    steps.iter().filter(|step| matches!(step, Step::Output(_))).count()
}

fn assert_contains(file: &Path, parts: &[&str]) {
    let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    parts.iter().for_each(|part| assert!(text.contains(part), "{part} is not in\n{text}"));
}
