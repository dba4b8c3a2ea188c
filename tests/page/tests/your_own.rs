//! `docs/your-own.md`, followed in a fresh folder outside the repository up to the client in Python.

use std::fs;

use page::{Folder, Step};

/// Given the page, when its steps are followed, then the device passes its tests, its image flies, and its data sheet is there.
#[test]
fn steps_up_to_the_client_work() {
    let top = tempfile::tempdir().expect("a folder");
    let mut folder = Folder::new(top.path());
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
    assert_eq!(outputs, 1, "the page shows what the flight prints");
    let sheet = fs::read_to_string(top.path().join("heater/heater.eds")).expect("a data sheet");
    assert!(sheet.contains("ParameterName=Setpoint") && sheet.contains("HighLimit=850"), "{sheet}");
}
