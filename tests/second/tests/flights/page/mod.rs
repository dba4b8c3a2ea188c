//! `docs/your-own.md`, followed in a fresh folder outside the repository up to the client in Python.

mod flights;
mod lines;

use std::fs;
use std::path::Path;

use second::page::{self, Folder, Step};

/// Given the page, when its steps are followed, then the device passes its tests, its image flies on the board of the page, and its data
/// sheet is there. The image survives a cut, a hang and a reset on that board.
#[test]
fn steps_up_to_the_client_work() {
    let top = page::fresh_folder("ecss-can-page").unwrap_or_else(|failure| panic!("{failure:#}"));
    follow(&top);
    let sheet = fs::read_to_string(top.join("heater/heater.eds")).expect("a data sheet");
    assert!(sheet.contains("ParameterName=Setpoint") && sheet.contains("HighLimit=850"), "{sheet}");
    lines::report(&top);
    flights::fly(&top);
    fs::remove_dir_all(&top).expect("the folder goes");
}

/// Follows the steps of the page, which shows what its two flights print.
fn follow(top: &Path) {
    let mut folder = Folder::new(top);
    let steps = page::your_own().unwrap_or_else(|failure| panic!("{failure:#}"));
    let steps: Vec<&Step> = steps.iter().take_while(|step| !matches!(step, Step::Background(_))).collect();
    for step in &steps {
        folder.follow(step).unwrap_or_else(|failure| panic!("{failure:#}"));
    }
    let outputs = steps.iter().filter(|step| matches!(step, Step::Output(_)));
    assert_eq!(outputs.count(), 2, "the page shows what a flight on each board prints");
}
