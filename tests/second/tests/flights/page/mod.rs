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
    let mut printed = String::new();
    let steps = page::your_own().unwrap_or_else(|failure| panic!("{failure:#}"));
    let mut outputs = 0;
    for step in steps.iter().take_while(|step| !matches!(step, Step::Background(_))) {
        let outcome = match step {
            Step::File(path, text) => folder.write(path, text),
            Step::Run(commands) => folder.run(commands).and_then(|output| {
                printed = output;
                if commands.starts_with("cargo new") { folder.keep_target("heater") } else { Ok(()) }
            }),
            Step::Output(expected) => {
                assert!(printed.ends_with(expected), "{printed}");
                outputs += 1;
                Ok(())
            }
            Step::Background(_) => unreachable!("the steps end before it"),
        };
        outcome.unwrap_or_else(|failure| panic!("{failure:#}"));
    }
    assert_eq!(outputs, 2, "the page shows what a flight on each board prints");
}
