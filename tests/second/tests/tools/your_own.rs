//! The last steps of `docs/your-own.md`: a client in Python changes a value of the device while it flies.
//!
//! The test `flights::page` executes the steps before. This test executes those that the client needs. The twin uses
//! free ports instead of those on the page.

use second::page::{self, Folder, Step};
use second::program::Twin;
use second::tools;

const FREE_PORTS: &str = " --slcan-nominal 0 --slcan-redundant 0";
const NOMINAL: &str = "socket://127.0.0.1:29501";

#[test]
fn client_of_the_page_talks_to_the_device() {
    let top = page::fresh_folder("ecss-can-client").unwrap_or_else(|failure| panic!("{failure:#}"));
    let python = tools::python().unwrap_or_else(|failure| panic!("{failure:#}"));
    let folder = Folder::new(&top).unwrap_or_else(|failure| panic!("{failure:#}"));
    let mut folder = folder.with_tools(python.parent().unwrap());
    let steps = page::your_own().and_then(|steps| follow(&steps, &mut folder));
    steps.unwrap_or_else(|failure| panic!("{failure:#}"));
    std::fs::remove_dir_all(&*top).unwrap();
}

/// Returns whether a step makes files, image or data sheet. Tests of the device and its flight are not needed.
fn is_needed(step: &Step) -> bool {
    match step {
        Step::Run(commands) => !commands.starts_with("cargo test") && !commands.starts_with("ecss-can fly"),
        Step::Output(_) => false,
        Step::File(..) | Step::Background(_) => true,
    }
}

fn follow(steps: &[Step], folder: &mut Folder) -> anyhow::Result<()> {
    let flight = steps.iter().position(|step| matches!(step, Step::Background(_))).expect("a spacecraft");
    let (before, after) = steps.split_at(flight);
    let mut twin: Option<Twin> = None;
    for step in before.iter().filter(|step| is_needed(step)).chain(after) {
        match step {
            Step::File(path, text) if path.extension().is_some_and(|name| name == "py") => {
                let twin = twin.as_ref().expect("the spacecraft flies before its client is written");
                assert!(text.contains(NOMINAL), "{text}");
                folder.write(path, &text.replace(NOMINAL, &twin.nominal))?;
            }
            Step::Background(command) => {
                let command = folder.background(&(command.trim_end().to_owned() + FREE_PORTS));
                twin = Some(Twin::of(command)?);
            }
            step => folder.follow(step)?,
        }
    }
    let said = twin.expect("a spacecraft that flies").end()?;
    assert!(said.contains("slave 5"), "{said}");
    Ok(())
}
